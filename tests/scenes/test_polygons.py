"""Polygons: which are accepted, what they are made of, how far they are."""

from itertools import combinations

import numpy as np
import pytest
import shapely
from matplotlib.path import Path

from scenes.polygons import MOST_CORNERS, counter_clockwise, flaw, signed_distance, triangles
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
        (((0, 0), (1, 1), (1, 0), (0, 1)), "its edges touch or cross at (0.5, 0.5)"),
        (((0, 0), (2, 0), (2, 2), (1, 0), (0, 2)), "its edges touch or cross"),
        (((0, 0), (2, 0), (1, 0), (1, 1)), "its edges touch or cross"),
        (((1, 0), (1, 1), (0, 0), (2, 0)), "its edges touch or cross"),
        (((0, 0), (1, 0), (2, 0)), "its edges touch or cross"),
    ],
)
def test_what_is_no_polygon_says_why(corners, message):
    assert message in flaw(corners)


@pytest.mark.parametrize("corners", POLYGONS)
def test_polygons_are_accepted_from_any_corner_in_either_sense(corners):
    for turn in range(len(corners)):
        turned = [*corners[turn:], *corners[:turn]]
        assert flaw(turned) == flaw(turned[::-1]) == ""
        x, y = counter_clockwise(turned).T
        area = (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2
        assert area == pytest.approx(shapely.Polygon(corners).area)


def test_random_corners_cross_where_two_edges_do():
    """Rings of random corners: nearly all larger ones cross themselves."""
    random, accepted = np.random.default_rng(1), 0
    for _ in range(400):
        corners = random.uniform(-1, 1, (random.integers(3, 7), 2))
        edges = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
        simple = not any(_cross(*one, *other) for one, other in combinations(edges, 2))
        accepted += simple
        assert (flaw(corners) == "") == simple
    assert 100 < accepted < 300


def _cross(a, b, c, d):
    """Whether the segments ab and cd cross; not where they share an end."""

    def side(p, q, r):
        return np.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


@pytest.mark.parametrize("corners", POLYGONS)
def test_triangles_cover_the_polygon_once(corners):
    found = triangles(corners)
    assert len(found) <= min(len(corners), MOST_CORNERS) - 2
    pieces = [shapely.Polygon(triangle) for triangle in found]
    outline = shapely.Polygon(corners)
    assert sum(piece.area for piece in pieces) == pytest.approx(outline.area, rel=1e-9)
    assert shapely.union_all(pieces).symmetric_difference(outline).area < 1e-9


@pytest.mark.parametrize("corners", POLYGONS)
def test_distances_are_those_to_the_nearest_of_many_points_of_the_boundary(corners):
    positions = np.random.default_rng(2).uniform(-4, 6, (200, 2))
    start = np.array(corners, float)
    share = np.linspace(0, 1, 400)[:, None, None]
    boundary = (start + share * (np.roll(start, -1, axis=0) - start)).reshape(-1, 2)
    away = np.linalg.norm(positions[:, None] - boundary, axis=-1).min(1)
    found = signed_distance(corners, positions)
    np.testing.assert_allclose(np.abs(found), away, atol=0.02)
    inside = Path(start, closed=False).contains_points(positions)
    clear = away > 0.02
    assert (found < 0)[clear].tolist() == inside[clear].tolist()
