"""Independent oracle for decompositions: recursive semantics, and every schedule tried.

Nothing here is taken from the code under test but the fields of its data.
"""

import itertools
from collections.abc import Callable
from functools import cache

import numpy as np

from core.decompose import Decomposition
from core.stl import (
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
    walk,
)

ATOMS = ("A", "B", "C")
Trace = dict[str, list[int]]
Integer = Callable[[int, int], int]


def brute_robustness(formula: Formula, trace: Trace) -> Callable[[int], float]:
    """Robustness at a step by the recursive definition (paper Eq. 2, `true` as +inf)."""

    @cache
    def rho(node: Formula, t: int) -> float:  # noqa: PLR0911 - one a construct
        match node:
            case Constant(value=value):
                return np.inf if value else -np.inf
            case Atom(name=name):
                return trace[name][t]
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
                    min(rho(right, t + k), *(rho(left, t + i) for i in range(k + 1)))
                    for k in range(a, b + 1)
                )
        raise TypeError(node)

    return lambda t: rho(formula, t)


def schedule_count(decomposition: Decomposition) -> int:
    return int(np.prod([v.high - v.low + 1 for v in decomposition.variables], dtype=np.int64))


def all_schedules(decomposition: Decomposition) -> np.ndarray:
    """Admissible schedules [N, V]."""
    domains = [range(v.low, v.high + 1) for v in decomposition.variables]
    rows = list(itertools.product(*domains))
    grid = np.array(rows, int).reshape(len(rows), len(domains))
    keep = np.ones(len(grid), bool)
    for requirement in decomposition.requirements:
        total = requirement.total.offset + grid[:, list(requirement.total.variables)].sum(1)
        met = total >= requirement.minimum
        if requirement.maximum is not None:
            met &= total <= requirement.maximum
        keep &= met | ~_agrees(requirement.guards, grid)
    return grid[keep]


def best_value(decomposition: Decomposition, trace: Trace, length: int) -> float:
    """Max over schedules of min over active tasks and steps of the margin; -inf for no schedule.

    Fails if a window of an active task leaves the trace of `length` steps.
    """
    grid = all_schedules(decomposition)
    values = np.full(len(grid), np.inf)
    for task in decomposition.tasks:
        active = _agrees(task.guards, grid)
        start = task.start.offset + grid[:, list(task.start.variables)].sum(1)
        end = task.end.offset + grid[:, list(task.end.variables)].sum(1)
        active &= start <= end
        assert (start[active] >= 0).all() and (end[active] < length).all()
        rho = brute_robustness(task.predicate, trace)
        worst = _window_minima(np.array([rho(t) for t in range(length)]))
        values[active] = np.minimum(values[active], worst[start[active], end[active]])
    return values.max(initial=-np.inf)


def _agrees(guards, grid: np.ndarray) -> np.ndarray:
    matches = np.ones(len(grid), bool)
    for variable, value in guards:
        matches &= grid[:, variable] == value
    return matches


def _window_minima(signal: np.ndarray) -> np.ndarray:
    """[i, j] = minimum of signal[i..j]."""
    table = np.full((len(signal), len(signal)), np.inf)
    for i in range(len(signal)):
        table[i, i:] = np.minimum.accumulate(signal[i:])
    return table


def random_trace(rng: np.random.Generator, length: int) -> Trace:
    """Margins in -3..3, ties at 0 included, constant for a few steps at a time."""
    trace = {}
    for name in ATOMS:
        stay, bias = rng.choice([0.2, 0.6, 0.9]), rng.integers(-1, 3)
        values = np.clip(rng.integers(-3, 4, length) + bias, -3, 3)
        for t in range(1, length):
            if rng.random() < stay:
                values[t] = values[t - 1]
        trace[name] = values.tolist()
    return trace


def random_formula(integer: Integer, depth: int) -> Formula:  # noqa: PLR0911 - one a construct
    """A formula that the rules cover; `integer(low, high)` makes the choices."""
    if depth == 0:
        return _state(integer, 1)
    inner = depth - 1
    match integer(0, 9):
        case 0:
            return _state(integer, 2)
        case 1:
            return And((random_formula(integer, inner), random_formula(integer, inner)))
        case 2:
            return Or((random_formula(integer, inner), random_formula(integer, inner)))
        case 3:
            return Implies(Always(_interval(integer), _state(integer, 1)), _temporal(integer))
        case 4:
            return Eventually(_interval(integer), random_formula(integer, inner))
        case 5:
            return Always(_interval(integer), _steady(integer, inner))
        case 6 | 7:
            right = random_formula(integer, inner)
            return Until(_interval(integer), _steady(integer, inner), right)
        case 8:
            return Not(Until(_interval(integer), _temporal(integer), _recurrent(integer)))
    visited = And((random_formula(integer, inner), _state(integer, 0)))
    return Always(_interval(integer, 4), Eventually(_interval(integer), visited))


def _interval(integer: Integer, width: int = 2) -> Interval:
    start = integer(0, 2)
    return Interval(start, start + integer(0, width))


def _literal(integer: Integer) -> Formula:
    atom = Atom(ATOMS[integer(0, len(ATOMS) - 1)])
    return atom if integer(0, 1) else Not(atom)


def _state(integer: Integer, depth: int) -> Formula:
    kind = integer(0, 4) if depth else 0
    if kind <= 1:
        return _literal(integer)
    operands = (_state(integer, depth - 1), _state(integer, depth - 1))
    return {2: And(operands), 3: Or(operands), 4: Not(Implies(*operands))}[kind]


def _steady(integer: Integer, depth: int) -> Formula:
    """What may hold throughout a window of variable length."""
    match integer(0, 3) if depth else 0:
        case 2:
            return Always(_interval(integer), _steady(integer, depth - 1))
        case 3:
            return And((_steady(integer, depth - 1), _steady(integer, depth - 1)))
    return _state(integer, 1)


def _temporal(integer: Integer) -> Formula:
    """What may be negated, and then required at one step."""
    state = _state(integer, 1)
    wrapped = (state, Eventually(_interval(integer), state), Always(_interval(integer), state))
    return wrapped[integer(0, 2)]


def _recurrent(integer: Integer) -> Formula:
    """What may be negated, and then required throughout a window."""
    state = _state(integer, 1)
    return (state, Eventually(_interval(integer), state), Or((state, state)))[integer(0, 2)]


def features(formula: Formula) -> set[str]:
    """Which of the constructs beyond plain F and G a formula has."""
    found = set()
    for node in walk(formula):
        match node:
            case Or() | Implies() if any(isinstance(n, Eventually | Always) for n in walk(node)):
                found.add("disjunction")
            case Until(right=right):
                found.add("until")
                if any(isinstance(n, Until) for n in walk(right)):
                    found.add("nested until")
            case Not(operand=Until()):
                found.add("negated until")
            case Always(operand=Eventually()):
                found.add("recurrence")
    return found
