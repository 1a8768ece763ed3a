"""Polygons against shapely: which are accepted, what they are made of, how far they are."""

import numpy as np
import pytest
import shapely

from scenes.polygons import MOST_CORNERS, area, counter_clockwise, flaw, signed_distance, triangles
from tests.scenes.outlines import star

L_ROOM = ((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3))
TEETH = ((5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3))
COMB = ((0, 0), *TEETH)
STRAIGHT = ((0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1))
STARS = [star(np.random.default_rng(seed), 3 + seed % 14) for seed in range(60)]
POLYGONS = [L_ROOM, COMB, STRAIGHT, *STARS]


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        (((0, 0), (1, 1)), "2 corners; a polygon has from 3 to 16"),
        (star(np.random.default_rng(0), 17), "17 corners"),
        (((0, 0), (0, 0), (1, 1)), "corner 1 and the next one are the same"),
        (((0, 0), (1, 1), (1, 0), (0, 1)), "edges from corner 1 and from corner 3 touch or cross"),
        (((0, 0), (2, 0), (2, 2), (1, 0), (0, 2)), "edges from corner 1 and from corner 3 touch"),
        (((0, 0), (2, 0), (1, 0), (1, 1)), "the edges at corner 2 lie on each other"),
        (((1, 0), (1, 1), (0, 0), (2, 0)), "edges from corner 1 and from corner 3 touch or cross"),
        (((0, 0), (1, 0), (2, 0)), "lie on each other"),
    ],
)
def test_what_is_no_polygon_says_why(corners, message):
    assert message in flaw(corners)


@pytest.mark.parametrize("corners", POLYGONS)
def test_polygons_are_accepted_from_any_corner_in_either_sense(corners):
    for turn in range(len(corners)):
        turned = [*corners[turn:], *corners[:turn]]
        assert flaw(turned) == flaw(turned[::-1]) == ""
        assert area(counter_clockwise(turned)) == pytest.approx(shapely.Polygon(corners).area)


def test_random_corners_are_judged_as_by_shapely():
    """Rings of random corners: nearly all larger ones cross themselves."""
    random, accepted = np.random.default_rng(1), 0
    for _ in range(400):
        corners = random.uniform(-1, 1, (random.integers(3, 7), 2))
        simple = shapely.Polygon(corners).is_valid
        accepted += simple
        assert (flaw(corners) == "") == simple
    assert 100 < accepted < 300


@pytest.mark.parametrize("corners", POLYGONS)
def test_triangles_cover_the_polygon_once(corners):
    found = triangles(corners)
    assert len(found) <= min(len(corners), MOST_CORNERS) - 2
    pieces = [shapely.Polygon(triangle) for triangle in found]
    outline = shapely.Polygon(corners)
    assert sum(piece.area for piece in pieces) == pytest.approx(outline.area, rel=1e-9)
    assert shapely.union_all(pieces).symmetric_difference(outline).area < 1e-9


@pytest.mark.parametrize("corners", POLYGONS)
def test_distances_are_those_of_shapely(corners):
    positions = np.random.default_rng(2).uniform(-4, 6, (200, 2))
    outline, points = shapely.Polygon(corners), shapely.points(positions)
    away = shapely.distance(outline.exterior, points)
    expected = np.where(shapely.contains(outline, points), -away, away)
    np.testing.assert_allclose(signed_distance(corners, positions), expected, atol=1e-9)
