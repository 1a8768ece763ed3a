import jax
import jax.numpy as jnp
import numpy as np
import pytest
import skfmm

from core.stl import parse
from envs import Linear
from scenes import Region, Scene, SceneError, goal_geometry, make_world
from scenes.fields import Grid, geodesic_field, interpolate

PLANAR = make_world(Linear().workspace)
GRID = PLANAR.grid
NODES = GRID.nodes().reshape(*GRID.shape, 2)
NOTHING = np.zeros(GRID.shape, bool)


def _disc(center, radius):
    return radius - np.linalg.norm(NODES - np.asarray(center), axis=-1)


def _at(table, position):
    return np.asarray(interpolate(GRID, table[None], 0, jnp.asarray(position, jnp.float32)))


def test_straight_lines_in_free_space():
    """Fast marching is second order: within 2 % and a tenth of a cell of the straight line."""
    table = geodesic_field(GRID, _disc((1.0, -0.5), 0.5), NOTHING, inset=0.1)
    exact = np.maximum(np.linalg.norm(NODES - (1.0, -0.5), axis=-1) - 0.4, 0)
    assert np.abs(table[..., 0] - exact).max() < 0.02 * exact.max() + 0.05
    away = exact > 0.5
    towards = (np.array([1.0, -0.5]) - NODES) / np.linalg.norm(
        NODES - (1.0, -0.5), axis=-1, keepdims=True
    ).clip(1e-9)
    agreement = (table[..., 1:] * towards).sum(-1)[away]
    assert agreement.min() > 0.98


@pytest.mark.parametrize("start", [(-3.0, 0.0), (-2.0, -1.0), (-3.5, 1.0)])
def test_around_one_wall(start):
    """A thin wall from the top border down to y = -2: the way leads around its end."""
    wall = (np.abs(NODES[..., 0]) < 0.2) & (NODES[..., 1] > -2.0)
    goal = np.array([3.0, 0.5])
    table = geodesic_field(GRID, _disc(goal, 0.5), wall, inset=0.0)
    corners = [np.array([-0.25, -2.06]), np.array([0.25, -2.06])]
    points = [np.array(start), *corners, goal]
    legs = [np.linalg.norm(b - a) for a, b in zip(points[:-1], points[1:], strict=True)]
    exact = sum(legs) - 0.5
    found = _at(table, start)
    assert found[0] == pytest.approx(exact, rel=0.04)
    direction = (corners[0] - start) / np.linalg.norm(corners[0] - start)
    assert found[1:] @ direction > 0.95
    straight = np.linalg.norm(goal - start) - 0.5
    assert found[0] > straight + 0.5


def test_inside_an_obstacle_the_field_leads_out():
    wall = (np.abs(NODES[..., 0]) < 0.8) & (np.abs(NODES[..., 1]) < 3.0)
    table = geodesic_field(GRID, _disc((3.0, 0.0), 0.5), wall)
    assert _at(table, (0.4, 0.0))[1] > 0.9
    assert _at(table, (0.4, 0.0))[0] > 1.5 * _at(table, (1.2, 0.0))[0]


def test_a_goal_smaller_than_a_cell_is_still_found():
    table = geodesic_field(GRID, _disc((0.06, 0.06), 0.02), NOTHING)
    assert _at(table, (2.06, 0.06))[0] == pytest.approx(2.0, abs=0.15)


def test_interpolation_is_exact_on_linear_functions_in_two_and_three_dimensions():
    for grid in (GRID, Grid((-1.0, 0.0, 2.0), 0.5, (5, 4, 6))):
        weights = np.arange(1, grid.dimension + 1)
        table = (grid.nodes() @ weights).reshape(1, *grid.shape, 1).astype(np.float32)
        low = np.asarray(grid.origin)
        high = low + grid.spacing * (np.asarray(grid.shape) - 1)
        points = np.random.default_rng(0).uniform(low, high - 0.01, (20, grid.dimension))
        found = jax.vmap(lambda p, g=grid, t=table: interpolate(g, jnp.asarray(t), 0, p))(
            jnp.asarray(points, jnp.float32)
        )
        np.testing.assert_allclose(found[:, 0], points @ weights, atol=2e-3)


def _scene(**regions):
    return Scene(
        name="probe",
        title="probe",
        robot="linear",
        formula="true",
        horizon=10,
        seed=0,
        regions=tuple(
            Region(name=name, kind="circle", center=center, size=(radius,))
            for name, (center, radius) in regions.items()
        ),
        initial=Region(name="initial", kind="circle", center=(-3.0, -3.0), size=(0.5,)),
    )


def test_geometry_of_subgoals():
    scene = _scene(A=((0.0, 0.0), 1.0), B=((3.0, 0.0), 0.5), O=((1.6, 0.0), 0.4))
    goals = [parse("A"), parse("B")]
    geometry = goal_geometry(PLANAR, scene, goals, [[parse("!O")], []], 64)
    assert geometry.fields.shape == (2, 2, *GRID.shape, 3)
    assert (np.linalg.norm(geometry.inside[0], axis=-1) <= 1.0 + 1e-6).all()
    assert np.linalg.norm(geometry.center[1] - (3.0, 0.0)) < 0.13
    assert geometry.legs[1, 0, 1] == pytest.approx(1.5 + 0.1, abs=0.1)  # nothing in the way
    assert geometry.legs[0, 0, 1] > geometry.legs[1, 0, 1] + 0.05  # around O
    np.testing.assert_allclose(geometry.legs[:, [0, 1], [0, 1]], 0.0, atol=0.02)


def test_a_subgoal_that_holds_nowhere_is_named():
    scene = _scene(A=((-2.0, 0.0), 0.5), B=((2.0, 0.0), 0.5))
    with pytest.raises(SceneError, match="no position in the workspace satisfies A & B"):
        goal_geometry(PLANAR, scene, [parse("A & B")], [[]], 8)


def test_a_field_is_computed_once(monkeypatch):
    """Dragging one goal leaves the other's field as it is."""
    marches = []
    monkeypatch.setattr("scenes.fields.skfmm.travel_time", _counting(marches))
    grid = Grid((0.0, 0.0), 0.25, (13, 14))
    nodes, blocked = grid.nodes(), np.zeros(grid.shape, bool)

    def field(x):
        goal = 0.3 - np.linalg.norm(nodes - [x, 1.0], axis=1)
        return geodesic_field(grid, goal.reshape(grid.shape), blocked)

    one, other = field(1.0), field(2.0)
    assert field(1.0) is one and len(marches) == 2
    assert not np.array_equal(one, other) and not one.flags.writeable
    blocked[5, 5] = True
    assert field(1.0) is not one and len(marches) == 3


def _counting(calls):
    march = skfmm.travel_time

    def counted(*arguments, **options):
        calls.append(arguments)
        return march(*arguments, **options)

    return counted
