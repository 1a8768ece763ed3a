"""Regions of the plane as outlines of facets, and a scene as exact plans know it."""

from collections.abc import Mapping, Sequence

import numpy as np
import shapely

from core.planning.exact import Setting
from core.planning.outline import Facets, Outline
from core.quoting import listed
from core.stl import quote_name
from core.task.protocols import stride_of
from envs import ENVS
from scenes.distances import margin_of
from scenes.polygons import counter_clockwise
from scenes.regions import Region, SceneError
from scenes.scene import Scene, robot_of


def setting_of(scene: Scene) -> Setting:
    """A scene for `plan_exactly`, from the centre of its initial set.

    Raises:
        SceneError: a robot that does not move by bounded strides in the plane, regions that move,
            or something that has no outline.
    """
    stride = stride_of(robot_of(scene))
    if stride is None or scene.dimension != 2:
        able = [name for name, robot in ENVS.items() if stride_of(robot) is not None]
        raise SceneError(
            f"exact plans are for robots whose action moves them straight, not for "
            f"{scene.robot!r}. Allowed: {', '.join(able)}"
        )
    if scene.moving:
        names = listed(sorted(map(quote_name, scene.moving)))
        raise SceneError(
            f"exact plans are for regions that stand, but {names} "
            f"{'moves' if len(scene.moving) == 1 else 'move'}"
        )
    if scene.predicates:
        names = ", ".join(predicate.name for predicate in scene.predicates)
        raise SceneError(f"exact plans know regions, no predicates of the state: {names}")
    regions = scene.regions
    for region in regions:
        if flaw := _without_outline(region):
            raise SceneError(f"exact plans know circles, rectangles and convex polygons; {flaw}")
    return Setting(
        np.array(scene.initial.center, np.float32).astype(float),
        np.array(stride),
        lambda directions: {region.name: outline_of(region, directions) for region in regions},
        lambda positions: margins_of(regions, positions),
    )


def margins_of(regions: Sequence[Region], positions: np.ndarray) -> Mapping[str, np.ndarray]:
    """Margins [P] of each region at positions [P, d] in [m]."""
    return {region.name: margin_of(region, positions) for region in regions}


def outline_of(region: Region, directions: int) -> Outline:
    """Bounds on a region's signed distance by facets in so many directions.

    With a half the angle between neighbouring directions, they differ from the distance to the
    centre of a circle, or to the corner of a rectangle that is nearest, by at most its share
    1 / cos(a) - 1: 2 % for 16 directions, 0.1 % for 64. Everywhere else a rectangle is exact. Its
    corners have half as many directions as a circle: they are near, where a centre is far.

    Args:
        region: a circle, a rectangle or a convex polygon.
        directions: a multiple of 8.
    """
    center = np.array(region.center)
    if region.kind == "circle":
        normals, radius = _unit(_angles(directions)), region.size[0]
        stretched = normals / np.cos(np.pi / directions)
        return Outline(
            Facets(normals, normals @ center + radius),
            Facets(stretched, stretched @ center + radius),
        )
    points, corners = _corners(region), directions // 2
    edges = np.roll(points, -1, axis=0) - points
    faces = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
    normals = np.concatenate([faces, _cuts(faces, 2 * np.pi / corners)])
    return Outline(_tangents(faces, points), _tangents(normals, points))


def _cuts(faces: np.ndarray, widest: float) -> np.ndarray:
    """Normals [K, 2] around corners: from each face to the next, in arcs no wider than given.

    Each is the middle of an arc, and so long that nowhere in the arc it falls short.
    """
    turn = np.arctan2(faces[:, 1], faces[:, 0])
    cuts = []
    for begin, width in zip(turn, np.mod(np.roll(turn, -1) - turn, 2 * np.pi), strict=True):
        count = max(int(np.ceil(width / widest - 1e-9)), 1)
        arc = width / count
        cuts.append(_unit(begin + arc * (np.arange(count) + 0.5)) / np.cos(arc / 2))
    return np.concatenate(cuts)


def _without_outline(region: Region) -> str:
    """Why a region has no outline; empty if it has one."""
    if region.kind == "polygon":
        hull = shapely.Polygon(region.points).convex_hull
        convex = np.isclose(hull.area, shapely.Polygon(region.points).area, rtol=1e-9)
        return "" if convex else f"{region.name} is not convex"
    return "" if region.kind in ("circle", "rectangle") else f"{region.name} is a {region.kind}"


def _corners(region: Region) -> np.ndarray:
    """Corners [N, 2] of a rectangle or a polygon, counter-clockwise."""
    if region.kind == "polygon":
        return counter_clockwise(region.points)
    (cosine, sine), (a, b) = region.turn, region.size
    flat = np.array([(-a, -b), (a, -b), (a, b), (-a, b)])
    return np.array(region.center) + flat @ np.array([[cosine, sine], [-sine, cosine]])


def _angles(count: int) -> np.ndarray:
    return 2 * np.pi / count * np.arange(count)


def _unit(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _tangents(normals: np.ndarray, corners: np.ndarray) -> Facets:
    """Facets that the polygon between corners touches."""
    return Facets(normals, (normals @ corners.T).max(axis=1))
