"""The command `tgpo-studio`: the page, or training and evaluation without it.

Everything heavy is imported after the arguments have been read, so that `--help` and errors in
the arguments answer at once.
"""

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Literal

import tyro

from core.errors import UserError

BAD_INPUT = 2
"""Exit status of arguments, scenes, formulas or files that cannot be used."""


def _shown(metavar: str, default: str = ""):
    """How --help shows a value and its default."""
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=default and f"(default: {default})")


Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
Folder = Annotated[Path | None, _shown("DIR")]


@dataclass(frozen=True)
class Options:
    """Type a Signal Temporal Logic formula, train a policy in seconds, watch it carried out.

    Without --train-only, --resume, --evaluate or --list, the page is served.
    """

    task: Annotated[str | None, _shown("NAME")] = None
    """A shipped task, linear-08 for instance."""
    scene: Annotated[Path | None, _shown("FILE")] = None
    """A scene file (*.stl.toml) instead of a shipped task."""
    formula: Annotated[str | None, _shown("TEXT")] = None
    """A formula instead of the task's own."""

    variant: Annotated[str | None, _shown("NAME", "the scene's")] = None
    """Another reading of the robot: links (panda) holds obstacles against the whole arm, raw-motors
    (quadrotor) acts by motor forces."""

    train_only: Flag = False
    """Train without the page. Ends with one JSON line."""
    method: Literal["tgpo", "tgpo-star"] = "tgpo-star"
    """tgpo draws schedules uniformly; tgpo-star also asks the critic and remembers the best."""
    mode: Literal["studio", "paper"] = "studio"
    """studio learns in seconds; paper is the paper's formulation with its hyper-parameters."""
    seed: Annotated[int | None, _shown("INT", "the scene's")] = None
    """Seed of the training."""
    epochs: Annotated[int | None, _shown("INT", "200, in paper mode 1000")] = None
    """Most epochs."""
    time_limit: Annotated[float | None, _shown("SECONDS", "none")] = None
    """Most seconds of training, compilation apart."""
    target: Annotated[float | None, _shown("SHARE", "0.995")] = None
    """Success rate at which the training stops; above 1 it goes on to the last epoch."""
    randomize: Flag = False
    """Train on many perturbed layouts of the regions, for a policy that carries over to others."""
    out: Annotated[Path | None, _shown("DIR", "runs/TASK-METHOD-SEED, numbered")] = None
    """Run directory."""

    resume: Folder = None
    """Go on with a run from its last checkpoint; the budget may be given anew."""
    evaluate: Folder = None
    """Measure the policy of a run or a bundle on 512 initial states, on --task if given."""
    layouts: Annotated[int | None, _shown("INT", "none")] = None
    """With --evaluate: measure also on this many perturbed layouts that no training has seen."""
    list: Flag = False
    """Print the shipped tasks."""

    host: Annotated[str, _shown("ADDRESS", "127.0.0.1")] = "127.0.0.1"
    """Address of the page."""
    port: Annotated[int, _shown("INT", "8080")] = 8080
    """Port of the page."""
    token: Annotated[str | None, _shown("TEXT", "made up")] = None
    """What clients must show where the address is not this machine's alone."""
    load: Annotated[Path | None, _shown("PATH")] = None
    """Open the page on the policy of a run, a bundle, or one of them zipped."""
    no_browser: Flag = False
    """Do not open a browser."""
    no_cache: Flag = False
    """Do not keep compiled programs on disk."""


TASK = {"task", "scene", "formula", "no_cache"}
MOST_LAYOUTS = 1000
BUDGET = {"epochs", "time_limit", "target"}
ALLOWED = {
    "list": {"list"},
    "evaluate": TASK | {"evaluate", "seed", "layouts", "variant"},
    "resume": BUDGET | {"resume", "train_only", "no_cache"},
    "train_only": TASK
    | BUDGET
    | {"train_only", "method", "mode", "seed", "randomize", "variant", "out"},
    "page": TASK | {"host", "port", "token", "load", "no_browser"},
}
"""Options that have a meaning for each action; the first action that is asked for counts."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status (argument errors raise SystemExit(2))."""
    options = tyro.cli(
        Options,
        prog="tgpo-studio",
        args=arguments,
        config=(tyro.conf.FlagCreatePairsOff,),
    )
    try:
        return _action(options)()
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("aborted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # whoever read our output has left
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _action(options: Options) -> Callable[[], int]:
    """What is asked for, after a check that every option has a meaning for it.

    Raises:
        UserError: options that contradict each other.
    """
    given = {f.name for f in fields(options) if getattr(options, f.name) != f.default}
    action = next((name for name in ALLOWED if name in given), "page")
    for name in sorted(given - ALLOWED[action]):
        beside = ", ".join(_flag(other) for other in sorted(ALLOWED[action] - {action}))
        where = "for the page without --train-only" if action == "page" else f"with {_flag(action)}"
        raise UserError(f"{_flag(name)} has no meaning {where}. Allowed: {beside or 'nothing'}")
    if options.task is not None and options.scene is not None:
        raise UserError("--task and --scene exclude each other; give one of them")
    if options.load is not None and (options.task is not None or options.scene is not None):
        raise UserError("--load brings its own scene; give neither --task nor --scene with it")
    if options.layouts is not None and not 1 <= options.layouts <= MOST_LAYOUTS:
        raise UserError(f"--layouts: {options.layouts} must be from 1 to {MOST_LAYOUTS}")
    if not 0 <= options.port < 2**16:
        raise UserError(f"--port: {options.port} must be from 0 to 65535")
    return lambda: _run(action, options)


def _run(action: str, options: Options) -> int:
    if action == "page":
        return _serve(options)
    from studio.headless import commands  # noqa: PLC0415

    if action == "list":
        return commands.list_tasks()
    _use_cache(options)
    actions = {
        "evaluate": commands.evaluate,
        "resume": commands.resume,
        "train_only": commands.train_only,
    }
    return actions[action](options)


def _serve(options: Options) -> int:
    from studio.app import serve  # noqa: PLC0415

    _use_cache(options)
    serve(
        task=options.task,
        scene=None if options.scene is None else str(options.scene),
        formula=options.formula,
        host=options.host,
        port=options.port,
        open_browser=not options.no_browser,
        load=options.load,
        token=options.token,
    )
    return 0


def _use_cache(options: Options) -> None:
    from core.programs import use_disk_cache  # noqa: PLC0415

    if not options.no_cache:
        use_disk_cache()


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")
