"""Hypothesis strategies shared by the tests: formulas of bounded size, and traces for them.

A law draws a formula, then a trace that is long enough for it:
`margins = data.draw(traces(horizon(formula) + 1))`.
"""

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st

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

ATOMS = ("A", "B", "C")


def intervals(max_bound: int = 4) -> st.SearchStrategy[Interval]:
    """Closed intervals within [0, max_bound], single steps included."""
    bounds = st.tuples(st.integers(0, max_bound), st.integers(0, max_bound))
    return bounds.map(lambda pair: Interval(min(pair), max(pair)))


def leaves(atoms: Sequence[str] = ATOMS, *, constants: bool = True) -> st.SearchStrategy[Formula]:
    """Atoms, and `true` and `false` where constants are wanted."""
    names = st.sampled_from(list(atoms)).map(Atom)
    return names | st.booleans().map(Constant) if constants else names


def boolean_operators(operand: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
    """One Boolean operator on top of the given operands."""
    several = st.lists(operand, min_size=2, max_size=3).map(tuple)
    return st.one_of(
        operand.map(Not),
        several.map(And),
        several.map(Or),
        st.tuples(operand, operand).map(lambda pair: Implies(*pair)),
    )


def temporal_operators(
    operand: st.SearchStrategy[Formula], max_bound: int = 4
) -> st.SearchStrategy[Formula]:
    """One temporal operator on top of the given operands."""
    interval = intervals(max_bound)
    return st.one_of(
        st.tuples(interval, operand).map(lambda parts: Eventually(*parts)),
        st.tuples(interval, operand).map(lambda parts: Always(*parts)),
        st.tuples(interval, operand, operand).map(lambda parts: Until(*parts)),
    )


def state_formulas(
    max_depth: int = 2, atoms: Sequence[str] = ATOMS, *, constants: bool = True
) -> st.SearchStrategy[Formula]:
    """Formulas without temporal operators."""
    strategy = leaf = leaves(atoms, constants=constants)
    for _ in range(max_depth):
        strategy = leaf | boolean_operators(strategy)
    return strategy


def formulas(
    max_depth: int = 3,
    atoms: Sequence[str] = ATOMS,
    max_bound: int = 4,
    *,
    constants: bool = True,
) -> st.SearchStrategy[Formula]:
    """Formulas with at most `max_depth` nested operators and interval bounds <= `max_bound`."""
    strategy = leaf = leaves(atoms, constants=constants)
    for _ in range(max_depth):
        strategy = leaf | boolean_operators(strategy) | temporal_operators(strategy, max_bound)
    return strategy


def nested_formulas(
    max_depth: int = 4,
    atoms: Sequence[str] = ATOMS,
    max_bound: int = 4,
    *,
    constants: bool = True,
) -> st.SearchStrategy[Formula]:
    """Formulas with a temporal operator within another, `max_depth` >= 3 operators deep."""
    innermost = formulas(max_depth - 3, atoms, max_bound, constants=constants)
    inner = temporal_operators(innermost, max_bound)
    mixed = boolean_operators(inner | leaves(atoms, constants=constants))
    return temporal_operators(inner | mixed, max_bound)


def traces(
    length: int, atoms: Sequence[str] = ATOMS, *, batch: tuple[int, ...] = (), ties: bool = True
) -> st.SearchStrategy[np.ndarray]:
    """Margins [*batch, length, A]: multiples of 1/4 with zeros and ties, or normal variates."""
    shape = (*batch, length, len(atoms))

    def sample(seed: int) -> np.ndarray:
        rng = np.random.default_rng(seed)
        return rng.integers(-8, 9, shape) / 4 if ties else rng.normal(size=shape)

    return st.integers(0, 2**32 - 1).map(sample)
