"""Perturbed layouts: what moves, what stays, and the distances that are kept."""

import itertools

import numpy as np
import pytest

from scenes import load_task, task_names, world_of
from scenes.layouts import Perturbation, perturbed
from tests.scenes import geometry
from tests.scenes.plans import WALLS, plan_of

TASKS = pytest.mark.parametrize("task", task_names())


def _goals(scene) -> set[str]:
    return {visit.region for visit in plan_of(scene)}


def _layouts(scene, count: int = 4, **how) -> list:
    world = world_of(scene)
    random = np.random.default_rng(7)
    how = Perturbation(**how) if how else None
    return [perturbed(scene, _goals(scene), world, random, how) for _ in range(count)]


@TASKS
def test_everything_but_walls_moves(task):
    scene = load_task(task)
    for layout in _layouts(scene):
        assert layout.region_names == scene.region_names
        for before, after in zip(scene.regions, layout.regions, strict=True):
            assert (before.kind, before.color) == (after.kind, after.color)
            if before.name in WALLS[scene.dimension]:
                assert after.size == before.size
                np.testing.assert_allclose(np.abs(after.center), np.abs(before.center))
            elif before.name in _goals(scene):
                assert after.center != before.center, before.name
        assert layout.initial.center != scene.initial.center


@TASKS
def test_goals_keep_their_distances(task):
    """Of the clearance and the inset of planned ways, or as near as they were."""
    scene = load_task(task)
    world = world_of(scene)
    apart = world.clearance + world.inset

    def distances(layout):
        marked = [r for r in layout.regions if r.name in _goals(scene)] + [layout.initial]
        pairs = itertools.product(marked, layout.regions)
        return np.array([geometry.separation(a, b) for a, b in pairs if a is not b])

    usual = np.minimum(distances(scene), apart)
    for layout in _layouts(scene):
        assert (distances(layout) >= usual - 1e-6).all()


def test_chambers_stay_closed_and_pillars_stand():
    for task, free in (("linear-10", []), ("unicycle-10", []), ("quadrotor-04", [0, 1])):
        scene = load_task(task)
        walls = WALLS[scene.dimension] | _goals(scene)
        for layout in _layouts(scene, mirror=False, shift=0.1, scale=0.1):
            for before, after in zip(scene.regions, layout.regions, strict=True):
                if before.name not in walls:
                    moved = np.flatnonzero(np.abs(np.subtract(before.center, after.center)) > 1e-9)
                    assert set(moved) == set(free), before.name


def test_the_same_generator_gives_the_same_layouts():
    scene = load_task("quadrotor-08")
    first, second = _layouts(scene), _layouts(scene)
    assert first == second
    assert len({layout.regions[0].center for layout in first}) == len(first)


def test_mirrored_layouts_are_among_them():
    scene = load_task("panda-08")
    sides = {np.sign(layout.regions[0].center[1]) for layout in _layouts(scene, 12)}
    assert sides == {-1.0, 1.0}
    assert all(layout.regions[0].center[0] > 0 for layout in _layouts(scene, 12))


def test_overlapping_goals_keep_their_overlap():
    scene = load_task("linear-08")
    goals = [r for r in scene.regions if r.name in _goals(scene)]
    first, second = goals[:2]
    center = tuple(np.add(first.center, 0.3).tolist())
    near = type(second)(second.name, second.kind, center, second.size)
    regions = tuple(near if r is second else r for r in scene.regions)
    scene = type(scene)(**{**vars(scene), "regions": regions})
    for layout in _layouts(scene, mirror=False, shift=0.1, scale=0.1):
        a, b = (r for r in layout.regions if r.name in (first.name, second.name))
        np.testing.assert_allclose(np.abs(np.subtract(a.center, b.center)), 0.3, atol=1e-9)


def test_where_nothing_fits_the_scene_stays():
    """Two goals fill the arena between its walls."""
    scene = load_task("linear-07")
    walls = [r for r in scene.regions if r.name in WALLS[2]]
    goals = [
        type(walls[0])(name, "rectangle", (x, 0.0), (2.1, 4.25))
        for name, x in (("A1", -2.15), ("A2", 2.15))
    ]
    scene = type(scene)(**{**vars(scene), "regions": (*walls, *goals)})
    layout = perturbed(
        scene, {"A1", "A2"}, world_of(scene), np.random.default_rng(0), Perturbation(mirror=False)
    )
    assert [r.center for r in layout.regions[:4]] == [r.center for r in walls]
    for before, after in zip(goals, layout.regions[4:], strict=True):
        np.testing.assert_allclose(before.center, after.center, atol=0.2)
