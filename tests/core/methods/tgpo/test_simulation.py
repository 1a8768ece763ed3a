"""True physics on the host: the same episodes, and a simulation that breaks down."""

from dataclasses import dataclass, field, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.evaluation import evaluate
from core.mdp.paper_mode import PaperMode
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.method import TgpoLearner
from core.methods.training import TrainingConfig, train
from core.rollout import roll_out, start_states
from tests.core.toy import PointRobot, toy_task

SMALL = Algorithm(
    environments=16, hidden=(16,), minibatches=2, passes=1, choice_candidates=8, evaluation_states=8
)
PHYSICAL = replace(SMALL, model_epochs=0)


@dataclass(frozen=True)
class HostPhysics:
    """The point robot in NumPy; beyond `cliff` [m] in x the simulation breaks down."""

    cliff: float = np.inf

    def warm_up(self, count):
        pass

    def step(self, states, actions):
        after = states + 0.5 * np.clip(actions, -1, 1)
        return np.where(after[:, :1] > self.cliff, np.nan, after)


@dataclass(frozen=True)
class HostRobot(PointRobot):
    """A point robot whose truth is on the host; programs do not depend on its cliff."""

    cliff: float = field(default=np.inf, compare=False)

    def physics(self):
        return HostPhysics(self.cliff)


@dataclass(frozen=True)
class CliffRobot(PointRobot):
    """A point robot whose own dynamics break down beyond x = 0.3 m."""

    def step(self, state, action):
        after = super().step(state, action)
        return jnp.where(after[0] > 0.3, jnp.nan, after)


def with_robot(robot):
    return toy_task("F_[2:10](A) & G_[0:12](!D)", robot=robot)


def untrained(task):
    learner = TgpoLearner(task, SMALL)
    return learner.controller(learner.fresh(3).parameters)


def test_rollouts_on_the_host_are_those_of_the_same_dynamics_in_jax():
    results = []
    for robot in (PointRobot(), HostRobot()):
        task = with_robot(robot)
        states = start_states(task.problem, jax.random.key(1), count=8)
        schedules = jnp.full((8, 8), 5, jnp.int32)
        results.append(roll_out(task, untrained(task), states, schedules))
    for one, other in zip(*results, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


def test_batches_on_the_host_are_those_of_the_same_dynamics_in_jax():
    task = with_robot(HostRobot())
    learner = TgpoLearner(task, SMALL)
    model = learner.collect(learner.fresh(3), 1)
    truth = TgpoLearner(task, PHYSICAL).collect(learner.fresh(3), 1)
    for name, one, other in zip(model._fields, model, truth, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5, err_msg=name)


def test_physics_gets_ready_before_the_first_step(monkeypatch):
    """What a simulator compiles is compiled with the rest, not in the time limit."""
    calls: list[str] = []

    class Recorder(HostPhysics):
        def warm_up(self, count):
            calls.append(f"ready for {count}")

        def step(self, states, actions):
            calls.append(f"step of {len(states)}")
            return super().step(states, actions)

    monkeypatch.setattr(HostRobot, "physics", lambda _: Recorder())
    list(train(with_robot(HostRobot()), TrainingConfig(PHYSICAL, epochs=1, evaluate_every=1)))
    first_steps = {step: calls.index(step) for step in set(calls) if step.startswith("step")}
    assert set(first_steps) == {"step of 8", "step of 16"}
    ready = {"ready for 8", "ready for 16"}
    assert ready <= set(calls[: min(first_steps.values())])


@pytest.mark.parametrize(
    ("mode", "robot"), [(SMALL.mode, HostRobot(cliff=0.3)), (PaperMode(), CliffRobot())]
)
def test_a_simulation_that_breaks_down_fails_alone_and_never_reaches_the_weights(mode, robot):
    task = with_robot(robot)
    algorithm = replace(PHYSICAL, mode=mode)
    config = TrainingConfig(algorithm, epochs=2, target=2, evaluate_every=2)
    *_, last = train(task, config)
    assert 0 < last.diverged < 16 * task.padded_horizon
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(last.weights))
    batch = TgpoLearner(task, algorithm).collect(last.state.learner, 1)
    for name in ("policy", "critic", "noise", "reward"):
        assert np.isfinite(getattr(batch, name)).all(), name
    assert last.evaluation is not None
    assert last.evaluation.diverged == (last.evaluation.robustness == -np.inf).sum()


def test_a_rollout_that_breaks_down_is_counted_as_failed():
    task = with_robot(HostRobot(cliff=-1.0))  # at once
    result = evaluate(task, untrained(task), jax.random.key(0), count=8)
    assert result.diverged == 8
    assert result.success_rate == 0
    assert result.robustness_mean == -np.inf
