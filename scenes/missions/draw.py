"""Random missions: a scene of a family, and a formula along a random plan that it admits."""

from zlib import crc32

import numpy as np

from core.decompose import decompose
from core.errors import UserError, allowed
from core.stl import Formula, atom_names, parse
from core.task.grounding import ground
from core.task.sizes import STANDARD
from envs import make_robot
from scenes.missions.arenas import draw_arena
from scenes.missions.families import FAMILIES, TRAINED
from scenes.missions.formulas import write_formula
from scenes.missions.lifting import regions_of
from scenes.missions.measures import measures_in
from scenes.missions.plans import draw_plan
from scenes.missions.stops import place_stops
from scenes.scene import LARGEST_SEED, Scene
from scenes.shared import require_shared

MOST_GOALS = 6
"""Goals that are placed; those for which no time is left are not asked for."""

OTHERS = 0.3
"""Share of missions with a region more, for branches."""

WRAPPED = 0.35
"""Share of missions that begin at a time of the robot's choice."""


def draw(robot_name: str, family: str, seed: int) -> Scene:
    """A random mission: the same for the same robot, family and seed.

    Whether obstacles leave enough room and time is for a judge to decide
    (`studio.runs.missions`). The families that are trained on vary: arenas of other sizes, regions
    of any shape, and more orders, responses and lockouts. Those that are held out do not.

    Raises:
        UserError: no such robot or family, or this draw does not come about: no room for a
            region, no time for a goal, or a formula that is too large.
    """
    if family not in FAMILIES:
        raise UserError(f"family: unknown {family!r}. {allowed(family, FAMILIES)}")
    random = np.random.default_rng([crc32(f"{robot_name}/{family}".encode()), seed])
    varied = family in TRAINED
    scale = measures_in(robot_name, draw_arena(robot_name, random) if varied else None)
    floor = FAMILIES[family](scale, random)
    if varied:
        floor.vary()
    goals = int(random.integers(1, MOST_GOALS + 1))
    stops = place_stops(floor, goals, others=int(random.random() < OTHERS))
    regions = regions_of(floor, stops)
    limit, shift = int(0.9 * scale.steps), None
    if random.random() < WRAPPED:
        first = int(0.05 * scale.steps)
        shift = first, first + int(random.integers(2, int(0.05 * scale.steps) + 1))
        limit = int(0.82 * scale.steps)
    plan = draw_plan(floor, regions, limit)
    together = len(floor.goal_areas) if floor.zone is not None else 0
    formula = write_formula(random, regions, plan, together, shift, varied=varied)
    names = tuple(region.name for region in regions.all)
    parsed = parse(formula, dt=make_robot(robot_name).dt, names=names)
    mentioned = atom_names(parsed)
    scene = Scene(
        name=f"{robot_name}-{family}-{seed}",
        title=f"Random mission of the family {family}",
        robot=robot_name,
        formula=formula,
        horizon=int(0.9 * scale.steps),
        seed=seed % (LARGEST_SEED + 1),
        regions=tuple(region for region in regions.all if region.name in mentioned),
        initial=regions.start,
        arena=scale.arena,
    )
    _check(scene, parsed, scale.steps)
    return scene


def _check(scene: Scene, formula: Formula, steps: int) -> None:
    """Raise UserError unless the mission fits into the standard sizes and so many steps."""
    require_shared(scene)
    grounding = ground(decompose(formula), scene.region_names, scene.horizon)
    if grounding.sizes != STANDARD:
        raise UserError(f"{scene.name}: it needs the sizes {grounding.sizes}")
    if grounding.horizon > steps:
        raise UserError(f"{scene.name}: {grounding.horizon} steps are more than {steps}")
