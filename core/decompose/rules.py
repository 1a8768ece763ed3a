"""The rules that reduce a formula to tasks (paper Sec. 4.1, extended).

Top-down from Reach(phi, 0), in negation normal form, without constants. State formulas (no
temporal operator) count as one predicate mu. At time e:

    mu                        Reach(mu, e)
    phi1 & phi2               both
    phi1 | phi2               a branch variable, one alternative for each disjunct
    F_[a:b] phi               a new tau in [a, b]; phi at e + tau
    G_[a:b] phi               phi throughout [e+a, e+b]
    phi1 U_[a:b] phi2         a new tau in [a, b]; phi2 at e + tau; phi1 throughout [e, e+tau]
    !(phi1 U_[a:b] phi2)      a branch: !phi2 throughout [e+a, e+b]; or a new s in [0, b] with
                              !phi1 at e + s and !phi2 throughout [e+a, e+s-1]

and throughout a window [s, t]:

    mu                        Inv(mu, [s, t])
    phi1 & phi2               both
    G_[a:b] phi               phi throughout [s+a, t+b]
    F_[c:d] phi               a chain of visits, see `visits` (windows of fixed length only)
    any phi if s = t          phi at s

Everything else raises a `DecompositionError`. Each rule is an equivalence of monotone formulas
over their literals, so it holds for every threshold on the margins: the robustness of the formula
is the maximum over admissible schedules of the minimum over active tasks of the margin of the
predicate in the window (for G(F) only with enough visits; never more otherwise).
"""

from dataclasses import replace
from typing import Literal

from core.decompose.grouping import flat, grouped
from core.decompose.model import (
    Decomposition,
    DecompositionError,
    Guards,
    Kind,
    Requirement,
    Task,
    TimeExpr,
    TreeNode,
    Variable,
)
from core.decompose.naming import name_nodes
from core.decompose.refusal import refusal
from core.decompose.visits import chain_of_visits, enough_visits, least_visits
from core.errors import UserError
from core.stl import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Until,
    fold_constants,
    horizon,
    is_state_formula,
    negation_normal_form,
    to_text,
    walk,
)

MAX_VARIABLES = 1000
"""Where nested chains of visits stop growing; far above what can be planned with."""


def decompose(formula: Formula, *, visits_extra: int = 0) -> Decomposition:
    """Reduce a formula to tasks.

    Args:
        formula: any formula.
        visits_extra: visits in each chain of a G(F) beyond the least number that can work. More
            visits let a trace be irregular and cost a time variable each.

    Raises:
        DecompositionError: a subformula is beyond the rules, or the formula can never hold.

    """
    if visits_extra < 0:
        raise UserError(f"visits_extra must be 0 or more, given {visits_extra}")
    normal = negation_normal_form(fold_constants(formula))
    if normal == Constant(False):
        raise DecompositionError(formula, "it can never hold, whatever the robot does")
    builder = _Builder(visits_extra)
    tree, names = name_nodes(builder.root(normal), builder.variables)
    return Decomposition(
        formula=formula,
        variables=tuple(builder.variables),
        tasks=tuple(builder.tasks),
        requirements=tuple(builder.requirements),
        tree=tree,
        horizon=horizon(formula),
        names=names,
        visits_missing=builder.visits_missing,
    )


