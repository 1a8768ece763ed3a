"""Every robot trains, exports, reloads and is evaluated without the page, at small size."""

import numpy as np
import pytest

from envs import ENVS
from studio.files.bundle import load_bundle
from tests.studio.headless.test_commands import here, run

__all__ = ["here"]


@pytest.mark.parametrize("robot", ENVS)
def test_train_export_reload_evaluate(robot, here, capsys):
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
