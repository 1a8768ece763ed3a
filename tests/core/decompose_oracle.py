"""Independent oracle for decompositions: every schedule tried, by the reference semantics.

Nothing here is taken from the code under test but the fields of its data.
"""

import itertools
import math
from collections.abc import Callable

import numpy as np

from core.decompose import Decomposition
from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    walk,
)
from tests.core.stl.reference import reference_robustness

ATOMS = ("A", "B", "C")
Integer = Callable[[int, int], int]


def schedule_count(decomposition: Decomposition) -> int:
    return math.prod(v.high - v.low + 1 for v in decomposition.variables)


def all_schedules(decomposition: Decomposition) -> np.ndarray:
    """Admissible schedules [N, V]."""
    domains = [range(v.low, v.high + 1) for v in decomposition.variables]
    rows = list(itertools.product(*domains))
    grid = np.array(rows, int).reshape(len(rows), len(domains))
    keep = np.ones(len(grid), bool)
    for requirement in decomposition.requirements:
        later, since = requirement.total, requirement.since
        total = later.offset + grid[:, list(later.variables)].sum(1)
        total = total - since.offset - grid[:, list(since.variables)].sum(1)
        met = np.ones(len(grid), bool)
        if requirement.minimum is not None:
            met &= total >= requirement.minimum
        if requirement.maximum is not None:
            met &= total <= requirement.maximum
        keep &= met | ~_agrees(requirement.guards, grid)
    return grid[keep]


def best_value(decomposition: Decomposition, trace: np.ndarray) -> float:
    """Max over schedules of min over active tasks and steps of the margin; -inf for no schedule.

    Fails if a window of an active task leaves the trace [T, A].
    """
    length = len(trace)
    grid = all_schedules(decomposition)
    values = np.full(len(grid), np.inf)
    for task in decomposition.tasks:
        active = _agrees(task.guards, grid)
        start = task.start.offset + grid[:, list(task.start.variables)].sum(1)
        end = task.end.offset + grid[:, list(task.end.variables)].sum(1)
        active &= start <= end
        assert (start[active] >= 0).all() and (end[active] < length).all()
        margins = [reference_robustness(task.predicate, trace, ATOMS, t) for t in range(length)]
        worst = _window_minima(np.array(margins))
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


def random_trace(rng: np.random.Generator, length: int) -> np.ndarray:
    """Margins [length, A] in -3..3, ties at 0 included, constant for a few steps at a time."""
    columns = []
    for _ in ATOMS:
        stay, bias = rng.choice([0.2, 0.6, 0.9]), rng.integers(-1, 3)
        values = np.clip(rng.integers(-3, 4, length) + bias, -3, 3)
        for t in range(1, length):
            if rng.random() < stay:
                values[t] = values[t - 1]
        columns.append(values)
    return np.stack(columns, axis=1)


def random_formula(integer: Integer, depth: int) -> Formula:  # noqa: PLR0911 - one a construct
    """A formula with every construct; `integer(low, high)` makes the choices."""
    if depth == 0:
        return _state(integer, 1)
    inner = depth - 1
    match integer(0, 12):
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
        case 10 | 11 | 12:
            return Always(_interval(integer, 4), _due(integer))
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
    match integer(0, 4) if depth else 0:
        case 2:
            return Always(_interval(integer), _steady(integer, depth - 1))
        case 3:
            return And((_steady(integer, depth - 1), _steady(integer, depth - 1)))
        case 4:
            return (
                _due(integer)
                if integer(0, 1)
                else Eventually(_interval(integer), _state(integer, 0))
            )
    return _state(integer, 1)


def _due(integer: Integer) -> Formula:
    """What a choice at each step of a window keeps up: responses, lockouts, untils, edges."""
    mu, goal = _state(integer, 0), _state(integer, 1)
    due = Eventually(_interval(integer), goal)
    match integer(0, 7):
        case 0:
            return Implies(mu, due)
        case 1:
            return Implies(mu, Always(_interval(integer), goal))
        case 2:
            return Not(And((mu, due)))
        case 3:
            return Until(_interval(integer), _state(integer, 0), goal)
        case 4:
            return Or((mu, Until(_interval(integer, 1), _state(integer, 0), goal)))
        case 5:
            step = Interval(1, 1)
            return Implies(And((Not(mu), Always(step, mu))), due)
        case 6:
            until = Until(_interval(integer, 1), _state(integer, 0), goal)
            return Implies(mu, Eventually(Interval(1, 1), until))
    return Or((due, Eventually(_interval(integer), _state(integer, 0))))


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
            case Always(operand=Implies(right=Eventually(operand=Until()))):
                found.add("until due later")
            case Always(operand=Implies(right=Eventually())):
                found.add("response")
            case Always(operand=Implies(right=Always()) | Not(operand=And())):
                found.add("lockout")
            case Always(operand=Until()):
                found.add("until at every step")
            case Always(operand=Or(operands=(_, Until()))):
                found.add("until when due")
    return found
