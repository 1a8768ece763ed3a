"""Learning on many layouts at once: problems of one shape, stacked.

A source gives the n-th layout's problem. Epoch e learns on the M layouts (e - 1) F, ...,
(e - 1) F + M - 1: the environments are divided among them, and for the next epoch the F oldest are
replaced. Which layouts an epoch uses depends only on its number, so a run resumed from a
checkpoint sees the same layouts as the uninterrupted run. The next layouts are made in the
background.
"""

from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial

import jax
import jax.numpy as jnp

from core.methods.tgpo.algorithm import Algorithm
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task


class LayoutStack:
    """The layouts of successive epochs, as problems stacked along a new axis [M, ...].

    Args:
        source: makes the problem of the n-th layout, always the same one.
        count: M.
        fresh: F <= M, layouts that are new in every epoch; 0 keeps the first M.
        epoch: the first epoch that will be requested.
    """

    def __init__(self, source: Callable[[int], Problem], count: int, fresh: int, epoch: int):
        self._source, self._count, self._fresh = source, count, fresh
        self._pool = ThreadPoolExecutor(2, thread_name_prefix="layouts")
        self._jobs: dict[int, Future[Problem]] = {}
        self._stack: Problem | None = None
        self._numbers: list[int] = []
        self._prepare(self._wanted(epoch))

    def at(self, epoch: int) -> Problem:
        """Stacked problems of an epoch, counted from 1; those of earlier calls are used up."""
        wanted = self._wanted(epoch)
        stack = self._stack
        if stack is None:
            self._numbers = sorted(wanted, key=lambda number: number % self._count)
            problems = [self._made(number) for number in self._numbers]
            stack = jax.tree.map(lambda *leaves: jnp.stack(leaves), *problems)
        for slot, old in enumerate(self._numbers):
            if old not in wanted:
                self._numbers[slot] = old + self._count
                stack = _put(stack, self._made(old + self._count), jnp.int32(slot))
        self._stack = stack
        self._prepare(range(wanted.stop, wanted.stop + self._fresh))
        return stack

    def _made(self, number: int) -> Problem:
        self._prepare((number,))
        return self._jobs.pop(number).result()

    def _wanted(self, epoch: int) -> range:
        first = (epoch - 1) * self._fresh
        return range(first, first + self._count)

    def _prepare(self, numbers: Iterable[int]) -> None:
        for number in numbers:
            if number not in self._jobs:
                self._jobs[number] = self._pool.submit(self._source, number)


def epoch_problems(task: Task, algorithm: Algorithm, epoch: int) -> Callable[[int], Problem]:
    """A function from an epoch, from the given one on, to the problem(s) to learn on."""
    if algorithm.layouts == 1:
        return lambda _: task.problem
    assert task.layouts is not None, "an algorithm of several layouts needs a task with layouts"
    source, fresh = task.layouts.training, algorithm.fresh_layouts
    return LayoutStack(source, algorithm.layouts, fresh, epoch).at


@partial(jax.jit, donate_argnums=0)
def _put(stack: Problem, problem: Problem, slot: Array) -> Problem:
    return jax.tree.map(lambda leaf, new: leaf.at[slot].set(new), stack, problem)
