"""What a benchmark runs: products of tasks, methods, variants, horizons and seeds, in a TOML file.

    format = 1
    title = "..."

    [variants.no-pruning]          # hyper-parameters that differ from the method's preset
    prune = false

    [[runs]]                       # as many products as one likes
    tasks = ["linear", "panda-08"] # a robot's name stands for its ten tasks
    methods = ["tgpo-star"]        # or ["all"]; "exact": the exact planner, for comparison
    modes = ["studio"]             # studio, paper
    variants = ["default", "no-pruning"]
    weights = ["none"]             # none, shipped
    horizons = [50, 100]           # [steps]; none: the scene's. All intervals are stretched alike
    seeds = [1007, 1008]
    epochs = 60                    # and seconds, cpu_seconds, target, evaluate_every: the budget
    critic_samples = 4096          # schedules on which the critic is held against robustness

`seconds` are wall-clock, `cpu_seconds` those of the processor, summed over the threads of a run: a
machine that does other things too leaves them as they are. What is used up first ends a run.

The files that come with the program are named without their ending: `smoke`, `comparison`, ...
"""

import hashlib
import re
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from core.documents import typed
from core.errors import UserError, allowed
from core.methods import METHODS
from envs import ENVS
from scenes import demo_names, load_task, task_names
from scenes.scene import LARGEST_HORIZON
from scenes.toml import read_toml
from studio.bench.shipped import matrices_folder, shipped_matrices
from studio.runs.config import make_config
from studio.runs.json_documents import algorithm_document, read_algorithm

FORMAT = 1
"""Version of the files."""

MOST_RUNS = 20_000
"""Of one file."""

DEFAULT = "default"
"""The variant that is the preset itself."""

ALL = "all"

PEERS = ("sb3-ppo", "sbx-ppo")
"""Other libraries' learners, which may be named beside the methods."""

BESIDE = (*PEERS, "exact", "rtamt", "stljax", "sentil")
"""All that may be named; `studio.bench.others` knows them."""

Names = Annotated[tuple[str, ...], Meta(min_length=1)]


