"""Paths of regions in scene files, and where regions are at a step."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import Region, Scene, SceneError, format_scene, load_task, parse_scene
from scenes.distances import margin_of
from scenes.motion import Motion, along, through

VELOCITY = """
format = 1
name = "moving"
title = "an obstacle that moves"
robot = "linear"
horizon = 30
seed = 1
formula = "F_[0:30](A) & G_[0:30](!O)"
[initial]
kind = "rectangle"
center = [-3.0, -3.0]
size = [0.3, 0.3]
[regions.A]
kind = "circle"
center = [2, 2]
size = [0.6]
[regions.O]
kind = "rectangle"
center = [0, 0]
size = [0.6, 0.6]
velocity = [0.1, 0.0]
"""
TRIANGLE = ((0.0, 0.0), (2.0, 0.0), (0.0, 1.0))


def with_path(text: str) -> str:
    return VELOCITY.replace("velocity = [0.1, 0.0]", text)


def test_a_velocity_goes_on_for_ever():
    moving = parse_scene(VELOCITY, "f").regions[1]
    for step in (0, 1, 7.5, 30, 500):
        assert moving.displaced(step).center == pytest.approx((0.1 * step, 0.0))
    assert moving.displaced(-3).center == (0.0, 0.0)


def test_a_path_leads_straight_from_waypoint_to_waypoint_and_stands_at_its_ends():
    path = "path = [[5, 0, 0], [15, 3, 1], [20, 3, -1]]"
    moving = parse_scene(with_path(path), "f").regions[1]
    wanted = {0: (0, 0), 5: (0, 0), 10: (1.5, 0.5), 15: (3, 1), 17.5: (3, 0), 20: (3, -1)}
    for step, center in (wanted | {99: (3, -1)}).items():
        assert moving.displaced(step).center == pytest.approx(center)


def test_a_centre_may_be_left_out_beside_a_path():
    text = with_path("path = [[0, 1, 2], [9, 3, 2]]").replace("center = [0, 0]\n", "")
    assert parse_scene(text, "f").regions[1].center == (1.0, 2.0)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("path = 3", "regions.O.path: 3 is not a list of waypoints; a waypoint is [step, x, y]"),
        ("path = [[0, 0, 0]]", "path: 1 waypoints; from 2 to 64 are allowed"),
        ("path = [[0, 0, 0], [5, 1]]", "path[1]: [5, 1] has 2 numbers"),
        ("path = [[0, 0, 0], [5, 1, nan]]", "path[1]: [5, 1, nan] is not a list of finite numbers"),
        ("path = [[0, 0, 0], [5, 1, true]]", "path[1]: [5, 1, True] is not a list of finite"),
        ("path = [[5, 0, 0], [5, 1, 1]]", "step 5 does not come after step 5"),
        ("path = [[0.5, 0, 0], [5, 1, 1]]", "the step must be an integer from 0 to 10,000"),
        ("path = [[0, 0, 0], [5, 1e4, 1]]", "coordinates may be at most 1000 m"),
        ("path = [[0, 1, 0], [5, 1, 1]]", "begins at [1.0, 0.0], but center is [0.0, 0.0]"),
        ("velocity = [0.1]", "velocity: [0.1] has 1 numbers; expected 2"),
        ('velocity = [0.1, "x"]', "must be a list of finite numbers"),
        ("velocity = [inf, 0]", "must be a list of finite numbers"),
        ("velocity = [1, 0]\npath = [[0, 0, 0], [1, 1, 1]]", "velocity: a path is given too"),
    ],
)
def test_errors_say_what_is_wrong_and_where(line, words):
    with pytest.raises(SceneError) as found:
        parse_scene(with_path(line), "f")
    assert words in str(found.value) and str(found.value).startswith("f: regions.O.")


@pytest.mark.parametrize(
    "initial",
    [
        'kind = "rectangle"\ncenter = [-3.0, -3.0]\nsize = [0.3, 0.3]\nvelocity = [1, 0]',
        'kind = "point"\ncenter = [-3.0, -3.0]\nvelocity = [1, 0]',
        'kind = "point"\ncenter = [0, 0]\npath = [[0, 0, 0], [1, 1, 0]]',
    ],
)
def test_the_initial_set_cannot_move(initial):
    before = 'kind = "rectangle"\ncenter = [-3.0, -3.0]\nsize = [0.3, 0.3]'
    with pytest.raises(SceneError, match="initial.*cannot move"):
        parse_scene(VELOCITY.replace(before, initial), "f")


def test_a_part_of_a_union_cannot_move_alone():
    part = Region("U", "circle", (0.0, 0.0), (1.0,), motion=along([1, 0], 2))
    with pytest.raises(SceneError, match="a part cannot move; the whole union can"):
        Region("U", "union", parts=(part,))


finite = st.floats(-500, 500).map(lambda value: round(value, 6))


@st.composite
def motions(draw, dimension):
    if draw(st.booleans()):
        return along(draw(st.lists(finite, min_size=dimension, max_size=dimension)), dimension)
    steps = sorted(draw(st.sets(st.integers(0, 10_000), min_size=2, max_size=5)))
    places = [draw(st.lists(finite, min_size=dimension, max_size=dimension)) for _ in steps]
    return through([[step, *place] for step, place in zip(steps, places, strict=True)], dimension)[
        0
    ]


@given(motions(2), st.tuples(st.floats(-100, 100), st.floats(-100, 100)))
@settings(max_examples=60, deadline=None)
def test_scenes_are_read_as_they_were_written(motion, center):
    shapes = (
        Region("O", "circle", center, (1.0,), motion=motion),
        Region("P", "polygon", points=TRIANGLE, motion=motion),
        Region("U", "union", parts=(Region("U", "circle", center, (1.0,)),), motion=motion),
    )
    for shape in shapes:
        scene = replace(load_task("linear-01"), regions=(shape,), formula=f"F_[0:9]({shape.name})")
        again = parse_scene(format_scene(scene), "f").regions[0]
        assert again.motion == motion and again.center == pytest.approx(shape.center, abs=1e-8)


@pytest.mark.parametrize("kind", ["rectangle", "polygon", "union"])
def test_a_region_that_is_displaced_has_its_margins_displaced(kind):
    motion = Motion((0, 10), ((0.0, 0.0), (2.0, -1.0)))
    box = Region("O", "rectangle", (0.3, 0.2), (0.5, 0.1), angle=30.0)
    shape = {
        "rectangle": replace(box, motion=motion),
        "polygon": Region("O", "polygon", points=TRIANGLE, motion=motion),
        "union": Region("O", "union", parts=(box,), motion=motion),
    }[kind]
    positions = np.random.default_rng(0).uniform(-3, 3, (200, 2))
    there = margin_of(shape.displaced(5), positions + np.array([1.0, -0.5]))
    np.testing.assert_allclose(there, margin_of(shape, positions), atol=1e-8)


def test_a_mirrored_region_goes_the_mirrored_way():
    sign, motion = np.array([-1.0, 1.0]), Motion((0, 10), ((0.0, 0.0), (2.0, -1.0)))
    for shape in (
        Region("O", "circle", (1.0, 0.5), (0.5,), motion=motion),
        Region("O", "polygon", points=TRIANGLE, motion=motion),
    ):
        one = np.array(shape.mirrored(sign).displaced(10).center)
        np.testing.assert_allclose(one, sign * shape.displaced(10).center, atol=1e-9)


def test_a_path_moves_with_its_region():
    shape = Region("O", "circle", (1.0, 0.5), (0.5,), motion=along([0.5, 0.0], 2))
    assert shape.at((0.0, 0.0)).displaced(4).center == (2.0, 0.0)


def test_a_path_has_the_dimension_of_its_region():
    with pytest.raises(SceneError, match="leads through 3 dimensions"):
        Region("O", "circle", (1.0, 0.5), (0.5,), motion=along([0.5, 0.0, 0.0], 3))


def test_speed_is_the_largest_of_a_path():
    assert along([0.3, 0.4], 2).speed == pytest.approx(0.5)
    assert Motion((0, 10, 12), ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))).speed == pytest.approx(0.5)


def test_a_scene_knows_what_moves():
    scene: Scene = parse_scene(VELOCITY, "f")
    assert scene.moving == {"O"} and not load_task("linear-01").moving
