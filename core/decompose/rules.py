"""The rules that reduce a formula to tasks (paper Sec. 4.1, extended).

Top-down from Reach(phi, 0), in negation normal form, simplified and without constants. State
formulas (no temporal operator) count as one predicate mu. At time e:

    mu                        Reach(mu, e)
    phi1 & phi2               both
    phi1 | phi2               a branch variable, one alternative for each disjunct
    F_[a:b] phi               a new tau in [a, b]; phi at e + tau
    G_[a:b] phi               phi throughout [e+a, e+b], see `throughout`
    phi1 U_[a:b] phi2         a new tau in [a, b]; phi2 at e + tau; phi1 throughout [e, e+tau]
    !(phi1 U_[a:b] phi2)      a branch: !phi2 throughout [e+a, e+b]; or a new s in [0, b] with
                              !phi1 at e + s and !phi2 throughout [e+a, e+s-1]

Each rule is an equivalence of monotone formulas over their literals, so it holds for every
threshold on the margins: the robustness of the formula is the maximum over admissible schedules
of the minimum over active tasks of the margin of the predicate in the window. Where a number of
visits is chosen it is that with enough visits, and never more otherwise.
"""

from dataclasses import replace

from core.decompose.collector import Window
from core.decompose.grouping import grouped
from core.decompose.model import Decomposition, DecompositionError, Guards, TimeExpr, TreeNode
from core.decompose.naming import name_nodes
from core.decompose.throughout import Throughout
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
    simplify,
    to_text,
)


def decompose(formula: Formula, *, visits_extra: int = 0) -> Decomposition:
    """Reduce a formula to tasks.

    Args:
        formula: any formula.
        visits_extra: visits in each chain, and episodes, beyond the least number that can work,
            up to the number that is enough for every trace. More of them let a trace be irregular
            and cost a time variable or two each.

    Raises:
        DecompositionError: the formula needs too much, or can never hold.

    """
    if visits_extra < 0:
        raise UserError(f"visits_extra is {visits_extra}; it must be 0 or more")
    normal = simplify(negation_normal_form(fold_constants(formula)))
    if normal == Constant(False):
        raise DecompositionError(formula, "it can never hold, whatever the robot does")
    rules = _Rules(visits_extra)
    tree, names = name_nodes(rules.root(normal), rules.variables)
    return Decomposition(
        formula=formula,
        variables=tuple(rules.variables),
        tasks=tuple(rules.tasks),
        requirements=tuple(rules.requirements),
        tree=tree,
        horizon=horizon(formula),
        names=names,
        visits_missing=rules.visits_missing,
        visits_extra=visits_extra,
        one_sided=rules.one_sided,
    )


class _Rules(Throughout):
    """The rules for a formula at one step."""

    def root(self, formula: Formula) -> TreeNode:
        """Build the whole tree."""
        now = TimeExpr()
        if formula == Constant(True):
            return TreeNode("", formula)
        if is_state_formula(formula):
            return self.reach(formula, now, ())
        return TreeNode("", formula, children=tuple(self._parts(formula, now, ())))

    def node(
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
            return [self.reach(formula, time, guards)]
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
                tau = self.time_variable(interval, formula, guards)
                end = time.plus(0, tau)
                parts = [self.node(goal, end, guards, tau)]
                if isinstance(formula, Until):
                    parts += self.throughout(formula.left, Window(time, end), guards, formula)
                return parts
            case Always(interval=(a, b), operand=operand):
                window = Window(time.plus(a), time.plus(b))
                return self.throughout(operand, window, guards, formula)
            case Not(operand=Until() as until):
                return self._negated_until(formula, until, time, guards)
        raise TypeError(f"not in negation normal form: {to_text(formula)}")

    def _conjunct(self, formula: Formula, time: TimeExpr, guards: Guards) -> list[TreeNode]:
        """Parts of a member of a conjunction; alternatives stay together under their own node."""
        if isinstance(formula, Or | Not) and not is_state_formula(formula):
            return [self.node(formula, time, guards)]
        return self._parts(formula, time, guards)

    def _branch(self, formula: Or, time: TimeExpr, guards: Guards) -> list[TreeNode]:
        disjuncts = grouped(formula)
        labels = tuple(to_text(disjunct) for disjunct in disjuncts)
        branch = self.branch_variable(labels, formula, guards)
        return [
            self.node(disjunct, time, (*guards, (branch, value)), branch, value)
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
        fails = simplify(negation_normal_form(Not(until.left)))
        never = simplify(negation_normal_form(Not(until.right)))
        split = not is_state_formula(never)
        domains = [Interval(0, a), Interval(a + 1, b)] if split and a < b else [Interval(0, b)]
        whole = simplify(Always(until.interval, never, span=formula.span))
        labels = (to_text(whole), *(to_text(Eventually(each, fails)) for each in domains))
        branch = self.branch_variable(labels, formula, guards)
        alternatives = [self.node(whole, time, (*guards, (branch, 0)), branch, 0)]
        for value, domain in enumerate(domains, start=1):
            inner = (*guards, (branch, value))
            s = self.time_variable(domain, formula, inner)
            failure = time.plus(0, s)
            parts = [self.node(fails, failure, inner, s)]
            if not (split and value == 1):
                window = Window(time.plus(a), failure.plus(-1))
                parts += self.throughout(never, window, inner, formula)
            node = TreeNode("", formula, None, branch, tuple(parts), value, time)
            alternatives.append(node)
        return alternatives
