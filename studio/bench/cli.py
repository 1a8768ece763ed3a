"""The command `tgpo-bench`: run the trainings of a file, report on them, and merge stores."""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from core.errors import UserError
from studio.bench.shipped import shipped_matrices

BAD_INPUT = 2
"""Exit status of arguments or files that cannot be used."""

FAILED = 1
"""Exit status where runs have failed; they are tried again the next time."""

MOST_PROCESSES = 256

Asked = Annotated[
    str,
    tyro.conf.arg(
        metavar="NAME|FILE.toml",
        help=f"One of {', '.join(shipped_matrices())} (docs/bench.md), or a file of one's own "
        "(studio/bench/matrix.py).",
    ),
]
Where = Annotated[Path, tyro.conf.arg(metavar="DIR")]
Origins = Annotated[
    tyro.conf.Positional[tuple[Path, ...]],
    tyro.conf.arg(metavar="DIR|FILE.parquet ...", help_behavior_hint=""),
]


@dataclass(frozen=True)
class RunOptions:
    """Run what a file asks for, except what is finished already."""

    matrix: tyro.conf.Positional[Asked]
    out: Where
    """Folder of the store; runs of several files may share it."""
    processes: Annotated[int | None, tyro.conf.arg(metavar="INT", aliases=["--jobs"])] = None
    """Runs at the same time, each kept to its share of the cores; one if nothing is said, on a
    cluster as many as it has cores."""
    cpu_budgets: bool = False
    """Take budgets of seconds as seconds of one core, for a machine that does other things."""
    ray: Annotated[str | None, tyro.conf.arg(metavar="ADDRESS")] = None
    """Address of a Ray cluster that carries out the runs; `local` begins one on this machine."""


@dataclass(frozen=True)
class ReportOptions:
    """Write DIR/report/index.html, its pictures and summary.json."""

    folder: tyro.conf.Positional[Where]
    """Folder of the store."""
    docs: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder in which benchmarks.md, benchmarks.json and benchmarks.parquet are written, too."""


@dataclass(frozen=True)
class MergeOptions:
    """Add runs of other stores to one, those that it lacks."""

    origins: Origins
    """Folders of stores, or tables such as docs/benchmarks.parquet."""
    out: Where
    """Folder of the store, which is made if it is not there."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = tyro.extras.subcommand_cli_from_dict(
        {"run": RunOptions, "report": ReportOptions, "merge": MergeOptions},
        prog="tgpo-bench",
        args=arguments,
    )
    try:
        match options:
            case RunOptions():
                return _run(options)
            case ReportOptions():
                return _report(options)
            case _:
                return _merge(options)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("aborted; the same command goes on with what is missing", file=sys.stderr)
        return 130


def _run(options: RunOptions) -> int:
    if options.processes is not None and not 1 <= options.processes <= MOST_PROCESSES:
        raise UserError(f"--processes: {options.processes} must be from 1 to {MOST_PROCESSES}")
    from studio.bench.cluster import run_on_cluster  # noqa: PLC0415
    from studio.bench.matrix import load_matrix, on_processor  # noqa: PLC0415
    from studio.bench.progress import Reporter  # noqa: PLC0415
    from studio.bench.runner import run_jobs  # noqa: PLC0415
    from studio.bench.store import Store  # noqa: PLC0415

    matrix, store = load_matrix(options.matrix), Store(options.out)
    jobs = [on_processor(job) for job in matrix.jobs] if options.cpu_budgets else matrix.jobs
    done = sum(store.finished(job.key) for job in jobs)
    with Reporter(len(jobs), done) as told:
        if options.ray is None:
            failed = run_jobs(store, jobs, processes=options.processes or 1, told=told)
        else:
            failed = run_on_cluster(
                store, jobs, address=options.ray, processes=options.processes, told=told
            )
    counts = {"runs": len(jobs), "already_finished": done, "failed": len(failed)}
    print(json.dumps({"matrix": matrix.title, **counts, "out": str(options.out)}))
    return FAILED if failed else 0


def _report(options: ReportOptions) -> int:
    from studio.bench.report import write_docs, write_report  # noqa: PLC0415
    from studio.bench.store import Store  # noqa: PLC0415

    store = Store(options.folder)
    page = write_report(store)
    print(page)
    if options.docs is not None:
        print(write_docs(page.parent / "summary.json", options.docs, store.rows()))
    return 0


def _merge(options: MergeOptions) -> int:
    from studio.bench.runner import alone  # noqa: PLC0415
    from studio.bench.store import Store  # noqa: PLC0415

    store = Store(options.out)
    if not options.origins:
        raise UserError("merge: name a store's folder, or a table of runs")
    store.open()
    with alone(store.folder):
        added = sum(store.merge(origin) for origin in options.origins)
    print(json.dumps({"added": added, "runs": len(store), "out": str(options.out)}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
