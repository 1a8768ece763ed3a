"""From lark's concrete tree to the syntax tree: names, bounds, spans and limits."""

import difflib
import re
from collections.abc import Collection

from lark import Token, Tree

from core.stl.bounds import BoundError, steps
from core.stl.errors import FormulaError
from core.stl.grammar import join_subscript
from core.stl.printer import quote_name
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

# Operators nested in one another, and parentheses nested in one another.
MAX_DEPTH = 64
_NO_OPERATOR = {"parentheses", "name", "quoted", "latex_text", "true", "false", "interval", "bound"}
_MAX_NAMES_SHOWN = 12


class Builder:
    """Builds the syntax tree of one text."""

    def __init__(self, text: str, dt: float | None, names: Collection[str] | None):
        self._text = text
        self._dt = dt
        self._names = None if names is None else list(dict.fromkeys(names))

    def build(self, tree: Tree) -> Formula:
        """Check the depth without recursion, then build."""
        self._check_depth(tree)
        return self._formula(tree.children[0])

    def _check_depth(self, tree: Tree) -> None:
        pending = [(tree.children[0], 0, 0)]
        while pending:
            node, operators, parentheses = pending.pop()
            operators += node.data not in _NO_OPERATOR
            parentheses += node.data == "parentheses"
            if max(operators, parentheses) > MAX_DEPTH:
                what = "operators" if operators > MAX_DEPTH else "parentheses"
                raise self._error(f"more than {MAX_DEPTH} {what} are nested in one another", node)
            pending += [(child, operators, parentheses) for child in _subtrees(node)]

    def _formula(self, node: Tree) -> Formula:
        span = Span(node.meta.start_pos, node.meta.end_pos)
        below = _subtrees(node)
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
            case "eventually":
                return Eventually(self._interval(below[0]), self._formula(below[1]), span=span)
            case "always":
                return Always(self._interval(below[0]), self._formula(below[1]), span=span)
            case "until":
                left, right = self._formula(below[0]), self._formula(below[2])
                return Until(self._interval(below[1]), left, right, span=span)
        raise AssertionError(f"no rule of the grammar: {node.data}")

    def _interval(self, node: Tree) -> Interval:
        first, last = _subtrees(node)
        start, stop = self._steps(first), self._steps(last)
        if (_unit(first) is None) != (_unit(last) is None) and start > 0 and stop > 0:
            raise self._error(
                "one bound has a unit and the other has none", node, hint="give both a unit"
            )
        if start > stop:
            raise self._error(
                f"the interval [{_bound_text(first)}:{_bound_text(last)}] is empty",
                node,
                hint="0 <= a <= b",
            )
        return Interval(start, stop)

    def _steps(self, node: Tree) -> int:
        try:
            return steps(str(node.children[0]), _unit(node), self._dt)
        except BoundError as error:
            raise self._error(str(error), node, hint=error.hint) from None

    def _name(self, node: Tree) -> str:
        written = str(node.children[0])
        if node.data == "name":
            name = written if self._names and written in self._names else join_subscript(written)
        elif node.data == "quoted":
            name = re.sub(r"\\(.)", lambda match: _ESCAPES.get(match[1], match[1]), written[1:-1])
        else:
            name = written[written.index("{") + 1 : -1].strip()
        if not name:
            raise self._error("the name is empty", node)
        if self._names is not None and name not in self._names:
            raise self._unknown_name(name, node)
        return name

    def _unknown_name(self, name: str, node: Tree) -> FormulaError:
        known = _closest_first(name, self._names or [])
        if not known:
            return self._error(f"unknown name '{name}'", node, hint="there are no names yet")
        shown = ", ".join(map(quote_name, known[:_MAX_NAMES_SHOWN]))
        more = len(known) - _MAX_NAMES_SHOWN
        rest = f" and {more} more" if more > 0 else ""
        return self._error(f"unknown name '{name}'", node, expected=f"one of {shown}{rest}")

    def _error(self, problem: str, node: Tree, *, expected: str = "", hint: str = ""):
        return FormulaError(problem, self._text, node.meta.start_pos, expected=expected, hint=hint)


_ESCAPES = {"n": "\n"}


def _subtrees(node: Tree) -> list[Tree]:
    return [child for child in node.children if isinstance(child, Tree)]


def _unit(bound: Tree) -> str | None:
    return str(bound.children[1]) if len(bound.children) > 1 else None


def _bound_text(bound: Tree) -> str:
    return " ".join(str(token) for token in bound.children if isinstance(token, Token))


def _closest_first(name: str, known: list[str]) -> list[str]:
    def likeness(other: str) -> float:
        return difflib.SequenceMatcher(None, name.lower(), other.lower()).ratio()

    return sorted(known, key=likeness, reverse=True)
