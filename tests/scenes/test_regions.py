import math

import numpy as np
import pytest

from scenes import Region, SceneError
from scenes.distances import margin_of
from scenes.regions import SHAPES
from tests.scenes.outlines import planar, spatial


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "circel"}, "kind: unknown 'circel'. Allowed: circle, "),
        ({"kind": []}, "kind: unknown"),
        ({"center": (0.0, math.nan)}, "center: nan must be finite"),
        ({"center": (0.0, -math.inf)}, "center: -inf must be finite"),
        ({"center": (0.0, 2e3)}, "center: 2000.0 must be finite and at most 1000 m"),
        ({"center": (10**400, 0)}, "must be finite and at most"),
        ({"center": (1.0,)}, "center: [1.0] has 1 numbers; a circle needs (x, y)"),
        ({"center": (1.0, 2.0, 3.0)}, "has 3 numbers; a circle needs (x, y)"),
        ({"center": "12"}, "center: '12' is not a list of numbers"),
        ({"center": ("1", 2)}, "center: '1' is not a number"),
        ({"center": (True, 2)}, "center: True is not a number"),
        ({"size": (0.0,)}, "size: [0.0] must be positive"),
        ({"size": (-1.0,)}, "size: [-1.0] must be positive"),
        ({"size": (1.0, 1.0)}, "a circle needs (radius)"),
        ({"color": "red"}, "color: 'red' is not of the form '#rrggbb'"),
        ({"color": "#12345g"}, "is not of the form"),
        ({"color": "#123456\n"}, "is not of the form"),
        ({"name": ""}, "name: '' must be non-empty text"),
        ({"name": 3}, "name: 3 must be non-empty text"),
        ({"name": "x" * 41}, "is longer than 40"),
        ({"name": " A"}, "without quotes, backslashes or spaces at the ends"),
        ({"name": 'a"b'}, "without quotes"),
        ({"name": "a\nb"}, "must be printable"),
    ],
)
def test_flaws_are_refused_with_the_field_and_what_is_allowed(changes, message):
    fields = {"name": "A", "kind": "circle", "center": (0.0, 1.0), "size": (1.0,)} | changes
    with pytest.raises(SceneError) as caught:
        Region(**fields)
    assert message in str(caught.value)


def test_numbers_become_floats_and_regions_hash():
    region = Region("A", "box", [1, 2, 3], [1, 1, 1], "#00ff7F")  # type: ignore[arg-type]
    assert region.center == (1.0, 2.0, 3.0)
    assert all(isinstance(value, float) for value in region.center + region.size)
    assert region.dimension == SHAPES["box"].dimension == 3
    assert len({region, Region("A", "box", (1, 2, 3), (1, 1, 1), "#00ff7F")}) == 1


@pytest.mark.parametrize("name", ["A", "B_1", "Küche", "pick up", "F", "<b>", "障害物"])
def test_names_that_a_formula_can_quote_are_accepted(name):
    assert Region(name, "circle", (0, 0), (1,)).name == name


CORNERS = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
UNION = Region("U", "union", parts=(Region("U", "circle", (0, 0), (1,)),))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"kind": "polygon"}, "points: 0 corners; a polygon has from 3 to 16"),
        ({"kind": "polygon", "points": 3}, "points: 3 is not a list of corners (x, y)"),
        ({"kind": "polygon", "points": ((0, 0), (1, 0), (1,))}, "a corner needs (x, y)"),
        ({"kind": "polygon", "points": ((0, 0), (1, 0), (1, math.nan))}, "nan must be finite"),
        ({"kind": "polygon", "points": CORNERS, "center": (9.0, 9.0)}, "follows from its points"),
        ({"kind": "polygon", "points": CORNERS, "z": (0, 1)}, "z: a polygon has none"),
        ({"kind": "polygon", "points": CORNERS, "angle": 3.0}, "angle: a polygon has none"),
        ({"kind": "prism", "points": CORNERS}, "z: [] has 0 numbers; a prism needs (low, high)"),
        ({"kind": "prism", "points": CORNERS, "z": (1, 1)}, "z: [1.0, 1.0]: low must be below"),
        ({"kind": "circle", "center": (0, 0), "size": (1,), "angle": 9.0}, "a circle has none"),
        ({"kind": "circle", "center": (0, 0), "size": (1,), "points": CORNERS}, "given by center"),
        ({"kind": "box", "center": (0, 0, 0), "size": (1, 1, 1), "angle": 400}, "at most 360"),
        ({"kind": "union"}, "parts: a union has from 1 to 16"),
        ({"kind": "union", "parts": (UNION,)}, "parts[0]: a union of dimension 2 cannot be part"),
        ({"kind": "point", "center": (0,)}, "a point needs (x, y)"),
    ],
)
def test_other_kinds_say_what_they_need(fields, message):
    with pytest.raises(SceneError) as caught:
        Region("A", **fields)
    assert message in str(caught.value)


def test_a_polygon_may_be_closed_as_maps_have_it():
    closed = Region("A", "polygon", points=(*CORNERS, CORNERS[0]))
    assert closed == Region("A", "polygon", points=CORNERS)
    assert (closed.center, closed.size) == ((0.5, 0.5), (0.5, 0.5))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dimension", [2, 3])
def test_moved_and_mirrored_regions_have_moved_and_mirrored_margins(seed, dimension):
    random = np.random.default_rng(seed)
    for flat in planar(random):
        region = flat if dimension == 2 else spatial(flat, -0.5, 1.0)
        positions = random.uniform(-3, 3, (50, dimension))
        before, center = margin_of(region, positions), random.uniform(-5, 5, dimension)
        moved = region.at(center.tolist())
        np.testing.assert_allclose(moved.center, center, atol=1e-8)
        shifted = positions + (center - region.center)
        np.testing.assert_allclose(margin_of(moved, shifted), before, atol=1e-7)
        sign = random.choice([-1.0, 1.0], dimension)
        mirrored = margin_of(region.mirrored(sign), positions * sign)
        np.testing.assert_allclose(mirrored, before, atol=1e-7)
        low, high = region.center - region.half_extents, region.center + region.half_extents
        inside = positions[before >= 0]
        assert ((inside >= low - 1e-9) & (inside <= high + 1e-9)).all()


def test_polygons_and_prisms_are_stretched_but_unions_are_not():
    wide = Region("A", "prism", points=CORNERS, z=(0, 1)).sized((1.0, 0.5, 2.0))
    assert wide.points == ((-0.5, 0.0), (1.5, 0.0), (1.5, 1.0))
    assert (wide.center, wide.z) == ((0.5, 0.5, 0.5), (-1.5, 2.5))
    with pytest.raises(SceneError, match="size: a union has none of its own"):
        UNION.sized((1.0, 1.0))
