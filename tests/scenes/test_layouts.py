"""The shipped scenes: the paper's formulas, sound layouts, deadlines that can be kept."""

import itertools
import re

import numpy as np
import pytest

from core.stl import atom_names, horizon, parse
from envs import ENVS
from scenes import load_task, task_names
from tests.scenes.geometry import margins_table, separation
from tests.scenes.plans import PLANS, WALLS, leg_lengths, needed_speed, number, obstacles

TASKS = pytest.mark.parametrize("task", task_names())


def _always(low, high, names):
    return "".join(rf" \land G_{{[{low}:{high}]}} (\neg {name})" for name in names.split())


B5 = "B_1 B_2 B_3 B_4 B_5"
PAPER = {
    1: r"F_{[5:7]} ( F_{[50:85]} (A)" + _always(0, 90, "B_5 B_1 B_2 B_3 B_4") + ")",
    2: r"F_{[5:10]} ( F_{[0:50]} (A) \land G_{[60:80]} (C)"
    + _always(0, 90, "B_5 B_1 B_2 B_3 B_4")
    + ")",
    3: r"F_{[5:10]} ( F_{[0:50]} (A) \land F_{[40:60]} (C) \land G_{[70:80]} (D)"
    + _always(0, 90, "B_5 B_0 B_1 B_2 B_3 B_4")
    + ")",
    4: r"F_{[5:10]} ( F_{[0:50]} (A) \land F_{[40:50]} (C) \land F_{[70:80]} (F)"
    r" \land G_{[50:60]} (D)" + _always(0, 90, "B E B_1 B_2 B_3 B_4") + ")",
    5: r"F_{[5:10]} ( F_{[0:30]} (A) \land F_{[30:50]} (C) \land F_{[70:80]} (F)"
    r" \land F_{[75:88]} (H) \land G_{[50:60]} (D)" + _always(0, 90, "B E G B_1 B_2 B_3 B_4") + ")",
    6: r"F_{[10:90]} (A)" + _always(0, 100, B5),
    7: r"F_{[0:90]} (A_1) \land F_{[40:80]} (A_2)" + _always(0, 100, B5),
    8: r"F_{[0:90]} (A_1) \land F_{[40:80]} ( A_2 \land F_{[10:20]} (G_{[0:10]} (A_3)) )"
    + _always(0, 100, B5),
    9: r"F_{[5:20]} ( A_1 \land F_{[10:20]} ( G_{[0:5]} (A_2) \land F_{[10:30]} (G_{[0:5]} (A_3))"
    r" \land F_{[10:30]} (G_{[0:10]} (A_4)) ) )" + _always(0, 100, B5 + " B_6 B_7 B_8 B_9"),
    10: r"(\neg D_1)U_{[0:100]}(K_1) \land (\neg D_2)U_{[0:100]}(K_2)"
    r" \land (\neg D_3)U_{[0:100]}(K_3) \land F_{[80:90]} (G_{[0:5]} (G))" + _always(0, 100, B5),
}
"""The appendix, A.8, in its own notation."""


@TASKS
def test_formulas_are_the_papers(task):
    scene = load_task(task)
    plain = PAPER[number(scene)].replace(r"\land", "&").replace(r"\neg", "!")
    plain = re.sub(r"([ABDK])_(\d)", r"\1\2", plain.replace("{", "").replace("}", ""))
    assert re.sub(r"\s", "", scene.formula) == re.sub(r"\s", "", plain)


@TASKS
def test_formulas_and_regions_name_each_other(task):
    scene = load_task(task)
    formula = parse(scene.formula, names=scene.region_names)
    assert set(atom_names(formula)) == set(scene.region_names)
    assert horizon(formula) <= 110


@TASKS
def test_regions_keep_their_distances(task):
    scene = load_task(task)
    regions = {region.name: region for region in scene.regions}
    blocked = obstacles(scene)
    goals = [regions[visit.region] for visit in PLANS[number(scene)]]
    clearance = {"linear": 0.25, "unicycle": 0.35}[scene.robot]
    for goal, name in itertools.product(goals, blocked):
        assert separation(goal, regions[name]) >= clearance - 1e-9, (goal.name, name)
    for first, second in itertools.combinations([*goals, scene.initial], 2):
        assert separation(first, second) >= 0.5, (first.name, second.name)
    for name in blocked:
        assert separation(scene.initial, regions[name]) >= 0.4, name
    for goal, name in itertools.product([*goals, scene.initial], set(regions) - blocked):
        assert name == goal.name or separation(goal, regions[name]) > 0.0, (goal.name, name)


@TASKS
def test_walls_close_the_arena(task):
    scene = load_task(task)
    border = np.linspace(-5, 5, 101)
    points = [(x, y) for x in border for y in (-5, 5)]
    points += [(y, x) for x, y in points]
    columns = [scene.region_names.index(name) for name in sorted(WALLS)]
    assert (margins_table(scene, points)[:, columns].max(-1) >= -1e-12).all()


@TASKS
def test_deadlines_leave_a_quarter_of_the_time_from_every_corner(task):
    """Shortest ways from center to center, 0.25 m clear of obstacles, at 75 % of the speed."""
    scene = load_task(task)
    speed = ENVS[scene.robot].speed
    for signs in itertools.product((-1, 1), repeat=2):
        start = np.add(scene.initial.center, np.multiply(signs, scene.initial.size))
        lengths = leg_lengths(scene, start, clearance=0.25)
        assert needed_speed(scene, lengths) <= 0.75 * speed, (start, lengths)


def _straight_lines_are_blocked(scene):
    regions = {region.name: region for region in scene.regions}
    plan = PLANS[number(scene)]
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
    for first, second in zip(task_names("linear"), task_names("unicycle"), strict=True):
        assert load_task(first).regions[0].center != load_task(second).regions[0].center
