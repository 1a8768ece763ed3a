"""Learning on many layouts: which ones an epoch sees, and that they do not mix."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.methods.tgpo.collection import Sources
from core.methods.tgpo.layouts import LayoutStack
from core.methods.tgpo.method import TgpoLearner, _collect
from scenes import load_task
from studio.runs.layouts import Drawing


def _source(number: int) -> Any:
    return {"number": jnp.int32(number), "table": jnp.full((2, 3), number, jnp.float32)}


def _numbers(stack, epoch: int) -> list[int]:
    problems: Any = stack.at(epoch)
    numbers = np.asarray(problems["number"])
    np.testing.assert_array_equal(problems["table"][:, 1, 2], numbers)
    return numbers.tolist()


def test_every_epoch_replaces_the_oldest_layouts():
    stack = LayoutStack(_source, 4, 1, 1)
    seen = [_numbers(stack, epoch) for epoch in range(1, 8)]
    assert [sorted(numbers) for numbers in seen] == [list(range(e, e + 4)) for e in range(7)]


@pytest.mark.parametrize("fresh", [0, 1, 4])
def test_a_run_that_goes_on_sees_the_same_layouts(fresh):
    whole = LayoutStack(_source, 4, fresh, 1)
    seen = [_numbers(whole, epoch) for epoch in range(1, 7)]
    later = LayoutStack(_source, 4, fresh, 4)
    assert [_numbers(later, epoch) for epoch in range(4, 7)] == seen[3:]


def test_an_error_of_the_source_reaches_the_caller():
    def broken(number: int) -> Any:
        raise ValueError(f"layout {number}")

    with pytest.raises(ValueError, match="layout 0"):
        LayoutStack(broken, 2, 1, 1).at(1)


def test_each_layout_has_its_own_environments(linear_task, small_algorithm):
    """The batch of two layouts holds, side by side, the batches of each of them alone."""
    algorithm = replace(small_algorithm, layouts=2, environments=16)
    drawing = Drawing(load_task("linear-08"), linear_task, algorithm, 3)
    problems = [drawing(number) for number in range(2)]
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves), *problems)
    state = TgpoLearner(linear_task, algorithm).fresh(0)
    key, steps = jax.random.key(5), linear_task.padded_horizon
    sources = Sources(state.parameters, state.chains, state.elite)
    both = _collect(stacked, sources, key, algorithm=algorithm, steps=steps)
    half = replace(algorithm, environments=8, layouts=1)
    keys, chains = jax.random.split(key, 2), jnp.split(state.chains, 2)
    for index, problem in enumerate(problems):
        mine = sources._replace(chains=chains[index])
        alone = _collect(problem, mine, keys[index], algorithm=half, steps=steps)
        mine = slice(8 * index, 8 * index + 8)
        np.testing.assert_allclose(both.states[:, mine], alone.states, atol=1e-4)
        np.testing.assert_allclose(both.reward[:, mine], alone.reward, atol=1e-4)
        np.testing.assert_array_equal(both.schedule[mine], alone.schedule)
    assert not np.allclose(both.states[:, :8], both.states[:, 8:])