class _Builder:
    """Collects variables, tasks and requirements while the tree is built, left to right."""

    def __init__(self, visits_extra: int):
        self.variables: list[Variable] = []
        self.tasks: list[Task] = []
        self.requirements: list[Requirement] = []
        self.visits_missing = 0
        self._visits_extra = visits_extra

    def root(self, formula: Formula) -> TreeNode:
        """Build the whole tree."""
        now = TimeExpr()
        if formula == Constant(True):
            return TreeNode("", formula)
        if is_state_formula(formula):
            return self._reach(formula, now, ())
        return TreeNode("", formula, children=tuple(self._parts(formula, now, ())))

    def _node(
        self,
        formula: Formula,
        time: TimeExpr,
        guards: Guards,
        variable: int | None = None,
        choice: int | None = None,
    ) -> TreeNode:
        """Tree of Reach(formula, time); a node whose only part needs no variable is that part."""
        parts = self._parts(formula, time, guards)
        if len(parts) == 1 and parts[0].variable is None:
            return replace(parts[0], variable=variable, choice=choice)
        return TreeNode("", formula, None, variable, tuple(parts), choice, time)

    def _parts(self, formula: Formula, time: TimeExpr, guards: Guards) -> list[TreeNode]:
        """Trees that together amount to Reach(formula, time)."""
        if is_state_formula(formula):
            return [self._reach(formula, time, guards)]
        match formula:
            case And():
                return [
                    part
                    for operand in grouped(formula)
                    for part in self._conjunct(operand, time, guards)
                ]
            case Or():
                return self._branch(formula, time, guards)
            case Eventually(interval=interval, operand=goal) | Until(interval=interval, right=goal):
                tau = self._time_variable(interval, formula, guards)
                end = time.plus(0, tau)
                parts = [self._node(goal, end, guards, tau)]
                if isinstance(formula, Until):
                    parts += self._throughout(formula.left, time, end, guards, formula)
                return parts
            case Always(interval=(a, b), operand=operand):
                return self._throughout(operand, time.plus(a), time.plus(b), guards, formula)
            case Not(operand=Until() as until):
                return self._negated_until(formula, until, time, guards)
        raise TypeError(f"not in negation normal form: {to_text(formula)}")

    def _conjunct(self, formula: Formula, time: TimeExpr, guards: Guards) -> list[TreeNode]:
        """Parts of a member of a conjunction; alternatives stay together under their own node."""
        if isinstance(formula, Or | Not) and not is_state_formula(formula):
            return [self._node(formula, time, guards)]
        return self._parts(formula, time, guards)

    def _branch(self, formula: Or, time: TimeExpr, guards: Guards) -> list[TreeNode]:
        disjuncts = grouped(formula)
        labels = tuple(to_text(disjunct) for disjunct in disjuncts)
        branch = self._branch_variable(labels, formula, guards)
        return [
            self._node(disjunct, time, (*guards, (branch, value)), branch, value)
            for value, disjunct in enumerate(disjuncts)
        ]

    def _negated_until(
        self, formula: Not, until: Until, time: TimeExpr, guards: Guards
    ) -> list[TreeNode]:
        """One alternative where phi2 never holds, others where phi1 fails first.

        A temporal !phi2 reaches beyond its window, so that an empty window would not be vacuous:
        there the alternative is split into s <= a (no window) and s > a (a window).
        """
        a, b = until.interval
        fails = negation_normal_form(Not(until.left))
        never = negation_normal_form(Not(until.right))
        split = not is_state_formula(never)
        domains = [Interval(0, a), Interval(a + 1, b)] if split and a < b else [Interval(0, b)]
        whole = Always(until.interval, never, span=formula.span)
        labels = (to_text(whole), *(to_text(Eventually(each, fails)) for each in domains))
        branch = self._branch_variable(labels, formula, guards)
        alternatives = [self._node(whole, time, (*guards, (branch, 0)), branch, 0)]
        for value, domain in enumerate(domains, start=1):
            inner = (*guards, (branch, value))
            s = self._time_variable(domain, formula, inner)
            failure = time.plus(0, s)
            parts = [self._node(fails, failure, inner, s)]
            if not (split and value == 1):
                last = failure.plus(-1)
                parts += self._throughout(never, time.plus(a), last, inner, formula)
            node = TreeNode("", formula, None, branch, tuple(parts), value, time)
            alternatives.append(node)
        return alternatives

    def _throughout(
        self, formula: Formula, start: TimeExpr, end: TimeExpr, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Trees that amount to the formula at every step of [start, end].

        The window is never empty unless the formula is a state formula.
        """
        match formula:
            case And():
                return [
                    node
                    for operand in flat(formula)
                    for node in self._throughout(operand, start, end, guards, source)
                ]
            case _ if is_state_formula(formula):
                return [self._invariance(formula, start, end, guards, source)]
            case Always(interval=(a, b), operand=operand):
                return self._throughout(operand, start.plus(a), end.plus(b), guards, source)
            case _ if start == end:
                return self._conjunct(formula, start, guards)
            case Eventually() if start.variables == end.variables:
                return self._visits(formula, start, end, guards, source)
        raise DecompositionError(formula, refusal(formula), near=source)

    def _visits(
        self, formula: Eventually, start: TimeExpr, end: TimeExpr, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Plan a chain of visits for F throughout a window of fixed length."""
        length, (c, d) = end.offset - start.offset, formula.interval
        count = least_visits(length, d - c + 1) + self._visits_extra
        missing = enough_visits(length, d - c + 1) - count
        self.visits_missing = max(self.visits_missing, missing)
        window = Interval(start.offset, end.offset)
        chain = chain_of_visits(window, formula.interval, count)
        nodes, chosen = [], []
        for visit in range(count):
            domain = chain.first if visit == 0 else chain.gap
            chosen.append(self._time_variable(Interval(*domain), source, guards))
            time = TimeExpr(0, (*start.variables, *chosen))
            nodes.append(self._node(formula.operand, time, guards, chosen[-1]))
        if not (chain.always_ends_late_enough and chain.never_ends_too_late):
            maximum = None if chain.never_ends_too_late else chain.maximum
            last = TimeExpr(0, tuple(chosen))
            self.requirements.append(Requirement(last, chain.minimum, guards, maximum))
        return nodes

    def _reach(self, predicate: Formula, time: TimeExpr, guards: Guards) -> TreeNode:
        self.tasks.append(Task(Kind.REACH, predicate, time, time, guards, predicate))
        label = f"Reach({to_text(predicate)}, {time.text(self.variables)})"
        return TreeNode(label, predicate, len(self.tasks) - 1, time=time)

    def _invariance(
        self, predicate: Formula, start: TimeExpr, end: TimeExpr, guards: Guards, source: Formula
    ) -> TreeNode:
        positive = not any(isinstance(node, Not) for node in walk(predicate))
        kind = Kind.STAY if positive else Kind.INVARIANT
        self.tasks.append(Task(kind, predicate, start, end, guards, source))
        window = f"[{start.text(self.variables)}, {end.text(self.variables)}]"
        label = f"Inv({to_text(predicate)}, {window})"
        return TreeNode(label, predicate, len(self.tasks) - 1, time=start)

    def _time_variable(self, domain: Interval, source: Formula, guards: Guards) -> int:
        return self._variable("time", domain, (), source, guards)

    def _branch_variable(self, labels: tuple[str, ...], source: Formula, guards: Guards) -> int:
        return self._variable("branch", Interval(0, len(labels) - 1), labels, source, guards)

    def _variable(
        self,
        kind: Literal["time", "branch"],
        domain: Interval,
        labels: tuple[str, ...],
        source: Formula,
        guards: Guards,
    ) -> int:
        if len(self.variables) == MAX_VARIABLES:
            raise DecompositionError(source, f"it needs more than {MAX_VARIABLES} variables")
        number = 1 + sum(variable.kind == kind for variable in self.variables)
        name = f"{'t' if kind == 'time' else 'b'}{number}"
        self.variables.append(Variable(name, *domain, kind, labels, source, guards))
        return len(self.variables) - 1
