"""Arenas of scenes' own: what may be asked for, and that planning scales with them."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.stl import parse
from core.task.grounding import MAX_ATOMS
from envs import ENVS
from scenes import (
    Region,
    SceneError,
    format_scene,
    goal_geometry,
    load_task,
    parse_scene,
    unit_of,
    workspace_of,
    world_arrays,
    world_of,
)
from scenes.arena import round_scale

SCENE = load_task("linear-demo")


def _scaled(region: Region, factor: float) -> Region:
    center, size = np.array(region.center), np.array(region.size)
    return replace(region, center=tuple(factor * center), size=tuple(factor * size))


@pytest.mark.parametrize(
    ("arena", "message"),
    [
        (5, "arena: 5 must be [[low, high], ...] in [m], one pair for each of 2 axes"),
        ([[0, 1]], "one pair for each of 2 axes"),
        ([[0, 1], [0, 1, 2]], "must be [[low, high], ...]"),
        ([[0, 1], [0, True]], "must be [[low, high], ...]"),
        ([[0, 1], [0, "1"]], "must be [[low, high], ...]"),
        ([[0, 10], [5, 5]], "low must be below high"),
        ([[0, 10], [0, float("nan")]], "low must be below high"),
        ([[0, 10], [0, 10**400]], "low must be below high"),
        ([[0, 50], [0, 2]], "the longest side may be 20 times the shortest"),
        ([[0, 101], [0, 101]], "the longest side must be from 0.5 to 100 m for the robot 'linear'"),
    ],
)
def test_what_is_no_arena_is_refused(arena, message):
    with pytest.raises(SceneError) as caught:
        replace(SCENE, arena=arena)
    assert message in str(caught.value)


def test_an_arm_keeps_to_its_reach():
    scene = load_task("panda-01")
    assert replace(scene, arena=((-0.5, 0.8), (-0.5, 0.5), (0.0, 1.0))).arena is not None
    with pytest.raises(SceneError, match=r"leaves the reach of the robot 'panda', \[\[-0.855, "):
        replace(scene, arena=((0.0, 1.0), (-0.5, 0.5), (0.0, 1.0)))


def test_files_keep_an_arena_and_do_without():
    own = replace(SCENE, arena=((0.0, 15.0), (0.0, 10.0)))
    assert parse_scene(format_scene(own), "here") == own
    assert "arena" not in format_scene(SCENE)
    for spelling in ("arena = [0, 15, 0, 10]", "workspace = [[0, 15], [0, 10]]"):
        text = format_scene(SCENE).replace("seed =", f"{spelling}\nseed =")
        assert parse_scene(text, "here") == own
    with pytest.raises(SceneError, match="here: workspace: another word for arena"):
        parse_scene(format_scene(own).replace("seed =", "workspace = [0, 1, 0, 1]\nseed ="), "here")


@pytest.mark.parametrize("robot", ENVS)
def test_the_robots_own_arena_changes_nothing(robot):
    scene = load_task(f"{robot}-demo")
    arena = ENVS[robot].workspace.arena
    assert world_of(replace(scene, arena=arena)) == world_of(scene)
    assert world_of(scene).compiled == world_of(scene)
    assert unit_of(scene) == ENVS[robot].length


def test_grids_cover_arenas_with_about_as_many_nodes_and_few_shapes():
    random, own = np.random.default_rng(0), np.prod(world_of(SCENE).grid.shape)
    compiled = set()
    for _ in range(500):
        low = random.uniform(-20, 20, 2)
        sides = random.uniform(1, 25) * np.array([1.0, random.uniform(1, 4)])
        arena = tuple(zip(low.tolist(), (low + sides).tolist(), strict=True))
        start = SCENE.initial.at((low + sides / 2).tolist()).sized((0.1,))
        world = world_of(replace(SCENE, arena=arena, initial=start))
        nodes = world.grid.nodes()
        np.testing.assert_allclose(nodes.min(0), low, atol=1e-9)
        assert (nodes.max(0) >= low + sides - 1e-9).all()
        assert 0.5 * own < len(nodes) < 3 * own
        assert (~world.beyond(nodes)).sum() > 0.4 * own
        compiled.add(world.compiled)
    assert len(compiled) <= 6


@pytest.mark.parametrize("factor", [0.2, 3.0])
def test_planning_scales_with_the_arena(factor):
    """Everything s times as large: the same ways, s times as long."""
    arena = tuple((factor * low, factor * high) for low, high in workspace_of(SCENE).arena)
    large = replace(
        SCENE,
        arena=arena,
        regions=tuple(_scaled(region, factor) for region in SCENE.regions),
        initial=_scaled(SCENE.initial, factor),
    )
    goal, free = [parse(SCENE.region_names[0])], [[parse(f"!{SCENE.region_names[1]}")]]
    one = goal_geometry(world_of(SCENE), SCENE, goal, free, 8)
    other = goal_geometry(world_of(large), large, goal, free, 8)
    np.testing.assert_allclose(other.center, factor * one.center, atol=1e-4)
    atol = 1e-3 * factor
    np.testing.assert_allclose(other.fields[..., 0], factor * one.fields[..., 0], 1e-3, atol)


def test_fields_are_read_where_the_arena_lies():
    """The distance to a disc in an empty arena, between the nodes of its grid."""
    goal = Region("A", "circle", (110.0, 48.0), (2.0,))
    arena, start = ((100.0, 120.0), (40.0, 50.0)), SCENE.initial.at((105.0, 45.0))
    scene = replace(SCENE, arena=arena, initial=start, regions=(goal,), formula="F_[0:9](A)")
    world = world_of(scene)
    geometry = goal_geometry(world, scene, [parse("A")], [[]], 8)
    data = world_arrays(scene, MAX_ATOMS, geometry.fields[0])
    points = np.random.default_rng(0).uniform((100, 40), (120, 50), (50, 2)).astype(np.float32)
    compiled = world.compiled
    field = jax.jit(jax.vmap(lambda p: compiled.field(data, 0, p)))
    distance, direction = field(jnp.asarray(points))
    exact = np.linalg.norm(points - goal.center, axis=1) - 2.0 + world.inset
    np.testing.assert_allclose(distance, np.maximum(exact, 0), rtol=0.03, atol=0.1)
    away = exact > 1.0
    towards = goal.center - points
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    assert ((np.asarray(direction) * towards).sum(1)[away] > 0.98).all()


def test_ways_stay_in_the_arena():
    """A wall from edge to edge cannot be walked around where the grid reaches further."""
    arena = ((0.0, 10.0), (0.0, 13.0))
    wall = Region("W", "rectangle", (5.0, 6.5), (0.5, 6.5))
    goal = Region("A", "circle", (9.0, 12.0), (0.5,))
    start = SCENE.initial.at((2.0, 2.0))
    scene = replace(SCENE, arena=arena, initial=start, regions=(wall, goal), formula="F_[0:9](A)")
    world = world_of(scene)
    assert world.grid.nodes().max(0)[1] > 13.5
    fields = goal_geometry(world, scene, [parse("A")], [[parse("!W")]], 8).fields[0, 0, ..., 0]
    start = np.linalg.norm(world.grid.nodes() - (1.0, 12.0), axis=1).argmin()
    assert fields.reshape(-1)[start] > 20.0  # through the wall, slowly


def test_a_goal_outside_is_answered_with_an_arena_that_would_do():
    far = Region("A", "circle", (7.0, 0.0), (0.5,))
    scene = replace(SCENE, regions=(far,), formula="F_[0:50](A)")
    with pytest.raises(SceneError, match=r"`arena = (.*)` holds all its regions") as caught:
        goal_geometry(world_of(scene), scene, [parse("A")], [[]], 8)
    arena = str(caught.value).split("`")[1].removeprefix("arena = ")
    wider = replace(scene, arena=eval(arena))
    assert goal_geometry(world_of(wider), wider, [parse("A")], [[]], 8).center[0, 0] > 6.5


def test_ways_lead_in_from_starts_outside():
    start = Region("initial", "circle", (-3.0, -2.0), (0.5,))
    goal = Region("A", "circle", (8.0, 8.0), (0.5,))
    scene = replace(SCENE, arena=((0.0, 10.0), (0.0, 10.0)), regions=(goal,), formula="F_[0:9](A)")
    world = world_of(replace(scene, initial=start))
    low, high = world.limits
    np.testing.assert_allclose((low, high), ((-3.5, -2.5), (10.0, 10.0)))
    assert not world.beyond(world.grid.nodes()[:1]).any()


@pytest.mark.parametrize(
    ("scale", "expected"),
    [(1, 1), (1.18, 1), (2, 2), (3, 2), (5.1, 5), (0.2, 0.2), (0.15, 0.1), (0.99, 0.5), (25, 20)],
)
def test_what_is_drawn_has_round_sizes(scale, expected):
    assert round_scale(scale) == pytest.approx(expected)
