"""Triangle meshes of polygons, prisms and unions, around the region's centre."""

from typing import NamedTuple

import numpy as np
import trimesh

from scenes import Region
from scenes.polygons import counter_clockwise, triangles

ROUND = 64
"""Segments of a circle."""


class Mesh(NamedTuple):
    """A surface."""

    vertices: np.ndarray  # [V, 3] in [m]
    faces: np.ndarray  # [F, 3] corners, counter-clockwise seen from outside


def mesh_of(region: Region, height: float) -> Mesh:
    """The surface of a region; one of the plane is as tall as given [m], half of it below 0."""
    middle = np.array([*region.center, 0.0][:3])
    found = [_piece(piece, height, middle) for piece in region.pieces]
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in found)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in found]).astype(np.float32),
        np.concatenate([mesh.faces + at for mesh, at in zip(found, first, strict=False)]),
    )


def turn_of(region: Region) -> np.ndarray:
    """Unit quaternion [4] of a region's angle."""
    half = np.deg2rad(region.angle) / 2
    return np.array([np.cos(half), 0.0, 0.0, np.sin(half)])


def _piece(piece: Region, height: float, middle: np.ndarray) -> Mesh:
    """The surface of a region without parts, around a position [3]."""
    half = height / 2 if piece.dimension == 2 else float(piece.half_extents[2])
    offset = np.array([*piece.center, 0.0][:3]) - middle
    match piece.kind:
        case "polygon" | "prism":
            return _extruded(piece, half, middle)
        case "circle" | "cylinder":
            solid = trimesh.creation.cylinder(piece.size[0], 2 * half, sections=ROUND)
        case "sphere":
            solid = trimesh.creation.icosphere(3, piece.size[0])
        case _:
            solid = trimesh.creation.box((2 * piece.size[0], 2 * piece.size[1], 2 * half))
    (cosine, sine), points = piece.turn, np.array(solid.vertices)
    x, y = points[:, 0].copy(), points[:, 1].copy()
    points[:, 0], points[:, 1] = cosine * x - sine * y, sine * x + cosine * y
    return Mesh(points + offset, np.array(solid.faces))


def _extruded(piece: Region, half: float, middle: np.ndarray) -> Mesh:
    """The base and the top of a polygon, and a rectangle for each of its edges."""
    level = (piece.center[2] if piece.dimension == 3 else 0.0) - middle[2]
    flat = triangles(piece.points)
    top = np.dstack([flat - middle[:2], np.full(flat.shape[:2], level + half)])
    bottom = top[:, ::-1] - [0.0, 0.0, 2 * half]
    corners = counter_clockwise(piece.points) - middle[:2]
    following = np.roll(corners, -1, axis=0)
    low, high = (np.full((len(corners), 1), level + side * half) for side in (-1.0, 1.0))
    a, b = np.hstack([corners, low]), np.hstack([following, low])
    c, d = np.hstack([following, high]), np.hstack([corners, high])
    sides = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    vertices = np.concatenate([top, bottom, sides]).reshape(-1, 3)
    return Mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))
