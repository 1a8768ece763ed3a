"""The smallest longer windows that leave time for everything."""

from collections.abc import Callable

from core.stl import Eventually, Formula, Interval, Until, to_text
from core.task.feasibility.bounds import UNBOUNDED, Bounds
from core.task.feasibility.obligations import Node, Obligations
from core.task.feasibility.search import OpenQuestionError, Search

MOST_WINDOWS = 3
"""Windows that advice lengthens."""

LONGEST = 2000
"""Steps by which a window is lengthened at most."""


def remedy(plan: Search, cores: list[tuple[int, ...]]) -> str:
    """`F_[0:18](C)`: longer windows with which a plan has time; empty if that is not simple.

    One window is lengthened if that helps, else all that matter.
    """
    obligations = plan.conflicts.obligations
    nodes = sorted({node for core in cores for i in core for node in _nodes(obligations, i)})
    sources = [obligations.nodes[node - 1].source for node in nodes]
    if not 0 < len(nodes) <= MOST_WINDOWS or not all(map(_is_simple, sources)):
        return ""
    every = [node.source for node in obligations.nodes]
    if any(sum(other is source for other in every) > 1 for source in sources):
        return ""  # asked for at several steps
    try:
        for chosen in [[node] for node in nodes] + [nodes]:
            highs = _lengthened(plan, chosen)
            if highs:
                return " and ".join(
                    _text(obligations.nodes[node - 1], high) for node, high in highs.items()
                )
    except OpenQuestionError:
        pass
    return ""


def _nodes(obligations: Obligations, i: int) -> set[int]:
    """Unknown steps that the window of a hold depends on."""
    found: set[int] = set()
    for instant in (obligations.holds[i].start, obligations.holds[i].end):
        node = instant.node
        while node:
            found.add(node)
            node = obligations.nodes[node - 1].after.node
    return found


def _is_simple(source: Formula) -> bool:
    return isinstance(source, Eventually | Until)


def _lengthened(plan: Search, nodes: list[int]) -> dict[int, int]:
    """Ends of the windows of some nodes that help; empty if none do.

    All are lengthened by as many steps as are needed, then each is shortened again.
    """
    obligations = plan.conflicts.obligations
    given = {node: obligations.nodes[node - 1].high for node in nodes}

    def helps(highs: dict[int, int]) -> bool:
        return plan.solution(bounds=_with(obligations, highs)) is not None

    def lengthened(steps: int) -> dict[int, int]:
        return {node: high + steps for node, high in given.items()}

    steps = 1
    while not helps(lengthened(steps)):
        steps *= 2
        if steps > LONGEST:
            return {}
    highs = lengthened(_least(steps // 2 + 1, steps, lambda more: helps(lengthened(more))))
    for node in nodes if len(nodes) > 1 else ():
        high = highs[node]
        while high > given[node] and helps(highs | {node: high - 1}):
            high -= 1
        highs[node] = high
    return {node: high for node, high in highs.items() if high > given[node]}


def _least(low: int, high: int, good: Callable[[int], bool]) -> int:
    """Least number in [low, high] that is good, where `high` and all above a good one are."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if good(middle) else (middle + 1, high)
    return low


def _with(obligations: Obligations, highs: dict[int, int]) -> Bounds:
    """The formula's bounds with other ends of windows."""
    nodes = [
        Node(node.after, node.low, highs.get(i, node.high), node.source)
        for i, node in enumerate(obligations.nodes, start=1)
    ]
    return Bounds.of(Obligations(nodes, obligations.holds, obligations.choices))


def _text(node: Node, high: int) -> str:
    """The temporal formula of a node with another end of its window."""
    assert high < UNBOUNDED
    match node.source:
        case Eventually(interval=(low, _), operand=operand):
            return to_text(Eventually(Interval(low, high), operand))
        case Until(interval=(low, _), left=left, right=right):
            return to_text(Until(Interval(low, high), left, right))
    raise TypeError(f"no window: {to_text(node.source)}")
