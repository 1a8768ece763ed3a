"""From lark's concrete tree to the syntax tree: names, bounds, spans and limits."""

import difflib
import re
from collections.abc import Collection
from functools import partial, reduce
from unicodedata import normalize

from lark import Token, Tree

from core.quoting import listed, quoted
from core.stl.bounds import BoundError, steps
from core.stl.errors import FormulaError
from core.stl.grammar import join_subscript
from core.stl.limits import subtrees, too_large
from core.stl.printer import quote_name
from core.stl.reach import OPEN
from core.stl.syntax import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Span,
    Until,
)


class Builder:
    """Builds the syntax tree of one text; open operators still have no upper bound.

    Args:
        text: as typed.
        dt: duration of a step [s], for bounds with units.
        names: the names that atoms may have; any, if None.
    """

    def __init__(self, text: str, dt: float | None, names: Collection[str] | None):
        self._text = text
        self._dt = dt
        self._names = None if names is None else list(dict.fromkeys(names))
        self.notes: list[str] = []
        """What was read otherwise than it may have been meant."""

    def build(self, tree: Tree) -> Formula:
        """Check depth and size without recursion, then build."""
        root = subtrees(tree)[0]
        found = too_large(root)
        if found:
            raise self._error(*found)
        label = tree.children[0]
        if isinstance(label, Token):
            self._leave_out(label, root)
        return self._formula(root)

    def _leave_out(self, label: Token, root: Tree) -> None:
        """Note the name in front of the formula, unless it is that of a region."""
        written = str(label).strip()
        name = written.rstrip(":= ≔")
        if self._names is not None and name in self._names:
            raise self._error(
                f"{quoted(written)} stands before a formula, but {quoted(name)} is an atom",
                root,
                hint=f"write {quote_name(name)} <-> ... for exactly when",
            )
        self.notes.append(f"{quoted(written)} names the formula and is left out.")

    def _formula(self, node: Tree) -> Formula:
        span = Span(node.meta.start_pos, node.meta.end_pos)
        below = subtrees(node)
        match node.data:
            case "parentheses":
                return self._formula(below[0])
            case "true" | "false":
                return Constant(node.data == "true", span=span)
            case "name" | "quoted" | "latex_text":
                return Atom(self._name(node), span=span)
            case "negation":
                return Not(self._formula(below[0]), span=span)
            case "conjunction":
                return And(tuple(map(self._formula, below)), span=span)
            case "disjunction":
                return Or(tuple(map(self._formula, below)), span=span)
            case "implication":
                return Implies(*map(self._formula, below), span=span)
            case "equivalence":
                left, right = map(self._formula, below)
                return _equivalence(left, right, span)
            case "exclusive":
                first, *rest = map(self._formula, below)
                return reduce(partial(_exclusive, span=span), rest, first)
            case "eventually":
                return Eventually(self._interval(below), self._formula(below[-1]), span=span)
            case "always":
                return Always(self._interval(below), self._formula(below[-1]), span=span)
            case "until":
                left, right = self._formula(below[0]), self._formula(below[-1])
                return Until(self._interval(below[1:]), left, right, span=span)
        raise AssertionError(f"no rule of the grammar: {node.data}")

    def _interval(self, below: list[Tree]) -> Interval:
        """The interval that stands first, if there is one; else all steps that are left."""
        node = below[0]
        if node.data != "interval":
            return Interval(0, OPEN)
        first, last = subtrees(node)[0], subtrees(node)[-1]
        start = self._steps(first)
        comparison = next((str(t) for t in node.children if _is_token(t, "COMPARISON")), "")
        if comparison:
            return self._compared(comparison, start, node)
        if last.data == "open":
            return Interval(start, OPEN)
        if first is last:
            self.notes.append(
                f"{self._typed(node)} is the one step [{start}:{start}]; "
                f"for any step up to it write [0:{start}]."
            )
        stop = self._steps(last)
        if (_unit(first) is None) != (_unit(last) is None) and start > 0 and stop > 0:
            raise self._error(
                "one bound has a unit and the other has none", node, hint="give both bounds a unit"
            )
        if start > stop:
            low, high = _bound_text(last), _bound_text(first)
            raise self._error(
                f"the interval [{high}:{low}] is empty",
                node,
                hint=f"[a:b] needs 0 <= a <= b; did you mean [{low}:{high}]?",
            )
        return Interval(start, stop)

    def _compared(self, comparison: str, bound: int, node: Tree) -> Interval:
        """The interval of `F_{<=5}` and its like."""
        match comparison.lstrip("\\")[0]:
            case "=" if comparison == "=":
                return Interval(bound, bound)
            case ">" | "≥" | "⩾" | "≧" | "g":
                return Interval(bound + (comparison == ">"), OPEN)
        if comparison == "<" and bound == 0:
            raise self._error("no step is before step 0", node, hint="[a:b] needs 0 <= a <= b")
        return Interval(0, bound - (comparison == "<"))

    def _steps(self, node: Tree) -> int:
        try:
            return steps(str(node.children[0]), _unit(node), self._dt)
        except BoundError as error:
            raise self._error(str(error), node, hint=error.hint) from None

    def _name(self, node: Tree) -> str:
        written = self._typed(node)
        readings = _readings(node.data, written)
        if not readings[-1]:
            raise self._error("the name is empty", node)
        if self._names is None:
            return readings[-1]
        known = [name for name in readings if name in self._names]
        if not known:
            raise self._unknown_name(written if node.data == "name" else readings[-1], node)
        return known[0]

    def _unknown_name(self, name: str, node: Tree) -> FormulaError:
        problem = f"unknown name {quoted(name)}"
        if not self._names:
            return self._error(problem, node, hint="no names are defined yet")
        nearest = _closest_first(name, self._names)
        known = listed([quote_name(each) for each in nearest])
        same = nearest[0].casefold() == name.casefold()
        hint = f"did you mean {quote_name(nearest[0])}? Capitals count" if same else ""
        return self._error(problem, node, expected=f"one of {known}", hint=hint)

    def _typed(self, node: Tree) -> str:
        """The node as it was typed."""
        return self._text[node.meta.start_pos : node.meta.end_pos]

    def _error(self, problem: str, node: Tree, *, expected: str = "", hint: str = ""):
        return FormulaError(problem, self._text, node.meta.start_pos, expected=expected, hint=hint)


