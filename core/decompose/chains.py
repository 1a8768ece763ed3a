"""What is kept up throughout a window by visits and episodes (see `visits` for how many).

Throughout [s, t], with mu a state formula:

    F_[c:d] phi               visits v_1 <= ... <= v_n to phi: v_1 in [s+c, s+d], gaps of at most
                              d-c+1, v_n in [t+c, t+d]
    phi1 U_[c:d] phi          the same, and phi1 throughout [s, v_n]
    mu | F_[c:d] phi          mu throughout; or visits v_1 <= ... <= v_n <= t+d to phi, and mu
                              wherever none is due: [s, v_1-d-1], [v_k-c+1, v_{k+1}-d-1],
                              [v_n-c+1, t]
    mu | G_[c:d] phi          mu throughout; or episodes [p_k, q_k] in [s, t], p_1 <= ... <= p_n:
                              phi throughout [p_k+c, q_k+d], and mu between the episodes
    mu | phi1 U_[c:d] phi     the same with phi at v_k in [p_k+c, p_k+d], phi1 throughout
                              [p_k, v_k], and q_k = v_k - c
    mu | G_[e:e] U            the same, e steps later

A step x in an episode is served by it, and all others satisfy mu: every rule is sound. Conversely
a trace that satisfies the formula has such visits or episodes, if n is large enough.
"""

from abc import ABC, abstractmethod
from dataclasses import replace

from core.decompose.collector import Collector, Window
from core.decompose.model import Guards, TimeExpr, TreeNode
from core.decompose.visits import (
    chain_of_visits,
    enough_episodes,
    enough_responses,
    enough_visits,
    least_visits,
)
from core.stl import Always, Eventually, Formula, Interval, Or, Until, to_text


