"""Bodies of regions in the 3D scene."""

import numpy as np
import viser

from scenes import Region

Color = tuple[int, int, int]


def add_solid(
    scene: viser.SceneApi, name: str, region: Region, color: Color, height: float, opacity: float
) -> float:
    """Add a region's body; planar regions stand on the floor with the given height [m].

    Returns:
        Height of the top above the new node's origin [m].
    """
    planar = region.dimension == 2
    at = np.array([*region.center, height / 2] if planar else region.center)
    solid = opacity >= 1
    see_through = None if solid else opacity
    if region.kind == "sphere":
        scene.add_icosphere(
            name, region.size[0], color, position=at, opacity=see_through, cast_shadow=solid
        )
        return region.size[0]
    half_height = height / 2 if planar else region.size[-1]
    if region.kind in ("circle", "cylinder"):
        scene.add_cylinder(
            name,
            region.size[0],
            2 * half_height,
            color,
            radial_segments=64,
            position=at,
            opacity=see_through,
            cast_shadow=solid,
        )
    else:
        size = 2 * np.array([*region.size[:2], half_height])
        scene.add_box(name, color, size, position=at, opacity=see_through, cast_shadow=solid)
    return half_height


def rgb(color: str) -> Color:
    """(r, g, b) of `#rrggbb`."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
