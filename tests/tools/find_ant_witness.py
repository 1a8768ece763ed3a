"""Waypoints that carry out an ant's task: `python -m tests.tools.find_ant_witness ant-08`.

No policy is asked. The plan's shortest ways are walked at a steady speed: the ant follows a point
a little ahead on its way, and waits in the middle of each goal until the next leg begins. What is
kept are the points, in the world's axes; replaying them feeds the ant's position back, so that a
replay holds although walking amplifies rounding.
"""

import sys

import numpy as np

from core.task.physics import physics_of
from envs import ENVS
from envs.ant.model import STANDING
from scenes import Scene, load_task, task_names
from tests.scenes.geometry import AXES, distance_from, margins_table
from tests.scenes.oracle import rtamt_robustness
from tests.scenes.plans import obstacles, plan_of
from tests.tools.witness import episode_length, save_witness

ANT = ENVS["ant"]
CLEARANCE = 0.25  # [m]
HOLD = 2  # steps for which a waypoint is kept


def way(scene: Scene, goal: str, start: np.ndarray, doors: frozenset[str]) -> np.ndarray:
    """Nodes [K, 2] of the shortest way from a point to the middle of a goal."""
    field = distance_from(scene, goal, obstacles(scene) | doors, CLEARANCE)
    axes = AXES["ant"]
    here = tuple(int(np.argmin(abs(axis - value))) for axis, value in zip(axes, start, strict=True))
    nodes = [here]
    around = [(i, j) for i in range(-2, 3) for j in range(-2, 3) if (i, j) != (0, 0)]
    while field[here] > 0:
        near = [(here[0] + i, here[1] + j) for i, j in around]
        near = [n for n in near if all(0 <= k < len(AXES["ant"][0]) for k in n)]
        spacing = axes[0][1] - axes[0][0]
        here = min(near, key=lambda n: field[n] + spacing * np.hypot(*np.subtract(n, here)))
        if here == nodes[-1] or len(nodes) > field.size:
            raise ValueError(f"{scene.name}: no way to {goal}")
        nodes.append(here)
    return np.array([[axes[0][i], axes[1][j]] for i, j in nodes])


def waypoints(scene: Scene, speed: float, ahead: float) -> np.ndarray:
    """Points [T, 2] to walk towards, one a step; `speed` in [m/step], `ahead` in [m]."""
    length = episode_length(scene)
    points, place, free = np.empty((length, 2)), np.array(scene.initial.center), 0.0
    entries: list[float] = []
    for visit in plan_of(scene):
        path = np.concatenate([place[None], way(scene, visit.region, place, visit.doors)])
        along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        base = 0.0 if visit.base is None else entries[visit.base]
        entry = max(base + visit.low, free + along[-1] / speed)
        for step in range(int(free), length):
            at = min((step - free) * speed + ahead, along[-1])
            points[step] = [np.interp(at, along, path[:, axis]) for axis in range(2)]
        entries.append(entry)
        free, place = entry + visit.stay, path[-1]
    return points


def walk(start: np.ndarray, points: np.ndarray) -> np.ndarray:
    """States [T + 1, 29] in true physics from a state, led by points [T, 2] in the world."""
    physics = physics_of(ANT)
    assert physics is not None
    states = [np.asarray(start, float)[None]]
    for point in points:
        action = (point - states[-1][:, :2]) / ANT.reach  # pyright: ignore[reportAttributeAccessIssue]
        states.append(physics.step(states[-1], action))
    return np.concatenate(states)


def judge_walk(scene: Scene, start: np.ndarray, points: np.ndarray) -> float:
    """rtamt's robustness of the walk [m]."""
    table = margins_table(scene, walk(start, points)[:, :2])
    return rtamt_robustness(scene.formula, scene.region_names, table)


def find(name: str) -> float:
    """Find and keep the witness of a task; its robustness [m]."""
    scene = load_task(name)
    start = STANDING.copy()
    start[:2] = scene.initial.center
    found = []
    for speed in (0.045, 0.05, 0.055, 0.06):
        for ahead in (0.25, 0.35, 0.45):
            points = waypoints(scene, speed, ahead)
            kept = np.repeat(points[::HOLD], HOLD, axis=0)[: len(points)]
            found.append((judge_walk(scene, start, kept), points[::HOLD]))
    best, points = max(found, key=lambda pair: pair[0])
    if best < 0:
        raise ValueError(f"{name}: the best walk has robustness {best:.3f} m")
    save_witness(name, start, points, HOLD)
    return best


if __name__ == "__main__":
    for task in sys.argv[1:] or [*task_names("ant"), "ant-demo"]:
        print(task, f"{find(task):.3f} m", flush=True)
