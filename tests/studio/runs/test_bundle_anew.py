"""Policy bundles: times chosen anew after a push, with nothing but jax."""

import json
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np

from core.controller import pad_schedule
from core.rollout import roll_on
from studio.runs.controller import FAILED, functions_of
from studio.runs.tasks import initial_state
from tests.studio.runs.test_bundle import ELSEWHERE, policy, saved

__all__ = ["policy", "saved"]

# The robot is pushed at a step, and the README's function chooses the times anew.
PUSHED = """
k, xs = 30, np.zeros((len(states) + 1, len(x)), np.float32)
xs[:k + 1] = states[:k + 1]
xs[k] += np.float32(1.5)
before, pushed = t, xs[k].tolist()
t, s = plan_anew(xs, k, t)
states, actions, x = [], [], xs[k]
for _ in range(k, 110):
    s, action = step(s, x)
    x = your_robot(x, action)
values = [float(rescore(xs, np.int32(k), each)) for each in (before, t)]
print(json.dumps([xs[:k + 1].tolist(), before.tolist(), t.tolist(), values, states, actions]))
"""


def test_the_exported_controller_is_planned_anew(saved, policy, linear_task):
    code = (
        "\n".join(line for line in ELSEWHERE.splitlines() if not line.startswith("print(")) + PUSHED
    )
    command = [sys.executable, "-I", "-c", code]
    done = subprocess.run(command, cwd=saved, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    past, before, chosen, values, states, actions = json.loads(done.stdout)
    assert values[1] >= values[0]
    past, last = np.array(past, np.float32), len(past) - 1
    long = np.concatenate([past, np.repeat(past[-1:], linear_task.padded_horizon - last, 0)])[
        :, None
    ]
    rows = np.asarray(pad_schedule(linear_task.problem, jnp.array(chosen)))[None]
    rollout = roll_on(linear_task, policy.controller, long, np.array([last]), rows)
    ahead = slice(last, last + len(actions))
    np.testing.assert_allclose(states, rollout.states[ahead, 0], atol=1e-4)
    np.testing.assert_allclose(actions, rollout.actions[ahead, 0], atol=1e-4)


def test_what_the_past_has_missed_is_marked_down(policy, linear_task):
    """Nothing was met at the start: only times that lie ahead are promising."""
    rescore = jax.jit(functions_of(linear_task, policy.controller).rescore)
    xs = np.repeat(np.asarray(initial_state(linear_task))[None], linear_task.horizon + 1, 0)
    missed, ahead = (float(rescore(xs, 30, jnp.array(t))) for t in [(10, 44, 16), (90, 44, 16)])
    assert missed < ahead - FAILED / 2
    early = float(rescore(xs, 5, jnp.array((10, 44, 16))))
    assert early > missed + FAILED / 2
    first = functions_of(linear_task, policy.controller).score(xs[0], jnp.array((90, 44, 16)))
    at_once = rescore(xs, 0, jnp.array((90, 44, 16)))
    np.testing.assert_allclose(at_once, first, rtol=1e-4)
