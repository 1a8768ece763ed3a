"""Find a control sequence for each Unicycle task with a path planner and a pursuit controller.

Development tool, not part of the test run:
`python -m tests.tools.find_unicycle_witness [TASK ...]`.

The hand-written plan of the task (`tests.scenes.plans`) gives the order of the visits. The robot
pursues a point ahead on the shortest grid path to the next region, forwards or backwards,
stands still inside while it waits, and goes on when the plan allows. rtamt judges the result;
the attempt with the largest robustness is kept.
"""

import math
import sys
from typing import NamedTuple

import numpy as np

from scenes import Scene, load_task, task_names
from tests.envs.reference import DT, unicycle_step
from tests.scenes.geometry import AXIS, NODES, distance_from, margins_table
from tests.scenes.plans import Visit, obstacles, plan_of
from tests.tools.witness import DIGITS, episode_length, judge, save_witness


class Driver(NamedTuple):
    """Settings of the pursuit."""

    cruise: float = 1.8  # [m/s]
    ahead: float = 0.7  # distance of the pursued point on the path [m]
    inside: float = 0.12  # margin at which a region counts as entered [m]
    clearance: float = 0.3  # of the path from obstacles [m]


def leg_fields(scene: Scene, driver: Driver) -> list[np.ndarray]:
    """Distance to go for each visit of the plan, on the planning grid."""
    blocked = obstacles(scene)
    return [
        distance_from(scene, visit.region, blocked | visit.doors, driver.clearance)
        for visit in plan_of(scene)
    ]


def drive(scene: Scene, initial, fields: list[np.ndarray], driver: Driver) -> np.ndarray:
    """Actions [T, 2] that follow the plan from an initial state [4]."""
    plan = plan_of(scene)
    state, backwards = np.asarray(initial, float), False
    centers = {region.name: region.center for region in scene.regions}
    entries: list[int] = []
    index, actions = 0, []
    for step in range(episode_length(scene)):
        inside = dict(zip(scene.region_names, margins_table(scene, state[:2]), strict=True))
        inside = {name: margin >= driver.inside for name, margin in inside.items()}
        while index < len(plan) and _done(
            plan[index], index, entries, inside[plan[index].region], step
        ):
            index += 1
        if index == len(plan):
            action = _brake(state)
        else:
            aim = _path_point(fields[index], state[:2], driver.ahead)
            backwards = _gear(state, aim, backwards)
            to_go = float(np.linalg.norm(state[:2] - centers[plan[index].region]))
            stops = plan[index].stay > 0 or index == len(plan) - 1
            cruise = min(driver.cruise, 1.5 * to_go) if stops else driver.cruise
            action = (
                _brake(state)
                if inside[plan[index].region]
                else _pursue(state, aim, backwards, cruise)
            )
        action = np.round(action, DIGITS)
        actions.append(action)
        state = unicycle_step(state, action)
    return np.asarray(actions)


def _done(visit: Visit, index: int, entries: list[int], entered: bool, step: int) -> bool:
    """Whether the visit is over at this step; notes its entry when it begins."""
    if len(entries) == index:
        base = 0 if visit.base is None else entries[visit.base]
        if not entered or step < base + visit.low:
            return False
        entries.append(step)
    return step >= entries[index] + visit.stay


def _path_point(field: np.ndarray, position: np.ndarray, ahead: float) -> np.ndarray:
    """The point that lies `ahead` metres down the path from a position [2]."""
    column, row = (int(np.argmin(abs(AXIS - value))) for value in position)
    if not np.isfinite(field[column, row]):
        distance = np.linalg.norm(NODES - position, axis=-1)
        near = np.where(np.isfinite(field), distance, np.inf)
        column, row = divmod(int(np.argmin(near)), field.shape[1])
    target = max(field[column, row] - ahead, 0.0)
    while field[column, row] > target:
        window = field[max(column - 1, 0) : column + 2, max(row - 1, 0) : row + 2]
        left, low = divmod(int(np.argmin(window)), window.shape[1])
        column, row = max(column - 1, 0) + left, max(row - 1, 0) + low
    return NODES[column, row]


def _heading_error(state: np.ndarray, aim: np.ndarray, backwards: bool) -> float:
    wanted = math.atan2(aim[1] - state[1], aim[0] - state[0]) + math.pi * backwards
    return (wanted - state[2] + math.pi) % (2 * math.pi) - math.pi


def _gear(state: np.ndarray, aim: np.ndarray, backwards: bool) -> bool:
    """Change the direction of travel when the point lies clearly on the other side."""
    turned = abs(_heading_error(state, aim, backwards)) > 1.8
    return backwards != (turned and abs(state[3]) < 1.7)


def _pursue(state: np.ndarray, aim: np.ndarray, backwards: bool, cruise: float) -> np.ndarray:
    error = _heading_error(state, aim, backwards)
    speed = cruise * max(0.15, math.cos(error) ** 3 if abs(error) < 1.5 else 0.0)
    signed = -speed if backwards else speed
    return np.clip([error / DT * 0.7, (signed - state[3]) / (4 * DT)], -1, 1)


def _brake(state: np.ndarray) -> np.ndarray:
    return np.clip([0.0, -state[3] / (4 * DT)], -1, 1)


def main(tasks: list[str]) -> None:
    """Search, judge and store."""
    for task in tasks or task_names("unicycle"):
        scene = load_task(task)
        best, kept = -math.inf, None
        for cruise in (1.4, 1.8, 2.2):
            driver = Driver(cruise=cruise)
            fields = leg_fields(scene, driver)
            for heading in (0.5, 2.0, -2.5, -1.0):
                initial = np.array([*scene.initial.center, heading, 0.0])
                actions = drive(scene, initial, fields, driver)
                value = judge(scene, initial, actions)
                if value > best:
                    best, kept = value, (initial, actions)
        print(f"{task}: robustness {best:.3f}", flush=True)
        if kept is not None and best > 0.01:
            save_witness(task, *kept, hold=1)


if __name__ == "__main__":
    main(sys.argv[1:])
