"""The regions of a scene, as judgements on its feasibility know them."""

import math

import numpy as np

from core.stl import Formula, fold_constants, negation_normal_form
from core.task.feasibility import Mission, Places
from scenes.distances import margin_of
from scenes.predicates import relaxed
from scenes.regions import Region
from scenes.scene import Scene, robot_of, workspace_of
from scenes.starts import inner_point

START = "\0start"
"""Name of the initial set among the places; no region can be called so."""

ACROSS = 9
"""Positions along each axis of the box around an initial set at which it is looked at."""

ROUNDING = 1e-6
"""Error of a trace's margins, which are float32, over the largest coordinate."""


def mission_of(scene: Scene, formula: Formula) -> Mission:
    """What is judged of a scene with its parsed formula.

    Predicates of the state and regions that move are left out: only regions that stand are places.
    What is asked without them is weaker, so that what is proved of it is proved of the formula.
    """
    names = scene.moving.union(predicate.name for predicate in scene.predicates)
    if names:
        formula = fold_constants(relaxed(negation_normal_form(formula), names))
    places = places_of(scene)
    robot = robot_of(scene)
    starts, arena = _starts(places, scene.initial), workspace_of(scene).arena
    return Mission(formula, places, starts, robot, arena, scene.between_steps)


def places_of(scene: Scene) -> Places:
    """The regions of a scene, where they begin, and last the initial set."""
    regions = (*scene.regions, scene.initial)
    center = np.array([region.center for region in regions], float)
    half = np.array([region.half_extents for region in regions])
    names = (*scene.region_names, START)

    def margin(i: int, positions: np.ndarray) -> np.ndarray:
        return margin_of(regions[i], positions)

    def tiny_ball(i: int, positions: np.ndarray) -> np.ndarray:
        if i < len(regions) - 1:
            return margin(i, positions)
        return tiny - np.linalg.norm(positions - scene.initial.center, axis=1)

    tolerance = ROUNDING * max(10.0, float((np.abs(center) + half).max()))
    radius = np.array([_radius(region) for region in regions])
    is_point, tiny = scene.initial.kind == "point", 2 * tolerance
    if is_point:  # otherwise it would have no inside
        half[-1], radius[-1] = tiny, tiny
    known = tiny_ball if is_point else margin
    return Places(names, center - half, center + half, radius, known, tolerance)


def _radius(region: Region) -> float:
    """Of a ball around a region's centre that contains it [m], the smallest for simple shapes."""
    match region.kind:
        case "circle" | "sphere":
            return region.size[0]
        case "polygon" | "prism":
            reach = np.linalg.norm(np.array(region.points) - region.center[:2], axis=1).max()
            return float(np.linalg.norm([reach, *region.size[2:]]))
        case "union":
            return max(
                math.dist(part.center, region.center) + _radius(part) for part in region.parts
            )
    return float(np.linalg.norm(region.size))


def _starts(places: Places, initial: Region) -> np.ndarray:
    """A grid of positions [P, d] in the initial set, its boundary included [m]."""
    if initial.kind == "point":
        return np.array([initial.center])
    axes = np.linspace(places.low[-1], places.high[-1], ACROSS).T
    positions = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))
    inside = places.margin(len(places.names) - 1, positions) >= -1e-4  # of the box around a ball
    return positions[inside] if inside.any() else inner_point(initial)[None]
