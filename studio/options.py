"""The options of the command `tgpo-studio`, and which of them can be combined."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Literal

import tyro

from core.errors import UserError


def _shown(metavar: str, default: str = ""):
    """How --help shows a value and its default."""
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=default and f"(default: {default})")


def _variants_hint(default: str) -> str:
    """The variants of all robots; called where help is shown, and only there."""
    del default
    from envs import VARIANTS  # noqa: PLC0415 - imports JAX

    found = [f"{robot}: {', '.join(names)}" for robot, names in VARIANTS.items() if names]
    return f"({'; '.join(found)}; default: the scene's)"


Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
Folder = Annotated[Path | None, _shown("DIR")]


@dataclass(frozen=True)
class Options:
    """Type a Signal Temporal Logic formula, train a policy in seconds, and watch it run.

    Serves the page unless one of --plan, --exact, --train-only, --pretrain, --resume, --evaluate,
    --new, --explain and --list is given.
    """

    task: Annotated[str | None, _shown("NAME")] = None
    """A shipped task, such as linear-08."""
    scene: Annotated[Path | None, _shown("FILE")] = None
    """A scene file (*.stl.toml) instead of a shipped task."""
    formula: Annotated[str | None, _shown("TEXT")] = None
    """A formula to use instead of the task's own."""

    variant: Annotated[
        str | None, tyro.conf.arg(metavar="NAME", help_behavior_hint=_variants_hint)
    ] = None
    """A variant of the robot; docs/robots says what each means."""

    train_only: Flag = False
    """Train without the page. The last line printed is the result, as JSON."""
    weights: Annotated[str | None, _shown("shipped|none|FILE", "shipped, in paper mode none")] = (
        None
    )
    """Weights that training and plans begin with: the robot's, none, or those of a file."""
    method: Literal["tgpo-star", "tgpo", "rnn", "cem", "grad", "tau-mdp", "f-mdp"] = "tgpo-star"
    """tgpo samples schedules uniformly, tgpo-star also by the critic and from the best so far; the
    others are baselines (docs/baselines.md)."""
    mode: Literal["studio", "paper"] = "studio"
    """studio learns in seconds; paper follows the paper, with its hyper-parameters."""
    seed: Annotated[int | None, _shown("INT", "the scene's")] = None
    """Training seed."""
    epochs: Annotated[int | None, _shown("INT", "200, in paper mode 1000")] = None
    """Maximum number of epochs."""
    time_limit: Annotated[float | None, _shown("SECONDS", "none, with --exact 60")] = None
    """Maximum training time in seconds, not counting compilation; with --exact, of the search."""
    target: Annotated[float | None, _shown("RATE", "0.995")] = None
    """Success rate at which training stops; above 1, it runs to the last epoch."""
    randomize: Flag = False
    """Train on many perturbed layouts of the regions, for a policy that generalises to new ones."""
    out: Annotated[Path | None, _shown("DIR", "runs/TASK-METHOD-SEED, numbered")] = None
    """Run directory; with --exact, a JSON file for the plan; with --new, the scene file."""

    force: Flag = False
    """Train or plan although it is proved that no behaviour can satisfy the formula."""

    plan: Flag = False
    """Answer without training: find a schedule, simulate it, print the result as one JSON line."""
    starts: Annotated[int | None, _shown("INT", "64")] = None
    """With --plan: number of random starts of which the share that succeeds is measured."""
    exact: Flag = False
    """Prove how robust a plan from the centre of the initial set can be at most, and find one."""
    explain: Flag = False
    """Print how the formula is read: in English, and the tasks it decomposes into."""
    new: Annotated[str | None, _shown("ROBOT")] = None
    """Write a scene file to begin with: the robot, a start and a goal."""
    pretrain: Annotated[str | None, _shown("ROBOT")] = None
    """Train a robot's weights on random missions, for answers without training."""

    resume: Folder = None
    """Resume a run from its last checkpoint; --epochs, --time-limit and --target may change."""
    evaluate: Folder = None
    """Evaluate a run's or bundle's policy on 512 initial states, on another task with --task."""
    layouts: Annotated[int | None, _shown("INT", "none")] = None
    """With --evaluate: also evaluate on this many perturbed layouts not used in training."""
    list: Flag = False
    """List the shipped tasks."""

    host: Annotated[str, _shown("ADDRESS", "127.0.0.1")] = "127.0.0.1"
    """Address to serve the page on."""
    port: Annotated[int, _shown("INT", "8080")] = 8080
    """Port to serve the page on."""
    token: Annotated[str | None, _shown("TEXT", "random")] = None
    """Access token; needed where --host can be reached from other machines."""
    load: Annotated[Path | None, _shown("PATH")] = None
    """Open the page with the policy of a run or a bundle (a folder or a zip file)."""
    no_browser: Flag = False
    """Do not open a browser."""
    no_cache: Flag = False
    """Do not cache compiled programs on disk."""


