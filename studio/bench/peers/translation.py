"""Formulas in the languages of other libraries.

Their discrete until may ask the left side before t' only; ours asks it up to t' inclusive, hence
`left until (right and left)`.
"""

from collections.abc import Sequence
from functools import reduce
from typing import Any

from core.stl import Always, And, Atom, Eventually, Formula, Implies, Not, Or, Until


def rtamt_text(formula: Formula) -> str:
    """In rtamt's language, over the variables `margin_<name>`."""
    return _text(formula, "[{},{}]")


def sentil_text(formula: Formula) -> str:
    """In sentil's language, over the variables `margin_<name>`."""
    return _text(formula, "[{}, {}]")


def _text(formula: Formula, window: str) -> str:
    def told(one: Formula) -> str:
        match one:
            case Atom(name=name):
                return f"(margin_{name} >= 0)"
            case Not(operand=operand):
                return f"(not {told(operand)})"
            case And(operands=operands):
                return f"({' and '.join(map(told, operands))})"
            case Or(operands=operands):
                return f"({' or '.join(map(told, operands))})"
            case Implies(left=left, right=right):
                return f"({told(left)} -> {told(right)})"
            case Eventually(interval=interval, operand=operand):
                return f"(eventually{window.format(*interval)} {told(operand)})"
            case Always(interval=interval, operand=operand):
                return f"(always{window.format(*interval)} {told(operand)})"
            case Until(interval=interval, left=left, right=right):
                first, second = told(left), told(right)
                return f"({first} until{window.format(*interval)} ({second} and {first}))"
        raise TypeError(one)

    return told(formula)


def stljax_formula(stljax: Any, formula: Formula, names: Sequence[str]) -> Any:
    """As an object of the module `stljax.formula`, on traces [T, A] of the names."""

    def made(one: Formula) -> Any:
        match one:
            case Atom(name=name):
                column = names.index(name)
                return stljax.GreaterThan(stljax.Predicate(name, lambda x: x[..., column]), 0.0)
            case Not(operand=operand):
                return stljax.Negation(made(operand))
            case And(operands=operands):
                return reduce(stljax.And, map(made, operands))
            case Or(operands=operands):
                return reduce(stljax.Or, map(made, operands))
            case Implies(left=left, right=right):
                return stljax.Implies(made(left), made(right))
            case Eventually(interval=interval, operand=operand):
                return stljax.Eventually(made(operand), list(interval))
            case Always(interval=interval, operand=operand):
                return stljax.Always(made(operand), list(interval))
            case Until(interval=interval, left=left, right=right):
                return stljax.Until(made(left), made(right), list(interval))
        raise TypeError(one)

    return made(formula)
