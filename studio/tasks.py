"""From a scene to a task: parse, decompose, ground, and build the world's fields."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from core.decompose import Decomposition, decompose
from core.grounding import COMBINATIONS, MAX_ATOMS, MAX_SUBGOALS, Grounding, ground
from core.problem import SAMPLES_INSIDE, Problem, to_device
from core.stl import Atom, Formula, Not, children, negation_normal_form, parse
from core.task import Task
from envs import Robot, make_robot
from scenes import (
    AIRSPACE,
    COURTYARD,
    PLANAR,
    TABLETOP,
    GoalGeometry,
    GridWorld,
    Scene,
    goal_geometry,
    walls,
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


def robot_of(scene: Scene) -> Robot:
    """The robot of a scene, in its variant."""
    return make_robot(scene.robot, scene.variant)


def decompose_scene(scene: Scene) -> Decomposition:
    """Parse and decompose a scene's formula.

    Raises:
        UserError: with the place in the formula.
    """
    robot = robot_of(scene)
    return decompose(parse(scene.formula, dt=robot.dt, names=scene.region_names))


def ground_scene(scene: Scene) -> Grounding:
    """What a scene's formula asks for, before any field is built.

    Raises:
        UserError: a formula that is malformed, cannot be grounded or is too large.
    """
    return ground(decompose_scene(scene), scene.region_names, scene.horizon)


def build_task(scene: Scene, formula: str | None = None) -> Task:
    """Ground a scene, with another formula than its own if one is given.

    Raises:
        UserError: a formula that is malformed, cannot be grounded or is too large, or a subgoal
            that no position satisfies.
    """
    if formula is not None:
        scene = replace(scene, formula=formula)
    robot = robot_of(scene)
    world = WORLDS[robot.name]
    grounding = ground_scene(scene)
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
        Problem(
            grounding.arrays,
            data,
            jnp.asarray(inside),
            jnp.asarray(center),
            jnp.asarray(legs),
            _on_body(scene, world, grounding) if scene.variant == "links" else None,
        )
    )


def _on_body(scene: Scene, world: GridWorld, grounding: Grounding) -> jax.Array:
    """[A] 1 for obstacles: what the formula only ever forbids, but for the workspace's walls."""
    formula = negation_normal_form(grounding.decomposition.formula)
    spared = _wanted_names(formula) | {wall.name for wall in walls(scene, world)}
    rows = [name not in spared for name in scene.region_names]
    return jnp.asarray(rows + [False] * (MAX_ATOMS - len(rows)), jnp.float32)


def _wanted_names(formula: Formula) -> set[str]:
    """Names of the atoms that do not stand directly behind a negation, in normal form."""
    match formula:
        case Atom(name):
            return {name}
        case Not(Atom()):
            return set()
    return {name for child in children(formula) for name in _wanted_names(child)}
