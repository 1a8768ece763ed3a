"""How much of a formula a trace misses: state formulas that do not hold where they should.

For formulas in negation normal form without constants, where choices are left open the least:

    m(mu, t) = 0 where the state formula mu holds, 1 elsewhere
    m(f & g, t) = m(f, t) + m(g, t)              m(f | g, t) = min(m(f, t), m(g, t))
    m(G_[a:b] f, t) = sum of m(f, .) over the window
    m(F_[a:b] f, t) = min of m(f, .) over it
    m(f U_[a:b] g, t) = min over t' of (m(g, t') + sum of m(f, .) over [t, t'])
    m(!(f U_[a:b] g), t) = min of the sum of m(!g, .) over [t + a, t + b]
                           and of m(!f, s) + sum of m(!g, .) over [t + a, s - 1], s in [t, t + b]

A formula holds where m = 0.
"""

import numpy as np

from core.monitor.signals import Signals
from core.stl import (
    Always,
    And,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Until,
    is_state_formula,
    negation_normal_form,
    to_text,
)
from core.stl.algebra import exact_algebra


class Misses:
    """Misses of subformulas over time, each distinct one counted once."""

    def __init__(self, signals: Signals):
        self._signals = signals
        self._known: dict[Formula, np.ndarray] = {}

    def __getitem__(self, formula: Formula) -> np.ndarray:
        """Number of misses at each step that the trace decides [T - horizon]."""
        if formula not in self._known:
            self._known[formula] = self._counted(formula)
        return self._known[formula]

    def _counted(self, formula: Formula) -> np.ndarray:
        if is_state_formula(formula):
            return np.where(self._signals[formula] >= 0, 0, 1)
        match formula:
            case And(operands=operands):
                return np.sum(_cut(*(self[each] for each in operands)), axis=0)
            case Or(operands=operands):
                return np.min(_cut(*(self[each] for each in operands)), axis=0)
            case Always(interval=interval, operand=operand):
                return _sum(self[operand], interval)
            case Eventually(interval=interval, operand=operand):
                return _least(self[operand], interval)
            case Until(interval=interval, left=left, right=right):
                held, goal = _cut(self[left], self[right])
                total = _running_sum(held)
                met = _least(goal + total[1:], interval)
                return met - total[: len(met)]
            case Not(operand=Until(interval=interval, left=left, right=right)):
                fails = self[negation_normal_form(Not(left))]
                never = self[negation_normal_form(Not(right))]
                return _of_negated_until(interval, *_cut(fails, never))
        raise TypeError(f"not in negation normal form: {to_text(formula)}")


def _of_negated_until(interval: Interval, fails: np.ndarray, never: np.ndarray) -> np.ndarray:
    a, b = interval
    counts = [_sum(never, interval), _least(fails, Interval(0, a))]
    if a < b:
        total = _running_sum(never)
        late = _least(fails + total[:-1], Interval(a + 1, b))
        counts.append(late - total[a : a + len(late)])
    return np.min(_cut(*counts), axis=0)


def _cut(*counts: np.ndarray) -> list[np.ndarray]:
    length = min(map(len, counts))
    return [count[:length] for count in counts]


def _running_sum(counts: np.ndarray) -> np.ndarray:
    """Sum of the counts before each step, and of all [L + 1]."""
    return np.concatenate([[0], np.cumsum(counts)])


def _sum(counts: np.ndarray, interval: Interval) -> np.ndarray:
    """Sum over the interval from each step on: [L] to [L - stop]."""
    total = _running_sum(counts)
    upper = total[interval.stop + 1 :]
    return upper - total[interval.start : interval.start + len(upper)]


def _least(counts: np.ndarray, interval: Interval) -> np.ndarray:
    """Least over the interval from each step on: [L] to [L - stop]."""
    start, stop = interval
    return -exact_algebra(counts).slide(-counts[start:], stop - start + 1)
