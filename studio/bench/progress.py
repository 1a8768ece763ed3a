"""What a benchmark shows while it runs: a bar on a terminal, a JSON line a run anywhere else."""

import json
import sys
from types import TracebackType

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from studio.bench.runner import Outcome

WINDOW = 24 * 3600.0
"""Seconds of runs from which the time left is estimated."""


class Reporter:
    """Told of each run as it ends; use it in a `with` statement."""

    def __init__(self, total: int, done: int):
        """Begin.

        Args:
            total: runs of the matrix.
            done: of them, those that are in the store.
        """
        self._bar = sys.stdout.isatty()
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left:"),
            TimeRemainingColumn(),
            console=Console(),
            speed_estimate_period=WINDOW,
            disable=not self._bar,
        )
        self._task = self._progress.add_task("runs", total=total, completed=done)

    def __call__(self, outcome: Outcome) -> None:
        """A run has ended."""
        self._progress.advance(self._task)
        if not self._bar:
            print(json.dumps({"run": outcome.job.key, "failure": outcome.failure}), flush=True)
        elif outcome.failure:
            self._progress.console.print(
                f"{outcome.job.key}: {outcome.failure}", markup=False, highlight=False
            )

    def __enter__(self) -> "Reporter":
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._progress.stop()
