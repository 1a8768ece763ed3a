"""The curves of a run as TensorBoard events.

tensorboardX's own `SummaryWriter` writes in a background thread that dies, and then blocks its
caller, when the disk is full; its event writer is used directly instead.
"""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tensorboardX.event_file_writer import EventsWriter
from tensorboardX.proto.event_pb2 import (
    Event,  # pyright: ignore[reportAttributeAccessIssue]
    SessionLog,  # pyright: ignore[reportAttributeAccessIssue]
)
from tensorboardX.summary import scalar

CURVES = {
    "batch_success": "success/episodes",
    "success_rate": "success/evaluation",
    "robustness_mean": "robustness/evaluation",
    "batch_return": "reward/step",
    "diverged": "simulations/diverged",
    "train_seconds": "time/train_seconds",
}
"""TensorBoard's names of the metrics."""


class EventLog:
    """An event file; every time a run is opened, a new one is added."""

    def __init__(self, folder: Path, epochs: int):
        """Events of epochs after `epochs` in older files are discarded."""
        folder.mkdir(parents=True, exist_ok=True)
        self._writer = EventsWriter(str(folder / "events"), f".{epochs:07d}")
        if epochs:
            start = SessionLog(status=SessionLog.START)
            self._writer.write_event(Event(step=epochs + 1, session_log=start))

    def write(self, metrics: Mapping[str, Any]) -> None:
        """Add the curves' points of an epoch.

        Raises:
            OSError: the disk is full.
        """
        for name, curve in CURVES.items():
            if metrics[name] is not None:
                event = Event(step=metrics["epoch"], summary=scalar(curve, metrics[name]))
                event.wall_time = time.time()
                self._writer.write_event(event)
        if metrics["success_rate"] is not None:
            self._writer.flush()

    def close(self) -> None:
        """Flush and close the file."""
        self._writer.close()
