"""The shipped scenes: the paper's formulas, sound layouts, deadlines that can be kept."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from core.stl import atom_names, horizon, parse
from envs import ENVS
from scenes import load_task, task_names
from tests.scenes.geometry import AXES, margins_table, separation
from tests.scenes.plans import WALLS, leg_lengths, needed_speed, obstacles, plan_of

TASKS = pytest.mark.parametrize("task", task_names())
APPENDIX = Path(__file__).parents[1] / "core" / "stl" / "paper_formulas.txt"
"""The appendix, A.8, in its own notation: a task's name and its formula a line."""

GOAL_CLEARANCE = {
    "linear": 0.25,
    "unicycle": 0.35,
    "panda": 0.03,
    "quadrotor": 0.3,
    "ant": 0.2,
}  # [m]
PATH_CLEARANCE = {
    "linear": 0.25,
    "unicycle": 0.25,
    "panda": 0.03,
    "quadrotor": 0.3,
    "ant": 0.2,
}  # [m]
APART = {"linear": 0.5, "unicycle": 0.5, "panda": 0.05, "quadrotor": 0.4, "ant": 0.2}  # [m]
START_CLEARANCE = {
    "linear": 0.4,
    "unicycle": 0.4,
    "panda": 0.05,
    "quadrotor": 0.4,
    "ant": 0.25,
}  # [m]


def _papers_formula(task: str) -> str:
    lines = dict(line.split(" ", 1) for line in APPENDIX.read_text("utf-8").splitlines())
    return lines[task].strip(" $")


@TASKS
def test_formulas_are_the_papers(task):
    scene = load_task(task)
    plain = _papers_formula(task).replace(r"\land", "&").replace(r"\neg", "!")
    plain = re.sub(r"([ABDKW])_(\d)", r"\1\2", plain.replace("{", "").replace("}", ""))
    assert re.sub(r"\s", "", scene.formula) == re.sub(r"\s", "", plain)


@TASKS
def test_formulas_and_regions_name_each_other(task):
    scene = load_task(task)
    formula = parse(scene.formula, names=scene.region_names)
    assert set(atom_names(formula)) == set(scene.region_names)
    assert horizon(formula) <= 1.1 * scene.horizon


@TASKS
def test_regions_keep_their_distances(task):
    scene = load_task(task)
    regions = {region.name: region for region in scene.regions}
    blocked = obstacles(scene)
    goals = [regions[visit.region] for visit in plan_of(scene)]
    for goal, name in itertools.product(goals, blocked):
        assert separation(goal, regions[name]) >= GOAL_CLEARANCE[scene.robot] - 1e-9, (goal, name)
    for first, second in itertools.combinations([*goals, scene.initial], 2):
        assert separation(first, second) >= APART[scene.robot], (first.name, second.name)
    for name in blocked:
        assert separation(scene.initial, regions[name]) >= START_CLEARANCE[scene.robot], name
    for goal, name in itertools.product([*goals, scene.initial], set(regions) - blocked):
        assert name == goal.name or separation(goal, regions[name]) > 0.0, (goal.name, name)


@TASKS
def test_walls_close_the_workspace(task):
    scene = load_task(task)
    limits = ENVS[scene.robot].workspace.arena
    points = []
    for axis, ends in enumerate(limits):
        sides = [np.linspace(*limit, 41) for limit in limits]
        sides[axis] = np.array(ends)
        points.append(np.stack(np.meshgrid(*sides), -1).reshape(-1, len(limits)))
    columns = [scene.region_names.index(name) for name in sorted(WALLS[scene.dimension])]
    assert (margins_table(scene, np.concatenate(points))[:, columns].max(-1) >= -1e-12).all()


@TASKS
def test_deadlines_leave_a_quarter_of_the_time_from_every_corner(task):
    """Shortest ways from center to center, clear of obstacles, at 75 % of the speed."""
    scene = load_task(task)
    speed = ENVS[scene.robot].speed
    half = np.resize(scene.initial.size, scene.dimension)
    corners = itertools.product((-1, 1), repeat=scene.dimension)
    starts = [np.add(scene.initial.center, signs * half) for signs in corners]
    for lengths in leg_lengths(scene, starts, PATH_CLEARANCE[scene.robot]):
        assert needed_speed(scene, lengths) <= 0.75 * speed, lengths


@TASKS
def test_obstacles_are_in_the_way(task):
    """Without them the ways of the plan are shorter, by more than the grid's resolution."""
    scene = load_task(task)
    starts = [scene.initial.center]
    clearance = PATH_CLEARANCE[scene.robot]
    blocked = leg_lengths(scene, starts, clearance).sum()
    free = leg_lengths(scene, starts, clearance, free=True).sum()
    axis = AXES[scene.robot][0]
    assert blocked - free > axis[1] - axis[0], (blocked, free)


def _straight_lines_are_blocked(scene):
    regions = {region.name: region for region in scene.regions}
    plan = plan_of(scene)
    stops = [scene.initial.center] + [regions[visit.region].center for visit in plan]
    names = scene.region_names
    for visit, start, end in zip(plan, stops, stops[1:], strict=False):
        columns = [names.index(name) for name in obstacles(scene) | visit.doors]
        line = np.linspace(start, end, 400)
        if (margins_table(scene, line)[:, columns] >= 0).any():
            return True
    return False


@pytest.mark.parametrize("robot", ENVS)
def test_straight_lines_are_blocked_in_most_tasks(robot):
    blocked = [_straight_lines_are_blocked(load_task(task)) for task in task_names(robot)]
    assert sum(blocked) >= 9, blocked


def test_robots_have_layouts_of_their_own():
    for tasks in zip(*(task_names(robot) for robot in ENVS), strict=True):
        centers = [load_task(task).regions[0].center for task in tasks]
        assert len(set(centers)) == len(centers)
