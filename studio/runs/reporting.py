"""What a headless run shows: a progress bar on a terminal, JSON lines anywhere else."""

import json
import math
import sys
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

from core.methods.training import TrainingConfig


class Reporter(Protocol):
    """Shows the progress of a run."""

    def begin(self, training: TrainingConfig, epochs: int, change: int | None = None) -> None:
        """A run begins.

        Args:
            training: the budget.
            epochs: epochs done before.
            change: epoch after which epochs take longer, None if they do not.
        """
        ...

    def report(self, metrics: dict[str, Any]) -> None:
        """Show an epoch (a line of metrics.jsonl)."""
        ...

    def note(self, text: str) -> None:
        """Show a message to the user; never on standard output, where the results go."""
        ...

    def restore(self) -> None:
        """Leave the terminal as it was."""
        ...


def make_reporter() -> Reporter:
    """The reporter that suits standard output."""
    return BarReporter(Console()) if sys.stdout.isatty() else LineReporter()


class LineReporter:
    """One JSON line an epoch."""

    def begin(self, training: TrainingConfig, epochs: int, change: int | None = None) -> None:
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
    """A bar with epoch, success and the maximum time left."""

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

    def begin(self, training: TrainingConfig, epochs: int, change: int | None = None) -> None:
        """Show the bar; the first epoch waits for the compilation."""
        self._training, self._first, self._change = training, epochs, change
        self._began: float | None = None
        self._task = self._progress.add_task("compiling", total=1.0, epoch="", success="-", left="")
        self._progress.start()

    def report(self, metrics: dict[str, Any]) -> None:
        """Move the bar."""
        training, epoch, seconds = self._training, metrics["epoch"], metrics["train_seconds"]
        if self._began is None:
            self._began = seconds
        if epoch == self._change:  # what was timed so far says nothing of what follows
            self._first, self._began = epoch - 1, seconds
        if metrics["success_rate"] is not None:
            self._progress.update(self._task, success=f"{100 * metrics['success_rate']:.1f} %")
        self._progress.update(
            self._task,
            description="training",
            completed=max(epoch / training.epochs, seconds / training.time_limit),
            epoch=f"epoch {epoch}/{training.epochs}",
            left=self._left(epoch, seconds),
        )
        if metrics["diverged"]:
            self.note(
                f"epoch {epoch}: {metrics['diverged']} simulations diverged and count as failed"
            )

    def _left(self, epoch: int, seconds: float) -> str:
        """The maximum time left; epochs left while epochs of another pace are still to come."""
        training, change = self._training, self._change
        if change is not None and epoch <= change < training.epochs:
            return f"at most {training.epochs - epoch} epochs left"
        left = seconds_left(training, epoch, seconds, self._first, self._began or 0.0)
        return f"at most {_duration(left)} left"

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
    """Maximum training time left: to the last epoch at the current pace, or to the time limit.

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
