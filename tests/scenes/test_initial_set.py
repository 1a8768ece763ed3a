"""Starts are uniform in the initial set, whatever its kind; exact laws, fixed seeds."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import chisquare, kstest

from core.task.grounding import MAX_ATOMS
from scenes import Region, load_task, world_arrays, world_of
from scenes.regions import SHAPES
from tests.scenes.geometry import margins_of

COUNT = 200_000
LEAST = 1e-3
"""Smallest p-value that counts as uniform: the seed is fixed, a sound sampler fails in one of a
thousand checks, and drawing from a cylinder's bounding box has p < 1e-300."""

SIZES = {
    "circle": (0.7,),
    "rectangle": (0.4, 1.1),
    "sphere": (0.6,),
    "box": (0.3, 0.5, 0.9),
    "cylinder": (0.8, 0.4),
}
VOLUMES = {
    "circle": np.pi * 0.7**2,
    "rectangle": 4 * 0.4 * 1.1,
    "sphere": 4 / 3 * np.pi * 0.6**3,
    "box": 8 * 0.3 * 0.5 * 0.9,
    "cylinder": np.pi * 0.8**2 * 2 * 0.4,
}
CENTERS = {2: (1.5, -2.0), 3: (1.5, -2.0, 2.0)}
KINDS = pytest.mark.parametrize("kind", SHAPES)


def _region(kind) -> Region:
    return Region("initial", kind, CENTERS[SHAPES[kind].dimension], SIZES[kind])


def _sampler(initial: Region):
    """Data of a scene with an initial set, and what draws from it."""
    scene = load_task("linear-demo" if initial.dimension == 2 else "quadrotor-demo")
    world = world_of(scene)
    scene = replace(scene, initial=initial)
    fields = np.zeros((1, *world.grid.shape, 1 + initial.dimension), np.float32)
    return world_arrays(scene, MAX_ATOMS, fields), jax.jit(
        jax.vmap(world.sample_initial, (None, 0))
    )


def _starts(initial: Region) -> np.ndarray:
    data, draw = _sampler(initial)
    return np.asarray(draw(data, jax.random.split(jax.random.key(7), COUNT)), float)


def test_every_kind_is_tested():
    assert set(SIZES) == set(VOLUMES) == set(SHAPES)


@KINDS
def test_every_start_lies_inside(kind):
    initial = _region(kind)
    assert margins_of(initial, _starts(initial)).min() >= -1e-5  # float32 of 2 m


@KINDS
def test_parts_get_their_share(kind):
    """The halves of every axis cut the set into 2^d equal parts; a region half as large in every
    size around the centre holds 2^-d of it."""
    initial = _region(kind)
    offset = _starts(initial) - initial.center
    part = (offset > 0) @ (2 ** np.arange(initial.dimension))
    assert chisquare(np.bincount(part, minlength=2**initial.dimension)).pvalue > LEAST
    inner = replace(initial, size=tuple(size / 2 for size in initial.size))
    within = (margins_of(inner, offset + initial.center) >= 0).sum()
    share = 2.0**-initial.dimension
    expected = COUNT * np.array([share, 1 - share])
    assert chisquare([within, COUNT - within], expected).pvalue > LEAST


@KINDS
def test_the_density_is_that_of_the_volume(kind):
    """A small box in the middle gets its volume's share."""
    initial = _region(kind)
    half = 0.35 * np.resize(min(initial.size), initial.dimension)
    inside = (np.abs(_starts(initial) - initial.center) <= half).all(1).sum()
    share = np.prod(2 * half) / VOLUMES[kind]
    expected = COUNT * np.array([share, 1 - share])
    assert chisquare([inside, COUNT - inside], expected).pvalue > LEAST


@pytest.mark.parametrize(("kind", "axes"), [("circle", 2), ("sphere", 3), ("cylinder", 2)])
def test_radii_and_heights_follow_their_laws(kind, axes):
    """(r / R)^k is uniform, k the axes of the ball; so is the height along a cylinder."""
    initial = _region(kind)
    offset = _starts(initial) - initial.center
    radius = np.linalg.norm(offset[:, :axes], axis=1) / initial.size[0]
    assert kstest(radius**axes, "uniform").pvalue > LEAST
    angle = np.arctan2(offset[:, 1], offset[:, 0]) / (2 * np.pi) + 0.5
    assert kstest(angle, "uniform").pvalue > LEAST
    if kind == "cylinder":
        height = offset[:, 2] / (2 * initial.size[1]) + 0.5
        assert kstest(height, "uniform").pvalue > LEAST
        assert abs(np.corrcoef(radius, height)[0, 1]) < 4 / np.sqrt(COUNT)


def test_another_kind_of_set_compiles_nothing():
    data, draw = _sampler(_region("box"))
    keys = jax.random.split(jax.random.key(0), 4)
    draw(jax.tree.map(jnp.asarray, data), keys)
    for kind in ("cylinder", "sphere"):
        other, _ = _sampler(_region(kind))
        draw(jax.tree.map(jnp.asarray, other), keys)
    assert draw._cache_size() == 1  # pyright: ignore[reportAttributeAccessIssue]
