"""What a task takes as data where regions move: which field and which place count at each step."""

import jax.numpy as jnp
import numpy as np

from core.task.grounding import Grounding
from core.task.problem import SAMPLES_INSIDE
from core.task.sites import Sites
from core.task.task import padded_steps
from scenes import GoalGeometry, GridWorld, Scene, Snapshots, WorldArrays, snapshots_of
from scenes.compound import padded

LEAST = 8
"""Sizes that fields and places are padded to, doubled until they suffice."""


def snapshots(scene: Scene, world: GridWorld, grounding: Grounding) -> Snapshots:
    """When the places of a formula are worked out."""
    combinations, steps = len(grounding.closed_sets()), padded_steps(grounding.horizon)
    return snapshots_of(scene, grounding.places, combinations, steps, world.grid.spacing)


def sites_of(grounding: Grounding, taken: Snapshots, geometry: GoalGeometry | None) -> Sites:
    """Where the subgoals of a formula are, step by step."""
    place = grounding.arrays.place[: len(grounding.subgoals)]
    dimension, steps = taken.drift.shape[-1], len(taken.row)
    subgoals, rows = grounding.sizes.subgoals, padded(len(taken.places), LEAST)
    row = np.zeros((steps, subgoals), np.int32)
    drift = np.zeros((steps, subgoals, dimension), np.float32)
    moves = np.zeros(subgoals, bool)
    center = np.zeros((rows, dimension), np.float32)
    inside = np.zeros((rows, SAMPLES_INSIDE, dimension), np.float32)
    depth = np.zeros(rows, np.float32)
    if geometry is not None:
        row[:, : len(place)], drift[:, : len(place)] = taken.row[:, place], taken.drift[:, place]
        moves[: len(place)] = taken.moves[place]
        count = len(geometry.center)
        center[:count], inside[:count] = geometry.center, geometry.inside
        depth[:count] = geometry.depth
    arrays = row, drift, center, inside, depth, moves
    return Sites(jnp.zeros(()), *map(jnp.asarray, arrays))


def with_fields(data: WorldArrays, grounding: Grounding, taken: Snapshots) -> WorldArrays:
    """The data of a world in which goals have a field for each snapshot, and which counts when."""
    assert data.paths is not None
    combinations, places = int(grounding.arrays.combinations), taken.row.shape[1]
    index = np.arange(padded(places * combinations, LEAST))
    place = np.minimum(index // combinations, max(places - 1, 0))
    row = np.zeros((len(taken.row), len(index)), np.int32)
    drift = np.zeros((*row.shape, taken.drift.shape[-1]), np.float32)
    if places:
        row[:] = taken.row[:, place] * combinations + index % combinations
        drift[:] = taken.drift[:, place]
    paths = data.paths._replace(row=jnp.asarray(row), drift=jnp.asarray(drift))
    return data._replace(paths=paths)