_ESCAPES = {"n": "\n"}


def _readings(rule: str, written: str) -> list[str]:
    """What a name may mean as typed; the last is what it means where no names are known."""
    match rule:
        case "name":
            joined = join_subscript(written)
            return [written, join_subscript(normalize("NFKC", written)), joined]
        case "quoted":
            return [re.sub(r"\\(.)", lambda match: _ESCAPES.get(match[1], match[1]), written[1:-1])]
    inner, _, subscript = written[written.index("{") + 1 :].partition("}")
    inner, subscript = inner.strip(), subscript.strip(" _{}")
    if subscript:
        name = f"{inner}_{subscript}"
        return [name, join_subscript(name)]
    return [inner, join_subscript(inner), inner]


def _equivalence(left: Formula, right: Formula, span: Span) -> Formula:
    return And((Implies(left, right, span=span), Implies(right, left, span=span)), span=span)


def _exclusive(left: Formula, right: Formula, span: Span) -> Formula:
    both = Not(And((left, right), span=span), span=span)
    return And((Or((left, right), span=span), both), span=span)


def _is_token(part: Tree | Token, kind: str) -> bool:
    return isinstance(part, Token) and part.type == kind


def _unit(bound: Tree) -> str | None:
    r"""`s` or `ms`, also of `\mathrm{s}`."""
    if len(bound.children) < 2:
        return None
    return str(bound.children[1]).rpartition("{")[2].strip(" }")


def _bound_text(bound: Tree) -> str:
    unit = _unit(bound)
    return f"{bound.children[0]} {unit}" if unit else str(bound.children[0])


def _closest_first(name: str, known: list[str]) -> list[str]:
    def likeness(other: str) -> float:
        return difflib.SequenceMatcher(None, name.lower(), other.lower()).ratio()

    return sorted(known, key=likeness, reverse=True)
