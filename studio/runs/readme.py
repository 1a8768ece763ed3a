"""README.txt of a policy bundle."""

import math
from string import Template

from core.stl import one_line
from core.task.protocols import Array
from core.task.task import Task
from scenes import Scene, robot_of
from studio.runs.controller import FAILED
from studio.runs.tasks import initial_state


def readme(scene: Scene, task: Task, success_rate: float, *, chooses_times: bool = True) -> str:
    """What the policy is for, and code that runs it with nothing but jax.

    Args:
        scene: with the formula that was trained on.
        task: the grounded scene.
        success_rate: measured share of initial states from which the policy succeeds, NaN if it
            was not measured.
        chooses_times: whether the policy carries out schedules; others ignore them.
    """
    robot = robot_of(scene)
    variables = task.grounding.decomposition.variables
    return _README.substitute(
        task=scene.name,
        robot=robot.name,
        formula=one_line(scene.formula),
        success=_success(success_rate),
        state_names=", ".join(robot.state_names),
        action_names=", ".join(robot.action_names),
        variables=", ".join(f"{v.name} in [{v.low}, {v.high}]" for v in variables) or "none",
        low=[v.low for v in variables],
        high=[v.high for v in variables],
        count=len(variables),
        state=_written(initial_state(task)),
        steps=task.horizon,
        rows=task.horizon + 1,
        dt=robot.dt,
        failed=f"{FAILED:,.0f}",
        ignored="" if chooses_times else _IGNORED,
    )


def _success(rate: float) -> str:
    if math.isnan(rate):
        return "Its success rate has not been measured."
    return f"It satisfied the formula from {100 * rate:.1f} % of random initial states."


def _written(state: Array) -> list[float]:
    """A state [n] to six decimals: as float32 has near 1, so that a quaternion stays a unit one."""
    return [round(float(value), 6) + 0.0 for value in state]  # + 0.0 makes -0.0 a plain zero


_IGNORED = """
This policy chooses no times: it carries out the formula as a whole, ignores t, and scores every
schedule 0. So there is nothing to plan anew either."""

_README = Template("""\
A policy for the task $task of the robot "$robot", trained by TGPO Studio

    $formula

$success

To evaluate it here:   tgpo-studio --evaluate THIS_FOLDER

To run it without TGPO Studio, in this folder, with only jax (and flatbuffers, which jax needs to
load programs: pip install jax flatbuffers):

    import jax
    import numpy as np
    from jax import export

    def load(name):
        with open(name + ".stablehlo", "rb") as file:
            return jax.jit(export.deserialize(bytearray(file.read())).call)

    score, start, step = load("score"), load("start"), load("step")
    x = np.array($state, np.float32)  # the current state
    low, high = np.array($low, np.int32), np.array($high, np.int32)
    candidates = np.random.default_rng(0).integers(low, high + 1, (64, $count), np.int32)
    t = max(candidates, key=lambda t: float(score(x, t)))  # the schedule of highest value
    s = start(x, t)
    for k in range($steps):
        s, action = step(s, x)
        x = your_robot(x, action)  # the state measured $dt s later

The state is ($state_names), float32. The action ($action_names) is in [-1, 1], in units of the
robot's limits, listed under "robot_constants" in metadata.json. The schedule t holds the
formula's time variables in steps, int32: $variables.$ignored
s is the controller's memory: a tuple of arrays to pass to the next call of step.

After a push, or whenever the robot is not where it should be, choose the times anew at a step k:

    rescore = load("rescore")

    def plan_anew(xs, k, t):  # xs [$rows, n]: the states measured at steps 0 to k, then anything
        random = np.random.default_rng(k)
        drawn = random.integers(low, high + 1, (256, $count), np.int32)
        mixed = np.where(random.random(drawn.shape) < 0.5, t, drawn).astype(np.int32)
        t = max([t, *mixed, *drawn], key=lambda t: float(rescore(xs, np.int32(k), t)))
        s = start(xs[0], t)
        for x in xs[:k]:
            s, _ = step(s, x)  # leads the memory along the past
        return t, s  # go on with step(s, xs[k])

rescore is the value of what is left of a schedule, less $failed for each of its tasks that the past
has made fail. So times at which something was met are kept, and those that were missed are not.
""")
