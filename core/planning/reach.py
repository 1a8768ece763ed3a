"""Where a robot that moves by bounded strides can be at each step of a trace that satisfies.

From the start on the boxes [low, high] grow by a stride each step; what a formula asks of a step
in any case (`certain`) cuts them, from the front and from the back, until nothing changes much.
Walls thus become bounds, and facets and goals out of reach fall away before the search begins.

Dimensions: T steps, d position.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from core.planning.outline import Sides
from core.stl import Always, And, Atom, Eventually, Formula, Not, Or, Until

ROUNDS = 3
"""Times that the boxes are cut from the front and from the back."""


Literal = tuple[Formula, int]
"""An atom or its negation, and a step."""


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes that contain the position at every step; empty ones if no trace satisfies."""

    low: np.ndarray  # [T + 1, d] [m]
    high: np.ndarray  # [T + 1, d] [m]

    @property
    def empty(self) -> bool:
        """Whether some step has no position left."""
        return bool((self.low > self.high).any())


def certain(formula: Formula, step: int) -> frozenset[Literal]:
    """Literals that hold on every trace that satisfies a formula at a step.

    Args:
        formula: in negation normal form, without constants.
        step: at which it holds.
    """
    match formula:
        case Atom() | Not(operand=Atom()):
            return frozenset({(formula, step)})
        case And(operands=operands):
            return frozenset().union(*(certain(each, step) for each in operands))
        case Or(operands=operands):
            return _common(certain(each, step) for each in operands)
        case Always(interval=(a, b), operand=operand):
            window = range(step + a, step + b + 1)
            return frozenset().union(*(certain(operand, k) for k in window))
        case Eventually(interval=(a, b), operand=operand):
            return _common(certain(operand, k) for k in range(step + a, step + b + 1))
        case Until(interval=(a, _), left=left):
            return frozenset().union(*(certain(left, k) for k in range(step, step + a + 1)))
    return frozenset()


def _common(parts: Iterable[frozenset[Literal]]) -> frozenset[Literal]:
    common: frozenset[Literal] | None = None
    for part in parts:
        common = part if common is None else common & part
        if not common:
            break
    return common or frozenset()


def reachable(
    start: np.ndarray,
    stride: np.ndarray,
    steps: int,
    literals: Iterable[Literal],
    sides: Mapping[str, Sides],
    least: float,
) -> Boxes:
    """Boxes around the positions of a trace on which some literals hold.

    Args:
        start: position [d] at step 0 [m].
        stride: most that a coordinate changes in a step [d] [m].
        steps: T.
        literals: what holds.
        sides: what stands for the regions.
        least: robustness with which they hold [m].
    """
    asked: list[list[Formula]] = [[] for _ in range(steps + 1)]
    for literal, step in literals:
        asked[step].append(literal)
    low = np.full((steps + 1, len(start)), -np.inf)
    high = -low
    low[0] = high[0] = start
    for _ in range(ROUNDS):
        for order in (range(steps + 1), range(steps, -1, -1)):
            before: int | None = None
            for step in order:
                if before is not None:
                    low[step] = np.maximum(low[step], low[before] - stride)
                    high[step] = np.minimum(high[step], high[before] + stride)
                for literal in asked[step]:
                    low[step], high[step] = _cut(literal, low[step], high[step], sides, least)
                before = step
    return Boxes(low, high)


def _cut(
    literal: Formula, low: np.ndarray, high: np.ndarray, sides: Mapping[str, Sides], least: float
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a box in which a literal can hold, as a box."""
    if not np.isfinite([low, high]).all():
        return low, high
    if isinstance(literal, Atom):
        for normal, offset in zip(*sides[literal.name].wanted, strict=True):
            low, high = _below(normal, offset - least, low, high)
        return low, high
    assert isinstance(literal, Not) and isinstance(literal.operand, Atom)
    facets = sides[literal.operand.name].avoided
    can = facets.most(low, high) >= least
    parts = [
        _below(-normal, -offset - least, low, high)
        for normal, offset in zip(facets.normals[can], facets.offsets[can], strict=True)
    ]
    if not parts:
        return np.full_like(low, np.inf), np.full_like(high, -np.inf)
    lows, highs = zip(*parts, strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _below(
    normal: np.ndarray, offset: float, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The box around the part of a box in which n . p <= o, by one pass over the coordinates."""
    least = np.minimum(normal * low, normal * high)
    room = offset - (least.sum() - least)  # what is left for each coordinate
    with np.errstate(divide="ignore", invalid="ignore"):
        limit = room / normal
    return (
        np.where(normal < 0, np.maximum(low, limit), low),
        np.where(normal > 0, np.minimum(high, limit), high),
    )
