"""A mixed-integer linear program, put together row by row and solved by HiGHS.

HiGHS is called through its own package: the version that scipy 1.17 carries breaks off with an
error on some of our programs, and `scipy.optimize.milp` holds back Ctrl-C until its time is up.
"""

import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import highspy
import numpy as np

INFINITY = math.inf

STOPPED = (
    highspy.HighsModelStatus.kTimeLimit,
    highspy.HighsModelStatus.kSolutionLimit,
    highspy.HighsModelStatus.kInterrupt,
)
"""Ends of a search whose solution and bound count although it was not brought to its end."""


INTERRUPTS = (
    highspy.cb.HighsCallbackType.kCallbackMipInterrupt,
    highspy.cb.HighsCallbackType.kCallbackSimplexInterrupt,
)

_Callbacks = highspy.Highs.__mro__[1]
"""The binding of HiGHS's own callbacks, below those of its Python package."""


class _Solver(highspy.Highs):
    """HiGHS without the banner that it prints when its callbacks are set up."""

    def enableCallbacks(self) -> None:  # noqa: N802
        """Set up none."""

    def heed(self, stop: threading.Event) -> None:
        """Break off soon after an event is set."""

        def asked(kind: object, message: str, known: object, answer: Any, data: object) -> None:
            del kind, message, known, data
            if answer is not None and stop.is_set():
                answer.user_interrupt = True

        _Callbacks.setCallback(self, asked, None)
        for kind in INTERRUPTS:
            _Callbacks.startCallback(self, kind)


@dataclass(frozen=True, eq=False)
class Solution:
    """What became of a maximisation."""

    values: np.ndarray | None
    """Of all columns; None if no solution was found."""
    bound: float
    """That no solution exceeds; -inf if it is proved that there is none."""


@dataclass
class Program:
    """Columns with bounds and rows `low <= a . x <= high`, to which more can be added."""

    lows: list[float] = field(default_factory=list)
    highs: list[float] = field(default_factory=list)
    integer: list[bool] = field(default_factory=list)
    rows: list[tuple[float, float]] = field(default_factory=list)
    starts: list[int] = field(default_factory=lambda: [0])
    indices: list[int] = field(default_factory=list)
    entries: list[float] = field(default_factory=list)

    def column(self, low: float, high: float, *, integer: bool = False) -> int:
        """Add a column; returns its index."""
        self.lows.append(low)
        self.highs.append(high)
        self.integer.append(integer)
        return len(self.lows) - 1

    def row(self, terms: Mapping[int, float], low: float, high: float) -> None:
        """Add a row."""
        kept = {column: entry for column, entry in terms.items() if entry != 0}
        self.indices += kept.keys()
        self.entries += kept.values()
        self.starts.append(len(self.indices))
        self.rows.append((low, high))

    def maximise(
        self,
        column: int,
        seconds: float,
        *,
        first: bool = False,
        stop: threading.Event | None = None,
    ) -> Solution:
        """Maximise a column on one thread.

        Args:
            column: what is maximised.
            seconds: of search, at most.
            first: whether to stop at the first solution.
            stop: ends the search once it is set; Ctrl-C sets it.
        """
        solver = _Solver()
        solver.setOptionValue("output_flag", False)
        solver.setOptionValue("threads", 1)
        solver.setOptionValue("time_limit", max(seconds, 0.01))
        if first:
            solver.setOptionValue("mip_max_improving_sols", 1)
        solver.passModel(self._model(column))
        _run(solver, stop or threading.Event())
        return _solution(solver)

    def _model(self, column: int) -> highspy.HighsLp:
        model, count = highspy.HighsLp(), len(self.lows)
        model.num_col_, model.num_row_ = count, len(self.rows)
        model.sense_ = highspy.ObjSense.kMaximize
        model.col_cost_ = np.eye(1, count, column)[0]
        model.col_lower_, model.col_upper_ = np.array(self.lows), np.array(self.highs)
        low, high = np.array(self.rows, float).reshape(-1, 2).T
        model.row_lower_, model.row_upper_ = low, high
        kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
        model.integrality_ = [kinds[whole] for whole in self.integer]
        matrix = model.a_matrix_
        matrix.format_ = highspy.MatrixFormat.kRowwise
        matrix.num_col_, matrix.num_row_ = count, len(self.rows)
        matrix.start_ = np.array(self.starts, np.int32)
        matrix.index_ = np.array(self.indices, np.int32)
        matrix.value_ = np.array(self.entries, float)
        return model


def _run(solver: _Solver, stop: threading.Event) -> None:
    """Solve on a thread: Ctrl-C reaches a thread that waits, but none that HiGHS has taken over.

    The thread is waited for in any case: one that is still in HiGHS when Python ends takes the
    process down.
    """
    solver.heed(stop)
    ended = threading.Event()  # an interrupted `join` of Python 3.11 takes the thread for ended

    def solve() -> None:
        try:
            solver.run()
        finally:
            ended.set()

    try:
        threading.Thread(target=solve, daemon=True).start()
        ended.wait()
    except KeyboardInterrupt:
        stop.set()
        ended.wait()
        raise


def _solution(solver: highspy.Highs) -> Solution:
    """What HiGHS says; nothing is believed of a solver that has broken off."""
    status, info = solver.getModelStatus(), solver.getInfo()
    if status == highspy.HighsModelStatus.kInfeasible:
        return Solution(None, -INFINITY)
    solved = status == highspy.HighsModelStatus.kOptimal
    if not solved and status not in STOPPED:
        return Solution(None, INFINITY)
    found = info.primal_solution_status == highspy.SolutionStatus.kSolutionStatusFeasible
    values = np.array(solver.getSolution().col_value) if found else None
    if any(kind == highspy.HighsVarType.kInteger for kind in solver.getLp().integrality_):
        return Solution(values, info.mip_dual_bound)
    return Solution(values, info.objective_function_value if solved else INFINITY)
