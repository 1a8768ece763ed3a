"""The largest robustness of a formula from one start, with a bound that is proved.

For a robot that moves by bounded strides, p' = p + u with |u_i| <= stride_i. Only traces that
satisfy the formula are searched, so that it is found out, too, if there is none:

1. Boxes of positions and a ceiling (`reach`, `ceiling`) may decide it already.
2. Small programs find traces: velocities are kept for some steps, and the outlines of the regions
   promise no more than they keep. The first trace of a program is polished.
3. Programs over all traces, whose outlines promise no less than anybody can have, ask for one that
   is better by `TOLERANCE`. If there is none, the optimum is proved. As obstacles grow and goals
   shrink by what is asked for, such a program is far tighter than one that only maximises.
4. Where the outlines keep bound and trace apart, outlines of more directions follow; the last ones
   are searched to the end for the best bound.

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
from core.planning.reach import Boxes, certain, reachable
from core.planning.trace import Trace
from core.planning.values import Values
from core.planning.watch import Watch
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
"""Steps for which small programs keep a velocity."""

DIRECTIONS = (16, 32, 64)
"""Directions of outlines in programs with choices, one after the other."""

FINE_DIRECTIONS = 128
"""Directions of outlines in programs without choices."""

SLACK = 1e-5
"""Traces of a robustness of no less than this below 0 are searched [m]: a solver keeps its rows up
to a tolerance of 1e-6 only, and none that satisfies must be missed."""

SHARE = 0.4
"""Share of the time that small programs may take."""

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


def plan_exactly(
    formula: Formula, setting: Setting, *, seconds: float = 60.0, watch: Watch | None = None
) -> ExactPlan:
    """The most robust trace that is found within a time, and a bound for all others.

    Args:
        formula: any formula over regions that have outlines.
        setting: robot and regions.
        seconds: of search, at most; the programs are put together besides.
        watch: told what is known, and asked whether to stop.
    """
    return _Search(formula, setting, seconds, watch or Watch()).run()


class _Found(NamedTuple):
    positions: np.ndarray | None
    robustness: float


NOTHING = _Found(None, -np.inf)


class _Solved(NamedTuple):
    positions: np.ndarray | None
    bound: float


class _Search:
    """One search; `run` is called once."""

    def __init__(self, formula: Formula, setting: Setting, seconds: float, watch: Watch):
        self.formula = simplify(negation_normal_form(fold_constants(formula)))
        self.setting, self.seconds, self.watch = setting, seconds, watch
        self.found, self.bound = NOTHING, np.inf
        self.began = time.perf_counter()
        self.steps = -(-horizon(self.formula) // HOLD) * HOLD or HOLD

    def run(self) -> ExactPlan:
        if isinstance(self.formula, Constant):
            return self._constant(self.formula.value)
        self.certain = certain(self.formula, 0)
        first = self.setting.outlines(DIRECTIONS[0])
        outer = {name: outline.outer for name, outline in first.items()}
        self.bound = self._ceiling(outer, -SLACK)
        self.watch.bound = self.bound
        if self.bound >= -SLACK:
            inner = {name: outline.inner for name, outline in first.items()}
            self._sketch(inner)
            for directions in DIRECTIONS:
                outlines = self.setting.outlines(directions)
                outer = {name: outline.outer for name, outline in outlines.items()}
                last = directions == DIRECTIONS[-1]
                self._improve(outer, first=not last)
        return self._answer()

    def _sketch(self, sides: Mapping[str, Sides]) -> None:
        """Find traces with few knots: ask for half of what there is to gain, and halve that."""
        gain, end = self.bound / 2, SHARE * self.seconds
        while gain > TOLERANCE and self._spent() < end:
            least = max(self.found.robustness, 0.0) + gain
            self._keep(self._solved(sides, HOLD, least, (end - self._spent()) / 2))
            reached = self.found.robustness >= least
            gain = (self.bound - self.found.robustness) / 2 if reached else gain / 2

    def _improve(self, sides: Mapping[str, Sides], *, first: bool) -> None:
        """Ask for better traces until there are none, these sides find none, or time is up.

        Args:
            sides: outer ones: what they do not find is not there.
            first: whether a program stops at its first trace, or at the best.
        """
        least = -np.inf
        while least < self._least() < self.bound and self._spent() < self.seconds:
            least = self._least()
            solved = self._solved(sides, 1, least, self.seconds - self._spent(), first=first)
            known = least if self.found.robustness >= 0 else -np.inf
            self.bound = self.watch.bound = min(self.bound, max(solved.bound, known))
            self._keep(solved)

    def _solved(
        self,
        sides: Mapping[str, Sides],
        hold: int,
        least: float,
        seconds: float,
        *,
        first: bool = True,
    ) -> "_Solved":
        """A trace of at least some robustness, the first or the best."""
        if self._ceiling(sides, least) < least:
            return _Solved(None, -np.inf)
        boxes, program = self._boxes(sides, least), Program()
        trace = Trace(program, boxes, self.setting.start, self.setting.stride, hold)
        robustness = program.column(least, self.bound)
        Encoder(program, trace, robustness, sides).require(self.formula, self.certain)
        stop = self.watch.stop
        solution = program.maximise(robustness, seconds, first=first, stop=stop)
        if solution.values is None:
            return _Solved(None, solution.bound)
        return _Solved(trace.positions(solution.values), solution.bound)

    def _keep(self, solved: "_Solved") -> None:
        """Polish a trace, and keep it if it is the best so far."""
        if solved.positions is not None:
            other = self._polished(solved.positions)
            self.found = max(self.found, other, key=lambda each: each.robustness)
            self.watch.robustness = self.found.robustness

    def _ceiling(self, sides: Mapping[str, Sides], least: float) -> float:
        boxes = self._boxes(sides, least)
        return -np.inf if boxes.empty else ceiling(self.formula, boxes, sides)

    def _least(self) -> float:
        """The least robustness that is still worth asking for [m]."""
        found = self.found.robustness
        return found + TOLERANCE if found >= 0 else -SLACK

    def _boxes(self, sides: Mapping[str, Sides], least: float) -> Boxes:
        setting = self.setting
        return reachable(setting.start, setting.stride, self.steps, self.certain, sides, least)

    def _polished(self, positions: np.ndarray) -> _Found:
        fine = self.setting.outlines(FINE_DIRECTIONS)
        inner = {name: outline.inner for name, outline in fine.items()}
        return _Found(*polish(positions, self._judged, self.setting.stride, inner))

    def _resting(self, found: _Found) -> _Found:
        """The same trace, but at rest from a step after which nothing depends on it."""
        positions, least = found
        if positions is None or isinstance(self.formula, Constant):
            return found
        low, high = 0, len(positions) - 1
        while low < high:
            middle = (low + high) // 2
            rested = positions.copy()
            rested[middle:] = rested[middle]
            robustness, _ = self._judged(rested)
            if robustness >= least:
                positions, high = rested, middle
                found = _Found(rested, robustness)
            else:
                low = middle + 1
        return found

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

    def _spent(self) -> float:
        """Seconds since the search began; all there are, once it is told to stop."""
        return np.inf if self.watch.stop.is_set() else time.perf_counter() - self.began

    def _constant(self, value: bool) -> ExactPlan:
        self.bound = np.inf if value else -np.inf
        if value:
            still = np.repeat(self.setting.start[None], self.steps + 1, axis=0)
            self.found = _Found(still, np.inf)
        return self._answer()

    def _answer(self) -> ExactPlan:
        found, bound = self.found, self.bound
        status: Status = "feasible"
        if bound < -SLACK:
            status, bound = "infeasible", -np.inf
        elif found.robustness < 0:
            status, found = "unknown", NOTHING
        elif bound <= self._least():
            status = "optimal"
        found = self._resting(found)
        return ExactPlan(status, *found, bound, time.perf_counter() - self.began)
