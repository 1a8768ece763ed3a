"""Drags in the 3D scene as points in space.

The viewer reports the pointer on a plane that faces the camera; the user means the point below it
on a horizontal plane. Handlers are coroutines: the library may call plain functions in a different
order than the events arrived.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from studio.page.editing.editor import Phase, Point
from studio.page.editing.selection import Ray

NEARLY_ALONG = 0.995
"""Cosine between a ray and a line above which the nearest point is unreliable."""

Dragged = Callable[[Phase, Point, Point], None]
"""Takes the phase, and the first and current point of the drag [m]."""


def level_point(eye: np.ndarray, through: np.ndarray, height: float) -> Point:
    """Where the ray from the eye through a point meets the plane z = height [m].

    A ray that does not reach the plane is cut at the given point.
    """
    ray = through - eye
    share = (height - eye[2]) / ray[2] if abs(ray[2]) > 1e-9 else 0.0
    if share <= 0:
        return float(through[0]), float(through[1]), height
    x, y, _ = eye + share * ray
    return float(x), float(y), height


def ray_of(event: viser.SceneNodePointerEvent) -> Ray | None:
    """Where a click came from and its direction [3], if the viewer says so."""
    if event.ray_origin is None or event.ray_direction is None:
        return None
    return np.asarray(event.ray_origin, float), np.asarray(event.ray_direction, float)


def on_level_drag(
    node: Any, dragged: Dragged, *, height: float | None = None, modifier: Any = None
) -> Callable[..., Any]:
    """Report drags of a node along a horizontal plane; returns the callback, to remove it by.

    Args:
        node: handle of a scene node.
        dragged: called on the server's event loop.
        height: of the plane; None for that of the point that was grabbed.
        modifier: key that must be held, None for no key.
    """

    @node.on_drag("left", modifier=modifier)
    async def callback(event: viser.SceneNodeDragEvent) -> None:
        eye = np.asarray(event.client.camera.position, float)
        grabbed, pointer = (
            np.asarray(point, float) for point in (event.start_position, event.end_position)
        )
        level = float(grabbed[2]) if height is None else height
        start = level_point(eye, grabbed, level)
        dragged(event.phase, start, level_point(eye, pointer, level))

    return callback


def axis_point(eye: np.ndarray, through: np.ndarray, origin: np.ndarray, axis: int) -> Point:
    """Point of a line along an axis that is nearest to the ray from the eye through a point [m].

    For a ray along the line the origin is returned.

    Args:
        eye: [3].
        through: [3].
        origin: a point of the line [3].
        axis: 0, 1 or 2.
    """
    ray = (through - eye) / np.linalg.norm(through - eye)
    along = ray[axis]
    gap = origin - eye
    share = (along * float(gap @ ray) - gap[axis]) / max(1 - along**2, 1e-9)
    point = origin.copy()
    point[axis] += share if abs(along) < NEARLY_ALONG else 0.0
    return tuple(float(value) for value in point)


def on_axis_drag(node: Any, dragged: Dragged, axis: int) -> None:
    """Report drags of a node along a line through the point that was grabbed, parallel to an axis.

    The grabbed point moves with the node, which stays on the line.
    """

    @node.on_drag("left")
    async def _(event: viser.SceneNodeDragEvent) -> None:
        eye = np.asarray(event.client.camera.position, float)
        grabbed, pointer = (
            np.asarray(point, float) for point in (event.start_position, event.end_position)
        )
        start = tuple(float(value) for value in grabbed)
        dragged(event.phase, start, axis_point(eye, pointer, grabbed, axis))
