"""Robustness straight from its definition, one step and one trace at a time. Slow on purpose."""

import math
from functools import cache
from typing import Protocol

import numpy as np

from core.stl import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Implies,
    Not,
    Or,
    Until,
)


class Samples(Protocol):
    """A trace [T, A]: an array, or what stands for one."""

    def __getitem__(self, sample: tuple[int, int], /) -> float: ...


def reference_robustness(formula: Formula, trace: Samples, names, t: int = 0) -> float:
    """rho(formula, t) on a trace [T, A] (paper, Eq. 2); an IndexError if the trace is too short."""

    @cache
    def rho(node: Formula, t: int) -> float:  # noqa: PLR0911 - one a construct
        match node:
            case Constant(value=value):
                return math.inf if value else -math.inf
            case Atom(name=name):
                return float(trace[t, names.index(name)])
            case Not(operand=operand):
                return -rho(operand, t)
            case And(operands=operands):
                return min(rho(operand, t) for operand in operands)
            case Or(operands=operands):
                return max(rho(operand, t) for operand in operands)
            case Implies(left=left, right=right):
                return max(-rho(left, t), rho(right, t))
            case Eventually(interval=(a, b), operand=operand):
                return max(rho(operand, t + k) for k in range(a, b + 1))
            case Always(interval=(a, b), operand=operand):
                return min(rho(operand, t + k) for k in range(a, b + 1))
            case Until(interval=(a, b), left=left, right=right):
                return max(
                    min(rho(right, t + k), *(rho(left, t + j) for j in range(k + 1)))
                    for k in range(a, b + 1)
                )
        raise TypeError(node)

    return rho(formula, t)


def reference_reads(formula: Formula, names, length: int, t: int = 0) -> np.ndarray:
    """The samples [length, A] that the definition looks at for rho(formula, t)."""
    read = np.zeros((length, len(names)), bool)

    class Trace:
        def __getitem__(self, sample: tuple[int, int]) -> float:
            read[sample] = True
            return 0.0

    reference_robustness(formula, Trace(), names, t)
    return read


def reference_satisfied(formula: Formula, trace: np.ndarray, names, t: int = 0) -> bool:
    """Whether (trace, t) satisfies the formula, by the Boolean semantics (paper, Sec. 3)."""

    def holds(operand: Formula, step: int) -> bool:
        return reference_satisfied(operand, trace, names, step)

    match formula:
        case Constant(value=value):
            return value
        case Atom(name=name):
            return bool(trace[t, names.index(name)] >= 0)
        case Not(operand=operand):
            return not holds(operand, t)
        case And(operands=operands):
            return all(holds(operand, t) for operand in operands)
        case Or(operands=operands):
            return any(holds(operand, t) for operand in operands)
        case Implies(left=left, right=right):
            return not holds(left, t) or holds(right, t)
        case Eventually(interval=(a, b), operand=operand):
            return any(holds(operand, t + k) for k in range(a, b + 1))
        case Always(interval=(a, b), operand=operand):
            return all(holds(operand, t + k) for k in range(a, b + 1))
        case Until(interval=(a, b), left=left, right=right):
            return any(
                holds(right, t + k) and all(holds(left, t + j) for j in range(k + 1))
                for k in range(a, b + 1)
            )
    raise TypeError(formula)
