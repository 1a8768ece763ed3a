"""Starts are uniform in initial sets of every kind: exact shares of a grid's cells, fixed seeds."""

from dataclasses import replace

import jax
import numpy as np
import pytest
import shapely
from scipy.stats import chisquare

from core.task.grounding import MAX_ATOMS
from scenes import Region, load_task, world_arrays, world_of
from scenes.distances import margin_of
from scenes.starts import inner_point
from tests.scenes.outlines import planar, shape, spatial, star

COUNT = 40_000
LEAST = 1e-3
"""Smallest p-value that counts as uniform: a sound sampler fails in one of a thousand seeds."""

ACROSS = 5
L_ROOM = Region("L", "polygon", points=((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3)))
TURNED = Region("R", "rectangle", (1.0, -2.0), (1.5, 0.3), angle=30.0)
OVERLAPPING = Region(
    "U",
    "union",
    parts=(
        Region("U", "circle", (0.0, 0.0), (1.0,)),
        Region("U", "circle", (0.5, 0.0), (1.0,)),
        Region("U", "rectangle", (0.0, 0.5), (2.0, 0.4), angle=20.0),
    ),
)
STAR = Region("S", "polygon", points=star(np.random.default_rng(3), 16))
SETS = {"polygon": L_ROOM, "turned": TURNED, "union": OVERLAPPING, "star": STAR}
KINDS = pytest.mark.parametrize("kind", SETS)


def _starts(initial: Region) -> np.ndarray:
    scene = load_task("linear-demo" if initial.dimension == 2 else "quadrotor-demo")
    scene, world = replace(scene, initial=initial), world_of(scene)
    fields = np.zeros((1, *world.grid.shape, 1 + initial.dimension), np.float32)
    data = world_arrays(scene, MAX_ATOMS, fields)
    draw = jax.jit(jax.vmap(world.sample_initial, (None, 0)))
    return np.asarray(draw(data, jax.random.split(jax.random.key(7), COUNT)), float)


def _shares(initial: Region, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Starts in each cell of a grid over the footprint, and how many belong there."""
    low = initial.center - initial.half_extents
    side = 2 * initial.half_extents[:2] / ACROSS
    cell = np.clip((starts[:, :2] - low[:2]) / side, 0, ACROSS - 1).astype(int)
    counts = np.bincount(cell[:, 0] * ACROSS + cell[:, 1], minlength=ACROSS**2)
    outline = shape(initial)
    boxes = [
        shapely.box(*(low[:2] + side * (i, j)), *(low[:2] + side * (i + 1, j + 1)))
        for i in range(ACROSS)
        for j in range(ACROSS)
    ]
    areas = np.array([outline.intersection(box).area for box in boxes])
    return counts, COUNT * areas / areas.sum()


@KINDS
def test_starts_in_the_plane_are_uniform(kind):
    starts = _starts(SETS[kind])
    assert margin_of(SETS[kind], starts).min() > -1e-5
    counts, expected = _shares(SETS[kind], starts)
    common = expected > 5
    assert counts[~common].sum() <= 5 + 2 * expected[~common].sum()
    rest = expected[common] * counts[common].sum() / expected[common].sum()
    assert chisquare(counts[common], rest).pvalue > LEAST


@KINDS
def test_starts_in_space_are_uniform(kind):
    initial = spatial(SETS[kind], 0.5, 2.5)
    starts = _starts(initial)
    assert margin_of(initial, starts).min() > -1e-5
    counts, expected = _shares(initial, starts)
    common = expected > 5
    rest = expected[common] * counts[common].sum() / expected[common].sum()
    assert chisquare(counts[common], rest).pvalue > LEAST
    assert chisquare(np.histogram(starts[:, 2], 10, (0.5, 2.5))[0]).pvalue > LEAST


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_point_is_where_all_start(dimension):
    point = Region("initial", "point", (1.0, -2.0, 0.5)[:dimension])
    np.testing.assert_array_equal(_starts(point), np.tile(point.center, (COUNT, 1)))


@pytest.mark.parametrize("seed", range(5))
def test_there_is_a_position_inside(seed):
    for region in planar(np.random.default_rng(seed)):
        for each in (region, spatial(region, -1.0, 1.0)):
            assert margin_of(each, inner_point(each)[None])[0] > 0
