from dataclasses import replace
from itertools import permutations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.decompose import DecompositionError, Kind, decompose
from core.stl import parse, robustness, to_text
from core.task.grounding import NEVER, ground
from core.task.problem import closed_doors, extended_margins
from core.task.sizes import LARGE, LARGEST, STANDARD, GroundingError
from core.task.windows import leg_slack, windows_of
from tests.core.toy import CENTERS, disc_margins, toy_task
from tests.strategies import formulas

windows_program = jax.jit(windows_of)


@settings(max_examples=120, deadline=None)
@given(
    formulas(max_depth=3, atoms=tuple(CENTERS), max_bound=6),
    st.lists(st.integers(0, 1000), min_size=32, max_size=32),
)
def test_windows_are_the_active_tasks(formula, seeds):
    """The padded arrays say the same as the decomposition, for any schedule."""
    try:
        task = toy_task(formula)
    except (DecompositionError, GroundingError):
        return
    variables = task.grounding.decomposition.variables
    schedule = np.zeros(task.grounding.sizes.variables, np.int32)
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
        mu, gradient = extended_margins(task.problem, position)
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
        (" & ".join(["F_[0:9](A)"] * 33), "33 time and branch variables, but at most 32"),
        (" & ".join(f"G_[{i}:99](A)" for i in range(65)), "65 subgoals, but at most 64"),
        (
            " & ".join(f"G_[{i}:999](!A)" for i in range(161)),
            "161 invariant constraints, but at most 160",
        ),
        (f"F_[0:9]({' & '.join(['(A | B)'] * 5)})", "needs 32 alternatives; at most 16"),
        (
            " & ".join(f"F_[0:9]({a} & {b} | {c})" for a, b, c in permutations("ABCD", 3))
            + " & "
            + " & ".join(f"F_[0:9]({a} & !{b} | {c})" for a, b, c in permutations("ABCD", 3)),
            "48 time and branch variables",
        ),
        (
            " & ".join(f"G_[0:9]({a} & {b} | {c})" for a, b, c in permutations("ABCD", 3))
            + " & "
            + " & ".join(f"G_[0:9]({a} & !{b} | {c})" for a, b, c in permutations("ABCD", 3)),
            "48 different state formulas .* at most 32",
        ),
        (" & ".join(f"G_[{i}:{i}](A & B | {c})" for i, c in enumerate("CD")), None),
    ],
)
def test_more_than_the_arrays_hold(formula, message):
    if message is None:
        toy_task(formula)
        return
    with pytest.raises(GroundingError, match=message):
        toy_task(formula)


ALTERNATIVES = " | ".join(f"{a} & {b}" for a, b in permutations("ABCD", 2))


@pytest.mark.parametrize(
    ("formula", "sizes"),
    [
        ("F_[0:9](A) & G_[0:9](!B)", STANDARD),
        (" & ".join(["F_[0:9](A)"] * 9), LARGE),
        (" & ".join(f"G_[{i}:99](A)" for i in range(16)), LARGE),
        (" & ".join(f"G_[{i}:99](!A)" for i in range(25)), LARGE),
        (" & ".join(["F_[0:9](A)"] * 17), replace(LARGEST, compounds=8, literals=4)),
        (f"F_[0:9]({ALTERNATIVES})", replace(STANDARD, literals=16)),
    ],
)
def test_larger_missions_have_larger_sizes(formula, sizes):
    assert toy_task(formula).grounding.sizes == sizes


def test_windows_of_one_predicate_are_one_door():
    """The gaps of a response: however many visits, its trigger is a door."""
    text = "G_[0:16](A -> F_[0:4](B)) & F_[0:9](A)"
    decomposition = decompose(parse(text), visits_extra=3)
    grounding = ground(decomposition, tuple(CENTERS), 16)
    assert len(grounding.doors) >= 4
    assert grounding.closed_sets() == [(), grounding.doors]
    assert grounding.sizes.doors == STANDARD.doors


def test_equal_places_share_their_fields():
    grounding = toy_task("G_[0:16](F_[0:4](A)) & F_[0:9](B)").grounding
    assert len(grounding.subgoals) == 5 and len(grounding.places) == 2
    places = [grounding.places[i] for i in grounding.arrays.place[:5]]
    assert places == [task.predicate for task in grounding.subgoals]


def test_a_forbidden_visit_has_no_time():
    """`!A` until step 5, and A at step 3: no schedule can do that, whatever the legs."""
    problem = toy_task("G_[0:5](!A) & F_[0:16](A)").problem
    for step, barred in ((3, True), (12, False)):
        schedule = jnp.zeros(8, jnp.int32).at[0].set(step)
        windows = windows_of(problem, schedule)
        _, short = leg_slack(problem, windows, jnp.zeros(2), 1.2)
        assert (float(short) >= 100) == barred


def test_more_regions_than_the_arrays_hold():
    decomposition = decompose(parse("F_[0:9](R0)"))
    names = tuple(f"R{i}" for i in range(33))
    with pytest.raises(GroundingError, match="33 regions, but at most 32"):
        ground(decomposition, names, 10)
    assert ground(decomposition, names[:32], 10).horizon == 10


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


def test_a_constraint_of_a_branch_is_closed_in_that_branch_alone():
    """`(F(A) & G(!B)) | F(C)`: on the way to C nothing is forbidden."""
    task = toy_task("(F_[0:9](A) & G_[0:9](!B)) | F_[0:9](C)", horizon=9)
    (branch,) = (
        index
        for index, variable in enumerate(task.grounding.decomposition.variables)
        if variable.kind != "time"
    )
    assert task.grounding.closed_sets() == [(), (0,)]
    closed = {}
    for choice in (0, 1):
        schedule = jnp.zeros(8, jnp.int32).at[branch].set(choice)
        windows = windows_of(task.problem, schedule)
        bounds = (windows.constraint_start, windows.constraint_end)
        goal = task.grounding.subgoals[int(windows.order[0])].predicate
        closed[to_text(goal)] = int(closed_doors(task.problem, *bounds, jnp.float32(0)))
    assert closed == {"A": 1, "C": 0}


def test_constraints_of_one_branch_share_a_door():
    text = "(F_[0:9](A) & G_[0:9](!B) & G_[0:9](!C) & G_[0:9](!D)) | F_[0:9](C)"
    grounding = toy_task(text, horizon=9).grounding
    assert grounding.closed_sets() == [(), grounding.doors]
    assert len(grounding.doors) == 3


def test_windows_are_no_matrix_product():
    """An accelerator rounds a product's factors: steps past 2048 would no longer be exact."""
    problem = toy_task("F_[0:9](A & F_[0:9](B)) & G_[0:9](F_[0:4](C))").problem
    schedule = jnp.zeros(8, jnp.int32)
    program = jax.make_jaxpr(lambda t: windows_of(problem, t))(schedule)
    slack = jax.make_jaxpr(lambda t: leg_slack(problem, windows_of(problem, t), jnp.zeros(2), 1.2))(
        schedule
    )
    assert "dot_general" not in str(program) + str(slack)
    control = jax.make_jaxpr(lambda t: problem.formula.subgoals.start_weight @ t)(schedule)
    assert "dot_general" in str(control)
