r"""From syntax tree to text.

    to_text  F_[0:90](A) & G_[0:100](!B) & (!D1)U_[0:100](K1)      canonical
    to_math  ◇[0,90](A) ∧ □[0,100](¬B) ∧ (¬D1)U[0,100](K1)         for display

Both can be read back: `parse(to_text(f)) == f` and `parse(to_math(f)) == f`.
"""

from typing import NamedTuple

from core.stl.grammar import is_plain_name
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
    Until,
)


class _Notation(NamedTuple):
    negation: str
    conjunction: str
    disjunction: str
    implication: str
    eventually: str
    always: str
    until: str
    interval: str
    true: str
    false: str


_TEXT = _Notation("!", " & ", " | ", " -> ", "F", "G", "U", "_[{}:{}]", "true", "false")
_MATH = _Notation("¬", " ∧ ", " ∨ ", " → ", "◇", "□", "U", "[{},{}]", "⊤", "⊥")

# Binding strength; a node in a place that needs a stronger one is put in parentheses.
_IMPLICATION, _DISJUNCTION, _CONJUNCTION, _UNTIL, _UNARY = range(5)


def to_text(formula: Formula) -> str:
    """Write the formula canonically, in ASCII but for names."""
    return _print(formula, _TEXT, _IMPLICATION)


def to_math(formula: Formula) -> str:
    """Write the formula with the symbols of mathematics."""
    return _print(formula, _MATH, _IMPLICATION)


def quote_name(name: str) -> str:
    """Write a name, in quotes where it would not be read as itself without them."""
    if is_plain_name(name):
        return name
    escaped = name.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _print(formula: Formula, signs: _Notation, place: int) -> str:
    strength = _strength(formula)
    text = _print_bare(formula, signs)
    return text if strength >= place else f"({text})"


def _strength(formula: Formula) -> int:
    match formula:
        case Implies():
            return _IMPLICATION
        case Or():
            return _DISJUNCTION
        case And():
            return _CONJUNCTION
        case Until():
            return _UNTIL
        case _:
            return _UNARY


def _print_bare(formula: Formula, signs: _Notation) -> str:
    match formula:
        case Constant(value=value):
            return signs.true if value else signs.false
        case Atom(name=name):
            return quote_name(name)
        case Not(operand=operand):
            return signs.negation + _print(operand, signs, _UNARY)
        case And(operands=operands):
            return signs.conjunction.join(_print(each, signs, _UNTIL) for each in operands)
        case Or(operands=operands):
            return signs.disjunction.join(_print(each, signs, _CONJUNCTION) for each in operands)
        case Implies(left=left, right=right):
            first = _print(left, signs, _DISJUNCTION)
            return first + signs.implication + _print(right, signs, _IMPLICATION)
        case Eventually(interval=interval, operand=operand):
            return signs.eventually + _temporal(interval, operand, signs)
        case Always(interval=interval, operand=operand):
            return signs.always + _temporal(interval, operand, signs)
        case Until(interval=interval, left=left, right=right):
            first = f"({_print_bare(left, signs)})"
            return first + signs.until + _temporal(interval, right, signs)
    raise TypeError(f"not a formula: {formula!r}")


def _temporal(interval: Interval, operand: Formula, signs: _Notation) -> str:
    return f"{signs.interval.format(*interval)}({_print_bare(operand, signs)})"
