"""The gait's training: its pieces at small size. It made what ships and is not run anew here."""

import subprocess
import sys

import numpy as np
import pytest

from envs.ant.gait import FEATURES, gait_metadata, read_gait, shipped_gait
from envs.ant.gait_training import __main__ as training
from envs.ant.gait_training import learner
from envs.ant.gait_training.chase import Chase
from envs.ant.model import MOTORS, STANDING
from envs.ant.native import NativePhysics

ANTS, STEPS = 8, 4


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(training, "ANTS", ANTS)
    monkeypatch.setattr(training, "STEPS", STEPS)
    weights = learner.initial_weights(3, FEATURES, MOTORS)
    chase = Chase(NativePhysics(shipped_gait(), 1.0), ANTS, seed=3)
    return weights, chase, training.Statistics()


def test_an_iteration_changes_the_weights_and_packs_a_gait(small, monkeypatch):
    weights, chase, statistics = small
    samples, seen = training.gather(chase, weights, statistics, np.random.default_rng(3))
    assert samples.observation.shape == (ANTS * STEPS, FEATURES)
    assert samples.action.shape == (ANTS * STEPS, MOTORS)
    assert all(np.isfinite(np.asarray(leaf)).all() for leaf in samples)
    assert set(seen) == {"falls_per_1000", "speed"}
    before = np.asarray(weights.actor[0][0]).copy()  # the update takes the weights over
    order = np.arange(ANTS * STEPS).reshape(2, -1)
    after, _, divergence = learner.update(
        weights, learner.OPTIMIZER.init(weights), samples, order, 5e-4
    )
    assert np.isfinite(divergence)
    assert np.abs(np.asarray(after.actor[0][0]) - before).max() > 1e-5
    gait = read_gait(training.pack(after, statistics, {"seed": 3}))
    torques = gait.torques(np.tile(STANDING, (2, 1)), np.ones((2, 2)))
    assert torques.shape == (2, MOTORS) and np.isfinite(torques).all()


def test_advantages_follow_their_recurrence():
    random = np.random.default_rng(0)
    reward, value = random.normal(size=(3, 2)), random.normal(size=(4, 2))
    over = np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]])
    found = learner.advantages(reward, value, over)
    decay = learner.DISCOUNT * learner.TRACE
    error = reward + learner.DISCOUNT * value[1:] * (1 - over) - value[:-1]
    expected = error[0, 0] + decay * error[1, 0] + decay**2 * error[2, 0]
    assert found[0, 0] == pytest.approx(expected)
    assert found[0, 1] == pytest.approx(reward[0, 1] - value[0, 1])  # its episode ended there


def test_the_shipped_gait_says_how_it_was_made():
    """By the defaults of the training as it stands."""
    made, default = gait_metadata(), training.Options()
    assert (made["seed"], made["iterations"]) == (default.seed, default.iterations)
    assert made["steps"] == default.iterations * training.STEPS * training.ANTS


def test_what_only_the_training_and_the_simulators_need_is_imported_there():
    heavy = {"brax", "mujoco", "optax", "tyro", "envs.ant.gait_training"}
    code = f"import sys, envs; print(sorted({heavy!r} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
