"""A matrix of trainings that take a second, and rows that nobody has trained."""

from typing import Any

from studio.bench.machine import versions
from studio.bench.matrix import Job

TINY = """
format = 1
title = "tiny"

[variants.tiny]
environments = 16
hidden = [16]
passes = 1
minibatches = 2
mcmc_steps = 2
elite_capacity = 16
prune_candidates = 4
choice_candidates = 8
evaluation_states = 16

[[runs]]
tasks = ["linear-demo"]
variants = ["tiny"]
seeds = [1, 2]
epochs = 2
target = 2.0
evaluate_every = 1
"""


def job(**changes: Any) -> Job:
    """A job; everything that is not given has a default."""
    default: dict[str, Any] = {
        **{"task": "linear-01", "method": "tgpo-star", "mode": "studio", "variant": "default"},
        **{"changes": {}, "weights": "none", "horizon": None, "seed": 1, "epochs": 2},
        **{"seconds": None, "cpu_seconds": None, "target": None, "evaluate_every": None},
    }
    return Job(**(default | changes))


def row(success: float, seconds: float = 10.0, **changes: Any) -> dict[str, Any]:
    """The row of a run that has finished."""
    import msgspec

    made = job(**changes)
    point = {"epoch": 5, "seconds": seconds / 2, "cpu_seconds": seconds / 3}
    point |= {"env_steps": 9, "robustness_mean": 0.0}
    return {
        "key": made.key,
        "status": "finished",
        "robot": made.task.rsplit("-", 1)[0],
        "horizon": made.horizon or 100,
        **{n: getattr(made, n) for n in ("task", "method", "mode", "variant", "weights", "seed")},
        "success_rate": success,
        "robustness_mean": 0.1,
        **{"middle_robustness": None, "bound": None, "critic_map": None, "cases": None},
        **{"critic_scores": None, "critic_robustness": None},
        **{"epochs": 10, "env_steps": 1000, "train_seconds": seconds, "compile_seconds": 1.0},
        **{"stopped": "epochs", "train_cpu_seconds": seconds / 2, "cpu_seconds": seconds},
        **{"concurrent": 1, "cores": 2},
        **{"wall_seconds": seconds + 3, "peak_bytes": 10**9, "started": "2026-11-29T09:00:00"},
        "curve": [point | {"success_rate": success}],
        "revision": "abc",
        "versions": versions(),
        "machine": {"processor": "made up"},
        "job": msgspec.json.encode(made).decode(),
        "configuration": "{}",
    }
