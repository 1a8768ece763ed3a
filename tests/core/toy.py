"""A point robot among discs: the smallest world that `core` can learn in, without scenes."""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.decompose import decompose
from core.stl import Formula, parse
from core.task.grounding import MAX_ATOMS, ground
from core.task.problem import SAMPLES_INSIDE, Problem, to_device
from core.task.protocols import Tuning
from core.task.task import Task


@dataclass(frozen=True)
class PointRobot:
    """x' = x + 0.5 u: state and position are the same two numbers."""

    name: str = "point"
    state_size: int = 2
    action_size: int = 2
    position_size: int = 2
    dt: float = 1.0
    speed: float = 0.5
    lag: float = 0.0
    length: float = 1.0
    tuning: Tuning = Tuning()

    def rest(self, key, position):
        del key
        return position

    def place(self, key, position):
        del key
        return position

    def step(self, state, action):
        return state + self.speed * jnp.clip(action, -1, 1)

    def position(self, state):
        return state

    def observe(self, state):
        return state[:0]

    def to_frame(self, state, vectors):
        del state
        return vectors


class Discs(NamedTuple):
    center: np.ndarray  # [A, 2]
    radius: np.ndarray  # [A]
    goal: np.ndarray  # [F, 2] what each field leads to; closed doors change nothing


@dataclass(frozen=True)
class DiscWorld:
    """Margins of discs; fields are straight lines to the subgoals' centres."""

    def margins(self, data, position):
        offset = data.center - position
        distance = jnp.sqrt((offset**2).sum(-1) + 1e-12)
        return data.radius - distance, offset / distance[:, None]

    def field(self, data, index, position):
        offset = data.goal[index] - position
        distance = jnp.sqrt((offset**2).sum() + 1e-12)
        return distance, offset / distance

    def sample_initial(self, data, key):
        del data
        return jax.random.uniform(key, (2,), minval=-0.2, maxval=0.2)


CENTERS = {"A": (1.5, 0.0), "B": (0.0, 1.5), "C": (-1.5, 0.0), "D": (0.0, -1.5)}
RADIUS = 0.6


def toy_task(formula: str | Formula, horizon: int = 16, robot: PointRobot | None = None) -> Task:
    """A task over the discs A, B, C, D around the origin."""
    if isinstance(formula, str):
        formula = parse(formula, names=CENTERS)
    grounding = ground(decompose(formula), tuple(CENTERS), horizon)
    center = np.full((MAX_ATOMS, 2), 99.0, np.float32)
    center[: len(CENTERS)] = list(CENTERS.values())
    radius = np.full(MAX_ATOMS, RADIUS, np.float32)
    sizes, arrays = grounding.sizes, grounding.arrays
    goal = np.zeros((sizes.subgoals, 2), np.float32)
    for i, predicate in enumerate(grounding.places):
        goal[i] = CENTERS.get(getattr(predicate, "name", ""), (0.0, 0.0))
    fields = np.repeat(goal, arrays.combinations, axis=0)
    center_of = goal[arrays.place]
    legs = np.linalg.norm(center_of[:, None] - center_of[None], axis=-1) - 2 * RADIUS
    problem = Problem(
        PointRobot() if robot is None else robot,
        DiscWorld(),
        arrays,
        Discs(center, radius, np.resize(fields, (sizes.subgoals * 2**sizes.doors, 2))),
        jnp.asarray(np.repeat(center_of[:, None], SAMPLES_INSIDE, 1)),
        jnp.asarray(center_of),
        jnp.asarray(np.repeat(np.maximum(legs, 0)[None], 2**sizes.doors, 0)),
    )
    return Task("toy", grounding, to_device(problem))


def disc_margins(positions: np.ndarray) -> np.ndarray:
    """Margins [..., 4] of the discs at positions [..., 2], in plain NumPy."""
    offset = np.asarray(positions)[..., None, :] - np.asarray(list(CENTERS.values()))
    return RADIUS - np.linalg.norm(offset, axis=-1)