class _Runs(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """A table [[runs]]: one product."""

    tasks: Names
    methods: Names = ("tgpo-star",)
    modes: Annotated[tuple[Literal["studio", "paper"], ...], Meta(min_length=1)] = ("studio",)
    variants: Names = (DEFAULT,)
    weights: Annotated[tuple[Literal["none", "shipped"], ...], Meta(min_length=1)] = ("none",)
    horizons: tuple[Annotated[int, Meta(ge=1, le=LARGEST_HORIZON)], ...] = ()
    seeds: Annotated[tuple[Annotated[int, Meta(ge=0, le=2**31 - 1)], ...], Meta(min_length=1)]
    epochs: Annotated[int, Meta(ge=1, le=10**6)] | None = None
    seconds: Annotated[float, Meta(gt=0, le=10**7)] | None = None
    cpu_seconds: Annotated[float, Meta(gt=0, le=10**7)] | None = None
    target: Annotated[float, Meta(gt=0, le=10**6)] | None = None
    evaluate_every: Annotated[int, Meta(ge=1, le=10**6)] | None = None
    critic_samples: Annotated[int, Meta(ge=0, le=10**5)] = 0


class _File(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """A whole file."""

    format: int
    title: str
    variants: dict[str, dict[str, Any]] = {}
    runs: Annotated[list[_Runs], Meta(min_length=1)]


class Job(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One training, fully described: the same job gives the same result."""

    task: str
    method: str
    mode: str
    variant: str
    changes: dict[str, Any]
    """Hyper-parameters that differ from the preset; `mode` is a table of its own."""
    weights: str
    horizon: int | None
    """[steps]; None for the scene's."""
    seed: int
    epochs: int | None
    seconds: float | None
    """Wall-clock [s], compilation apart."""
    cpu_seconds: float | None = None
    """Of the processor [s], compilation apart."""
    target: float | None
    evaluate_every: int | None
    critic_samples: int = 0
    """Random schedules whose score and robustness are kept, with a map of the critic."""

    @property
    def key(self) -> str:
        """A name for files: readable, and another one for every other job."""
        digest = hashlib.sha256(msgspec.json.encode(self, order="deterministic")).hexdigest()[:10]
        parts = (self.task, self.method, self.mode, self.variant, self.weights)
        horizon = "" if self.horizon is None else f"-T{self.horizon}"
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", "-".join(parts))
        return f"{name}{horizon}-{self.seed}-{digest}"


class Matrix(msgspec.Struct, frozen=True):
    """The jobs of a file, in its order, none twice."""

    title: str
    jobs: tuple[Job, ...]


def on_processor(job: Job) -> Job:
    """The job with its budget of seconds, if it has one, in seconds of the processor."""
    if job.seconds is None or job.method in BESIDE and job.method not in PEERS:
        return job
    return msgspec.structs.replace(job, seconds=None, cpu_seconds=job.seconds)


def load_matrix(name: str) -> Matrix:
    """Read a shipped file by its name, or a file of one's own by its path.

    Raises:
        UserError: no such file, or one that is malformed; the message names file and field.
    """
    if name in shipped_matrices():
        text = (matrices_folder() / f"{name}.toml").read_text(encoding="utf-8")
        return parse_matrix(text, f"{name}.toml")
    if not name.endswith(".toml"):
        names = [*shipped_matrices(), "the path of a .toml file"]
        raise UserError(f"matrix: unknown {name!r}. {allowed(name, names)}")
    try:
        return parse_matrix(Path(name).read_text(encoding="utf-8"), name)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise UserError(f"{name}: cannot be read: {reason}") from error


def parse_matrix(text: str, where: str) -> Matrix:
    """The jobs of a TOML text; `where` names it in errors.

    Raises:
        UserError: with the field at fault.
    """
    try:
        read = typed(read_toml(text), _File)
        if read.format != FORMAT:
            raise UserError(f"format: {read.format} is not known; this program reads {FORMAT}")
        jobs: dict[str, Job] = {}
        for number, runs in enumerate(read.runs):
            for job in _jobs(runs, read.variants, f"runs[{number}]"):
                jobs.setdefault(job.key, job)
                if len(jobs) > MOST_RUNS:
                    raise UserError(f"runs[{number}]: more than {MOST_RUNS:,} runs in all")
    except UserError as error:
        raise UserError(f"{where}: {error}") from error
    return Matrix(read.title, tuple(jobs.values()))


def _jobs(runs: _Runs, variants: dict[str, dict[str, Any]], where: str) -> Iterator[Job]:
    """The product of a table, seeds first, so that what is done early speaks of all tasks."""
    tasks, methods = _tasks(runs.tasks, where), _methods(runs.methods, where)
    known = {DEFAULT: {}} | variants
    for name in runs.variants:
        if name not in known:
            raise UserError(f"{where}.variants: unknown {name!r}. {allowed(name, known)}")
    for name, method, mode in product(runs.variants, methods, runs.modes):
        _check_variant(known[name], method, mode, f"variants.{name}")
    axes = (
        *(runs.seeds, runs.horizons or (None,), tasks, methods),
        *(runs.modes, runs.variants, runs.weights),
    )
    for seed, horizon, task, method, mode, variant, weights in product(*axes):
        yield Job(
            task=task,
            method=method,
            mode=mode,
            variant=variant,
            changes=known[variant],
            weights=weights,
            horizon=horizon,
            seed=seed,
            epochs=runs.epochs,
            seconds=runs.seconds,
            cpu_seconds=runs.cpu_seconds,
            target=runs.target,
            evaluate_every=runs.evaluate_every,
            critic_samples=runs.critic_samples,
        )


def _tasks(names: Sequence[str], where: str) -> list[str]:
    known = [*ENVS, *task_names(), *demo_names()]
    found: list[str] = []
    for name in names:
        if name not in known:
            raise UserError(f"{where}.tasks: unknown {name!r}. {allowed(name, known)}")
        found += task_names(name) if name in ENVS else [name]
    return list(dict.fromkeys(found))


def _methods(names: Sequence[str], where: str) -> list[str]:
    for name in names:
        known = [ALL, *METHODS, *BESIDE]
        if name not in known:
            raise UserError(f"{where}.methods: unknown {name!r}. {allowed(name, known)}")
    every = list(METHODS) if ALL in names else []
    return list(dict.fromkeys([*every, *(name for name in names if name != ALL)]))


def _check_variant(changes: dict[str, Any], method: str, mode: str, where: str) -> None:
    """Refuse hyper-parameters that the method does not have, before hours are spent."""
    if changes and method in BESIDE:
        raise UserError(f"{where}: {method} has no hyper-parameters here")
    if changes:
        config = make_config(load_task("linear-demo"), mode=mode, method=method, weights="none")
        changed(config.training.algorithm, changes, method, mode, where)


def changed(algorithm: Any, changes: dict[str, Any], method: str, mode: str, where: str) -> Any:
    """An algorithm with some hyper-parameters changed.

    Raises:
        UserError: a hyper-parameter that is unknown or out of bounds.
    """
    document = algorithm_document(algorithm)
    for name, value in changes.items():
        if isinstance(value, dict) and isinstance(document.get(name), dict):
            document[name] = document[name] | value
        else:
            document[name] = value
    return read_algorithm(document, method, mode, where)
