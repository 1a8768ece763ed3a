"""A trace made more robust without changing its choices, by a few linear programs.

What decides a trace's robustness (`Values.supports`) is kept: each wanted region by all facets of
an outline of many directions, each avoided one by the facet that is farthest away. These are
convex and promise no more than they keep, so that the trace of each program is no worse than the
one before.
"""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from core.planning.outline import Sides
from core.planning.program import INFINITY, Program
from core.planning.reach import Boxes, Literal
from core.planning.trace import Trace
from core.stl import Atom, Formula, Not

ROUNDS = 8
"""Most linear programs."""

GAIN = 1e-4
"""Gain in robustness below which it is left at that [m]."""

Judge = Callable[[np.ndarray], tuple[float, list[Literal]]]
"""From positions [T + 1, d] to their robustness and the literals that decide it."""


def polish(
    positions: np.ndarray, judge: Judge, stride: np.ndarray, sides: Mapping[str, Sides]
) -> tuple[np.ndarray, float]:
    """The most robust of the traces that follow from one another, and its robustness.

    Args:
        positions: [T + 1, d] [m].
        judge: of robustness.
        stride: most that a coordinate changes in a step [d] [m].
        sides: what stands for the regions; inner sides.
    """
    robustness, supports = judge(positions)
    for _ in range(ROUNDS):
        better = _improved(positions, supports, stride, sides)
        if better is None:
            break
        value, following = judge(better)
        if value <= robustness + GAIN:
            break
        positions, robustness, supports = better, value, following
    return positions, robustness


def _improved(
    positions: np.ndarray,
    supports: Iterable[Literal],
    stride: np.ndarray,
    sides: Mapping[str, Sides],
) -> np.ndarray | None:
    program = Program()
    free = np.full(positions.shape, INFINITY)
    trace = Trace(program, Boxes(-free, free), positions[0], stride, 1)
    robustness = program.column(-INFINITY, INFINITY)
    for literal, step in dict.fromkeys(supports):
        for normal, offset in _kept(literal, positions[step], sides):
            terms = trace.along(normal, step) | {robustness: -1.0}
            program.row(terms, offset, INFINITY)
    values = program.maximise(robustness, INFINITY).values
    return None if values is None else trace.positions(values)


def _kept(literal: Formula, position: np.ndarray, sides: Mapping[str, Sides]):
    """Normals and offsets that keep a literal: n . p - o >= r."""
    match literal:
        case Atom(name):
            wanted = sides[name].wanted
            return zip(-wanted.normals, -wanted.offsets, strict=True)
        case Not(operand=Atom(name)):
            avoided = sides[name].avoided
            best = avoided.values(position).argmax()
            return [(avoided.normals[best], avoided.offsets[best])]
    raise TypeError(f"not a literal: {literal!r}")
