"""Walls around a workspace: only inner faces that face the camera are drawn.

The workspace is seen from outside, so walls between the camera and the robot must be invisible.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import viser

from scenes import Region, Scene, workspace_of
from studio.page.views.solids import settle

PLASTER, OPACITY = (198, 206, 216), 0.3

Limits = tuple[tuple[float, float], ...]
"""(low, high) of each axis of a workspace [m]."""


class Wall(NamedTuple):
    """A side of the workspace.

    Attributes:
        axis: the axis it is perpendicular to.
        side: -1 at the low end of the axis, 1 at the high one.
        level: of its inner face on the axis [m].
    """

    axis: int
    side: int
    level: float


class Face(NamedTuple):
    """What is drawn of a wall."""

    wall: Wall
    hall: Limits


def wall_faces(scene: Scene) -> dict[str, Face]:
    """Faces of a scene's walls by their regions' names; none in the plane."""
    if scene.dimension == 2:
        return {}
    limits = workspace_of(scene).arena
    inside = hall(scene.regions, limits)
    walls = {region.name: wall_of(region, limits) for region in scene.regions}
    return {name: Face(wall, inside) for name, wall in walls.items() if wall is not None}


def face_edges(face: Face) -> np.ndarray:
    """Edges [4, 2, 3] of a wall's face."""
    corners = inner_face(*face)[0]
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def add_face(scene: viser.SceneApi, node: str, face: Face) -> viser.MeshHandle:
    """Draw a wall's face, visible from inside only.

    It must have no handlers: the viewer also picks hidden faces, which would catch clicks meant
    for things behind them.
    """
    vertices, triangles = inner_face(*face)
    body = scene.add_mesh_simple(
        node,
        vertices,
        triangles,
        color=PLASTER,
        opacity=OPACITY,
        side="front",
        flat_shading=True,
        cast_shadow=False,
        receive_shadow=False,
    )
    settle(body)
    return body


def wall_of(region: Region, limits: Limits) -> Wall | None:
    """The side of the workspace that a box closes; None if it closes none."""
    if region.kind != "box" or region.angle:
        return None
    ends = [(c - s, c + s) for c, s in zip(region.center, region.size, strict=True)]
    spans = [
        low <= least and high >= most
        for (low, high), (least, most) in zip(ends, limits, strict=True)
    ]
    if sum(spans) != len(limits) - 1:
        return None
    axis = spans.index(False)
    (low, high), (least, most) = ends[axis], limits[axis]
    if low <= least < high < most:
        return Wall(axis, -1, high)
    if least < low < most <= high:
        return Wall(axis, 1, low)
    return None


def hall(regions: Iterable[Region], limits: Limits) -> Limits:
    """The part of a workspace that the walls among some regions leave free [m]."""
    left = [list(ends) for ends in limits]
    for region in regions:
        wall = wall_of(region, limits)
        if wall is not None:
            left[wall.axis][0 if wall.side < 0 else 1] = wall.level
    return tuple((low, high) for low, high in left)


def inner_face(wall: Wall, limits: Limits) -> tuple[np.ndarray, np.ndarray]:
    """Corners [4, 3] and triangles [2, 3] of a wall's face, its front towards the hall.

    Args:
        wall: the side.
        limits: of the hall.
    """
    first, second = (axis for axis in range(3) if axis != wall.axis)
    corners = np.empty((4, 3))
    corners[:, wall.axis] = wall.level
    corners[:, first] = np.take(limits[first], [0, 1, 1, 0])
    corners[:, second] = np.take(limits[second], [0, 0, 1, 1])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    inward = normal[wall.axis] * wall.side < 0
    return corners, np.array([[0, 1, 2], [0, 2, 3]] if inward else [[0, 2, 1], [0, 3, 2]])