TASK = {"task", "scene", "formula", "no_cache"}
MOST_LAYOUTS = 1000
MOST_STARTS = 10_000
BUDGET = {"epochs", "time_limit", "target"}
ALLOWED = {
    "list": {"list"},
    "new": {"new", "out", "variant"},
    "explain": {"explain", "task", "scene", "formula", "variant"},
    "plan": TASK | {"plan", "force", "starts", "seed", "variant", "weights", "out"},
    "exact": {"exact", "task", "scene", "formula", "time_limit", "out"},
    "pretrain": {"pretrain", "seed", "epochs", "time_limit", "out", "no_cache"},
    "evaluate": TASK | {"evaluate", "seed", "layouts", "variant"},
    "resume": BUDGET | {"resume", "train_only", "no_cache"},
    "train_only": TASK
    | BUDGET
    | {"train_only", "force", "method", "mode", "seed", "randomize", "variant", "out", "weights"},
    "page": TASK | {"host", "port", "token", "load", "no_browser"},
}
"""Options that each action accepts; if several actions are given, the first one here counts."""


def chosen_action(options: Options) -> str:
    """The requested action: a key of `ALLOWED`.

    Raises:
        UserError: options that contradict each other.
    """
    given = {f.name for f in fields(options) if getattr(options, f.name) != f.default}
    action = next((name for name in ALLOWED if name in given), "page")
    if action == "plan" and "method" in given:
        raise UserError(
            "--method cannot be used with --plan: it answers by tgpo's weights, without training. "
            "Other methods are trained first, with --train-only"
        )
    for name in sorted(given - ALLOWED[action]):
        beside = ", ".join(_flag(other) for other in sorted(ALLOWED[action] - {action}))
        where = "without --train-only" if action == "page" else f"with {_flag(action)}"
        raise UserError(f"{_flag(name)} cannot be used {where}. Allowed: {beside or 'nothing'}")
    if options.task is not None and options.scene is not None:
        raise UserError("--task and --scene cannot be combined; give one of them")
    if options.load is not None and (options.task is not None or options.scene is not None):
        raise UserError("--load brings its own scene; do not combine it with --task or --scene")
    if options.layouts is not None and not 1 <= options.layouts <= MOST_LAYOUTS:
        raise UserError(f"--layouts: {options.layouts} must be from 1 to {MOST_LAYOUTS}")
    if options.starts is not None and not 1 <= options.starts <= MOST_STARTS:
        raise UserError(f"--starts: {options.starts} must be from 1 to {MOST_STARTS}")
    if options.exact and options.time_limit is not None and not 0 < options.time_limit <= 1e6:
        raise UserError(f"--time-limit: {options.time_limit} must be above 0 and at most 1e6")
    if not 0 <= options.port < 2**16:
        raise UserError(f"--port: {options.port} must be from 0 to 65535")
    return action


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")
