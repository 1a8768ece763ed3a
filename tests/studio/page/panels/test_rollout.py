"""What the verdict on a rollout says of what lies between its steps."""

import io

import jax.numpy as jnp
import numpy as np
import pytest

from core.task.problem import trace_margins
from studio.export.tables import rollout_npz, rollout_table
from studio.page.panels.rollout import verdict_html
from studio.runs.recording import record
from studio.runs.tasks import build_task
from tests.scenes.test_thin import HALF, THIN, closed_room


def trace(task):
    """A way out of the closed room, one state on either side of the wall above."""
    steps = np.minimum(np.arange(task.padded_horizon + 1), 8)
    states = np.stack([0 * steps, 0.05 + 0.38 * steps], 1).astype(np.float32)
    margins = np.asarray(trace_margins(task.problem, jnp.asarray(states[:, None])))[:, 0]
    return states, np.zeros((len(states) - 1, 2), np.float32), margins


@pytest.mark.parametrize("asked", [False, True])
def test_a_wall_that_is_jumped_is_told_once(asked):
    task = build_task(closed_room(between_steps=asked))
    shown = verdict_html(record(task, (8,), *trace(task)))
    told = f"between steps 3 and 4 it cuts above by 0.035 m at (0.0, {HALF})"
    assert shown.count(told) == 1
    if asked:
        assert ">Violated</span>" in shown and "Violated: it holds at every step, but" in shown
    else:
        assert ">Satisfied</span>" in shown and "Satisfied at every step; between" in shown


@pytest.mark.parametrize("asked", [False, True])
def test_an_exported_rollout_says_so_too(asked):
    task = build_task(closed_room(between_steps=asked))
    file = rollout_npz(rollout_table(task, np.array([8]), *trace(task)))
    found = np.load(io.BytesIO(file), allow_pickle=False)
    assert found["between_margin"] == pytest.approx(-THIN, abs=1e-3)
    assert (str(found["between_invariant"]), int(found["between_step"])) == ("!above", 3)
    np.testing.assert_allclose(found["between_position"], (0.0, HALF), atol=1e-2)
    assert bool(found["satisfied"]) != asked
