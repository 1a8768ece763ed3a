"""Worlds of one robot in arrays of the same shapes, so that many missions are learnt on at once.

A scene of its own is compiled for the arrays that it needs (`scenes.world`). Here every scene of a
robot has those of the richest: regions with room for polygons and unions, and a grid with as many
nodes as the robot's, which covers the scene's arena by its longest side.
"""

import numpy as np

from core.task.grounding import MAX_ATOMS
from envs import Workspace
from scenes.arena import Arena, scale_of
from scenes.compound import Room, shapes_of
from scenes.fields import Grid
from scenes.regions import SHAPES, Region, SceneError
from scenes.scene import Scene, robot_of
from scenes.world import GridWorld, make_world

ROOM = Room(polygons=4, corners=8, parts=2)
"""What regions of a scene may consist of."""


def shared_world(scene: Scene) -> GridWorld:
    """The world that a scene's robot moves in, on a grid of the robot's shape.

    Raises:
        SceneError: the scene's regions need larger arrays than others'.
    """
    require_shared(scene)
    own = robot_of(scene).workspace
    arena = own.arena if scene.arena is None else scene.arena
    scale, shape = scale_of(own, arena), make_world(own).grid.shape
    origin = tuple(float(low) for low, _ in arena)
    grid = Grid(origin, shared_spacing(own, arena), shape)
    return GridWorld(grid, scale * own.clearance, scale * own.inset, arena)


def shared_spacing(workspace: Workspace, arena: Arena) -> float:
    """Distance in [m] of the nodes of a grid of a robot's shape that covers an arena."""
    if arena == workspace.arena:
        return workspace.spacing
    low, high = np.array(arena, float).T
    return float(((high - low) / (np.array(make_world(workspace).grid.shape) - 1)).max())


def require_shared(scene: Scene) -> None:
    """Refuse a scene that the shared arrays have no room for.

    Raises:
        SceneError: with what it needs.
    """
    pieces = [piece for region in scene.regions for piece in region.pieces]
    corners = [len(piece.points) for piece in pieces if piece.kind not in SHAPES]
    parts = max((len(region.pieces) for region in scene.regions), default=1)
    found = Room(len(corners), max(corners, default=0), parts)
    if any(have > most for have, most in zip(found, ROOM, strict=True)):
        raise SceneError(f"{scene.name}: {found} is more than {ROOM}")
    if len(shapes_of(scene.regions)) > MAX_ATOMS:
        raise SceneError(f"{scene.name}: more than {MAX_ATOMS} parts of regions")
    if not _is_plain(scene.initial):
        raise SceneError(f"initial: a {scene.initial.kind} with an angle or corners is not shared")


def _is_plain(region: Region) -> bool:
    return region.angle == 0 and (region.kind in SHAPES or region.kind == "point")
