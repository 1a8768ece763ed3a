"""Witness files: a control sequence that carries out a task, kept as compact JSON.

`hold` is the number of steps for which each action is kept.
"""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from core.stl import horizon, parse
from scenes import Scene
from tests.envs.reference import position, rollout
from tests.scenes.geometry import margins_table
from tests.scenes.oracle import rtamt_robustness

FOLDER = Path(__file__).resolve().parent.parent / "witnesses"
DIGITS = 4  # decimals that are kept


class Witness(NamedTuple):
    """Initial state [n] and actions [T, m], one a step."""

    initial: np.ndarray
    actions: np.ndarray


def episode_length(scene: Scene) -> int:
    """Steps that decide the formula: its horizon, and the scene's at least."""
    return max(scene.horizon, horizon(parse(scene.formula)))


def load_witness(task: str) -> Witness:
    data = json.loads((FOLDER / f"{task}.json").read_text(encoding="utf-8"))
    actions = np.repeat(np.asarray(data["actions"], float), data["hold"], axis=0)
    return Witness(np.asarray(data["initial"], float), actions)


def save_witness(task: str, initial, actions, hold: int) -> None:
    data = {
        "task": task,
        "hold": hold,
        "initial": np.round(initial, DIGITS).tolist(),
        "actions": np.round(actions, DIGITS).tolist(),
    }
    FOLDER.mkdir(exist_ok=True)
    text = json.dumps(data, separators=(",", ":")).replace("],[", "],\n[")
    (FOLDER / f"{task}.json").write_text(text + "\n", encoding="utf-8")


def judge(scene: Scene, initial, actions) -> float:
    """rtamt's robustness of the float64 rollout of a robot under actions [T, m]."""
    states = rollout(scene.robot, initial, actions)
    table = margins_table(scene, [position(scene.robot, state) for state in states])
    return rtamt_robustness(scene.formula, scene.region_names, table)
