"""Find a control sequence for each Panda and Quadrotor task with a path planner and a tracker.

Development tool, not part of the test run:
`python -m tests.tools.find_spatial_witness [TASK ...]`.

The hand-written plan of the task (`tests.scenes.plans`) gives the order of the visits. The robot
pursues a point ahead on the shortest grid path to the next region, halts inside while it waits,
and goes on when the plan allows: the arm by damped least squares on its joint velocities, the
quadrotor by a wish for an acceleration, turned into thrust and tilt. All in float64 NumPy. rtamt
judges the result; the attempt with the largest robustness is kept.
"""

import math
import sys
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_are

from scenes import Scene, load_task, task_names
from tests.envs.reference import (
    PANDA_DT,
    PANDA_HIGH,
    PANDA_LOW,
    PANDA_READY,
    PANDA_VELOCITY,
    STEPS,
    panda_jacobian,
    panda_tip,
    position,
)
from tests.scenes.geometry import AXES, distance_from, margins_table
from tests.scenes.plans import Visit, obstacles, plan_of
from tests.tools.witness import DIGITS, episode_length, judge, save_witness


class Tracker(NamedTuple):
    """Settings of the pursuit."""

    cruise: float  # [m/s]
    ahead: float  # distance of the pursued point on the path [m]
    inside: float  # margin at which a region counts as entered [m]
    clearance: float  # of the path from obstacles [m]
    approach: float  # speed over the distance to go [1/s]
    lean: float = 0.0  # from a region's center towards the next while it waits there [m]


TRACKERS = {
    "panda": [
        Tracker(cruise, 0.08, inside, clearance, 10.0)
        for cruise in (0.7, 1.0)
        for inside in (0.03, 0.015)
        for clearance in (0.06, 0.04)
    ],
    "quadrotor": [
        Tracker(cruise, ahead, inside, clearance, approach, lean)
        for cruise in (3.0, 4.0)
        for ahead in (0.8, 1.2)
        for inside in (0.25, 0.05)
        for clearance in (0.5, 0.35)
        for approach in (1.5, 2.2, 3.0)
        for lean in (0.0, 0.5)
    ],
}


def drive(scene: Scene, initial: np.ndarray, tracker: Tracker) -> np.ndarray:
    """Actions [T, m] that follow the plan from an initial state [n]."""
    plan, axes = plan_of(scene), AXES[scene.robot]
    blocked = obstacles(scene)
    fields = [
        distance_from(scene, visit.region, blocked | visit.doors, tracker.clearance)
        for visit in plan
    ]
    centers = {region.name: np.array(region.center) for region in scene.regions}
    control, step_robot = CONTROLS[scene.robot], STEPS[scene.robot]
    state, entries, index, actions = initial, [], 0, []
    for step in range(episode_length(scene)):
        place = position(scene.robot, state)
        depth = dict(zip(scene.region_names, margins_table(scene, place), strict=True))
        while index < len(plan):
            entered = depth[plan[index].region] >= tracker.inside
            if not _done(plan[index], index, entries, entered, step):
                break
            index += 1
        ahead = place + _coasting(scene.robot, state)
        visit = plan[min(index, len(plan) - 1)]
        center = centers[visit.region]
        if index < len(plan) - 1 and not visit.stay:
            onward = centers[plan[index + 1].region] - center
            center = center + tracker.lean * onward / np.linalg.norm(onward)
        if index == len(plan) or depth[visit.region] >= tracker.inside:
            wish = 1.2 * (center - ahead)
        else:
            aim = _path_point(axes, fields[index], ahead, tracker.ahead)
            wish = aim - ahead
            to_go = np.linalg.norm(center - ahead)
            speed = min(tracker.cruise, tracker.approach * to_go)
            wish = speed * wish / max(np.linalg.norm(wish), tracker.ahead / 2)
        action = np.round(control(state, wish), DIGITS)
        actions.append(action)
        state = step_robot(state, action)
    return np.asarray(actions)


def _done(visit: Visit, index: int, entries: list[int], entered: bool, step: int) -> bool:
    """Whether the visit is over at this step; notes its entry when it begins."""
    if len(entries) == index:
        base = 0 if visit.base is None else entries[visit.base]
        if not entered or step < base + visit.low:
            return False
        entries.append(step)
    return step >= entries[index] + visit.stay


