"""Shapes that are drawn and resized by a drag."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import Region
from studio.page.editing import shapes
from tests.scenes.outlines import planar, spatial


def test_snapping():
    assert shapes.snap((0.13, -0.37, 0.12), 0.25) == (0.25, -0.25, 0.0)
    assert shapes.snap((0.1 + 0.2,), 0.1) == (0.3,)
    assert shapes.snap((0.13, 1), 0) == (0.13, 1.0)


def test_drawing_by_a_drag():
    assert shapes.drawn("rectangle", (1, 1), (-1, 0)) == ((0, 0.5), (1, 0.5))
    assert shapes.drawn("circle", (1, 1), (1, 3)) == ((1, 1), (2,))
    assert shapes.drawn("sphere", (1, 1), (1, 3)) == ((1, 1, 2), (2,))
    assert shapes.drawn("box", (0, 0), (2, 2)) == ((1, 1, 0.5), (1, 1, 0.5))
    assert shapes.drawn("cylinder", (0, 0), (0, 2)) == ((0, 0, 0.5), (2, 0.5))
    assert shapes.drawn("rectangle", (0.1, 0), (0.9, 1.1), step=0.5) == ((0.5, 0.5), (0.5, 0.5))
    assert shapes.drawn("circle", (1, 1), (1.01, 1)) is None
    assert shapes.drawn("rectangle", (0, 0), (1, 0)) == ((0.5, 0), (0.5, shapes.SMALLEST))


KINDS = {"circle": 1, "rectangle": 2, "sphere": 1, "box": 3, "cylinder": 2}


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_a_dragged_handle_lands_where_the_pointer_is(data):
    kind = data.draw(st.sampled_from(sorted(KINDS)))
    dimension = 2 if kind in ("circle", "rectangle") else 3
    number = st.floats(-5, 5)
    center = data.draw(st.tuples(*[number] * dimension))
    size = data.draw(st.tuples(*[st.floats(0.1, 3)] * KINDS[kind]))
    region = Region("A", kind, center, size)
    points = shapes.handles(region)
    handle = data.draw(st.integers(0, len(points) - 1))
    same = shapes.resized(region, handle, points[handle])
    assert same.center == pytest.approx(center)
    assert same.size == pytest.approx(size)
    # Away from the centre by up to twice the size: the handle follows the pointer.
    scale = data.draw(st.floats(1.0, 2.0))
    target = tuple(c + scale * (p - c) for c, p in zip(center, points[handle], strict=True))
    new = shapes.resized(region, handle, target)
    moved = Region("A", kind, new.center, new.size)
    assert shapes.handles(moved)[handle] == pytest.approx(target, abs=1e-9)
    # Whatever the pointer does, the region stays one.
    wild = shapes.resized(region, handle, data.draw(st.tuples(*[number] * dimension)), step=0.25)
    assert Region("A", kind, wild.center, wild.size)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dimension", [2, 3])
def test_handles_of_other_kinds_follow_the_pointer(seed, dimension):
    """Outwards by half: kind and angle stay, and of a polygon the other corners."""
    for flat in planar(np.random.default_rng(seed)):
        region = flat if dimension == 2 else spatial(flat, 0.0, 1.0)
        points = shapes.handles(region)
        assert (len(points) == 0) == (region.kind == "union")
        for handle, point in enumerate(points):
            same = shapes.reshaped(region, handle, point)
            assert same.half_extents == pytest.approx(region.half_extents)
            target = np.array(region.center) + 1.5 * (np.array(point) - region.center)
            moved = shapes.reshaped(region, handle, tuple(target.tolist()))
            assert (moved.kind, moved.angle) == (region.kind, region.angle)
            if moved != region:  # a corner that would make a polygon cross itself stays
                assert shapes.handles(moved)[handle] == pytest.approx(target, abs=1e-6)
            if region.kind == "polygon":
                others = zip(moved.points, region.points, strict=True)
                assert sum(a != b for a, b in others) <= 1


def test_a_polygon_never_crosses_itself():
    square = Region("A", "polygon", points=((0, 0), (1, 0), (1, 1), (0, 1)))
    assert shapes.reshaped(square, 0, (3.0, 0.5)) == square
    assert shapes.reshaped(square, 0, (-1.0, 0.1), step=0.5).points[0] == (-1.0, 0.0)


def test_corners_opposite_to_the_pointer_stay():
    region = Region("A", "rectangle", (0, 0), (1, 2))
    assert shapes.resized(region, 3, (3, 0)) == ((1, -1), (2, 1))
    assert shapes.resized(region, 0, (0.5, -4)) == ((0.75, -1), (0.25, 3))
    assert shapes.resized(region, 0, (9, -2)) == ((1 - shapes.SMALLEST, 0), (shapes.SMALLEST, 2))
    cylinder = Region("A", "cylinder", (0, 0, 1), (2, 1))
    assert shapes.resized(cylinder, 5, (7, 7, 4)) == ((0, 0, 2), (2, 2))
    assert shapes.resized(cylinder, 0, (0, 3, 9)) == ((0, 0, 1), (3, 1))
