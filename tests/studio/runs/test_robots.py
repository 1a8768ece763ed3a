"""Every robot trains, exports, reloads and is evaluated without the page, at small size."""

from pathlib import Path

import jax
import numpy as np
import pytest

from envs import ENVS, Panda
from scenes import Scene, margins, region_arrays
from studio.runs.bundle import load_bundle
from studio.runs.tasks import robot_of
from tests.studio.runs.test_commands import here, run

__all__ = ["here"]


@pytest.mark.parametrize("robot", ENVS)
def test_train_export_reload_evaluate(robot, here, capsys, monkeypatch):
    task = f"{robot}-demo"
    status, lines, _ = run(
        capsys, "--train-only", "--task", task, "--target", "2", "--epochs", "2", "--out", "x"
    )
    assert status == 0
    assert [line.get("epoch") for line in lines] == [1, 2, None]
    assert all(line["diverged"] == 0 for line in lines[:-1])

    policy = load_bundle(here / "x" / "bundle")
    assert policy.scene.name == task
    status, (again,), _ = run(capsys, "--evaluate", "x")
    assert status == 0
    assert again["success_rate"] == lines[-1]["success_rate"]
    np.testing.assert_allclose(again["robustness_mean"], lines[-1]["robustness_mean"], rtol=1e-6)

    monkeypatch.chdir(here / "x" / "bundle")
    states, actions = by_the_readme(policy.scene)
    assert len(actions) == policy.scene.horizon
    assert np.isfinite(actions).all() and np.isfinite(states).all()
    check_start(policy.scene, states[0])


def by_the_readme(scene: Scene) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """States and actions of the code in README.txt, as printed, with the scene's robot."""
    lines = Path("README.txt").read_text(encoding="utf-8").splitlines()
    code = [line[4:] for line in lines if line.startswith("    ")]
    states, actions = [], []
    step = jax.jit(robot_of(scene).step)

    def your_robot(x, action):
        states.append(np.asarray(x))
        actions.append(np.asarray(action))
        return step(x, action)

    exec("\n".join(code[code.index("import jax") :]), {"your_robot": your_robot})
    return states, actions


def check_start(scene: Scene, state: np.ndarray) -> None:
    """A state that the robot can be in, at a position of the initial set."""
    robot = robot_of(scene)
    initial = region_arrays((scene.initial,), scene.dimension, 1)
    assert margins(initial, robot.position(jax.numpy.asarray(state)))[0] >= 0
    if scene.robot == "ant":
        height, quaternion = state[2], state[3:7]
        assert height > 0.3 and abs(np.linalg.norm(quaternion) - 1) < 1e-5
    if isinstance(robot, Panda):
        assert (robot.low <= state).all() and (state <= robot.high).all()