def _path_point(axes, field: np.ndarray, place: np.ndarray, ahead: float) -> np.ndarray:
    """The point that lies `ahead` metres down the path from a position [3]."""
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    distance = np.linalg.norm(nodes - place, axis=-1)
    node = np.unravel_index(np.where(np.isfinite(field), distance, np.inf).argmin(), field.shape)
    target = max(field[node] - ahead, 0.0)
    while field[node] > target:
        window = tuple(slice(max(i - 2, 0), i + 3) for i in node)
        lowest = np.unravel_index(field[window].argmin(), field[window].shape)
        node = tuple(w.start + int(low) for w, low in zip(window, lowest, strict=True))
    return nodes[node]


def _move_arm(state: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Joint velocities for a velocity [3] of the end effector, in units of their limits.

    Redundant joints drift towards the middle of their ranges.
    """
    jacobian = panda_jacobian(state)
    inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + 1e-3 * np.eye(3))
    rest = np.clip(PANDA_READY - state, -0.3, 0.3)
    rates = inverse @ velocity + (np.eye(7) - inverse @ jacobian) @ rest
    room = np.where(rates > 0, PANDA_HIGH - state, state - PANDA_LOW)
    rates = np.sign(rates) * np.minimum(np.abs(rates), room / PANDA_DT)
    return rates / PANDA_VELOCITY / max(1.0, np.abs(rates / PANDA_VELOCITY).max())


def _fly(state: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Thrust and tilt for a velocity [3] in the scene's frame; heading kept at zero.

    Each horizontal axis is a linear system (velocity, tilt, tilt rate) under a regulator.
    """
    error = np.clip(velocity - position("quadrotor", state[3:6]), -2.0, 2.0)
    pitch = _tilt_gains() @ [error[0], state[7], state[10]]
    roll = _tilt_gains() @ [error[1], state[6], state[9]]
    lean = math.cos(state[6]) * math.cos(state[7])
    thrust = (9.81 + 3.0 * error[2]) / max(lean, 0.6) / 9.81 - 1
    return np.clip([thrust / 0.6, roll, pitch, -state[8]], -1, 1)


@cache
def _tilt_gains() -> np.ndarray:
    """Gains on (velocity error, tilt, tilt rate): a tilt below zero accelerates forward, left."""
    plant = np.array([[1, -0.981, 0], [0, 1, 0.1], [0, -2.5, 0]])
    control = np.array([[0], [0], [1.5]])
    weight, effort = np.diag([1.0, 0.0, 0.0]), np.array([[0.6]])
    value = solve_discrete_are(plant, control, weight, effort)
    gains = np.linalg.solve(effort + control.T @ value @ control, control.T @ value @ plant)[0]
    return -gains * [-1, 1, 1]


def _coasting(robot: str, state: np.ndarray) -> np.ndarray:
    """Way [3] that the robot makes before it can follow another wish."""
    return 0.15 * position(robot, state[3:6]) if robot == "quadrotor" else np.zeros(3)


CONTROLS = {"panda": _move_arm, "quadrotor": _fly}


def initial_state(scene: Scene) -> np.ndarray:
    """At rest at the middle of the initial set."""
    center = np.array(scene.initial.center)
    if scene.robot == "quadrotor":
        return np.concatenate([position("quadrotor", center), np.zeros(9)])
    angles = np.array(PANDA_READY) + [math.atan2(center[1], center[0]), *[0.0] * 6]
    for _ in range(100):
        jacobian = panda_jacobian(angles)
        change = np.linalg.pinv(jacobian) @ (center - panda_tip(angles))
        angles = np.clip(angles + np.clip(change, -0.2, 0.2), PANDA_LOW, PANDA_HIGH)
    return np.round(angles, DIGITS)


def main(tasks: list[str]) -> None:
    """Search, judge and store."""
    for task in tasks or task_names("panda") + task_names("quadrotor"):
        scene = load_task(task)
        initial = initial_state(scene)
        best, kept = -math.inf, None
        for tracker in TRACKERS[scene.robot]:
            actions = drive(scene, initial, tracker)
            value = judge(scene, initial, actions)
            if value > best:
                best, kept = value, actions
        print(f"{task}: robustness {best:.3f}", flush=True)
        if kept is not None and best > 0.002:
            save_witness(task, initial, kept, hold=1)


if __name__ == "__main__":
    main(sys.argv[1:])
