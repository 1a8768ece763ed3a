import jax
import jax.numpy as jnp
import numpy as np

from core.task.windows import task_windows


def test_windows_do_not_depend_on_the_place_in_a_batch(linear_task):
    """A batch gives each schedule what NumPy gives it (jaxlib 0.10.2 did not)."""
    tasks = linear_task.problem.formula.subgoals
    variables = tasks.start_weight.shape[1]
    schedules = np.random.default_rng(0).integers(0, 100, (4096, variables)).astype(np.int32)
    windows = jax.jit(jax.vmap(task_windows, (None, 0)))(tasks, jnp.asarray(schedules))
    for index, weight, offset in (
        (0, tasks.start_weight, tasks.start_offset),
        (1, tasks.end_weight, tasks.end_offset),
    ):
        expected = schedules @ np.asarray(weight).T + np.asarray(offset)
        found = np.asarray(windows[index])
        opens = found < 1e5
        assert opens.any(0).sum() == np.asarray(tasks.mask).sum()
        np.testing.assert_array_equal(found[opens], expected[opens])
