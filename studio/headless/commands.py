"""Training and evaluation without the page."""

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from core.checkpoint import DivergedError
from core.errors import UserError
from core.training import TrainingConfig, final_evaluation, train
from scenes import Scene, demo_names, load_scene, load_task, task_names
from studio.files.bundle import METADATA, load_bundle
from studio.files.json_documents import plain
from studio.headless.config import make_config
from studio.headless.reporting import Reporter, make_reporter
from studio.headless.run import Run, default_folder
from studio.headless.stopping import StopRequest, abort_process
from studio.layouts import held_out
from studio.tasks import build_task

if TYPE_CHECKING:
    from studio.cli import Options

RUNS = Path("runs")
"""Where runs go without --out, below the present directory."""

FAILED = 1
"""Exit status of a run that could not go on: it diverged, or the disk is full."""


def train_only(options: "Options") -> int:
    """Make a new run and train it to its end; returns the exit status."""
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
    )
    task = config.build_task()  # before a folder is made: a bad formula leaves no trace
    folder = default_folder(RUNS, config) if options.out is None else options.out
    return _to_the_end(Run.create(folder, config, task))


def resume(options: "Options") -> int:
    """Go on with a run; returns the exit status."""
    assert options.resume is not None
    run = Run.resume(
        options.resume,
        epochs=options.epochs,
        time_limit=options.time_limit,
        target=options.target,
    )
    return _to_the_end(run)


def evaluate(options: "Options") -> int:
    """Measure a policy by the paper's protocol and print one JSON line."""
    assert options.evaluate is not None
    policy = load_bundle(bundle_folder(options.evaluate))
    scene = chosen_scene(options, policy.scene)
    if scene.robot != policy.scene.robot:
        raise UserError(
            f"{options.evaluate}: a policy for the robot {policy.scene.robot!r} cannot carry out "
            f"{scene.name}, a task of {scene.robot!r}. Allowed: "
            + ", ".join(task_names(policy.scene.robot))
        )
    seed = policy.seed if options.seed is None else options.seed
    began = time.perf_counter()
    config = TrainingConfig(policy.algorithm, seed=seed)
    task = build_task(scene)
    evaluation = final_evaluation(task, config, policy.parameters)
    layouts = [
        final_evaluation(layout, config, policy.parameters).success_rate
        for layout in held_out(scene, task, policy.algorithm, options.layouts or 0)
    ]
    result = {
        "task": scene.name,
        "formula": " ".join(scene.formula.split()),
        "trained_on": policy.scene.name,
        "method": policy.method,
        "mode": policy.mode,
        "seed": seed,
        "success_rate": evaluation.success_rate,
        "robustness_mean": evaluation.robustness_mean,
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


def chosen_scene(options: "Options", default: Scene | None = None) -> Scene:
    """The scene of --task or --scene, with --formula and --variant.

    Raises:
        UserError: there is no such task or scene file, or it is malformed.
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
    return scene


def bundle_folder(path: Path) -> Path:
    """The bundle of a run directory, or the bundle itself.

    Raises:
        UserError: the path holds neither.
    """
    if (path / METADATA).is_file():
        return path
    if (path / "bundle").is_dir():
        return path / "bundle"
    if (path / "config.json").is_file():
        raise UserError(f"{path}: this run has no policy yet; finish it with --resume {path}")
    raise UserError(f"{path}: neither a run nor a policy bundle ({METADATA} is missing)")


def _to_the_end(run: Run) -> int:
    """Train, keep the results, print the last line."""
    reporter = make_reporter()

    def asked() -> None:
        reporter.note("stopping after this epoch; once more aborts at once")

    def abort(number: int) -> None:
        reporter.restore()
        abort_process(number)

    for note in run.notes:
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
    print(json.dumps(summary), flush=True)
    return 0


def _train(run: Run, reporter: Reporter, stop: StopRequest) -> dict[str, Any]:
    training = run.config.training
    reporter.begin(training, run.epochs)
    try:
        for progress in train(run.task, training, run.state):
            reporter.report(run.record(progress))
            if stop.requested:
                break
    except DivergedError:
        if run.state is not None:
            run.finish("diverged")
        raise
    return run.finish(_reason(run, stop))


def _reason(run: Run, stop: StopRequest) -> str:
    """Why a training has stopped."""
    if run.state is not None and bool(run.state.finished):
        return "target"
    if run.epochs >= run.config.training.epochs:
        return "epochs"
    return "interrupted" if stop.requested else "time limit"


def _failure(run: Run, error: UserError) -> str:
    kept = f"; what was kept is in {run.folder}" if run.state is not None else ""
    return f"error: {error}{kept}"
