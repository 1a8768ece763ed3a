"""True physics on the host: the same episodes, and a simulation that breaks down."""

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.algorithm import Algorithm, PaperMode
from core.evaluation import evaluate
from core.programs import evaluation_programs, fresh_learner, training_programs
from core.training import TrainingConfig, train
from tests.core.toy import PointRobot, toy_task

SMALL = Algorithm(environments=16, minibatches=2, passes=1, choice_candidates=8)


@dataclass(frozen=True)
class HostPhysics:
    """The point robot in NumPy; beyond `cliff` [m] in x the simulation breaks down."""

    cliff: float = np.inf

    def step(self, states, actions):
        after = states + 0.5 * np.clip(actions, -1, 1)
        return np.where(after[:, :1] > self.cliff, np.nan, after)


@dataclass(frozen=True)
class HostRobot(PointRobot):
    """A point robot whose truth is on the host."""

    cliff: float = np.inf

    def physics(self):
        return HostPhysics(self.cliff)


@dataclass(frozen=True)
class CliffRobot(PointRobot):
    """A point robot whose own dynamics break down beyond x = 0.3 m."""

    def step(self, state, action):
        after = super().step(state, action)
        return jnp.where(after[0] > 0.3, jnp.nan, after)


def with_robot(robot):
    return replace(toy_task("F_[2:10](A) & G_[0:12](!D)"), robot=robot)


def test_rollouts_on_the_host_are_those_of_the_same_dynamics_in_jax():
    results = []
    for robot in (PointRobot(), HostRobot()):
        task = with_robot(robot)
        learner = fresh_learner(task, SMALL, 3)
        programs = evaluation_programs(task, SMALL, rollouts=8)
        states = programs.initial(task.problem, jax.random.key(1))
        schedules = jnp.full((8, 8), 5, jnp.int32)
        results.append(programs.roll_out(task.problem, learner.parameters, states, schedules))
    for one, other in zip(*results, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


def test_batches_on_the_host_are_those_of_the_same_dynamics_in_jax():
    task = with_robot(HostRobot())
    learner = fresh_learner(task, SMALL, 3)
    programs = training_programs(task, SMALL)
    model = programs.collect(task.problem, learner)
    truth = programs.collect_in_physics(task.problem, learner)
    for name, one, other in zip(model._fields, model, truth, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5, err_msg=name)


def test_without_physics_there_is_one_program():
    programs = training_programs(with_robot(PointRobot()), SMALL)
    assert programs.collect is programs.collect_in_physics


@pytest.mark.parametrize(
    ("mode", "robot"), [(SMALL.mode, HostRobot(cliff=0.3)), (PaperMode(), CliffRobot())]
)
def test_a_simulation_that_breaks_down_fails_alone_and_never_reaches_the_weights(mode, robot):
    task = with_robot(robot)
    algorithm = replace(SMALL, mode=mode, model_epochs=0)
    config = TrainingConfig(algorithm, epochs=2, target=2, evaluate_every=2)
    *_, last = train(task, config)
    assert 0 < last.diverged < 16 * task.steps
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(last.parameters))
    batch = training_programs(task, algorithm).collect_in_physics(task.problem, last.state.learner)
    for name in ("policy", "critic", "noise", "reward"):
        assert np.isfinite(getattr(batch, name)).all(), name
    assert last.evaluation is not None
    assert last.evaluation.diverged == (last.evaluation.robustness == -np.inf).sum()


def test_a_rollout_that_breaks_down_is_counted_as_failed():
    task = with_robot(HostRobot(cliff=-1.0))  # at once
    programs = evaluation_programs(task, SMALL, rollouts=8)
    learner = fresh_learner(task, SMALL, 3)
    result = evaluate(task, programs, learner.parameters, jax.random.key(0))
    assert result.diverged == 8
    assert result.success_rate == 0
    assert result.robustness_mean == -np.inf
