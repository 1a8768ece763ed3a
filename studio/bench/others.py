"""What a matrix may name beside this program's methods: the exact planner, and other libraries.

They are measured in the same way and kept in the same store, but are no methods of `METHODS`: they
have no hyper-parameters here, and no weights that could be exported.
"""

import time
from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from core.errors import UserError
from core.planning.exact import plan_exactly
from scenes import load_task, scene_formula
from scenes.outlines import setting_of
from studio.bench.horizons import with_horizon
from studio.bench.matrix import Job
from studio.bench.peers.learners import LIBRARIES, learn
from studio.bench.peers.robustness import RIVALS, compare
from studio.runs.exact import SECONDS, replayed
from studio.runs.json_documents import plain

Measured = Callable[[Job], dict[str, Any]]
"""Carries out a job; returns the columns of its row."""


def exact(job: Job) -> dict[str, Any]:
    """The most robust plan from the middle of the initial set, and the bound of all others."""
    scene = with_horizon(load_task(job.task), job.horizon)
    formula = scene_formula(scene)
    began, cpu_began = time.perf_counter(), time.process_time()
    seconds = SECONDS if job.seconds is None else job.seconds
    found = plan_exactly(formula, setting_of(scene), seconds=seconds)
    robustness = replayed(scene, formula, found)["robustness"]
    return {
        "success_rate": float(robustness >= 0),
        "robustness_mean": plain(robustness),
        "middle_robustness": plain(robustness),
        "bound": plain(found.bound),
        "stopped": found.status,
        "train_seconds": time.perf_counter() - began,
        "train_cpu_seconds": time.process_time() - cpu_began,
        "curve": [],
        "configuration": "{}",
    }


def _robustness(job: Job) -> dict[str, Any]:
    """Robustness by the library that the job names, and by ours; the task does not matter."""
    began, cpu_began = time.perf_counter(), time.process_time()
    return {
        "cases": compare(job.method),
        "train_seconds": time.perf_counter() - began,
        "train_cpu_seconds": time.process_time() - cpu_began,
        "curve": [],
        "configuration": "{}",
    }


OTHERS: MappingProxyType[str, Measured] = MappingProxyType(
    {"exact": exact, **dict.fromkeys(LIBRARIES, learn), **dict.fromkeys(RIVALS, _robustness)}
)
"""By name."""


def measured(job: Job) -> dict[str, Any]:
    """Carry out a job of one of `OTHERS`.

    Raises:
        UserError: hyper-parameters or weights are asked for.
    """
    if job.changes or job.weights != "none":
        raise UserError(f"{job.method}: has neither variants nor weights here")
    return OTHERS[job.method](job)
