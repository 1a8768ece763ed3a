"""Regions, scenes and the shipped tasks."""

from scenes.layouts import walls
from scenes.margins import RegionArrays, margins, margins_and_gradients, region_arrays
from scenes.regions import Region, SceneError
from scenes.scene import (
    WORKSPACE_DIMENSION,
    Scene,
    demo_names,
    format_scene,
    load_scene,
    load_task,
    parse_scene,
    save_scene,
    task_names,
)
from scenes.world import (
    AIRSPACE,
    COURTYARD,
    PLANAR,
    TABLETOP,
    GoalGeometry,
    GridWorld,
    goal_geometry,
    world_arrays,
)

__all__ = [
    "AIRSPACE",
    "COURTYARD",
    "PLANAR",
    "TABLETOP",
    "WORKSPACE_DIMENSION",
    "GoalGeometry",
    "GridWorld",
    "Region",
    "RegionArrays",
    "Scene",
    "SceneError",
    "demo_names",
    "format_scene",
    "goal_geometry",
    "load_scene",
    "load_task",
    "margins",
    "margins_and_gradients",
    "parse_scene",
    "region_arrays",
    "save_scene",
    "task_names",
    "walls",
    "world_arrays",
]
