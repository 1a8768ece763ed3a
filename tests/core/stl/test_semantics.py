"""Robustness against its definition, and the laws that it obeys."""

import jax
import jax.extend
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import UserError
from core.stl import (
    Constant,
    Not,
    TraceError,
    horizon,
    parse,
    robustness,
    robustness_signal,
    satisfied,
)
from tests.core.stl.reference import reference_robustness, reference_satisfied
from tests.strategies import ATOMS, formulas, nested_formulas, traces

# One of each kind of operator and window: single steps, offsets, blocks cut at either end.
FORMULAS = [
    "A & !B | true",
    "F_[0:4](A) -> G_[3:3](B)",
    "G_[2:9](F_[1:5](A | B))",
    "(A)U_[0:0](B)",
    "(A | C)U_[2:7](B & F_[0:3](C))",
    "!((F_[0:2](A))U_[1:4](G_[0:1](B)))",
    "F_[0:3](A & (B)U_[0:5](true)) & G_[0:6](false -> C)",
]


@settings(deadline=None, max_examples=300)
@given(formulas(max_depth=3, max_bound=3) | nested_formulas(max_depth=3, max_bound=3), st.data())
def test_robustness_is_what_the_definition_says(formula, data):
    length = horizon(formula) + 1 + data.draw(st.integers(0, 3))
    margins = data.draw(traces(length, batch=(2,)))
    values = robustness_signal(formula, margins, ATOMS)
    assert values.shape == (2, length - horizon(formula))
    for trace, row in zip(margins, values, strict=True):
        for step in {0, values.shape[-1] - 1}:
            assert row[step] == reference_robustness(formula, trace, ATOMS, step)


@settings(deadline=None, max_examples=200)
@given(formulas(max_depth=3, max_bound=3) | nested_formulas(max_depth=3, max_bound=3), st.data())
def test_a_trace_satisfies_a_formula_iff_its_robustness_is_not_negative(formula, data):
    margins = data.draw(traces(horizon(formula) + 1, batch=(2,), ties=False))
    verdicts = satisfied(formula, margins, ATOMS)
    assert verdicts.dtype == bool
    np.testing.assert_array_equal(verdicts, robustness(formula, margins, ATOMS) >= 0)
    for trace, verdict in zip(margins, verdicts, strict=True):
        assert verdict == reference_satisfied(formula, trace, ATOMS)


def test_on_the_boundary_a_region_and_its_complement_hold():
    on_boundary = np.zeros((1, 1))
    assert satisfied(parse("A & !A"), on_boundary, ["A"])


@settings(deadline=None)
@given(formulas(), st.data())
def test_values_beyond_the_horizon_do_not_matter(formula, data):
    length = horizon(formula) + 4
    margins, other = data.draw(traces(length)), data.draw(traces(length))
    other[: horizon(formula) + 1] = margins[: horizon(formula) + 1]
    value = robustness(formula, margins, ATOMS)
    assert value == robustness(formula, other, ATOMS)
    assert value == robustness_signal(formula, other, ATOMS)[0]


@pytest.mark.parametrize(
    "text",
    [
        "A",
        "F_[0:5](A)",
        "G_[2:4](A)",
        "F_[0:3](G_[0:2](A))",
        "(B)U_[0:4](A)",
        "(A)U_[0:4](F_[1:2](B))",
        "(F_[1:5](A))U_[1:2](B)",
        "G_[0:2](F_[0:3](A | B) & C)",
    ],
)
def test_the_value_at_the_horizon_matters(text):
    formula = parse(text)
    shape = (4096, horizon(formula) + 1, 3)
    margins = np.random.default_rng(7).choice([-1.0, 1.0], shape)
    other = margins.copy()
    other[:, -1] *= -1
    before, after = (satisfied(formula, trace, ATOMS) for trace in (margins, other))
    assert (before != after).any()


@settings(deadline=None)
@given(formulas(), st.data())
def test_the_signal_is_the_robustness_of_the_shifted_trace(formula, data):
    margins = data.draw(traces(horizon(formula) + 4))
    values = robustness_signal(formula, margins, ATOMS)
    shifted = [robustness(formula, margins[step:], ATOMS) for step in range(len(values))]
    np.testing.assert_array_equal(values, shifted)


@settings(deadline=None)
@given(formulas(), st.data())
def test_negation_negates(formula, data):
    margins = data.draw(traces(horizon(formula) + 1))
    assert robustness(Not(formula), margins, ATOMS) == -robustness(formula, margins, ATOMS)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("F_[2:5](A)", "(true)U_[2:5](A)"),
        ("G_[2:5](A)", "!F_[2:5](!A)"),
        ("F_[1:2](F_[3:5](A))", "F_[4:7](A)"),
        ("G_[1:2](G_[3:5](A))", "G_[4:7](A)"),
        ("G_[0:4](A & B)", "G_[0:4](A) & G_[0:4](B)"),
        ("(A)U_[3:5](B)", "G_[0:2](A) & F_[3:3]((A)U_[0:2](B))"),
        ("A -> B", "!A | B"),
    ],
)
def test_equivalent_formulas(one, other):
    margins = np.random.default_rng(3).normal(size=(64, 12, 2))
    values = [robustness(parse(text), margins, ["A", "B"]) for text in (one, other)]
    np.testing.assert_array_equal(*values)


