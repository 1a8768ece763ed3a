"""The monitor table: subformula x time of one trace."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from core.monitor.signals import Signals
from core.stl import (
    Always,
    Atom,
    Constant,
    Eventually,
    Formula,
    Interval,
    Not,
    Until,
    check_columns,
    children,
    operand_windows,
    to_text,
)


@dataclass(frozen=True, eq=False)
class MonitorRow:
    """One subformula along the trace.

    Attributes:
        formula: the subformula.
        text: its canonical text.
        depth: nesting in the tree of the formula, 0 for the formula itself.
        signal: robustness [m] at the steps that the trace decides [T - horizon, at least 0].
        windows: the steps at which the subformula can matter for the verdict at step 0, as
            disjoint closed intervals in increasing order.
    """

    formula: Formula
    text: str
    depth: int
    signal: np.ndarray
    windows: tuple[Interval, ...]

    @property
    def interval(self) -> Interval | None:
        """The interval of the outermost operator, if that is a temporal one."""
        match self.formula:
            case Eventually(interval=interval) | Always(interval=interval):
                return interval
            case Until(interval=interval):
                return interval
        return None


def monitor_rows(
    formula: Formula, margins: np.ndarray, names: Sequence[str]
) -> tuple[MonitorRow, ...]:
    """Rows in the order of the tree, parents first; a repeated subformula has one row.

    A negated atom is one row, not two.

    Args:
        formula: its atoms are among the names.
        margins: [T, A] of one trace [m].
        names: of the columns.

    Raises:
        TraceError: margins of a wrong shape, or an atom without margins.
    """
    check_columns(formula, margins, names)
    signals = Signals(margins, names)
    depths: dict[Formula, int] = {}
    windows: dict[Formula, list[Interval]] = {}
    for node, depth, window in _nodes(formula, 0, Interval(0, 0)):
        depths.setdefault(node, depth)
        windows.setdefault(node, []).append(window)
    return tuple(
        MonitorRow(node, to_text(node), depth, signals[node], _union(windows[node]))
        for node, depth in depths.items()
    )


def _nodes(
    formula: Formula, depth: int, window: Interval
) -> Iterator[tuple[Formula, int, Interval]]:
    yield formula, depth, window
    if isinstance(formula, Constant | Atom):
        return
    if isinstance(formula, Not) and isinstance(formula.operand, Atom):
        return
    for child, inner in zip(children(formula), operand_windows(formula, window), strict=True):
        yield from _nodes(child, depth + 1, inner)


def _union(windows: list[Interval]) -> tuple[Interval, ...]:
    """Join intervals that overlap or are adjacent."""
    joined: list[Interval] = []
    for window in sorted(windows):
        if joined and window.start <= joined[-1].stop + 1:
            joined[-1] = Interval(joined[-1].start, max(joined[-1].stop, window.stop))
        else:
            joined.append(window)
    return tuple(joined)
