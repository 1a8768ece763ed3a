"""The rules for a formula throughout a window that is not empty.

    mu                        Inv(mu, [s, t])
    phi1 & phi2               both
    G_[a:b] phi               phi throughout [s+a, t+b]
    any phi if s = t          phi at s
    F, phi1 U phi2            visits, see `chains`
    mu | F, G or U            visits or episodes, see `chains`
    phi | (psi1 & psi2)       phi | psi1 throughout, and phi | psi2 throughout
    !(phi1 U phi2)            as the disjunction in `released`

A disjunction of several temporal formulas is unrolled over a short window: a choice at each step.
Over a longer one, a branch chooses one or two disjuncts for the whole window, which is sound but
leaves out traces that need more.
"""

from core.decompose.chains import Chains, alternative
from core.decompose.collector import Window
from core.decompose.grouping import flat, grouped
from core.decompose.model import Guards, TreeNode
from core.decompose.released import released
from core.stl import (
    Always,
    And,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Until,
    disjunction,
    is_state_formula,
    to_text,
)

MOST_UNROLLED = 4
"""Steps of a window over which a choice is unrolled."""


class Throughout(Chains):
    """One rule for each kind of formula."""

    def __init__(self, visits_extra: int) -> None:
        super().__init__(visits_extra)
        self.one_sided = False

    def throughout(
        self, formula: Formula, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        """Trees that amount to the formula at every step of the window."""
        match formula:
            case _ if is_state_formula(formula) and not isinstance(formula, And):
                return [self.invariance(formula, window, guards, source)]
            case And():
                return [
                    node
                    for operand in flat(formula)
                    for node in self.throughout(operand, window, guards, source)
                ]
            case Always(interval=(a, b), operand=operand):
                inner = Window(window.start.plus(a), window.end.plus(b))
                return self.throughout(operand, inner, guards, source)
            case _ if window.start == window.end:
                return [self.node(formula, window.start, guards)]
            case Eventually() | Until():
                return self.recurrence(formula, window, guards, source)
            case Or():
                return self._choice(formula, window, guards, source)
            case Not(operand=Until() as until):
                return self.throughout(released(until, formula.span), window, guards, source)
        raise TypeError(f"not in negation normal form: {to_text(formula)}")

    def _choice(
        self, formula: Or, window: Window, guards: Guards, source: Formula
    ) -> list[TreeNode]:
        disjuncts = _disjuncts(formula)
        for index, disjunct in enumerate(disjuncts):
            if isinstance(disjunct, And) and not is_state_formula(disjunct):
                rest = (*disjuncts[:index], *disjuncts[index + 1 :])
                return [
                    node
                    for part in grouped(disjunct)
                    for each in [disjunction((*rest, part), span=formula.span)]
                    for node in self.throughout(each, window, guards, source)
                ]
        steady = [each for each in disjuncts if is_state_formula(each)]
        due = [each for each in disjuncts if not is_state_formula(each)]
        if not steady and len(due) == 1:
            return self.throughout(due[0], window, guards, source)
        if len(due) == 1:
            return self.steady_or_due(steady[0], due[0], window, guards, source)
        steps = self.difference(window.end, window.start)
        if steps.start == steps.stop < MOST_UNROLLED:
            return [
                self.node(formula, window.start.plus(step), guards)
                for step in range(steps.stop + 1)
            ]
        return self._whole_window(steady, due, window, guards, source)

    def _whole_window(
        self,
        steady: list[Formula],
        due: list[Formula],
        window: Window,
        guards: Guards,
        source: Formula,
    ) -> list[TreeNode]:
        """A branch: what is due, with a state formula or a later one wherever it is not."""
        self.one_sided = True
        pairs = [(kept, each) for each in due for kept in (steady or [None])]
        pairs += [(kept, each) for kept in due for each in due if _is_later(kept) and kept != each]
        labels = tuple(to_text(each if kept is None else Or((kept, each))) for kept, each in pairs)
        branch = self.branch_variable(labels, source, guards)
        nodes = []
        for value, (kept, each) in enumerate(pairs):
            inner = (*guards, (branch, value))
            whole = each if kept is None else Or((kept, each))
            parts = (
                self.throughout(each, window, inner, source)
                if kept is None
                else self.due(kept, each, window, inner, source)
            )
            nodes.append(alternative(whole, window, parts, branch, value))
        return nodes


def _disjuncts(formula: Or) -> list[Formula]:
    """State formulas as one disjunct; `F_[I] A | F_[I] B` as `F_[I](A | B)`."""
    found: list[Formula] = []
    for disjunct in flat(formula):
        if isinstance(disjunct, Not) and isinstance(disjunct.operand, Until):
            choice = released(disjunct.operand, disjunct.span)
            found += flat(choice) if isinstance(choice, Or) else [choice]
        else:
            found.append(disjunct)
    goals: dict[Interval, list[Formula]] = {}
    for each in found:
        if isinstance(each, Eventually):
            goals.setdefault(each.interval, []).append(each.operand)
    rest = [each for each in found if not isinstance(each, Eventually)]
    rest += [Eventually(interval, disjunction(parts)) for interval, parts in goals.items()]
    whole = disjunction(rest, span=formula.span)
    return grouped(whole) if isinstance(whole, Or) else [whole]


def _is_later(formula: Formula) -> bool:
    """Whether it is a state formula at one later step, as the next one in a rising edge."""
    return (
        isinstance(formula, Always)
        and formula.interval.start == formula.interval.stop
        and is_state_formula(formula.operand)
    )
