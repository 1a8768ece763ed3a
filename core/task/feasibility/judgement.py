"""What stands in the way of a mission: proofs first, then warnings.

Two questions are asked of the obligations of a formula (`obligations`). With the fastest that the
robot can be, from anywhere in the initial set, and with places apart where not even boundaries
meet: if there is no solution, the mission is impossible, and this is a proof. With planning speed,
from the nearest start, and with places apart where no interior is common: if there is no solution,
training will hardly find one. Then the same is asked of single starts.
"""

from dataclasses import dataclass

import numpy as np

from core.stl import Atom, Formula, horizon, to_text
from core.task.feasibility.bounds import Bounds
from core.task.feasibility.conflicts import Conflicts
from core.task.feasibility.cores import cores_of
from core.task.feasibility.finding import Finding, Severity
from core.task.feasibility.obligations import Obligations, obligations_of
from core.task.feasibility.places import Geometry, Places
from core.task.feasibility.remedy import remedy
from core.task.feasibility.search import Search
from core.task.feasibility.starts import start_findings
from core.task.feasibility.thin import thin_findings
from core.task.feasibility.travel import Fastest, Planned
from core.task.feasibility.wording import Wording, extent
from core.task.protocols import Robot, begins_exactly

SLACK = 0.2
"""Rounding of a step over that of a margin: one addition instead of several operations."""


@dataclass(frozen=True, eq=False)
class Mission:
    """What a judgement is about.

    Attributes:
        formula: Its atoms are among the names of the places, but not the last of them.
        places: The regions, and last the initial set.
        starts: Positions [P, d] of the initial set, spread evenly [m].
        robot: Who carries it out.
        arena: (low, high) of each axis, where ways are planned [m].
        between_steps: Whether invariants must hold between the steps, too.
    """

    formula: Formula
    places: Places
    starts: np.ndarray
    robot: Robot
    arena: tuple[tuple[float, float], ...]
    between_steps: bool = False

    @property
    def start(self) -> Atom:
        """The initial set as a state formula."""
        return Atom(self.places.names[-1])


def judge(mission: Mission) -> tuple[Finding, ...]:
    """Everything that a user should know before training; nothing for an ordinary mission."""
    obligations = obligations_of(mission.formula, mission.start)
    geometry, bounds = Geometry(mission.places), Bounds.of(obligations)
    last = max(horizon(mission.formula), 1)
    unknown = frozenset() if begins_exactly(mission.robot) else frozenset({0})
    proof = Search(
        Conflicts(obligations, geometry, bounds, strict=False, ignored=unknown),
        Fastest(mission.robot, last, SLACK * mission.places.tolerance),
    )
    plan = Search(Conflicts(obligations, geometry, bounds, strict=True), Planned(mission.robot))
    found = _impossible(proof, plan, Severity.PROVED, mission.starts)
    if not found:
        found = _impossible(plan, plan, Severity.WARNING, mission.starts)
        if not found:
            found = start_findings(plan, mission.starts)
    found += _outside(mission, obligations, geometry)
    if not mission.between_steps:
        found += thin_findings(obligations, bounds, mission.places, mission.robot)
    return tuple(found)


def _impossible(
    search: Search, plan: Search, severity: Severity, starts: np.ndarray
) -> list[Finding]:
    """Why there is no solution, if there is none."""
    if search.possible():
        return []
    cores = cores_of(search)
    wording = Wording(search, severity, starts)
    told = [Finding(severity, wording.of(core), wording.names(core)) for core in cores]
    found = list(dict.fromkeys(told))
    if advice := remedy(plan, cores):
        last = found[-1]
        found[-1] = Finding(severity, f"{last.words}; {advice} would do", last.tasks)
    return found


def _outside(mission: Mission, obligations: Obligations, geometry: Geometry) -> list[Finding]:
    """Goals and starts outside the arena, within which ways are planned."""
    low, high = np.array(mission.arena, float).T
    found = []
    goals = [hold.predicate for hold in obligations.holds[1:] if not hold.scope]
    for goal in dict.fromkeys(goals):
        pieces = geometry.pieces(goal)
        beyond = [((piece.low > high) | (piece.high < low)).any() for piece in pieces]
        if all(beyond):
            text = to_text(goal)
            words = f"{text} lies outside the arena, {extent(mission.arena)}"
            found.append(Finding(Severity.WARNING, words, (text,)))
    outside = float(((mission.starts < low) | (mission.starts > high)).any(1).mean())
    if outside > 0:
        words = (
            f"about {outside:.0%} of the initial set lies outside the arena, "
            f"{extent(mission.arena)}"
        )
        found.append(Finding(Severity.WARNING, words))
    return found
