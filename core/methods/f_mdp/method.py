"""F-MDP: a flag for each subformula is part of the state, and PPO learns from flags and robustness.

App. A.3 (after Venkataraman et al. 2020, who learn by tabular Q-learning). The paper does not say
what its version in PPO is paid. Here it is paid, at every step, the rise of what the flags have
met,

    r_k = mean over flags of (y_k - y_{k-1}),    y = z/w for a G, and 1(z > 0) for an F,

in robot lengths, and the robustness at the end, as the other baselines are. The sum over an episode
telescopes: it earns the share of the subformulas that it has met at its end, however it came there.

Dimensions: S flags (padded), L literals, A atoms, n state.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from core.errors import UserError
from core.methods.f_mdp.flags import Flag, flags_of
from core.methods.whole_formula.features import state_features
from core.methods.whole_formula.feed_forward import Observed, feed_forward_method
from core.task.clauses import clauses_of
from core.task.problem import Problem, atom_margins
from core.task.protocols import Array
from core.task.task import Task

CAPACITIES = (16, 32, 128)
"""S: programs are compiled for the smallest that holds the formula's flags."""

LITERALS = (1, 4, 16)
"""L, alternatives of a state formula, and regions of an alternative: the smallest that will do."""


class FlagArrays(NamedTuple):
    """The flags of a formula as data."""

    atom: Array  # [S, L, L] atom of each literal of each clause of psi
    sign: Array  # [S, L, L] its sign, 0 for padding
    always: Array  # [S] whether it is a G
    width: Array  # [S] w, 0 for padding
    first: Array  # [S] steps that are read
    last: Array  # [S]


class Flags(NamedTuple):
    """The flags after a step."""

    level: Array  # [S] z [steps]
    step: Array  # [] the next step


@dataclass(frozen=True)
class FlagHistory:
    """A `History` that keeps a flag for each subformula."""

    def data(self, task: Task) -> FlagArrays:
        """The flags of the task's formula.

        Raises:
            UserError: it is not of two layers, or too large.
        """
        return _arrays(flags_of(task.formula), task.grounding.atoms)

    def start(self, problem: Problem, data: FlagArrays) -> Flags:
        """Nothing is met."""
        del problem
        return Flags(jnp.zeros_like(data.width), jnp.zeros((), jnp.int32))

    def observe(self, problem: Problem, data: FlagArrays, memory: Flags, state: Array) -> Observed:
        """The flags with a further state [n]."""
        margin, _ = atom_margins(problem, state, memory.step)
        held = jnp.where(data.always, jnp.minimum(memory.level + 1, data.width), data.width)
        missed = jnp.where(data.always, 0, jnp.maximum(memory.level - 1, 0))
        read = (data.first <= memory.step) & (memory.step <= data.last)
        level = jnp.where(read, jnp.where(_holds(data, margin), held, missed), memory.level)
        risen = (_met(data, level) - _met(data, memory.level)).sum()
        paid = risen / jnp.maximum((data.width > 0).sum(), 1)
        own = state_features(problem, state, memory.step)
        features = jnp.concatenate([own, _share(data, level)])
        return Observed(Flags(level, memory.step + 1), features, paid)


def _holds(data: FlagArrays, margin: Array) -> Array:
    """Whether psi holds [S] at margins [A]: some clause, all of its literals."""
    literal = jnp.where(data.sign == 0, True, data.sign * margin[data.atom] >= 0)
    used = (data.sign != 0).any(-1)
    return (literal.all(-1) & used).any(-1)


def _share(data: FlagArrays, level: Array) -> Array:
    """z / w [S], 0 for padding."""
    return level / jnp.maximum(data.width, 1)


def _met(data: FlagArrays, level: Array) -> Array:
    """y [S]: how far subformulas are met."""
    return jnp.where(data.always, _share(data, level), (level > 0) * 1.0)


def _arrays(flags: tuple[Flag, ...], atoms: tuple[str, ...]) -> FlagArrays:
    clauses = [clauses_of(flag.predicate, LITERALS[-1]) for flag in flags]
    widest = max((max(len(each), *map(len, each)) for each in clauses), default=1)
    size = next(size for size in LITERALS if size >= widest)
    capacity = _capacity(len(flags))
    atom = np.zeros((capacity, size, size), np.int32)
    sign = np.zeros((capacity, size, size), np.float32)
    for i, alternatives in enumerate(clauses):
        for j, clause in enumerate(alternatives):
            for k, (name, polarity) in enumerate(clause):
                atom[i, j, k], sign[i, j, k] = atoms.index(name), polarity
    numbers = np.zeros((4, capacity), np.int32)
    for i, flag in enumerate(flags):
        numbers[:, i] = flag.always, flag.width, flag.first, flag.last
    always, width, first, last = map(jnp.asarray, numbers)
    return FlagArrays(jnp.asarray(atom), jnp.asarray(sign), always > 0, width, first, last)


def _capacity(count: int) -> int:
    capacity = next((size for size in CAPACITIES if size >= count), None)
    if capacity is None:
        raise UserError(
            f"f-mdp: the formula has {count} subformulas; at most {CAPACITIES[-1]} have flags"
        )
    return capacity


F_MDP = feed_forward_method(
    "f-mdp", "F-MDP (a flag for each subformula; two layers only)", FlagHistory()
)
