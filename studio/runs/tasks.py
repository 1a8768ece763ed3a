"""From a scene to a task: parse, decompose, ground, and build the world's fields."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from core.between import SUBSTEPS
from core.compilation import program
from core.decompose import Decomposition, DecompositionError, Kind, TimeExpr, decompose
from core.stl import Atom, Formula, Not, children, negation_normal_form
from core.task.grounding import MAX_ATOMS, Grounding, ground
from core.task.inequalities import Inequalities, inequality_arrays
from core.task.problem import SAMPLES_INSIDE, Problem, to_device
from core.task.protocols import Array, Robot, has_body
from core.task.task import Task, padded_steps
from scenes import (
    ROOM,
    GoalGeometry,
    GridWorld,
    Scene,
    Snapshots,
    goal_geometry,
    inequality_of,
    robot_of,
    scene_formula,
    shared_world,
    walls,
    world_arrays,
    world_of,
)
from scenes.compound import Room, padded
from studio.runs.findings import findings_of, require_possible
from studio.runs.moving import sites_of, snapshots, with_fields
from studio.runs.refusals import refusal
from studio.runs.visits import with_enough_visits

LEAST_FIELDS = 96
"""Distance fields of a task: its places times its combinations of closed doors, or more."""


def decompose_scene(scene: Scene, visits_extra: int = 0) -> Decomposition:
    """Parse and decompose a scene's formula.

    Raises:
        UserError: with the place in the formula.
    """
    formula = scene_formula(scene)
    try:
        return decompose(formula, visits_extra=visits_extra)
    except DecompositionError as error:
        raise refusal(error, scene.formula, formula) from None


def ground_scene(scene: Scene, visits_extra: int = 0) -> Grounding:
    """The grounding of a scene's formula, before any field is built.

    Raises:
        UserError: a formula that is malformed, cannot be grounded or is too large.
    """
    return ground(decompose_scene(scene, visits_extra), scene.atom_names, scene.horizon)


def build_task(
    scene: Scene,
    formula: str | None = None,
    *,
    force: bool = False,
    visits_extra: int | None = None,
    shared: bool = False,
) -> Task:
    """Ground a scene, with its own formula unless another is given.

    Args:
        scene: what is grounded.
        formula: another formula for it.
        force: whether a mission that cannot be carried out is grounded all the same.
        visits_extra: visits in each chain beyond the least number; as many as leave time to
            travel, unless given.
        shared: whether its arrays have the same shapes as those of all the robot's scenes that
            are grounded so (`scenes.shared`).

    Raises:
        ImpossibleError: the mission cannot be carried out.
        UserError: a formula that is malformed, cannot be grounded or is too large, or a subgoal
            outside the arena that every branch asks for.
    """
    if formula is not None:
        scene = replace(scene, formula=formula)
    world = shared_world(scene) if shared else world_of(scene)
    least = ground_scene(scene)
    findings = findings_of(scene) if force else require_possible(scene)
    geometries: dict[Any, GoalGeometry] = {}

    def build(extra: int) -> Task:
        grounding = ground_scene(scene, extra) if extra else least
        taken = snapshots(scene, world, grounding) if scene.moving else None
        geometry = _geometry(scene, world, grounding, force, taken, geometries)
        problem = _problem(scene, world, grounding, geometry, taken, ROOM if shared else None)
        return Task(scene.name, grounding, problem, findings=findings)

    return with_enough_visits(build) if visits_extra is None else build(visits_extra)


def _geometry(  # noqa: PLR0913
    scene: Scene,
    world: GridWorld,
    grounding: Grounding,
    force: bool,
    taken: Snapshots | None,
    known: dict[Any, GoalGeometry],
) -> GoalGeometry | None:
    """Geometry of the places of a formula; that of the same places is made once."""
    constraints = [task.predicate for task in grounding.constraints]
    kept = _kept(grounding)
    obstacles = tuple(
        tuple(dict.fromkeys((*(constraints[i] for i in group), *kept)))
        for group in grounding.closed_sets()
    )
    goals = tuple(grounding.places)
    asked = {task.predicate for task in grounding.subgoals if not task.guards}
    spared = tuple(force or goal not in asked for goal in goals)
    if not goals:
        return None
    rows, steps = tuple(range(len(goals))), tuple[int, ...]()
    if taken is not None:
        rows, steps = tuple(taken.places.tolist()), tuple(taken.steps.tolist())
    key = goals, obstacles, spared, rows, steps
    if key not in known:
        known[key] = goal_geometry(
            world,
            scene,
            [goals[row] for row in rows],
            obstacles,
            SAMPLES_INSIDE,
            [spared[row] for row in rows],
            steps,
        )
    return known[key]


def _kept(grounding: Grounding) -> list[Formula]:
    """What must hold from the first step to the last: ways may not leave it, as in a room."""
    whole = TimeExpr(), TimeExpr(grounding.decomposition.horizon)
    return [
        task.predicate
        for task in grounding.subgoals
        if task.kind is Kind.STAY and not task.guards and (task.start, task.end) == whole
    ]


def initial_state(task: Task, start: tuple[float, ...] | None = None) -> Array:
    """At rest at a position, by default in the middle of the initial set [n]."""
    data: Any = task.problem.data
    middle = (data.initial_low + data.initial_high) / 2
    if data.start is not None:
        middle = data.start.middle
    position = middle if start is None else start
    return _at_rest(jnp.asarray(position, jnp.float32), robot=task.robot)


@program
def _at_rest(position: Array, *, robot: Robot) -> Array:
    """Compiled: each call of a loop that is not keeps a program of its own."""
    return robot.rest(jax.random.key(0), position)


def _problem(  # noqa: PLR0913
    scene: Scene,
    world: GridWorld,
    grounding: Grounding,
    geometry: GoalGeometry | None,
    taken: Snapshots | None,
    room: Room | None,
) -> Problem:
    """Pad the geometry to the sizes that programs are compiled for."""
    robot = robot_of(scene)
    dimension, shape = world.grid.dimension, world.grid.shape
    sizes, formula = grounding.sizes, grounding.arrays
    empty = np.zeros((1, *shape, 1 + dimension), np.float32)
    inside = np.zeros((sizes.subgoals, SAMPLES_INSIDE, dimension), np.float32)
    center = np.zeros((sizes.subgoals, dimension), np.float32)
    legs = np.zeros((2**sizes.doors, sizes.subgoals, sizes.subgoals), np.float32)
    fields = empty
    if geometry is not None:
        place = formula.place[: len(grounding.subgoals)]
        if taken is not None:
            place = taken.row[0, place]
        combinations, count = geometry.fields.shape[1], len(place)
        fields = geometry.fields.reshape(-1, *empty.shape[1:])
        inside[:count], center[:count] = geometry.inside[place], geometry.center[place]
        legs[:combinations, :count, :count] = geometry.legs[:, place][:, :, place]
    padding = np.repeat(empty, padded(len(fields), LEAST_FIELDS) - len(fields), axis=0)
    steps = padded_steps(grounding.horizon)
    whole = np.concatenate([fields, padding])
    data = world_arrays(scene, MAX_ATOMS, whole, steps, world=world, room=room)
    if taken is not None:
        data = with_fields(data, grounding, taken)
    return to_device(
        Problem(
            robot,
            world.compiled,
            grounding.arrays,
            data,
            jnp.asarray(inside),
            jnp.asarray(center),
            jnp.asarray(legs),
            _on_body(scene, world, grounding) if has_body(robot) else None,
            jnp.arange(1, SUBSTEPS) / SUBSTEPS if scene.between_steps else None,
            _inequalities(scene) if scene.predicates else None,
            None if taken is None else sites_of(grounding, taken, geometry),
        )
    )


def _inequalities(scene: Scene) -> Inequalities:
    """The predicates of the state; their atoms follow the regions'."""
    robot = robot_of(scene)
    found = [inequality_of(each, robot) for each in scene.predicates]
    return inequality_arrays(found, robot, len(scene.regions), MAX_ATOMS)


def _on_body(scene: Scene, world: GridWorld, grounding: Grounding) -> jax.Array:
    """[A] 1 for obstacles: regions that the formula only forbids, except the workspace's walls."""
    formula = negation_normal_form(grounding.decomposition.formula)
    spared = _wanted_names(formula) | {wall.name for wall in walls(scene, world)}
    rows = [name not in spared for name in scene.region_names]
    return jnp.asarray(rows + [False] * (MAX_ATOMS - len(rows)), jnp.float32)


def _wanted_names(formula: Formula) -> set[str]:
    """Names of the atoms that are not directly negated, in normal form."""
    match formula:
        case Atom(name):
            return {name}
        case Not(Atom()):
            return set()
    return {name for child in children(formula) for name in _wanted_names(child)}
