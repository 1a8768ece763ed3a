"""`--exact`: the most robust plan from one start, with a proved bound, as one JSON line."""

import json
from typing import Any

import jax.numpy as jnp
import numpy as np

from core.planning.exact import ExactPlan, plan_exactly
from core.stl import Formula, horizon, one_line, robustness
from core.task.protocols import stride_of
from scenes import Scene, robot_of, scene_formula
from scenes.outlines import margins_of, setting_of
from studio.options import Options
from studio.runs.commands import chosen_scene
from studio.runs.json_documents import plain, write_document

SECONDS = 60.0
"""Of search, where no limit is given."""


def plan_exact(options: Options) -> int:
    """Search, print one JSON line, and write the plan with --out; returns the exit status.

    Raises:
        UserError: no such task, or one that exact plans do not know.
    """
    scene = chosen_scene(options)
    formula = scene_formula(scene)
    seconds = SECONDS if options.time_limit is None else options.time_limit
    found = plan_exactly(formula, setting_of(scene), seconds=seconds)
    plan = replayed(scene, formula, found)
    result = {
        "task": scene.name,
        "formula": one_line(scene.formula),
        "start": list(scene.initial.center),
        "status": found.status,
        "robustness": plan["robustness"],
        "bound": found.bound,
        "seconds": round(found.seconds, 3),
    }
    if options.out is not None:
        write_document(options.out, plain({"format": 1, **result, **plan}))
        result["out"] = str(options.out)
    print(json.dumps(plain(result)), flush=True)
    return 0


def replayed(scene: Scene, formula: Formula, found: ExactPlan) -> dict[str, Any]:
    """A plan's actions [T, m], carried out by the robot: positions [T + 1, d] and robustness."""
    if found.positions is None:
        return {"robustness": -np.inf, "actions": [], "positions": []}
    robot, length = robot_of(scene), max(scene.horizon, horizon(formula))
    moves = np.diff(found.positions[: length + 1], axis=0) / np.array(stride_of(robot))
    actions = np.zeros((length, robot.action_size), np.float32)
    actions[: len(moves)] = np.clip(moves, -1, 1)
    states = [jnp.asarray(found.positions[0], jnp.float32)]
    for action in jnp.asarray(actions):
        states.append(robot.step(states[-1], action))
    positions = np.asarray(jnp.stack(states), float)
    margins = np.stack(list(margins_of(scene.regions, positions).values()), axis=-1)
    value = float(robustness(formula, margins, scene.region_names))
    return {
        "robustness": value,
        "actions": actions.tolist(),
        "positions": positions.tolist(),
    }
