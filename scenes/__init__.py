"""Regions, scenes and the shipped tasks."""

from scenes.blank import blank
from scenes.formula import scene_formula, scene_reading
from scenes.layouts import walls
from scenes.margins import RegionArrays, margins, margins_and_gradients, region_arrays
from scenes.places import mission_of
from scenes.predicates import Predicate, inequality_of
from scenes.regions import Region, SceneError
from scenes.scene import (
    Scene,
    demo_names,
    format_scene,
    load_scene,
    load_task,
    parse_scene,
    robot_of,
    save_scene,
    task_names,
    unit_of,
    workspace_of,
)
from scenes.shared import ROOM, shared_world
from scenes.snapshots import Snapshots, snapshots_of
from scenes.world import (
    GoalGeometry,
    GridWorld,
    WorldArrays,
    goal_geometry,
    make_world,
    world_arrays,
    world_of,
)

__all__ = [
    "ROOM",
    "GoalGeometry",
    "GridWorld",
    "Predicate",
    "Region",
    "RegionArrays",
    "Scene",
    "SceneError",
    "Snapshots",
    "WorldArrays",
    "blank",
    "demo_names",
    "format_scene",
    "goal_geometry",
    "inequality_of",
    "load_scene",
    "load_task",
    "make_world",
    "margins",
    "margins_and_gradients",
    "mission_of",
    "parse_scene",
    "region_arrays",
    "robot_of",
    "save_scene",
    "scene_formula",
    "scene_reading",
    "shared_world",
    "snapshots_of",
    "task_names",
    "unit_of",
    "walls",
    "world_arrays",
    "workspace_of",
    "world_of",
]
