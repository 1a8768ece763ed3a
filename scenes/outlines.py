"""Regions of the plane as outlines of facets, and a scene as exact plans know it."""

from collections.abc import Mapping, Sequence

import numpy as np

from core.planning.exact import Setting
from core.planning.outline import Facets, Outline
from core.quoting import listed
from core.stl import quote_name
from core.task.protocols import stride_of
from envs import ENVS
from scenes.distances import margin_of
from scenes.regions import Region, SceneError
from scenes.scene import Scene, robot_of


def setting_of(scene: Scene) -> Setting:
    """A scene for `plan_exactly`, from the centre of its initial set.

    Raises:
        SceneError: a robot that does not move by bounded strides in the plane, or regions that
            move.
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
    regions = scene.regions
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
        region: a circle or a rectangle.
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
    half, corners = np.array(region.size), directions // 2
    faces = _unit(_angles(4)).round()
    cut = _unit(_angles(corners) + np.pi / corners) / np.cos(np.pi / corners)
    normals = np.concatenate([faces, cut])
    return Outline(_tangents(faces, center, half), _tangents(normals, center, half))


def _angles(count: int) -> np.ndarray:
    return 2 * np.pi / count * np.arange(count)


def _unit(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _tangents(normals: np.ndarray, center: np.ndarray, half: np.ndarray) -> Facets:
    """Facets that a rectangle touches."""
    return Facets(normals, normals @ center + np.abs(normals) @ half)
