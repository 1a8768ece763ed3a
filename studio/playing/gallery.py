"""Rollouts kept on screen beside the one that plays: ghosts, and a sample of random starts."""

from dataclasses import dataclass

from studio.playing.recording import Recording

MOST = 6
"""Ghosts that are kept."""

COLORS = ("#f76707", "#1971c2", "#9c36b5", "#2b8a3e", "#e03131", "#0c8599")
"""Of the ghosts, the one that goes longest unused next."""


@dataclass(frozen=True, eq=False)
class Ghost:
    """A rollout with its colour."""

    recording: Recording
    color: str

    @property
    def label(self) -> str:
        """Its schedule: `t1 = 3, t2 = 40`."""
        variables = self.recording.task.grounding.decomposition.variables
        pairs = zip(variables, self.recording.schedule, strict=True)
        return ", ".join(f"{variable.name} = {value}" for variable, value in pairs) or "rollout"


class Gallery:
    """The last rollouts that were asked for; what changes is replaced, never altered."""

    def __init__(self) -> None:
        self.ghosts: tuple[Ghost, ...] = ()
        self.sample: tuple[Recording, ...] = ()
        """Rollouts from random starts, the critic choosing each one's schedule."""

    def add(self, recording: Recording) -> None:
        """Keep a rollout; the oldest goes when there are too many, and all of another task."""
        kept = [ghost for ghost in self.ghosts if ghost.recording.task is recording.task]
        if any(ghost.recording is recording for ghost in kept):
            return
        kept = kept[-(MOST - 1) :]
        used = [ghost.color for ghost in kept]
        color = next(color for color in COLORS if color not in used)
        self.ghosts = (*kept, Ghost(recording, color))

    def clear(self) -> None:
        """Keep none."""
        self.ghosts, self.sample = (), ()

    @property
    def successes(self) -> int:
        """How many of the sample satisfy the formula."""
        return sum(recording.satisfied for recording in self.sample)