class Chains(Collector, ABC):
    """Rules with a number of visits or episodes that is chosen."""

    def __init__(self, visits_extra: int) -> None:
        super().__init__()
        self.visits_missing = 0
        self._visits_extra = visits_extra

    @abstractmethod
    def node(
        self, formula: Formula, time: TimeExpr, guards: Guards, variable: int | None = None
    ) -> TreeNode:
        """Tree of a formula at a step."""

    @abstractmethod
    def throughout(
        self, formula: Formula, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Trees of a formula at every step of a window."""

    def recurrence(
        self, formula: Eventually | Until, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """F or U throughout a window that is not empty."""
        goal = formula.right if isinstance(formula, Until) else formula.operand
        (c, d), lengths = formula.interval, self.difference(window.end, window.start)
        width, longest = d - c + 1, lengths.stop
        count = self._count(least_visits(longest, width), enough_visits(longest, width), source)
        begin = window.start.offset
        chain = chain_of_visits(Interval(begin, begin + longest), formula.interval, count)
        fixed = lengths.start == lengths.stop
        first, gap = (chain.first, chain.gap) if fixed else ((begin + c, begin + d), (0, width))
        nodes, visit = [], TimeExpr(0, window.start.variables)
        for number in range(count):
            domain = Interval(*(gap if number else first))
            tau = self.time_variable(domain, source, guards)
            visit = visit.plus(0, tau)
            nodes.append(self.node(goal, visit, guards, tau))
        self.require(visit, window.end, guards, minimum=c, maximum=d)
        if isinstance(formula, Until):
            nodes += self.throughout(formula.left, Window(window.start, visit), guards, source)
        return nodes

    def response(
        self, steady: Formula, due: Eventually, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Visits to what is due, and `steady` wherever none is; the window is not empty."""
        (c, d), longest = due.interval, self.difference(window.end, window.start).stop
        count = self._count(1, enough_responses(longest, d - c + 1), source)
        nodes, begin, free = [], window.start.offset, window.start
        visit = TimeExpr(0, window.start.variables)
        for number in range(count):
            span = longest + d - c
            first = 0 if number else begin + c
            domain = Interval(first, first + span)
            tau = self.time_variable(domain, source, guards)
            visit = visit.plus(0, tau)
            nodes.append(self.node(due.operand, visit, guards, tau))
            before = Window(free, visit.plus(-d - 1))
            nodes += self._unless_empty(steady, before, guards, source)
            free = visit.plus(1 - c)
        self.require(visit, window.end, guards, maximum=d)
        return nodes + self._unless_empty(steady, Window(free, window.end), guards, source)

    def episodes(
        self, steady: Formula, due: Always | Until, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Episodes of what is due, and `steady` between them; the window is not empty."""
        shift, due = _shifted(due)
        (c, d), longest = due.interval, self.difference(window.end, window.start).stop
        until = isinstance(due, Until)
        enough = longest + 1 if until else enough_episodes(longest, d - c + 1)
        nodes, free = [], window.start
        start, offset = TimeExpr(0, window.start.variables), window.start.offset
        for number in range(self._count(1, enough, source, each=2)):
            first = 0 if number else offset
            begins = self.time_variable(Interval(first, first + longest), source, guards)
            start = start.plus(0, begins)
            asked = start.plus(shift)
            lasts = Interval(c, d) if until else Interval(0, longest)
            tau = self.time_variable(lasts, source, guards)
            if isinstance(due, Until):
                met = asked.plus(0, tau)
                parts = [self.node(due.right, met, guards, tau)]
                parts += self.throughout(due.left, Window(asked, met), guards, source)
                last = met.plus(-c - shift)
            else:
                last = start.plus(0, tau)
                self.require(last, window.end, guards, maximum=0)
                held = Window(start.plus(c), last.plus(d))
                parts = self.throughout(due.operand, held, guards, source)
                parts = [_introduced(due.operand, held, parts, tau)]
            nodes.append(TreeNode("", due, None, begins, tuple(parts), time=asked))
            nodes += self._unless_empty(steady, Window(free, start.plus(-1)), guards, source)
            free = last.plus(1)
        if until:
            self.require(start, window.end, guards, maximum=0)
        return nodes + self._unless_empty(steady, Window(free, window.end), guards, source)

    def steady_or_due(
        self, steady: Formula, due: Formula, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """A branch: `steady` throughout, or with visits or episodes of what is due."""
        whole = Or((steady, due), span=source.span)
        branch = self.branch_variable((to_text(steady), to_text(due)), source, guards)
        kept, served = ((*guards, (branch, value)) for value in (0, 1))
        alternatives = (
            self.throughout(steady, window, kept, source),
            self.due(steady, due, window, served, source),
        )
        return [
            alternative(whole, window, parts, branch, value)
            for value, parts in enumerate(alternatives)
        ]

    def due(
        self, steady: Formula, due: Formula, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Visits or episodes of what is due, at least one."""
        if isinstance(due, Eventually):
            return self.response(steady, due, window, guards, source)
        assert isinstance(due, Always | Until)
        return self.episodes(steady, due, window, guards, source)

    def _unless_empty(
        self, steady: Formula, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Steady throughout a window that may be empty, and is left out if it always is."""
        if self.difference(window.end, window.start).stop < 0:
            return []
        return self.throughout(steady, window, guards, source)

    def _count(self, least: int, enough: int, source: Formula, each: int = 1) -> int:
        """The number of visits or episodes, which need so many variables each."""
        count = min(enough, least + self._visits_extra)
        self.check_variables(count * each, source)
        self.visits_missing = max(self.visits_missing, enough - count)
        return count


def alternative(
    formula: Formula, window: Window, parts: list[TreeNode], branch: int, value: int
) -> TreeNode:
    """An alternative of a branch on how a formula holds throughout a window."""
    return TreeNode("", formula, None, branch, tuple(parts), value, window.start, window.end)


def _shifted(due: Always | Until) -> tuple[int, Always | Until]:
    """`G_[k:k](phi1 U phi2)` as k and the until, which is due k steps later."""
    if isinstance(due, Always) and due.interval.start == due.interval.stop:
        if isinstance(due.operand, Until):
            return due.interval.start, due.operand
    return 0, due


def _introduced(formula: Formula, window: Window, parts: list[TreeNode], variable: int) -> TreeNode:
    """One node for the parts of a formula throughout a window, which introduces a variable."""
    if len(parts) == 1 and parts[0].variable is None:
        return replace(parts[0], variable=variable)
    return TreeNode("", formula, None, variable, tuple(parts), None, *window)
