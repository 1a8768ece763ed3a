"""The playhead of a recording."""

from studio.runs.recording import Recording

SPEEDS = (1, 2, 4, 8)
"""Playback speeds, relative to real time."""


class Player:
    """Moves a playhead over a recording; the views draw its position."""

    def __init__(self) -> None:
        self.recording: Recording | None = None
        self.position = 0.0
        """Steps since the start, fractional."""
        self.playing = False
        self.speed = 4
        self._last: float | None = None

    def load(self, recording: Recording | None, step: int = 0) -> None:
        """Play a recording from a step on."""
        self.recording, self.position = recording, float(step)
        self.playing, self._last = recording is not None, None

    def seek(self, step: float) -> None:
        """Pause at a step."""
        self.playing = False
        if self.recording is not None:
            self.position = min(max(float(step), 0.0), float(self.recording.steps))

    def step(self, steps: int) -> None:
        """Pause some whole steps forward or back."""
        self.seek(int(self.position) + steps)

    def toggle(self) -> None:
        """Play or pause; at the end, play again from the start."""
        if self.recording is None:
            return
        if not self.playing and self.position >= self.recording.steps:
            self.position = 0.0
        self.playing, self._last = not self.playing, None

    def restart(self) -> None:
        """Play from the start."""
        self.load(self.recording)

    def tick(self, now: float) -> None:
        """Move on to monotonic time `now` [s]; late frames are skipped."""
        if self.recording is None or not self.playing:
            return
        if self._last is not None:
            self.position += (now - self._last) * self.speed / self.recording.task.robot.dt
        self._last = now
        if self.position >= self.recording.steps:
            self.position, self.playing = float(self.recording.steps), False
