"""Operators without an upper bound reach as far as the scene's horizon T allows.

`F A` is `F_[0:T](A)`. Those nested in one another share the steps: on a path to an atom with n
open operators whose other bounds add up to S, each gets (T - S) / n steps, rounded down; of
several paths the tightest counts. So the whole formula is decided by step T.
"""

from dataclasses import replace
from typing import TypeGuard

from core.stl.syntax import (
    Always,
    Eventually,
    Formula,
    Interval,
    Span,
    Until,
    children,
    with_children,
)

OPEN = -1
"""Upper bound of an interval that `closed` has yet to close."""

Temporal = Eventually | Always | Until


class NoRoomError(ValueError):
    """An open operator for which no step is left."""

    def __init__(self, operator: Temporal, used: int):
        self.operator = operator
        self.used = used
        super().__init__(f"{used} steps are used")


def open_operators(formula: Formula) -> list[Temporal]:
    """Operators that have no upper bound yet, parents first."""
    found, pending = [], [formula]
    while pending:
        node = pending.pop()
        if _is_open(node):
            found.append(node)
        pending += reversed(children(node))
    return found


def closed(formula: Formula, horizon: int) -> tuple[Formula, dict[Span, Interval]]:
    """Give every open operator its upper bound.

    Args:
        formula: its nodes have spans.
        horizon: T [steps].

    Returns:
        The formula, and the new intervals by the spans of their operators.

    Raises:
        NoRoomError: the bounds that were given leave no step.
    """
    steps: dict[Span, int] = {}
    _share(formula, horizon, 0, [], steps)
    intervals: dict[Span, Interval] = {}
    return _close(formula, steps, intervals), intervals


def _share(
    node: Formula, horizon: int, used: int, above: list[Temporal], steps: dict[Span, int]
) -> None:
    """Lower `steps` of the open operators above an atom to what the path to it leaves."""
    parts = children(node)
    if isinstance(node, Eventually | Always | Until):
        start, stop = node.interval
        used += start if stop == OPEN else stop
        above = [*above, node] if stop == OPEN else above
    if not parts and above:
        left = (horizon - used) // len(above)
        if left < 1:
            raise NoRoomError(above[-1], used)
        for operator in above:
            steps[_place(operator)] = min(left, steps.get(_place(operator), left))
    for part in parts:
        _share(part, horizon, used, above, steps)


def _close(node: Formula, steps: dict[Span, int], intervals: dict[Span, Interval]) -> Formula:
    parts = tuple(_close(part, steps, intervals) for part in children(node))
    node = with_children(node, parts)
    if not _is_open(node):
        return node
    start = node.interval.start
    interval = intervals[_place(node)] = Interval(start, start + steps[_place(node)])
    return replace(node, interval=interval)


def _is_open(node: Formula) -> TypeGuard[Temporal]:
    return isinstance(node, Eventually | Always | Until) and node.interval.stop == OPEN


def _place(operator: Temporal) -> Span:
    assert operator.span is not None
    return operator.span
