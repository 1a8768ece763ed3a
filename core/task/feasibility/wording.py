"""Why a set of holds cannot be met, in words."""

from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np

from core.quoting import LONGEST_FORMULA, listed, shown
from core.stl import And, Atom, Formula, Not, Until, to_text, walk
from core.task.feasibility.bounds import Bounds
from core.task.feasibility.cores import minimal
from core.task.feasibility.finding import Severity
from core.task.feasibility.obligations import Hold, Scope
from core.task.feasibility.search import Search
from core.task.feasibility.travel import NEVER

START = "the start"
AT_ONCE = "at once"
MOST_ALTERNATIVES = 3
"""Alternatives of a choice that are each told about."""

MOST_ORDERED = 6
"""Places of which the best order is looked for."""


def extent(arena: tuple[tuple[float, float], ...]) -> str:
    """`which extends from [-5.0, -5.0] to [5.0, 5.0] m`."""
    low, high = ([float(pair[i]) for pair in arena] for i in (0, 1))
    return f"which extends from {low} to {high} m"


@dataclass(frozen=True)
class Wording:
    """Words for the minimal sets that a search has found.

    Attributes:
        search: In whose terms there is no solution.
        severity: What the words are for.
        starts: Positions [P, d] of the initial set [m].
    """

    search: Search
    severity: Severity
    starts: np.ndarray

    def names(self, core: tuple[int, ...]) -> tuple[str, ...]:
        """State formulas of holds as text, the start apart."""
        holds = self._company(core[0]) if len(core) == 1 else core
        return tuple(dict.fromkeys(self._name(i) for i in holds if i != 0))

    def of(self, core: tuple[int, ...], scope: Scope = ()) -> str:
        """One sentence on a minimal set, with the alternatives in `scope`."""
        open_choices = {each for i in core for each in self._hold(i).scope} - set(scope)
        if open_choices:
            return self._either_way(core, min(open_choices)[0], scope)
        if len(core) == 1:
            return self._alone(core[0])
        if len(core) == 2 and self._together(*core):
            if core[0] == 0:
                return self._contradicted(core[1:])
            return self._exclusive(core, self._when(core))
        if len(core) > MOST_ORDERED:
            return f"{self._list(core)} leave no time to travel between them, in any order"
        return self._legs(core)

    def _either_way(self, core: tuple[int, ...], number: int, scope: Scope) -> str:
        """What stands in the way of each alternative of a choice."""
        alternatives = self.search.conflicts.obligations.choices[number].alternatives
        if len(alternatives) > MOST_ALTERNATIVES:
            return f"whichever alternative is chosen, there is no time for {self._list(core)}"
        reasons = {}
        for value, alternative in enumerate(alternatives):
            chosen = (*scope, (number, value))
            smaller = minimal(self.search, core, chosen)
            reasons[_text(alternative)] = self.of(smaller, chosen)
        if len(set(reasons.values())) == 1:
            return next(iter(reasons.values()))
        return "; ".join(f"with {text}, {reason}" for text, reason in reasons.items())

    def _company(self, i: int) -> tuple[int, ...]:
        """Of a hopeless hold and its company, those that no position satisfies."""
        conflicts = self.search.conflicts
        holds = conflicts.company(i)
        for j in holds:
            without = tuple(k for k in holds if k != j)
            if without and conflicts.apart(without):
                holds = without
        return holds

    def _alone(self, i: int) -> str:
        """A state formula that no position satisfies, or none where others must hold too."""
        holds = self._company(i)
        if 0 in holds and len(holds) > 1:
            return self._contradicted(tuple(j for j in holds if j != 0))
        return self._exclusive(holds, self._when((i,)))

    def _contradicted(self, holds: tuple[int, ...]) -> str:
        """The start breaks what must hold from step 0."""
        wanted = self.search.conflicts.joint(holds)
        margin = self.search.conflicts.geometry.margins_of(wanted, self.starts).max()
        if margin >= 0:  # on a boundary, or with what must hold besides
            return self._exclusive((0, *holds), "at step 0")
        return (
            f"the start contradicts the formula: {_text(wanted)} must hold from step 0, but all "
            f"of the initial set is {-margin:.2g} m or more away from that"
        )

    def _exclusive(self, holds: tuple[int, ...], when: str) -> str:
        """State formulas that no position satisfies together."""
        conflicts = self.search.conflicts
        touching = conflicts.geometry.best(conflicts.joint(holds)).bound >= 0
        predicates = list(dict.fromkeys(self._hold(i).predicate for i in holds))
        if len(predicates) == 1:
            if touching:
                return f"{_text(predicates[0])} holds on a boundary only"
            return f"no position satisfies {_text(predicates[0])}"
        inside, outside = _goal_and_obstacle(predicates)
        if inside and outside and not touching and 0 not in holds:
            meanwhile = "meanwhile" if when == AT_ONCE else when
            return f"{inside} lies inside {outside}, which is forbidden {meanwhile}"
        names = self._list(holds)
        if not touching:
            return f"{names} are wanted {when}, but do not meet"
        hint = ""
        if any(isinstance(self._hold(i).source, Until) for i in holds):
            hint = "; in `phi1 U phi2`, phi1 must still hold at the step of phi2"
        return f"{names} are wanted {when}, which only a boundary allows{hint}"

    def _together(self, i: int, j: int) -> bool:
        """Whether two holds are wanted at one time, in either order without a step between."""
        bounds, one, other = self.search.conflicts.bounds, self._hold(i), self._hold(j)
        return bounds.last(other.start) <= bounds.first(one.end) and (
            bounds.last(one.start) <= bounds.first(other.end)
        )

    def _when(self, core: tuple[int, ...]) -> str:
        """`at once`, or the steps where these are known."""
        bounds = self.search.conflicts.bounds
        holds = [self._hold(i) for i in core]
        first = max(bounds.last(hold.start) for hold in holds)
        last = min(bounds.first(hold.end) for hold in holds)
        fixed = all(_is_fixed(bounds, hold) for hold in holds)
        if not fixed or first > last:
            return AT_ONCE
        return f"at step {first}" if first == last else f"from step {first} to {last}"

    def _legs(self, core: tuple[int, ...]) -> str:
        """The order that lacks least, with its first leg that lacks time."""
        first = core[:1] if core[0] == 0 else ()
        orders = permutations(core[len(first) :])
        told = [self._in_order((*first, *order)) for order in orders]
        _, words = min(told, key=lambda each: each[0])
        return words

    def _in_order(self, order: tuple[int, ...]) -> tuple[int, str]:
        """Steps that an order lacks, and what it lacks them for."""
        bounds = self.search.conflicts.bounds
        done, legs = bounds.first(self._hold(order[0]).end), []
        for i, j in pairwise(order):
            hold, needed = self._hold(j), self._least(i, j)
            room = bounds.between(self._hold(i).end, hold.start)
            if needed > room:
                return needed - room, self._told([(i, j, needed)], needed - room)
            opens = bounds.first(hold.start)
            legs = [*legs, (i, j, needed)] if done + needed >= opens else []
            arrival = max(done + needed, opens)
            lack = arrival - bounds.last(hold.start)
            if lack > 0:
                return lack, self._told(legs, lack)
            done = max(arrival + bounds.first(hold.end) - opens, bounds.first(hold.end))
        return NEVER, f"{self._list(order)} leave no time to travel between them"

    def _told(self, legs: list[tuple[int, int, int]], lack: int) -> str:
        proved = self.severity is Severity.PROVED
        total = sum(needed for _, _, needed in legs)
        names = " then ".join(self._name(i) for i in (legs[0][0], *(leg[1] for leg in legs)))
        names = names.replace(f"{START} then", f"{START} to", 1)
        if total >= NEVER:
            return f"{names} is farther than any way of the robot within the episode"
        parts = " (" + " + ".join(str(needed) for _, _, needed in legs) + ")"
        return (
            f"{names} is {'at least' if proved else 'about'} {total} steps"
            f"{parts if len(legs) > 1 else ''}{'' if proved else ' at planning speed'}, "
            f"{max(total - lack, 0)} are left"
        )

    def _least(self, i: int, j: int) -> int:
        if self.search.conflicts.gaps(i, j) is None:
            return 0
        return self.search.least(i, j, self.search.conflicts.bounds)

    def _hold(self, i: int) -> Hold:
        return self.search.conflicts.obligations.holds[i]

    def _name(self, i: int) -> str:
        return START if i == 0 else _text(self._hold(i).predicate)

    def _list(self, core: tuple[int, ...]) -> str:
        return _listed(list(dict.fromkeys(self._name(i) for i in core)))


def _is_fixed(bounds: Bounds, hold: Hold) -> bool:
    """Whether a window is the same for every solution."""
    return all(bounds.first(each) == bounds.last(each) for each in (hold.start, hold.end))


def _goal_and_obstacle(predicates: list[Formula]) -> tuple[str, str]:
    """Names of a region and of one that contains it, empty where it is not that simple."""
    goals = [p for p in predicates if not any(isinstance(node, Not) for node in walk(p))]
    others = [p for p in predicates if p not in goals]
    if len(goals) != 1 or len(others) != 1:
        return "", ""
    literals = others[0].operands if isinstance(others[0], And) else (others[0],)
    if (
        len(literals) == 1
        and isinstance(literals[0], Not)
        and isinstance(literals[0].operand, Atom)
    ):
        return _text(goals[0]), to_text(literals[0].operand)
    return "", ""


def _text(formula: Formula) -> str:
    return shown(to_text(formula), LONGEST_FORMULA)


def _listed(names: list[str]) -> str:
    """`A`, `A and B`, `A, B and C`."""
    if len(names) == 1:
        return names[0]
    return f"{listed(names[:-1])} and {names[-1]}"
