"""Obstacles that the robot may jump over from one step to the next.

An obstacle is a region that a formula forbids for longer than a step. It is as thick as the
largest ball in it is wide, at least; where that is less than the robot moves in a step at
planning speed, a trace can keep out of it at every step and go through it all the same.
"""

from itertools import product

import numpy as np

from core.monitor.wording import metres
from core.quoting import listed
from core.stl import Atom, Not, quote_name
from core.task.feasibility.bounds import Bounds
from core.task.feasibility.finding import Finding, Severity
from core.task.feasibility.obligations import Obligations
from core.task.feasibility.places import Places
from core.task.protocols import Robot

ACROSS, ROUNDS = 9, 8
"""Positions along each axis of a box, and how often the box shrinks around the deepest of them."""


def thin_findings(
    obligations: Obligations, bounds: Bounds, places: Places, robot: Robot
) -> list[Finding]:
    """Warnings of the obstacles that are thinner than a step is long."""
    forbidden = [
        hold.predicate.operand.name
        for hold in obligations.holds
        if isinstance(hold.predicate, Not)
        and isinstance(hold.predicate.operand, Atom)
        and bounds.between(hold.start, hold.end) > 0
    ]
    thin: dict[str, list[str]] = {}
    for name in dict.fromkeys(forbidden):
        thick = thickness(places, places.names.index(name))
        if 0 < thick < robot.speed:
            thin.setdefault(metres(thick), []).append(quote_name(name))
    return [_finding(names, thick, metres(robot.speed)) for thick, names in thin.items()]


def _finding(names: list[str], thick: str, step: str) -> Finding:
    """Of obstacles of one thickness."""
    words = (
        f"{listed(names)} {'is' if len(names) == 1 else 'are'} {thick} thick, but the robot moves "
        f"about {step} a step: it may go through between two steps, which the formula does not "
        "see; `between_steps = true` in the scene forbids that"
    )
    return Finding(Severity.WARNING, words, tuple(f"!{name}" for name in names))


def thickness(places: Places, i: int) -> float:
    """Diameter of the largest ball that is found in the i-th region [m]."""
    center, half = (places.low[i] + places.high[i]) / 2, (places.high[i] - places.low[i]) / 2
    offsets = np.array(list(product(np.linspace(-1.0, 1.0, ACROSS), repeat=len(center))))
    deepest = -np.inf
    for _ in range(ROUNDS):
        positions = center + offsets * half
        margins = places.margin(i, positions)
        if margins.max() > deepest:
            deepest, center = float(margins.max()), positions[margins.argmax()]
        half = half / 2
    return 2 * deepest
