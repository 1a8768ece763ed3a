"""Training and evaluation without the page."""

import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from core.checkpoint import DivergedError
from core.decompose import advice
from core.errors import UserError
from core.methods.training import (
    TrainingConfig,
    best_weights,
    final_evaluation,
    train,
    what_fails,
)
from core.stl import one_line
from scenes import Scene, demo_names, load_scene, load_task, scene_reading, task_names
from studio.options import Options
from studio.runs.bundle import bundle_folder, load_bundle
from studio.runs.config import RunConfig, make_config
from studio.runs.findings import offering_force
from studio.runs.json_documents import plain
from studio.runs.layouts import held_out
from studio.runs.pretraining import finish_pretraining, pretraining_config
from studio.runs.reporting import Reporter, make_reporter
from studio.runs.run import Run, default_folder
from studio.runs.stopping import StopRequest, abort_process
from studio.runs.tasks import build_task

RUNS = Path("runs")
"""Where runs go without --out, below the current directory."""

FAILED = 1
"""Exit status of a run that could not continue: it diverged, or the disk is full."""


def train_only(options: Options) -> int:
    """Create a run and train it to its end; returns the exit status."""
    scene = chosen_scene(options)
    config = make_config(
        scene,
        mode=options.mode,
        method=options.method,
        seed=options.seed,
        epochs=options.epochs,
        time_limit=options.time_limit,
        target=options.target,
        randomize=options.randomize,
        weights=options.weights,
    )
    return start(config, options.out, force=options.force)


def resume(options: Options) -> int:
    """Resume a run; returns the exit status."""
    assert options.resume is not None
    run = Run.resume(
        options.resume,
        epochs=options.epochs,
        time_limit=options.time_limit,
        target=options.target,
    )
    return _to_the_end(run)


def evaluate(options: Options) -> int:
    """Evaluate a policy by the paper's protocol and print one JSON line."""
    assert options.evaluate is not None
    policy = load_bundle(bundle_folder(options.evaluate))
    scene = chosen_scene(options, policy.scene)
    if scene.robot != policy.scene.robot:
        raise UserError(
            f"{options.evaluate}: a policy for the robot {policy.scene.robot!r} cannot carry out "
            f"{scene.name}, a task for {scene.robot!r}. Allowed: "
            + ", ".join(task_names(policy.scene.robot))
        )
    seed = policy.seed if options.seed is None else options.seed
    began = time.perf_counter()
    config = TrainingConfig(policy.algorithm, policy.method, seed=seed)
    task = build_task(scene, force=True)
    evaluation = final_evaluation(task, config, policy.weights)
    layouts = [
        final_evaluation(layout, config, policy.weights).success_rate
        for layout in held_out(scene, task, policy.algorithm, options.layouts or 0)
    ]
    result = {
        "task": scene.name,
        "formula": one_line(scene.formula),
        "trained_on": policy.scene.name,
        "method": policy.method,
        "mode": policy.mode,
        "seed": seed,
        "success_rate": evaluation.success_rate,
        "robustness_mean": evaluation.robustness_mean,
        "between_rate": evaluation.between_rate,
        "initial_states": len(evaluation.robustness),
        **({"layouts": layouts, "layouts_mean": sum(layouts) / len(layouts)} if layouts else {}),
        "seconds": round(time.perf_counter() - began, 3),
        "bundle": str(options.evaluate),
    }
    print(json.dumps(plain(result)), flush=True)
    return 0


def list_tasks() -> int:
    """Print the names and titles of the shipped tasks."""
    for name in demo_names() + task_names():
        print(f"{name:14} {load_task(name).title}")
    return 0


def chosen_scene(options: Options, default: Scene | None = None) -> Scene:
    """The scene of --task or --scene, with --formula and --variant.

    Raises:
        UserError: there is no such task or scene file, or it is malformed, or its formula is.
    """
    if options.task is not None:
        scene = load_task(options.task)
    elif options.scene is not None:
        scene = load_scene(options.scene)
    elif default is not None:
        scene = default
    else:
        raise UserError("give --task NAME or --scene FILE.stl.toml; --list prints the tasks")
    if options.formula is not None:
        scene = replace(scene, formula=options.formula.strip())
    if options.variant is not None:
        scene = replace(scene, variant=options.variant)
    for note in scene_reading(scene).notes:
        print(note, file=sys.stderr, flush=True)
    return scene


def pretrain(options: Options) -> int:
    """Train a robot's weights on random missions; returns the exit status."""
    assert options.pretrain is not None
    budget = {"seed": options.seed, "epochs": options.epochs, "time_limit": options.time_limit}
    return start(pretraining_config(options.pretrain, **budget), options.out)


def start(config: RunConfig, out: Path | None, *, force: bool = False) -> int:
    """Create a run and train it to its end; returns the exit status.

    Args:
        config: of the run.
        out: its folder; None for a fresh one below `RUNS`.
        force: whether to train on a mission that cannot be carried out.
    """
    with offering_force():
        task = config.build_task(force=force)  # before the folder is made: an error leaves none
    config.training.learner(task).weight_shapes()  # so does a method that knows other formulas
    folder = default_folder(RUNS, config) if out is None else out
    return _to_the_end(Run.create(folder, config, task))


def _to_the_end(run: Run) -> int:
    """Train, save the results, print the last line."""
    reporter = make_reporter()

    def asked() -> None:
        reporter.note("stopping after this epoch; press Ctrl-C again to abort immediately")

    def abort(number: int) -> None:
        reporter.restore()
        abort_process(number)

    told = (*advice(run.task.formula), *map(str, run.task.findings), *run.notes)
    for note in told:
        reporter.note(note)
    with run, StopRequest(asked, abort) as stop:
        try:
            summary = _train(run, reporter, stop)
        except UserError as error:
            reporter.restore()
            reporter.note(_failure(run, error))
            return FAILED
        finally:
            reporter.restore()
        if summary["success_rate"] == 0 and not run.config.missions:
            found = _what_fails(run)
            if found:
                reporter.note(found)
        if run.config.missions:
            summary = plain(finish_pretraining(run, summary))
    print(json.dumps(summary), flush=True)
    return 0


def _train(run: Run, reporter: Reporter, stop: StopRequest) -> dict[str, Any]:
    training = run.config.training
    reporter.begin(training, run.epochs, training.learner(run.task).pace_change)
    try:
        state = run.config.first_state(run.task) if run.state is None else run.state
        for progress in train(run.task, training, state):
            reporter.report(run.record(progress))
            if stop.requested:
                break
    except DivergedError:
        if run.state is not None:
            run.finish("diverged")
        raise
    return run.finish(_reason(run, stop))


def _what_fails(run: Run) -> str:
    """What stands in the way of a run that never succeeds; empty where it cannot be told."""
    assert run.state is not None
    training = run.config.training
    return what_fails(run.task, training, best_weights(run.task, training, run.state))


def _reason(run: Run, stop: StopRequest) -> str:
    """Why a training has stopped."""
    if run.state is not None and bool(run.state.finished):
        return "target"
    if run.epochs >= run.config.training.epochs:
        return "epochs"
    return "interrupted" if stop.requested else "time limit"


def _failure(run: Run, error: UserError) -> str:
    kept = f"; the results so far are in {run.folder}" if run.state is not None else ""
    return f"error: {error}{kept}"
