"""Every baseline on a probe that it must solve, and one that it must fail for the paper's reason.

The probes are learnt in a few small epochs, the same number for both.
"""

from dataclasses import dataclass, replace

import jax.numpy as jnp
import pytest

from core.errors import UserError
from core.methods import METHODS
from core.methods.training import TrainingConfig, final_evaluation, fresh_state, train
from tests.core.toy import PointRobot, toy_task

SIZES = {
    "rnn": {"environments": 128, "units": 32},
    "cem": {"population": 64, "elite": 8, "starts": 2},
    "grad": {"environments": 64},
    "tau-mdp": {"environments": 128, "minibatches": 4},
    "f-mdp": {"environments": 128, "minibatches": 4},
}
EPOCHS = 10
REACH_AND_STAY = "F_[2:8](G_[0:6](A))"


@dataclass(frozen=True)
class Quantised(PointRobot):
    """Moves by whole quarters of its speed: the gradient of its step is zero wherever it exists."""

    name: str = "quantised"

    def step(self, state, action):
        return super().step(state, jnp.round(4 * action) / 4)


@dataclass(frozen=True)
class Heavy(PointRobot):
    """Two axes, each a chain of four integrators: eight numbers, and unstable."""

    name: str = "heavy"
    state_size: int = 8

    def rest(self, key, position):
        del key
        return jnp.concatenate([position, jnp.zeros(6)])

    def place(self, key, position):
        return self.rest(key, position)

    def step(self, state, action):
        chain = state.reshape(4, 2)
        pushed = jnp.concatenate([chain[1:], jnp.clip(action, -1, 1)[None]])
        return (chain + self.speed * pushed).reshape(-1)

    def position(self, state):
        return state[:2]

    def observe(self, state):
        return state[2:]


def config(method: str) -> TrainingConfig:
    preset = METHODS[method].preset("studio", PointRobot())
    small = replace(preset, hidden=(32, 32), evaluation_states=32, **SIZES[method])
    return TrainingConfig(small, method, seed=3, epochs=EPOCHS)


def learnt(task, method: str) -> tuple[float, float]:
    """Success rates before and after a training."""
    asked = config(method)
    before = final_evaluation(task, asked, fresh_state(task, asked).best)
    *_, last = train(task, asked)
    return before.success_rate, final_evaluation(task, asked, last.state.best).success_rate


@pytest.mark.parametrize("method", SIZES)
def test_it_reaches_a_goal_and_stays(method):
    before, after = learnt(toy_task(REACH_AND_STAY), method)
    assert before < 0.2
    assert after > 0.8


@pytest.mark.parametrize("method", ["rnn", "tau-mdp"])
def test_a_reward_at_the_end_of_a_long_episode_teaches_less(method):
    """The formula is decided at step 14, but the episode goes on six times as long as above."""
    _, after = learnt(toy_task(REACH_AND_STAY, horizon=96), method)
    assert after < 0.5


def test_populations_do_not_find_what_a_system_of_higher_order_needs():
    _, after = learnt(toy_task(REACH_AND_STAY, robot=Heavy()), "cem")
    assert after < 0.2


def test_dynamics_without_gradients_teach_nothing():
    """The policy stays as it was; without gradients the same robot learns."""
    task = toy_task(REACH_AND_STAY, robot=Quantised())
    before, after = learnt(task, "grad")
    assert before == after == 0
    assert learnt(task, "cem")[1] > 0.5


@pytest.mark.parametrize(
    ("formula", "part"),
    [
        ("F_[0:4](A & F_[0:4](G_[0:2](B)))", "F_[0:4](G_[0:2](B))` holds a third layer"),
        ("F_[0:4](A) & (!B)U_[0:9](C)", "(!B)U_[0:9](C)` is an until"),
    ],
)
def test_flags_are_for_two_layers(formula, part):
    with pytest.raises(UserError) as refused:
        fresh_state(toy_task(formula), config("f-mdp"))
    assert part in str(refused.value)
