"""The largest robustness of a formula from one start, with a bound that is proved.

For a robot that moves by bounded strides, p' = p + u with |u_i| <= stride_i. Only traces that
satisfy the formula are searched, so that it is found out, too, if there is none:

1. Boxes of positions and a ceiling (`reach`, `ceiling`) may decide it already.
2. A small program finds a trace: velocities are kept for some steps, and the outlines of the
   regions promise no more than they keep. The trace is polished.
3. A program over all traces, whose outlines promise no less than anybody can have, begins with
   that trace. What it proves is the bound; a better trace that it finds is polished, too.
4. Where the outlines keep bound and trace apart, outlines of more directions follow.

The robustness of a trace is always the exact one.

Dimensions: T steps, d position, A regions.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from core.planning.ceiling import ceiling
from core.planning.encoding import Encoder
from core.planning.outline import Outline, Sides
from core.planning.polish import polish
from core.planning.program import Program
from core.planning.reach import SLACK, Boxes, certain, reachable
from core.planning.trace import Trace
from core.planning.values import Values
from core.stl import (
    Atom,
    Constant,
    Formula,
    Not,
    fold_constants,
    horizon,
    negation_normal_form,
)
from core.stl.simplify import simplify

HOLD = 5
"""Steps for which the small program keeps a velocity."""

DIRECTIONS = (16, 32, 64)
"""Directions of outlines in programs with choices, one after the other."""

FINE_DIRECTIONS = 128
"""Directions of outlines in programs without choices."""

SHARE = 0.4
"""Share of the time that the small program may take."""

TOLERANCE = 0.01
"""Distance from the bound up to which a robustness counts as the optimum [m]."""

Status = Literal["optimal", "feasible", "infeasible", "unknown"]


@dataclass(frozen=True, eq=False)
class Setting:
    """Where a robot moves, and what its formula speaks of.

    Attributes:
        start: Position [d] at step 0 [m].
        stride: Most that a coordinate changes in a step [d] [m].
        outlines: Outlines of the regions by name, for a number of directions.
        margins: Of the named regions at positions [P, d]: [P] each [m].
    """

    start: np.ndarray
    stride: np.ndarray
    outlines: Callable[[int], Mapping[str, Outline]]
    margins: Callable[[np.ndarray], Mapping[str, np.ndarray]]


@dataclass(frozen=True, eq=False)
class ExactPlan:
    """What is proved of the robustness of a formula from a start.

    Attributes:
        status: `optimal`: no trace is more robust than this one by `TOLERANCE`; `feasible`: a
            trace that satisfies the formula, perhaps not the best; `infeasible`: none does, and
            that is proved; `unknown`: the time was up before.
        positions: The trace [T + 1, d] [m], None if there is none.
        robustness: Of the trace, by the exact semantics [m]; -inf if there is none.
        bound: That the robustness of no trace exceeds [m]; -inf for `infeasible`: none reaches 0.
        seconds: Wall-clock time.
    """

    status: Status
    positions: np.ndarray | None
    robustness: float
    bound: float
    seconds: float


def plan_exactly(formula: Formula, setting: Setting, *, seconds: float = 60.0) -> ExactPlan:
    """The most robust trace that is found within a time, and a bound for all others.

    Args:
        formula: any formula over regions that have outlines.
        setting: robot and regions.
        seconds: of search, at most; the programs are put together besides.
    """
    return _Search(formula, setting, seconds).run()


class _Found(NamedTuple):
    positions: np.ndarray | None
    robustness: float


class _Search:
    """One search; `run` is called once."""

    def __init__(self, formula: Formula, setting: Setting, seconds: float):
        self.formula = simplify(negation_normal_form(fold_constants(formula)))
        self.setting, self.seconds = setting, seconds
        self.began = time.perf_counter()
        self.steps = -(-horizon(self.formula) // HOLD) * HOLD or HOLD

    def run(self) -> ExactPlan:
        if isinstance(self.formula, Constant):
            return self._constant(self.formula.value)
        coarse = self.setting.outlines(DIRECTIONS[0])
        outer = {name: outline.outer for name, outline in coarse.items()}
        self.certain = certain(self.formula, 0)
        boxes = self._boxes(outer)
        bound = -np.inf if boxes.empty else ceiling(self.formula, boxes, outer)
        if bound < -SLACK:
            return self._answer(_Found(None, -np.inf), -np.inf)
        inner = {name: outline.inner for name, outline in coarse.items()}
        found = self._small(boxes, inner, bound)
        for directions in DIRECTIONS:
            if found.robustness >= bound - TOLERANCE or bound < -SLACK or self._left() == 0:
                break
            outlines = self.setting.outlines(directions)
            outer = {name: outline.outer for name, outline in outlines.items()}
            found, bound = self._whole(boxes, outer, bound, found)
        return self._answer(found, bound)

    def _small(self, boxes: Boxes, sides: Mapping[str, Sides], most: float) -> _Found:
        """A trace with few knots, polished."""
        program = Program()
        trace, robustness, _ = self._encoded(program, boxes, sides, most, HOLD)
        solved = program.maximise(robustness, SHARE * self._left())
        if solved.values is None:
            return _Found(None, -np.inf)
        return self._polished(trace.positions(solved.values))

    def _whole(
        self, boxes: Boxes, sides: Mapping[str, Sides], most: float, found: _Found
    ) -> tuple[_Found, float]:
        """Search all traces; returns the best and the bound."""
        program = Program()
        trace, robustness, encoder = self._encoded(program, boxes, sides, most, 1)
        start: dict[int, float] = {}
        if found.positions is not None and found.robustness >= 0:
            start = encoder.choices(found.positions, found.robustness)
        solved = program.maximise(robustness, self._left(), start)
        if solved.values is not None and solved.values[robustness] > found.robustness:
            other = self._polished(trace.positions(solved.values))
            found = max(found, other, key=lambda each: each.robustness)
        return found, min(most, solved.bound)

    def _encoded(
        self, program: Program, boxes: Boxes, sides: Mapping[str, Sides], most: float, hold: int
    ) -> tuple[Trace, int, Encoder]:
        trace = Trace(program, boxes, self.setting.start, self.setting.stride, hold)
        robustness = program.column(-SLACK, most)
        encoder = Encoder(program, trace, robustness, sides)
        encoder.require(self.formula, self.certain)
        return trace, robustness, encoder

    def _boxes(self, sides: Mapping[str, Sides]) -> Boxes:
        setting = self.setting
        return reachable(setting.start, setting.stride, self.steps, self.certain, sides)

    def _polished(self, positions: np.ndarray) -> _Found:
        fine = self.setting.outlines(FINE_DIRECTIONS)
        inner = {name: outline.inner for name, outline in fine.items()}
        return _Found(*polish(positions, self._judged, self.setting.stride, inner))

    def _judged(self, positions: np.ndarray):
        """Exact robustness of positions [T + 1, d], and the literals that decide it."""
        margins = self.setting.margins(positions)

        def value(literal: Formula, step: int) -> float:
            match literal:
                case Atom(name):
                    return float(margins[name][step])
                case Not(operand=Atom(name)):
                    return -float(margins[name][step])
            raise TypeError(f"not a literal: {literal!r}")

        values = Values(value)
        return values.of(self.formula, 0), list(values.supports(self.formula, 0))

    def _left(self) -> float:
        return max(self.seconds - self._spent(), 0.0)

    def _spent(self) -> float:
        return time.perf_counter() - self.began

    def _constant(self, value: bool) -> ExactPlan:
        if not value:
            return self._answer(_Found(None, -np.inf), -np.inf)
        still = np.repeat(self.setting.start[None], self.steps + 1, axis=0)
        return self._answer(_Found(still, np.inf), np.inf)

    def _answer(self, found: _Found, bound: float) -> ExactPlan:
        status: Status = "feasible"
        if bound < -SLACK:
            status = "infeasible"
        elif found.robustness < 0:
            status = "unknown"
        elif found.robustness >= bound - TOLERANCE:
            status = "optimal"
        kept = found if found.robustness >= 0 else _Found(None, -np.inf)
        return ExactPlan(status, *kept, bound, self._spent())
