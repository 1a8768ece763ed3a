"""What is left of a problem in the middle of an episode, and what has failed by then."""

import jax.numpy as jnp
import numpy as np

from core.controller import pad_schedule
from core.task.grounding import NEVER
from core.task.later import failures, later, past_margins
from core.task.windows import windows_of
from tests.core.toy import CENTERS, toy_task

TASK = toy_task("F_[0:9](A) & F_[0:12](G_[0:4](B)) & G_[2:14](!C)")


def schedule(*times):
    return pad_schedule(TASK.problem, jnp.asarray(times, jnp.int32))


def test_windows_come_nearer_and_those_that_are_over_do_not_open():
    windows = windows_of(later(TASK.problem, 6), schedule(3, 5))
    assert windows.count == 1
    assert (windows.start[0], windows.end[0]) == (0, 3)  # B has begun at 5 and lasts until 9
    assert windows.start[1] == NEVER
    assert (windows.constraint_start[0], windows.constraint_end[0]) == (0, 8)
    ahead = windows_of(later(TASK.problem, 2), schedule(3, 5))
    np.testing.assert_array_equal(ahead.start[:2], [1, 3])
    now = windows_of(later(TASK.problem, 0), schedule(3, 5))
    for found, expected in zip(now, windows_of(TASK.problem, schedule(3, 5)), strict=True):
        np.testing.assert_array_equal(found, expected)


def failed(places, step, *times):
    """Tasks that have failed on a way [T, 2] by a step."""
    mu = past_margins(TASK.problem, jnp.asarray(places, jnp.float32))
    return int(failures(TASK.problem, mu, jnp.asarray(step), schedule(*times)))


def test_failures_are_counted_up_to_the_step_and_no_further():
    way = [(0.0, 0.0)] * 3 + [CENTERS["A"]] + [(0.0, 0.0)] * 2 + [CENTERS["B"]] * 9
    assert failed(way, 14, 3, 6) == 0
    assert failed(way, 14, 4, 6) == 1  # not in A at step 4
    assert failed(way, 3, 4, 6) == 0  # not known yet
    assert failed(way, 14, 3, 5) == 1  # the stay begins too early
    assert failed([CENTERS["C"]] * 15, 14, 3, 6) == 3
    assert failed([CENTERS["C"]] * 15, 1, 3, 6) == 0
