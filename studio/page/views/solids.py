"""Bodies of regions in the 3D scene."""

from typing import Any

import numpy as np
import viser

from scenes import Region
from studio.page.views.meshes import mesh_of, turn_of

Color = tuple[int, int, int]
Solid = viser.BoxHandle | viser.CylinderHandle | viser.IcosphereHandle | viser.MeshHandle

PIN = 0.1
"""Radius at which a point is drawn, in units of the scene."""


def add_solid(  # noqa: PLR0913
    scene: viser.SceneApi, name: str, region: Region, color: Color, height: float, opacity: float
) -> Solid:
    """Add a region's body; planar regions stand on the floor with the given height [m]."""
    solid = opacity >= 1
    looks: dict[str, Any] = {"opacity": None if solid else opacity, "cast_shadow": solid}
    at = body_position(region, height)
    if region.kind == "sphere":
        return scene.add_icosphere(
            name, region.size[0], color, subdivisions=4, position=at, **looks
        )
    if region.kind in ("circle", "cylinder"):
        tall = 2 * top(region, height)
        return scene.add_cylinder(
            name, region.size[0], tall, color, radial_segments=64, position=at, **looks
        )
    if region.kind in ("polygon", "prism", "union"):
        mesh = mesh_of(region, height)
        return scene.add_mesh_simple(
            name, *mesh, color=color, position=at, flat_shading=True, **looks
        )
    return scene.add_box(
        name, color, _extents(region, height), position=at, wxyz=turn_of(region), **looks
    )


def place_solid(body: Solid, region: Region, height: float) -> None:
    """Give a body its region's position, angle and size."""
    body.position = body_position(region, height)
    if isinstance(body, viser.MeshHandle):
        body.vertices, body.faces = mesh_of(region, height)
        return
    if isinstance(body, viser.BoxHandle):
        body.dimensions = _extents(region, height)
        body.wxyz = turn_of(region)
        return
    body.radius = region.size[0]
    if isinstance(body, viser.CylinderHandle):
        body.height = 2 * top(region, height)


def seen(region: Region, unit: float) -> Region:
    """What is drawn of a region: of a point, something that can be seen and clicked.

    Args:
        region: of a scene.
        unit: of the scene [m].
    """
    if region.kind != "point":
        return region
    kind = "circle" if region.dimension == 2 else "sphere"
    return Region(region.name, kind, region.center, (PIN * unit,), region.color)


def settle(node: viser.SceneNodeHandle) -> None:
    """Send the pose of a new node that stands at the origin.

    The library sends none, and a client gives a new node the pose of an older node of the same
    name.
    """
    position, wxyz = node.position.copy(), node.wxyz.copy()
    node.position, node.wxyz = position + 1.0, -wxyz
    node.position, node.wxyz = position, wxyz


def top(region: Region, height: float) -> float:
    """Height of the top above the body's own position [m]."""
    return height / 2 if region.dimension == 2 else region.size[-1]


def rgb(color: str) -> Color:
    """(r, g, b) of `#rrggbb`."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def body_position(region: Region, height: float) -> np.ndarray:
    """Where the body of a region is [3]; planar ones stand on the floor with a height [m]."""
    return np.array([*region.center, height / 2] if region.dimension == 2 else region.center)


def _extents(region: Region, height: float) -> tuple[float, float, float]:
    return 2 * region.size[0], 2 * region.size[1], 2 * top(region, height)