def test_until_asks_the_left_side_at_the_moment_of_the_right():
    """The closed version of the paper: K must be taken while D is still avoided."""
    inside, outside = 1.0, -1.0
    margins = np.full((4, 2), outside)
    margins[2] = inside
    assert robustness(parse("(!D)U_[0:3](K)"), margins, ["D", "K"]) == -1.0
    margins[2, 0] = outside
    assert robustness(parse("(!D)U_[0:3](K)"), margins, ["D", "K"]) == 1.0


@pytest.mark.parametrize("text", FORMULAS)
def test_jax_gives_what_numpy_gives(text):
    formula = parse(text)
    margins = np.random.default_rng(11).integers(-8, 9, (3, 5, 40, 3)) / 4
    expected = robustness_signal(formula, margins, ATOMS)
    with jax.numpy_rank_promotion("raise"):
        signal, single = jax.jit(
            lambda margins: (
                robustness_signal(formula, margins, ATOMS),
                jax.vmap(jax.vmap(lambda trace: robustness(formula, trace, ATOMS)))(margins),
            )
        )(margins)
    assert isinstance(signal, jax.Array) and isinstance(expected, np.ndarray)
    np.testing.assert_array_equal(signal, expected)
    np.testing.assert_array_equal(single, expected[..., 0])


@pytest.mark.parametrize("text", [text for text in FORMULAS if "true" not in text])
def test_the_gradient_is_that_of_the_deciding_margin(text):
    """Away from ties, robustness is plus or minus one of the margins."""
    formula = parse(text)
    margins = np.random.default_rng(5).normal(size=(40, 3)).astype(np.float32)
    gradient = jax.jit(jax.grad(lambda margins: robustness(formula, margins, ATOMS)))(margins)
    assert np.count_nonzero(gradient) == 1
    assert np.abs(gradient).sum() == 1.0
    assert (np.asarray(gradient) * margins).sum() == robustness(formula, margins, ATOMS)


def test_gradients_are_finite_where_a_constant_decides():
    formula = parse("G_[0:3](true) | (false)U_[0:2](A) & F_[0:3](A)")
    gradient = jax.jit(
        jax.grad(lambda margins: jnp.minimum(robustness(formula, margins, ["A"]), 1.0))
    )(jnp.ones((5, 1)))
    np.testing.assert_array_equal(gradient, np.zeros((5, 1)))


@pytest.mark.parametrize("text", ["F_[0:{w}](A)", "G_[3:{w}](A)", "(A)U_[2:{w}](B)"])
def test_programs_do_not_grow_with_the_trace_and_memory_grows_linearly(text):
    programs = {}
    for width in (30, 300):
        formula = parse(text.format(w=width))
        margins = jnp.zeros((2 * width, 2))
        program = jax.make_jaxpr(lambda m, f=formula: robustness(f, m, ["A", "B"]))(margins)
        sizes = [v.aval.size for eqn in _equations(program.jaxpr) for v in eqn.outvars]
        assert max(sizes) <= 4 * margins.size
        programs[width] = len(sizes)
    assert programs[30] == programs[300]


def _equations(jaxpr):
    for equation in jaxpr.eqns:
        yield equation
        for inner in jax.extend.core.jaxprs_in_params(equation.params):
            yield from _equations(inner)


@pytest.mark.parametrize("value", [True, False])
def test_constants_are_infinite(value):
    expected = np.inf if value else -np.inf
    margins = np.zeros((2, 3, 1), np.float32)
    values = robustness_signal(Constant(value), margins, ["A"])
    np.testing.assert_array_equal(values, np.full((2, 3), expected, np.float32))
    assert values.dtype == np.float32


def test_whole_numbers_and_spare_columns_are_fine():
    margins = np.array([[1, 2, -9], [3, -4, -9]])
    values = robustness_signal(parse("A | B"), margins, ["A", "B"])
    np.testing.assert_array_equal(values, [2.0, 3.0])
    np.testing.assert_array_equal(
        robustness_signal(parse("A | B"), jnp.asarray(margins), ["A", "B"]), values
    )


@pytest.mark.parametrize("text", ["F_[0:4](A)", "G_[0:4](A)", "!G_[0:4](A)", "(A)U_[0:4](A)"])
@pytest.mark.parametrize("library", [np, jnp])
def test_nan_satisfies_nothing(text, library):
    margins = np.ones((5, 1))
    margins[2] = np.nan
    assert not satisfied(parse(text), library.asarray(margins), ["A"])


@pytest.mark.parametrize("library", [np, jnp])
def test_a_short_trace_is_refused(library):
    formula = parse("F_[0:3](G_[0:2](A))")
    for function in (robustness, robustness_signal, satisfied):
        with pytest.raises(TraceError, match="has 5 steps.*5 steps ahead and needs at least 6"):
            function(formula, library.ones((5, 1)), ["A"])
        assert function(formula, library.ones((6, 1)), ["A"]).size == 1


def test_unknown_atoms_and_wrong_shapes_are_refused():
    with pytest.raises(TraceError, match="no margins for C, D; it has A, B"):
        robustness(parse("A & C & D"), np.ones((1, 2)), ["A", "B"])
    with pytest.raises(TraceError, match=r"shape \(1, 1\)"):
        robustness(parse("A"), np.ones((1, 1)), ["A", "B"])
    with pytest.raises(TraceError, match=r"shape \(3,\)"):
        robustness(parse("A"), np.ones(3), ["A", "B"])
    assert issubclass(TraceError, UserError)
