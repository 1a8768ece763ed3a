"""What a headless run shows: a progress bar on a terminal, JSON lines anywhere else."""

import json
import math
import sys
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

from core.training import TrainingConfig


class Reporter(Protocol):
    """Shows a run while it goes on."""

    def begin(self, training: TrainingConfig, epochs: int) -> None:
        """A run begins, with that many epochs done before."""
        ...

    def report(self, metrics: dict[str, Any]) -> None:
        """Show an epoch (a line of metrics.jsonl)."""
        ...

    def note(self, text: str) -> None:
        """Tell something to the person; never on standard output, where the results go."""
        ...

    def restore(self) -> None:
        """Leave the terminal as it was."""
        ...


def make_reporter() -> Reporter:
    """The reporter that suits standard output."""
    return BarReporter(Console()) if sys.stdout.isatty() else LineReporter()


class LineReporter:
    """One JSON line an epoch."""

    def begin(self, training: TrainingConfig, epochs: int) -> None:
        """Say nothing: every line is a report."""

    def report(self, metrics: dict[str, Any]) -> None:
        """Print the epoch."""
        print(json.dumps(metrics), flush=True)

    def note(self, text: str) -> None:
        """Print on standard error."""
        print(text, file=sys.stderr, flush=True)

    def restore(self) -> None:
        """Nothing was changed."""


class BarReporter:
    """A bar with epoch, success and the time that is left at most."""

    def __init__(self, console: Console):
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[epoch]}"),
            TextColumn("success {task.fields[success]}"),
            TextColumn("{task.fields[left]}"),
            console=console,
            transient=True,
        )

    def begin(self, training: TrainingConfig, epochs: int) -> None:
        """Show the bar; the first epoch waits for the compilation."""
        self._training, self._first = training, epochs
        self._began: float | None = None
        self._task = self._progress.add_task("compiling", total=1.0, epoch="", success="-", left="")
        self._progress.start()

    def report(self, metrics: dict[str, Any]) -> None:
        """Move the bar."""
        training, epoch, seconds = self._training, metrics["epoch"], metrics["train_seconds"]
        began = self._began = seconds if self._began is None else self._began
        left = seconds_left(training, epoch, seconds, self._first, began)
        if metrics["success_rate"] is not None:
            self._progress.update(self._task, success=f"{100 * metrics['success_rate']:.1f} %")
        self._progress.update(
            self._task,
            description="training",
            completed=max(epoch / training.epochs, seconds / training.time_limit),
            epoch=f"epoch {epoch}/{training.epochs}",
            left=f"at most {_duration(left)} left",
        )
        if metrics["diverged"]:
            self.note(
                f"epoch {epoch}: {metrics['diverged']} simulations broke down and have failed"
            )

    def note(self, text: str) -> None:
        """Print above the bar."""
        self._progress.console.print(text, markup=False, highlight=False)

    def restore(self) -> None:
        """Remove the bar and show the cursor."""
        self._progress.stop()
        self._progress.console.show_cursor(True)


def seconds_left(
    training: TrainingConfig, epoch: int, seconds: float, first: int, began: float
) -> float:
    """Training time left at most: to the last epoch at the present pace, or to the time limit.

    Args:
        training: the budget.
        epoch: epochs done.
        seconds: training time so far.
        first: epochs that were done when this process began.
        began: training time at the end of this process's first epoch.
    """
    timed = epoch - first - 1  # epochs between `began` and now
    pace = (seconds - began) / timed if timed > 0 else seconds / epoch
    return max(0.0, min((training.epochs - epoch) * pace, training.time_limit - seconds))


def _duration(seconds: float) -> str:
    minutes, rest = divmod(math.ceil(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
