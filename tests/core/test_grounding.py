import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.decompose import DecompositionError, Kind, decompose
from core.grounding import NEVER, GroundingError, ground
from core.problem import extended_margins
from core.stl import parse, robustness
from core.windows import windows_of
from tests.core.toy import CENTERS, DiscWorld, PointRobot, disc_margins, toy_task
from tests.strategies import formulas

windows_program = jax.jit(windows_of)


@settings(max_examples=120, deadline=None)
@given(
    formulas(max_depth=3, atoms=tuple(CENTERS), max_bound=6),
    st.lists(st.integers(0, 1000), min_size=8, max_size=8),
)
def test_windows_are_the_active_tasks(formula, seeds):
    """The padded arrays say the same as the decomposition, for any schedule."""
    try:
        task = toy_task(formula)
    except (DecompositionError, GroundingError):
        return
    variables = task.grounding.decomposition.variables
    schedule = np.zeros(8, np.int32)
    for i, variable in enumerate(variables):
        schedule[i] = variable.low + seeds[i] % (variable.high - variable.low + 1)
    windows = windows_program(task.problem, jnp.asarray(schedule))
    active = task.grounding.decomposition.active_tasks(schedule[: len(variables)].tolist())
    expected = {True: [], False: []}
    for item, start, end in active:
        if start <= end:
            expected[item.kind is Kind.INVARIANT].append((start, end))
    count = int(windows.count)
    found = list(zip(windows.start[:count].tolist(), windows.end[:count].tolist(), strict=True))
    assert sorted(found) == sorted(expected[False])
    assert found == sorted(found, key=lambda window: window[0])
    opens = np.asarray(windows.constraint_start) < NEVER
    starts, ends = windows.constraint_start[opens], windows.constraint_end[opens]
    assert sorted(zip(starts.tolist(), ends.tolist(), strict=True)) == sorted(expected[True])


@pytest.mark.parametrize(
    "state_formula",
    ["A", "!A", "A & !B", "A | B", "(A & B) | (!C & D)", "!(A & (B | C))", "A & (B | C) & !D"],
)
def test_extended_margins_evaluate_state_formulas(state_formula):
    """The predicate of a task has the robustness and the gradient of its state formula."""
    task = toy_task(f"F_[1:9]({state_formula})")
    arrays = task.problem.formula.subgoals
    positions = np.random.default_rng(3).uniform(-2, 2, (50, 2)).astype(np.float32)

    def value(position):
        mu, gradient = extended_margins(PointRobot(), DiscWorld(), task.problem, position)
        index, sign = arrays.predicate[0], arrays.sign[0]
        return sign * mu[index], sign * gradient[index]

    found, gradient = jax.vmap(value)(positions)
    formula = parse(state_formula)
    expected = robustness(formula, disc_margins(positions)[:, None, :], tuple(CENTERS))
    np.testing.assert_allclose(found, expected, atol=1e-5)
    step = np.array([1e-3, 0.0], np.float32)
    slope = (jax.vmap(value)(positions + step)[0] - jax.vmap(value)(positions - step)[0]) / 2e-3
    smooth = np.abs(slope) > 1e-2  # a kink between the two positions has no derivative
    error = np.abs(np.asarray(gradient[:, 0]) - np.asarray(slope))
    assert np.mean(error[smooth] < 2e-2) > 0.9


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (" & ".join(["F_[0:9](A)"] * 9), "9 time and branch variables, at most 8"),
        (
            " & ".join(f"G_[{i}:9](A)" for i in range(9))
            + " & "
            + " & ".join(f"G_[0:{i}](B)" for i in range(4)),
            "13 subgoals, at most 12",
        ),
        (" & ".join(f"G_[0:{i}](!A)" for i in range(25)), "25 invariant constraints, at most 24"),
        ("F_[0:9](A | B | C | D | !A)", "more than 4 alternatives"),
        (" & ".join(f"G_[{i}:{i}](A & B | {c})" for i, c in enumerate("CD")), None),
    ],
)
def test_more_than_the_arrays_hold(formula, message):
    if message is None:
        toy_task(formula)
        return
    with pytest.raises(GroundingError, match=message):
        toy_task(formula)


def test_more_regions_than_the_arrays_hold():
    decomposition = decompose(parse("F_[0:9](R0)"))
    names = tuple(f"R{i}" for i in range(33))
    with pytest.raises(GroundingError, match="33 regions, at most 32"):
        ground(decomposition, names, 10)
    assert ground(decomposition, names[:32], 10).steps == 10


def test_unknown_region():
    with pytest.raises(GroundingError, match=r"unknown region 'X'.*Available"):
        ground(decompose(parse("F_[0:9](X)")), ("A",), 10)


def test_episode_reaches_the_formula_s_horizon():
    assert toy_task("F_[0:90](A)", horizon=20).horizon == 90
    assert toy_task("F_[0:9](A)", horizon=20).horizon == 20


def test_doors_are_the_constraints_that_open():
    grounding = toy_task("(!A)U_[0:16](B) & G_[0:16](!C) & F_[0:16](D)").grounding
    assert grounding.doors == (0,)
    assert grounding.closed_sets() == [(1,), (1, 0)]
    assert toy_task("G_[0:16](!C) & F_[0:16](D)").grounding.closed_sets() == [(0,)]
