"""Rounded solids for bodies: convex hulls of discs with rounded edges, as triangle meshes."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import trimesh
import viser

from studio.page.views.bodies.body import Color

AROUND, EDGE = 40, 5
"""Points of a disc's rim, and of the quarter circle that rounds its edge."""


class Piece(NamedTuple):
    """A solid of one colour."""

    mesh: trimesh.Trimesh
    color: Color


def drum(radius: float, start, end, edge: float = 0.012) -> np.ndarray:
    """Points [n, 3] whose hull is a cylinder with rounded edges.

    Args:
        radius: of the cylinder in [m].
        start: centre of one end [3] in [m].
        end: centre of the other.
        edge: radius of the rounding in [m].
    """
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = float(np.linalg.norm(end - start))
    edge = min(edge, radius, length / 2)
    around = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    points = []
    for angle in np.linspace(0, np.pi / 2, EDGE):
        reach, depth = radius - edge * (1 - np.sin(angle)), edge * (1 - np.cos(angle))
        ring = np.stack([reach * np.cos(around), reach * np.sin(around), 0 * around], -1)
        points += [ring + [0, 0, depth], ring + [0, 0, length - depth]]
    turn = np.asarray(trimesh.geometry.align_vectors([0, 0, 1], (end - start) / length))[:3, :3]
    return np.concatenate(points) @ turn.T + start


def capsule(radius: float, start, end) -> np.ndarray:
    """Points [n, 3] whose hull is a cylinder with round ends about two points [3] in [m]."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=radius).vertices
    return np.concatenate([ball + np.asarray(start), ball + np.asarray(end)])


def block(half, center=(0, 0, 0), edge: float = 0.006) -> np.ndarray:
    """Points [n, 3] whose hull is a box with rounded edges, of half extents [3] in [m]."""
    corner = trimesh.creation.icosphere(subdivisions=2, radius=edge).vertices
    inner = np.asarray(half) - edge
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    return np.concatenate([corner + inner * sign for sign in signs]) + np.asarray(center)


def hull(color: Color, *points: np.ndarray) -> Piece:
    """The convex hull of points [n, 3]."""
    return Piece(trimesh.convex.convex_hull(np.concatenate(points)), color)


def add_pieces(scene: viser.SceneApi, node: str, pieces: Iterable[Piece]) -> None:
    """Add solids below a node."""
    for index, (mesh, color) in enumerate(pieces):
        scene.add_mesh_simple(
            f"{node}/piece{index}", mesh.vertices, mesh.faces, color=color, flat_shading=False
        )
