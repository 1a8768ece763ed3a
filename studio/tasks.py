"""From a scene to a task: parse, decompose, ground, and build the world's fields."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from core.decompose import Decomposition, decompose
from core.grounding import COMBINATIONS, MAX_ATOMS, MAX_SUBGOALS, Grounding, ground
from core.problem import SAMPLES_INSIDE, Problem, to_device
from core.stl import parse
from core.task import Task
from envs import ENVS
from scenes import (
    AIRSPACE,
    COURTYARD,
    PLANAR,
    TABLETOP,
    GoalGeometry,
    GridWorld,
    Scene,
    goal_geometry,
    world_arrays,
)

WORLDS: dict[str, GridWorld] = {
    "linear": PLANAR,
    "unicycle": PLANAR,
    "panda": TABLETOP,
    "quadrotor": AIRSPACE,
    "ant": COURTYARD,
}
"""Workspace by robot."""


def decompose_scene(scene: Scene) -> Decomposition:
    """Parse and decompose a scene's formula.

    Raises:
        UserError: with the place in the formula.
    """
    robot = ENVS[scene.robot]
    return decompose(parse(scene.formula, dt=robot.dt, names=scene.region_names))


def build_task(scene: Scene, formula: str | None = None) -> Task:
    """Ground a scene, with another formula than its own if one is given.

    Raises:
        UserError: a formula that is malformed, cannot be grounded or is too large, or a subgoal
            that no position satisfies.
    """
    if formula is not None:
        scene = replace(scene, formula=formula)
    robot = ENVS[scene.robot]
    world = WORLDS[robot.name]
    grounding = ground(decompose_scene(scene), scene.region_names, scene.horizon)
    goals = [task.predicate for task in grounding.subgoals]
    constraints = [task.predicate for task in grounding.constraints]
    obstacles = [[constraints[i] for i in group] for group in grounding.closed_sets()]
    geometry = goal_geometry(world, scene, goals, obstacles, SAMPLES_INSIDE) if goals else None
    return Task(scene.name, robot, world, grounding, _problem(scene, world, grounding, geometry))


def _problem(
    scene: Scene, world: GridWorld, grounding: Grounding, geometry: GoalGeometry | None
) -> Problem:
    """Pad the geometry to the sizes that programs are compiled for."""
    dimension, shape = world.grid.dimension, world.grid.shape
    fields = np.zeros((MAX_SUBGOALS, COMBINATIONS, *shape, 1 + dimension), np.float32)
    inside = np.zeros((MAX_SUBGOALS, SAMPLES_INSIDE, dimension), np.float32)
    center = np.zeros((MAX_SUBGOALS, dimension), np.float32)
    legs = np.zeros((COMBINATIONS, MAX_SUBGOALS, MAX_SUBGOALS), np.float32)
    if geometry is not None:
        count, combinations = geometry.fields.shape[:2]
        fields[:count, :combinations] = geometry.fields
        inside[:count], center[:count] = geometry.inside, geometry.center
        legs[:combinations, :count, :count] = geometry.legs
    flat = fields.reshape(MAX_SUBGOALS * COMBINATIONS, *shape, 1 + dimension)
    data = world_arrays(scene, MAX_ATOMS, flat)
    return to_device(
        Problem(grounding.arrays, data, jnp.asarray(inside), jnp.asarray(center), jnp.asarray(legs))
    )
