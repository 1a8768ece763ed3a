"""`--plan`: an answer without training, as one JSON line."""

import json
import math
import sys
from collections.abc import Sequence

import jax
import numpy as np

from core.answer import Plan, answer, answer_jobs
from core.attempts import tries
from core.compilation import compile_together
from core.controller import Controller
from core.errors import UserError
from core.evaluation import Evaluation, evaluate
from core.task.task import Task
from studio.options import Options
from studio.runs.bundle import save_bundle
from studio.runs.commands import chosen_scene
from studio.runs.findings import offering_force
from studio.runs.json_documents import plain
from studio.runs.pretrained import chosen_weights
from studio.runs.recording import Recording, record
from studio.runs.tasks import build_task, initial_state

STARTS = 64
"""Random initial states of which the share that succeeds is measured."""


def plan(options: Options) -> int:
    """Answer, print one JSON line, and write a bundle with --out; returns the exit status.

    Raises:
        UserError: no such task, or no weights for its robot.
    """
    scene = chosen_scene(options)
    with offering_force():
        task = build_task(scene, force=options.force)
    for finding in task.findings:
        print(finding, file=sys.stderr, flush=True)
    source = options.weights or "shipped"
    weights = chosen_weights(source, task)
    if weights is None:
        raise UserError(f"--weights: there are none for {task.robot.name}; train with --train-only")
    controller, seed = weights.controller, scene.seed if options.seed is None else options.seed
    compile_seconds = compile_together(*answer_jobs(task, controller))
    found = answer(task, controller, initial_state(task), seed=seed)
    best = recorded(task, found.plan)
    others = [recorded(task, other) for other in found.alternatives]
    sample = sample_starts(task, controller, options.starts or STARTS, seed)
    result = {
        "task": scene.name,
        "satisfied": best.satisfied,
        "success_rate": sample.success_rate,
        "robustness": best.robustness,
        "nudged": best.nudged,
        "between": best.between.document(),
        "between_rate": sample.between_rate,
        "schedule": named_times(task, best.schedule),
        "alternatives": [named_times(task, other.schedule) for other in others],
        "answer_seconds": round(found.seconds, 3),
        "compile_seconds": round(compile_seconds + found.compile_seconds, 3),
        "weights": source,
    }
    if options.out is not None:
        policy = weights.policy(scene, sample.success_rate, sample.robustness_mean)
        save_bundle(policy, options.out)
        result["out"] = str(options.out)
    print(json.dumps(plain(result)), flush=True)
    return 0


def recorded(task: Task, plan: Plan) -> Recording:
    """A plan's trace, with the times at which it satisfies the formula."""
    traces = plan.states, plan.actions, plan.margins
    return record(task, plan.schedule, *traces, nudged=plan.nudged)


def sample_starts(task: Task, controller: Controller, count: int, seed: int) -> Evaluation:
    """Verdicts from random initial states, one schedule each, in batches of one size."""
    key, size = jax.random.fold_in(jax.random.key(seed), 2**20), tries(task)
    batches = [
        evaluate(task, controller, jax.random.fold_in(key, number), count=size, between=True)
        for number in range(math.ceil(count / size))
    ]
    joined = [np.concatenate(parts)[:count] for parts in zip(*batches, strict=True)]
    return Evaluation(*joined)


def named_times(task: Task, schedule: Sequence[int] | np.ndarray) -> dict[str, int]:
    """Values of the formula's variables by name [steps]."""
    variables = task.grounding.decomposition.variables
    return {variable.name: int(value) for variable, value in zip(variables, schedule, strict=False)}
