"""Joins of signals over time, exact and smooth, for NumPy and JAX arrays alike.

An algebra has an associative join: the maximum, or log-sum-exp, its smooth counterpart. The meet
is its dual, `-join(-x, -y)`. A signal is an array [..., L] with time last; everything here takes
time linear in L and has no loop over L in the JAX program other than scans.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

Array = Any  # np.ndarray or jax.Array; an operation keeps the kind


@dataclass(frozen=True)
class Algebra:
    """A join and what follows from it."""

    join: Callable[[Array, Array], Array]
    """Elementwise and associative."""

    accumulate: Callable[[Array], Array]
    """Running join along the last axis."""

    scan_back: Callable[[Callable[[Array, Array], Array], Array, Array], Array]
    """`scan_back(step, last, xs)` [..., L + 1] of carries: `last`, and backwards in time
    `carry = step(carry, x)` for the x of xs [L, ...]."""

    xp: Any
    """The array library: `numpy` or `jax.numpy`."""

    def meet(self, left: Array, right: Array) -> Array:
        """Join of the dual order, elementwise."""
        return -self.join(-left, -right)

    def slide(self, signal: Array, width: int) -> Array:
        """Join over every window of `width` steps: [..., L] to [..., L - width + 1].

        Blocks of `width` steps are accumulated forwards and backwards; a window is the end of one
        block and the beginning of the next (van Herk 1992; Gil and Werman 1993). The two parts
        are disjoint, hence no element is counted twice by a join that is not idempotent.
        """
        length = signal.shape[-1]
        if width == 1:
            return signal
        if width == length:
            return self.accumulate(signal)[..., -1:]
        blocks = self._blocks(signal, width)
        running = self.accumulate(self.xp.stack([blocks, self.xp.flip(blocks, -1)]))
        heads, tails = _unblocked(running[0]), _unblocked(self.xp.flip(running[1], -1))
        tails = tails[..., : length - width + 1]
        return self._across(tails, self.join(tails, heads[..., width - 1 : length]), width)

    def slide_until(self, left: Array, right: Array, width: int) -> Array:
        """Join over k < width of the meet of right(t + k) and of left over [t, t + k].

        From [..., L] to [..., L - width + 1], in blocks like `slide`: a window is met either in
        its tail of one block, or in the head of the next when left holds throughout the tail.
        The value at t depends on the window [t, t + width - 1] and on nothing else.
        """
        length = left.shape[-1]
        if width == 1:
            return self.meet(left, right)
        if width == length:
            return self._until_the_end(left, right)[..., :1]
        left, right = self._blocks(left, width), self._blocks(right, width)
        tails = _unblocked(self._until_the_end(left, right))[..., : length - width + 1]
        held = -self.accumulate(-self.xp.stack([left, self.xp.flip(left, -1)]))
        heads = _unblocked(self.accumulate(self.meet(held[0], right)))
        throughout = _unblocked(self.xp.flip(held[1], -1))[..., : length - width + 1]
        later = self.meet(throughout, heads[..., width - 1 : length])
        return self._across(tails, self.join(tails, later), width)

    def _until_the_end(self, left: Array, right: Array) -> Array:
        """The until of [t, L - 1] for every t: u(t) = meet(left, join(right, u(t + 1)))."""

        def step(later: Array, now: Array) -> Array:
            return self.meet(now[0], self.join(now[1], later))

        pairs = self.xp.moveaxis(self.xp.stack([left, right]), -1, 0)  # [L, 2, ...]
        return self.scan_back(step, self.meet(left[..., -1], right[..., -1]), pairs[:-1])

    def _blocks(self, signal: Array, width: int) -> Array:
        """[..., L] as [..., ceil(L / width), width]; the padding is in no window."""
        batch, length = signal.shape[:-1], signal.shape[-1]
        count = -(-length // width)
        padded = self.xp.pad(signal, [(0, 0)] * len(batch) + [(0, count * width - length)])
        return padded.reshape(*batch, count, width)

    def _across(self, within: Array, across: Array, width: int) -> Array:
        """Values of the windows that are a whole block, and of those across two blocks."""
        whole_block = np.arange(within.shape[-1]) % width == 0
        return self.xp.where(self.xp.broadcast_to(whole_block, within.shape), within, across)


def _unblocked(blocks: Array) -> Array:
    return blocks.reshape(*blocks.shape[:-2], -1)


def exact_algebra(signal: Array) -> Algebra:
    """Return the maximum, in the library of the signal."""
    if isinstance(signal, jax.Array):
        return Algebra(jnp.maximum, _accumulate_jax(jnp.maximum), _scan_jax, jnp)
    return Algebra(np.maximum, _accumulate_numpy(np.maximum), _scan_numpy, np)


def smooth_algebra(signal: Array) -> Algebra:
    """Return log-sum-exp at temperature 1, in the library of the signal."""
    if isinstance(signal, jax.Array):
        return Algebra(jnp.logaddexp, _accumulate_jax(jnp.logaddexp), _scan_jax, jnp)
    return Algebra(np.logaddexp, _accumulate_numpy(np.logaddexp), _scan_numpy, np)


def _accumulate_numpy(join: np.ufunc) -> Callable[[Array], Array]:
    return lambda signal: join.accumulate(signal, axis=-1)


def _accumulate_jax(join: Callable[[Array, Array], Array]) -> Callable[[Array], Array]:
    """Accumulate by a sequential scan.

    On a CPU it compiles and runs several times faster, above all with gradients, than the
    associative scans `jax.lax.cummax` and `cumlogsumexp`.
    """

    def accumulate(signal: Array) -> Array:
        def body(carry: Array, x: Array) -> tuple[Array, Array]:
            carry = join(carry, x)
            return carry, carry

        xs = jnp.moveaxis(signal, -1, 0)
        _, rest = jax.lax.scan(body, xs[0], xs[1:])
        return jnp.moveaxis(jnp.concatenate([xs[:1], rest]), 0, -1)

    return accumulate


def _scan_jax(step: Callable[[Array, Array], Array], last: Array, xs: Array) -> Array:
    def body(carry: Array, x: Array) -> tuple[Array, Array]:
        carry = step(carry, x)
        return carry, carry

    _, carries = jax.lax.scan(body, last, xs, reverse=True)
    return jnp.concatenate([jnp.moveaxis(carries, 0, -1), last[..., None]], axis=-1)


def _scan_numpy(step: Callable[[Array, Array], Array], last: Array, xs: Array) -> Array:
    carries = [last]
    for x in xs[::-1]:
        carries.append(step(carries[-1], x))
    return np.stack(carries[::-1], axis=-1)
