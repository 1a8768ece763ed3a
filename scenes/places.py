"""The regions of a scene, as judgements on its feasibility know them."""

import numpy as np

from core.stl import Formula, fold_constants, negation_normal_form
from core.task.feasibility import Mission, Places
from scenes.distances import margin_of
from scenes.layouts import half_extents
from scenes.predicates import relaxed
from scenes.regions import Region
from scenes.scene import Scene, robot_of

START = "\0start"
"""Name of the initial set among the places; no region can be called so."""

ACROSS = 9
"""Positions along each axis of the box around an initial set at which it is looked at."""

ROUNDING = 1e-6
"""Error of a trace's margins, which are float32, over the largest coordinate."""


def mission_of(scene: Scene, formula: Formula) -> Mission:
    """What is judged of a scene with its parsed formula.

    Predicates of the state are left out: only regions are places. What is asked without them is
    weaker, so that what is proved of it is proved of the formula.
    """
    if scene.predicates:
        names = frozenset(predicate.name for predicate in scene.predicates)
        formula = fold_constants(relaxed(negation_normal_form(formula), names))
    regions = (*scene.regions, scene.initial)
    center = np.array([region.center for region in regions], float)
    half = np.array([half_extents(region) for region in regions])
    names = (*scene.region_names, START)

    def margin(i: int, positions: np.ndarray) -> np.ndarray:
        return margin_of(regions[i], positions)

    tolerance = ROUNDING * max(10.0, float((np.abs(center) + half).max()))
    radius = np.array([_radius(region) for region in regions])
    places = Places(names, center - half, center + half, radius, margin, tolerance)
    robot = robot_of(scene)
    starts, arena = _starts(places), robot.workspace.arena
    return Mission(formula, places, starts, robot, arena, scene.between_steps)


def _radius(region: Region) -> float:
    """Of the smallest ball around a region's centre that contains it [m]."""
    if region.kind in ("circle", "sphere"):
        return region.size[0]
    return float(np.linalg.norm(region.size))


def _starts(places: Places) -> np.ndarray:
    """A grid of positions [P, d] in the initial set, its boundary included [m]."""
    axes = np.linspace(places.low[-1], places.high[-1], ACROSS).T
    positions = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))
    inside = places.margin(len(places.names) - 1, positions) >= -1e-4  # of the box around a ball
    return positions[inside]
