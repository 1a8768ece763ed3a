"""Flags against the semantics of the subformulas that they stand for."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.methods.f_mdp.flags import Flag, Interval, flags_of
from core.methods.f_mdp.method import FlagHistory
from core.stl import Atom, Not, parse, robustness_signal, satisfied
from tests.core.toy import CENTERS, disc_margins, toy_task

STEPS = 16
NAMES = tuple(CENTERS)


def walks(count: int, seed: int = 0) -> np.ndarray:
    """Random positions [count, STEPS + 1, 2] that enter and leave the discs."""
    random = np.random.default_rng(seed)
    jumps = random.normal(scale=0.8, size=(count, STEPS + 1, 2))
    return np.clip(np.cumsum(jumps, 1), -1.6, 1.6).astype(np.float32)


def followed(task, positions: np.ndarray):
    """Levels [R, STEPS + 1, S] and payments [R, STEPS + 1] along walks [R, STEPS + 1, 2]."""
    history = FlagHistory()
    data = history.data(task)

    def step(memory, state):
        observed = history.observe(task.problem, data, memory, state)
        return observed.memory, (observed.memory.level, observed.paid)

    @jax.jit
    @jax.vmap
    def along(walk):
        return jax.lax.scan(step, history.start(task.problem, data), walk)[1]

    return data, *map(np.asarray, along(jnp.asarray(positions)))


@pytest.mark.parametrize(
    "text", ["F_[2:6](A)", "G_[0:3](!B)", "F_[0:0](A | B & !C)", "G_[1:4](A | !C)"]
)
@pytest.mark.parametrize("shift", [0, 3])
def test_a_flag_says_whether_its_subformula_is_met(text, shift):
    """For one instance of it, at step c of F_[c:c]: once all that it reads has been read."""
    formula = parse(f"F_[{shift}:{shift}]({text})", names=NAMES)
    positions = walks(200)
    data, level, _ = followed(toy_task(formula), positions)
    met = level[:, -1, 0] == data.width[0] if text[0] == "G" else level[:, -1, 0] > 0
    expected = satisfied(formula, disc_margins(positions), NAMES)
    assert 0.01 < expected.mean() < 0.99
    np.testing.assert_array_equal(met, expected)


def test_a_flag_slides_with_the_instances_of_its_subformula():
    """At step t + b it is met iff the subformula holds at t, for every t of the outer window."""
    inner = parse("F_[1:3](A)", names=NAMES)
    formula = parse("G_[2:8](F_[1:3](A))", names=NAMES)
    positions = walks(200)
    _, level, _ = followed(toy_task(formula), positions)
    expected = robustness_signal(inner, disc_margins(positions), NAMES)[:, 2:9] >= 0
    np.testing.assert_array_equal(level[:, 5:12, 0] > 0, expected)


def test_payments_sum_to_the_share_that_is_met_at_the_end():
    task = toy_task("F_[1:4](F_[0:6](A) & G_[2:6](!B)) & F_[0:9](C)")
    data, level, paid = followed(task, walks(50))
    share = level[:, -1] / np.maximum(data.width, 1)
    expected = np.where(data.always, share, level[:, -1] > 0).sum(1) / 3
    np.testing.assert_allclose(paid.sum(1), expected, atol=1e-5)
    assert np.ptp(expected) > 0.4


def test_what_a_formula_s_flags_are():
    formula = parse("F_[5:7](F_[50:85](A) & G_[0:90](!B)) & (G_[0:3](A) | C)", names=NAMES)
    once = Interval(0, 0)
    assert flags_of(formula) == (
        Flag(Atom("A"), False, Interval(50, 85), Interval(5, 7)),
        Flag(Not(Atom("B")), True, Interval(0, 90), Interval(5, 7)),
        Flag(Atom("A"), True, Interval(0, 3), once),
        Flag(Atom("C"), False, once, once),
    )


def test_implications_are_read_as_disjunctions():
    formula = parse("F_[0:5](A) -> G_[0:5](B)", names=NAMES)
    assert [(flag.predicate, flag.always) for flag in flags_of(formula)] == [
        (Not(Atom("A")), True),
        (Atom("B"), True),
    ]
