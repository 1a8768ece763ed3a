"""The world as `core` sees it: regions as atoms, distance fields of subgoals.

`GridWorld` is static and hashable; `WorldArrays` is the data of one scene and formula. Only
state formulas are known here: the caller decides which are goals and which sets of them are
obstacles at the same time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.stl import Formula, fold_constants, robustness, to_text
from core.task.sites import step_row
from envs import Workspace
from scenes.arena import Arena, cells, fitted, holding, hull
from scenes.compound import Room
from scenes.fields import Grid, geodesic_field, interpolate
from scenes.margins import PADDING_MARGIN, RegionArrays, margins_and_gradients, region_arrays
from scenes.paths import Paths, moved, offsets, paths_of
from scenes.predicates import positional_margins, relaxed, without_state
from scenes.regions import SceneError
from scenes.scene import Scene, robot_of, workspace_of
from scenes.starts import Cells, cells_of, draw, round_axes


class Frame(NamedTuple):
    """Where the grid of a scene's own arena lies, so that another arena compiles nothing."""

    origin: np.ndarray  # [d] of its first node [m]
    per_metre: np.ndarray  # [] nodes in a metre


class WorldArrays(NamedTuple):
    """Data of one scene and formula."""

    regions: RegionArrays
    fields: np.ndarray  # [F, *grid, 1 + d] distance [m] and direction
    initial_low: np.ndarray  # [d] bounding box of the initial set [m]
    initial_high: np.ndarray  # [d]
    initial_round: np.ndarray  # [d] 1 for the axes in which it is a ball
    frame: Frame | None = None
    """None where the arena is the robot's: its numbers are constants of the programs then."""
    start: Cells | None = None
    """The initial set; None where the three fields above say it all."""
    paths: Paths | None = None
    """Of the regions that move; None where none does."""
    step: jax.Array | None = None
    """[] At which regions are looked at; until it is given, those that move are nowhere."""


