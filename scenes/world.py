"""The world that `core` moves in: regions behind atoms, distance fields behind subgoals.

`GridWorld` is static and hashable; `WorldArrays` is the data of one scene and formula. Only
state formulas are known here: which of them are goals and which sets of them are obstacles at
the same time is the caller's business.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.stl import Formula, robustness, to_text
from scenes.fields import Grid, geodesic_field, interpolate
from scenes.margins import RegionArrays, margins_and_gradients, region_arrays
from scenes.regions import SceneError
from scenes.scene import Scene


class WorldArrays(NamedTuple):
    """Data of one scene and formula."""

    regions: RegionArrays
    fields: np.ndarray  # [F, *grid, 1 + d] distance [m] and direction
    initial_low: np.ndarray  # [d] bounding box of the initial set [m]
    initial_high: np.ndarray  # [d]
    initial_round: np.ndarray  # [] 1 for a circle or sphere


@dataclass(frozen=True)
class GridWorld:
    """A workspace with a grid for its distance fields.

    Attributes:
        grid: Nodes of the fields.
        clearance: Distance that planned ways keep from obstacles in [m].
        inset: Depth in goals that planned ways aim at in [m].
    """

    grid: Grid
    clearance: float = 0.15
    inset: float = 0.1

    def margins(self, data: WorldArrays, position: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Margins [A] of the regions in [m] and their gradients [A, d] at a position [d]."""
        return margins_and_gradients(data.regions, position)

    def field(self, data: WorldArrays, index, position: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Distance [m] and unit direction [d] of travel in the index-th field."""
        value = interpolate(self.grid, data.fields, index, position)
        return value[0], value[1:]

    def sample_initial(self, data: WorldArrays, key: jax.Array) -> jax.Array:
        """A position [d] of the initial set, uniform."""
        box_key, angle_key, radius_key = jax.random.split(key, 3)
        low, high = data.initial_low, data.initial_high
        dimension = self.grid.dimension
        box = jax.random.uniform(box_key, (dimension,), minval=low, maxval=high)
        direction = jax.random.normal(angle_key, (dimension,))
        direction = direction / jnp.linalg.norm(direction)
        radius = jax.random.uniform(radius_key) ** (1 / dimension)
        ball = (low + high) / 2 + (high - low) / 2 * radius * direction
        return jnp.where(data.initial_round > 0, ball, box)


PLANAR = GridWorld(Grid((-5.0, -5.0), 0.125, (81, 81)))
"""The arena [-5, 5]^2 m of the planar robots."""

AIRSPACE = GridWorld(Grid((-5.0, -5.0, 0.0), 0.3125, (33, 33, 17)), clearance=0.35, inset=0.15)
"""The arena [-5, 5]^2 x [0, 5] m of the quadrotor."""

TABLETOP = GridWorld(Grid((0.1, -0.7, 0.0), 0.04, (20, 36, 26)), clearance=0.03, inset=0.02)
"""The space [0.1, 0.86] x [-0.7, 0.7] x [0, 1] m in front of the arm."""


COURTYARD = GridWorld(Grid((-3.0, -3.0), 0.1, (61, 61)), clearance=0.2, inset=0.15)
"""The arena [-3, 3]^2 m of the ant."""


class GoalGeometry(NamedTuple):
    """Host-side geometry of the subgoals, G of them, M combinations of obstacles."""

    fields: np.ndarray  # [G, M, *grid, 1 + d]
    inside: np.ndarray  # [G, S, d] random positions that satisfy each subgoal [m]
    center: np.ndarray  # [G, d] its deepest position [m]
    legs: np.ndarray  # [M, G, G] distance from subgoal i's region to subgoal j's [m]


def world_arrays(scene: Scene, capacity: int, fields: np.ndarray) -> WorldArrays:
    """Data of a scene for `GridWorld`, with fields [F, *grid, 1 + d]."""
    initial = scene.initial
    center = np.asarray(initial.center, np.float32)
    half = np.resize(np.asarray(initial.size, np.float32), scene.dimension)
    if initial.kind == "cylinder":
        half = np.asarray([initial.size[0], initial.size[0], initial.size[1]], np.float32)
    return WorldArrays(
        region_arrays(scene.regions, scene.dimension, capacity),
        fields,
        center - half,
        center + half,
        np.asarray(initial.kind in ("circle", "sphere"), np.float32),
    )


def goal_geometry(
    world: GridWorld,
    scene: Scene,
    goals: Sequence[Formula],
    obstacles: Sequence[Sequence[Formula]],
    samples: int,
) -> GoalGeometry:
    """Fields, sample positions and distances of the subgoals of a formula.

    Args:
        world: the workspace.
        scene: regions; its seed draws the sample positions.
        goals: the state formula of each subgoal [G].
        obstacles: for each combination [M], the state formulas that must keep holding.
        samples: number of positions per subgoal.

    Raises:
        SceneError: a subgoal holds nowhere on the workspace's grid.
    """
    grid = world.grid
    nodes = grid.nodes()
    atoms = _node_margins(grid, region_arrays(scene.regions, scene.dimension, 32))
    atoms = atoms[:, : len(scene.regions)]

    def value(formula: Formula) -> np.ndarray:
        return robustness(formula, atoms[:, None, :], scene.region_names)

    goal_margin = [value(goal) for goal in goals]
    obstacle_margin = {o: value(o) for combination in obstacles for o in combination}
    blocked = [
        _blocked([obstacle_margin[o] for o in group], len(nodes), world.clearance)
        for group in obstacles
    ]
    fields = np.stack(
        [[_field(world, margin, ~(margin > 0) & b) for b in blocked] for margin in goal_margin]
    )
    random = np.random.default_rng(scene.seed)
    for goal, margin in zip(goals, goal_margin, strict=True):
        if margin.max() < -grid.spacing:
            raise SceneError(
                f"{scene.name}: no position of the workspace satisfies {to_text(goal)}"
            )
    points = [_sample_inside(nodes, m, blocked[0], samples, random) for m in goal_margin]
    center = [nodes[m.argmax()] for m in goal_margin]
    legs = _legs(fields.reshape(*fields.shape[:2], len(nodes), -1)[..., 0], goal_margin)
    return GoalGeometry(fields, np.stack(points), np.stack(center), legs)


@cache
def _margins_at_nodes(grid: Grid):
    nodes = jnp.asarray(grid.nodes(), jnp.float32)
    return jax.jit(lambda arrays: jax.vmap(partial(margins_and_gradients, arrays))(nodes)[0])


def _node_margins(grid: Grid, arrays: RegionArrays) -> np.ndarray:
    return np.asarray(_margins_at_nodes(grid)(arrays))


def _blocked(margins: list[np.ndarray], size: int, clearance: float) -> np.ndarray:
    worst = np.min(margins, axis=0) if margins else np.full(size, np.inf)
    return worst < clearance


def _field(world: GridWorld, goal: np.ndarray, blocked: np.ndarray) -> np.ndarray:
    shape = world.grid.shape
    return geodesic_field(world.grid, goal.reshape(shape), blocked.reshape(shape), world.inset)


def _sample_inside(nodes, margin, blocked, samples, random) -> np.ndarray:
    """Random nodes [S, d] in a goal, in its free part if there is one."""
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
