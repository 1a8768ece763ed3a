"""Disjunctive normal form of state formulas; its size is known before it is built."""

import math
from itertools import product

from core.quoting import LONGEST_FORMULA, shown
from core.stl import And, Atom, Constant, Formula, Not, Or, to_text
from core.task.sizes import GroundingError

Clause = list[tuple[str, int]]
"""Atoms with their signs, +1 or -1; all must hold."""

_READABLE = 10**12
_MOST_PAIRS = 64


def clauses_of(predicate: Formula, most: int) -> list[Clause]:
    """Clauses of a state formula in negation normal form, one of which must hold.

    Args:
        predicate: the state formula.
        most: clauses, and literals of a clause, that are supported.

    Raises:
        GroundingError: it needs more.
    """
    count = _clause_count(predicate)
    if count > most:
        raise _too_wide(predicate, f"{_grouped(count)} alternatives", most)
    clauses = _clauses(predicate)
    longest = max(map(len, clauses))
    if longest > most:
        raise _too_wide(predicate, f"{longest} regions in one alternative", most)
    return clauses


def exclude(left: list[Clause], right: list[Clause]) -> bool:
    """Whether no position is inside of both: each pair of clauses contradicts itself.

    Predicates of very many pairs are taken to meet.
    """
    if len(left) * len(right) > _MOST_PAIRS:
        return False
    negated = [{(name, -sign) for name, sign in clause} for clause in left]
    return all(not clause.isdisjoint(other) for clause in negated for other in right)


def _clause_count(formula: Formula) -> int:
    """Number of clauses that `_clauses` would build."""
    match formula:
        case Or(operands=operands):
            return sum(map(_clause_count, operands))
        case And(operands=operands):
            return math.prod(map(_clause_count, operands))
    return 1


def _clauses(formula: Formula) -> list[Clause]:
    match formula:
        case Constant(value=value):
            raise GroundingError(
                f"the formula asks for {'true' if value else 'false'} as a task, which no robot "
                "can reach or leave; remove it"
            )
        case Atom(name=name):
            return [[(name, 1)]]
        case Not(operand=Atom(name=name)):
            return [[(name, -1)]]
        case Or(operands=operands):
            return [clause for operand in operands for clause in _clauses(operand)]
        case And(operands=operands):
            parts = [_clauses(operand) for operand in operands]
            return [list(dict.fromkeys(sum(choice, []))) for choice in product(*parts)]
    raise TypeError(f"not in negation normal form: {to_text(formula)}")


def _too_wide(predicate: Formula, needs: str, most: int) -> GroundingError:
    return GroundingError(
        f"the state formula {shown(to_text(predicate), LONGEST_FORMULA)} needs {needs}; at most "
        f"{most} alternatives of {most} regions each are supported"
    )


def _grouped(count: int) -> str:
    """A number for reading, however large."""
    return f"{count:,}" if count < _READABLE else f"more than 10^{len(str(count)) - 1}"