@dataclass(frozen=True)
class GridWorld:
    """A workspace with a grid for its distance fields.

    Attributes:
        grid: Nodes of the fields.
        clearance: Distance that planned paths keep from obstacles in [m].
        inset: Depth inside goals that planned paths aim for in [m].
        arena: Where ways may lead: (low, high) of each axis in [m], if it is the scene's own; its
            grid may reach further. None where it is the robot's.
    """

    grid: Grid
    clearance: float
    inset: float
    arena: Arena | None = None

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Low and high corner [d] of where ways may lead, in [m]."""
        if self.arena is not None:
            low, high = np.array(self.arena, float).T
            return low, high
        low = np.asarray(self.grid.origin, float)
        return low, low + self.grid.spacing * (np.asarray(self.grid.shape) - 1)

    @property
    def compiled(self) -> "GridWorld":
        """What programs are compiled for: of a scene's own arena, only the number of nodes."""
        if self.arena is None:
            return self
        grid = Grid((0.0,) * self.grid.dimension, 1.0, self.grid.shape)
        return GridWorld(grid, clearance=0.0, inset=0.0)

    @property
    def frame(self) -> Frame | None:
        """What `compiled` leaves out."""
        if self.arena is None:
            return None
        origin, per_metre = np.array(self.grid.origin), np.array(1 / self.grid.spacing)
        return Frame(origin.astype(np.float32), per_metre.astype(np.float32))

    def beyond(self, positions: np.ndarray) -> np.ndarray:
        """Whether positions [P, d] lie outside a scene's own arena [P], half a cell spared."""
        if self.arena is None:
            return np.zeros(len(positions), bool)
        (low, high), slack = self.limits, self.grid.spacing / 2
        return np.any((positions < low - slack) | (positions > high + slack), axis=1)

    def margins(self, data: WorldArrays, position: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Margins [A] of the regions in [m] and their gradients [A, d] at a position [d]."""
        if data.paths is None:
            return margins_and_gradients(data.regions, position)
        return margins_and_gradients(moved(data.regions, data.paths, _step(data)), position)

    def field(self, data: WorldArrays, index, position: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Distance [m] and unit direction [d] of travel in the index-th field."""
        if data.paths is not None:
            number = step_row(_step(data), data.paths.row.shape[0] - 1)
            position = position - data.paths.drift[number, index]
            index = data.paths.row[number, index]
        if data.frame is not None:
            position = (position - data.frame.origin) * data.frame.per_metre
        value = interpolate(self.grid, data.fields, index, position)
        return value[0], value[1:]

    def at(self, data: WorldArrays, step: jax.Array) -> WorldArrays:
        """The data at a step, or between two: margins and fields are those of that time."""
        return data if data.paths is None else data._replace(step=step)

    def displacements(self, data: WorldArrays) -> jax.Array:
        """How far regions have moved [U, d] by the data's step, each different way once [m]."""
        if data.paths is None:
            return jnp.zeros((1, self.grid.dimension))
        return offsets(data.paths, _step(data))

    def sample_initial(self, data: WorldArrays, key: jax.Array) -> jax.Array:
        """A position [d] of the initial set, uniform.

        Without cells, a region is a ball of k axes times a box of the others: a circle or sphere
        has k = d, a cylinder k = 2, a rectangle or box k = 0. A ball's radius at a random point
        is its own times the k-th root of a uniform number.
        """
        if data.start is not None:
            return draw(data.start, key)
        box_key, angle_key, radius_key = jax.random.split(key, 3)
        low, high, is_round = data.initial_low, data.initial_high, data.initial_round
        dimension = self.grid.dimension
        box = jax.random.uniform(box_key, (dimension,), minval=low, maxval=high)
        direction = jax.random.normal(angle_key, (dimension,)) * is_round
        direction = direction / jnp.maximum(jnp.linalg.norm(direction), 1e-9)
        radius = jax.random.uniform(radius_key) ** (1 / jnp.maximum(is_round.sum(), 1))
        ball = (low + high) / 2 + (high - low) / 2 * radius * direction
        return jnp.where(is_round > 0, ball, box)


def _step(data: WorldArrays) -> jax.Array:
    if data.step is None:
        raise ValueError("regions move: margins and fields are those at a step, see GridWorld.at")
    return data.step


def make_world(workspace: Workspace) -> GridWorld:
    """The world of a workspace: its grid begins at the arena's low corner and covers it."""
    low, high = np.array(workspace.arena, float).T
    cells = np.ceil((high - low) / workspace.spacing - 1e-9).astype(int)
    grid = Grid(tuple(low.tolist()), workspace.spacing, tuple((cells + 1).tolist()))
    return GridWorld(grid, workspace.clearance, workspace.inset)


def world_of(scene: Scene) -> GridWorld:
    """The world that a scene's robot moves in.

    In a scene's own arena, ways are planned from starts outside it too.
    """
    own, arena = robot_of(scene).workspace, workspace_of(scene).arena
    if arena == own.arena:
        return make_world(own)
    arena = hull(arena, (scene.initial,))
    workspace = fitted(own, arena)
    origin = tuple(low for low, _ in arena)
    grid = Grid(origin, workspace.spacing, tuple((cells(own, arena) + 1).tolist()))
    return GridWorld(grid, workspace.clearance, workspace.inset, arena)


class GoalGeometry(NamedTuple):
    """Host-side geometry of the subgoals, G of them, M combinations of obstacles."""

    fields: np.ndarray  # [G, M, *grid, 1 + d]
    inside: np.ndarray  # [G, S, d] random positions that satisfy each subgoal [m]
    center: np.ndarray  # [G, d] its deepest position [m]
    legs: np.ndarray  # [M, G, G] distance from subgoal i's region to subgoal j's [m]
    depth: np.ndarray  # [G] margin of that position, 0 where it is outside [m]


def world_arrays(  # noqa: PLR0913
    scene: Scene,
    capacity: int,
    fields: np.ndarray,
    steps: int = 0,
    *,
    world: GridWorld | None = None,
    room: Room | None = None,
) -> WorldArrays:
    """Data of a scene for `world.compiled`.

    Args:
        scene: its regions and its initial set.
        capacity: number that regions are padded to.
        fields: [F, *grid, 1 + d].
        steps: for which paths are known; only scenes whose regions move need them.
        world: the scene's own unless given.
        room: regions that fit into it have arrays of the same shapes; None for their own.
    """
    regions = region_arrays(scene.regions, scene.dimension, capacity, room)
    initial = scene.initial
    center = np.asarray(initial.center, np.float32)
    half = initial.half_extents.astype(np.float32)
    return WorldArrays(
        regions,
        fields,
        center - half,
        center + half,
        round_axes(initial),
        (world_of(scene) if world is None else world).frame,
        cells_of(initial),
        paths_of(scene.regions, regions, steps) if scene.moving else None,
    )


def goal_geometry(
    world: GridWorld,
    scene: Scene,
    goals: Sequence[Formula],
    obstacles: Sequence[Sequence[Formula]],
    samples: int,
    spared: Sequence[bool] = (),
    steps: Sequence[int] = (),
) -> GoalGeometry:
    """Fields, sample positions and distances of the subgoals of a formula.

    Only what subgoals and obstacles ask of the position counts: the way to `A & slow` leads to A,
    and `!B | slow` bars no way. A subgoal that asks for nothing but a state is everywhere. Regions
    that move are where they are at a step, and bar no way.

    Args:
        world: the workspace.
        scene: regions; its seed draws the sample positions.
        goals: the state formula of each subgoal [G].
        obstacles: for each combination [M], the state formulas that must keep holding.
        samples: number of positions per subgoal.
        spared: for each subgoal [G] whether it may hold nowhere on the grid; the node nearest to
            it then stands for it. None may unless given.
        steps: for each subgoal [G] the step at which its regions are looked at; 0 unless given. The
            same subgoal may be given at several steps.

    Raises:
        SceneError: a subgoal that is not spared holds nowhere on the workspace's grid, at any of
            its steps.
    """
    grid = world.grid
    nodes = grid.nodes()
    value = _values_on(nodes, scene)
    beyond, at = world.beyond(nodes), steps or [0] * len(goals)
    goal_margin = [
        np.where(beyond, PADDING_MARGIN, value(goal, step))
        for goal, step in zip(goals, at, strict=True)
    ]
    standing = {o: _standing(o, scene.moving) for combination in obstacles for o in combination}
    obstacle_margin = {o: value(asked, 0) for o, asked in standing.items()}
    blocked = [
        beyond | _blocked([obstacle_margin[o] for o in group], len(nodes), world.clearance)
        for group in obstacles
    ]
    fields = np.stack(
        [[_field(world, margin, ~(margin > 0) & b) for b in blocked] for margin in goal_margin]
    )
    random = np.random.default_rng(scene.seed)
    low, high = world.limits
    deepest = {goal: -np.inf for goal in goals}
    for goal, margin in zip(goals, goal_margin, strict=True):
        deepest[goal] = max(deepest[goal], float(margin.max()))
    for i, goal in enumerate(goals):
        if deepest[goal] < -grid.spacing and not (spared and spared[i]):
            raise SceneError(
                f"{scene.name}: no position in the workspace satisfies {to_text(goal)}; the "
                f"arena extends from {low.tolist()} to {high.tolist()} m{_wider(scene)}"
            )
    points = [_sample_inside(nodes, m, blocked[0], samples, random) for m in goal_margin]
    center = [nodes.mean(0) if m.min() == np.inf else nodes[m.argmax()] for m in goal_margin]
    legs = _legs(fields.reshape(*fields.shape[:2], len(nodes), -1)[..., 0], goal_margin)
    depth = np.clip([margin.max() for margin in goal_margin], 0.0, -PADDING_MARGIN)
    return GoalGeometry(fields, np.stack(points), np.stack(center), legs, depth)


def _values_on(nodes: np.ndarray, scene: Scene) -> Callable[[Formula, int], np.ndarray]:
    """Values [P] of what state formulas ask of the position, at positions [P, d] and a step [m]."""
    names, robot = scene.region_names, robot_of(scene)
    own = positional_margins(scene.predicates, robot, nodes) if scene.predicates else {}
    positions = jnp.asarray(nodes, jnp.float32)

    @lru_cache
    def atoms_at(step: int) -> np.ndarray:
        regions = tuple(region.displaced(step) for region in scene.regions)
        atoms = np.asarray(_margins_at(region_arrays(regions, scene.dimension, 32), positions))
        atoms = atoms[:, : len(regions)]
        return np.column_stack([atoms, *own.values()]) if own else atoms

    def value(formula: Formula, step: int) -> np.ndarray:
        asked = without_state(formula, scene.predicates, robot)
        return robustness(asked, atoms_at(step)[:, None, :], (*names, *own))

    return value


def _standing(obstacle: Formula, moving: frozenset[str]) -> Formula:
    """What an obstacle, in negation normal form, asks of the regions that stand, or less."""
    return fold_constants(relaxed(obstacle, moving)) if moving else obstacle


def _wider(scene: Scene) -> str:
    """What to write so that all regions lie in the arena; nothing where that does not help."""
    everywhere = (*scene.regions, scene.initial)
    wider = holding(workspace_of(scene).arena, everywhere, robot_of(scene))
    pairs = [] if wider is None else [list(pair) for pair in wider]
    return f"; a scene with `arena = {pairs}` holds all its regions" if pairs else ""


@jax.jit
def _margins_at(arrays: RegionArrays, positions: jax.Array) -> jax.Array:
    return jax.vmap(partial(margins_and_gradients, arrays))(positions)[0]


def _blocked(margins: list[np.ndarray], size: int, clearance: float) -> np.ndarray:
    worst = np.min(margins, axis=0) if margins else np.full(size, np.inf)
    return worst < clearance


def _field(world: GridWorld, goal: np.ndarray, blocked: np.ndarray) -> np.ndarray:
    shape = world.grid.shape
    return geodesic_field(world.grid, goal.reshape(shape), blocked.reshape(shape), world.inset)


def _sample_inside(nodes, margin, blocked, samples, random) -> np.ndarray:
    """Random nodes [S, d] in a goal, in its unblocked part if there is one."""
    for candidates in ((margin >= 0) & ~blocked, margin >= 0, margin == margin.max()):
        if candidates.any():
            return nodes[random.choice(np.flatnonzero(candidates), samples)]
    raise AssertionError("a margin has a maximum")


def _legs(distance: np.ndarray, goal_margin: list[np.ndarray]) -> np.ndarray:
    """Distance from the nearest point of subgoal i to subgoal j, [M, G, G]."""
    rows = []
    for margin in goal_margin:
        region = margin >= 0 if (margin >= 0).any() else margin == margin.max()
        rows.append(distance[:, :, region].min(-1))
    return np.stack(rows, 1).transpose(2, 1, 0)
