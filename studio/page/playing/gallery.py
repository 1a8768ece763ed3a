"""Rollouts on screen beside the one that plays: ghosts, and a sample of random starts."""

from dataclasses import dataclass

from studio.runs.recording import Recording

MOST = 6
"""Maximum number of ghosts."""

COLORS = ("#f76707", "#1971c2", "#9c36b5", "#2b8a3e", "#e03131", "#0c8599")
"""Colours of the ghosts; the first free one is used next."""


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
    """The last rollouts that were requested; values are replaced, never mutated."""

    def __init__(self) -> None:
        self.ghosts: tuple[Ghost, ...] = ()
        self.sample: tuple[Recording, ...] = ()
        """Rollouts from random starts, the critic choosing each one's schedule."""

    def add(self, recording: Recording) -> None:
        """Add a rollout; drop those of other tasks, and the oldest if there are too many."""
        kept = [ghost for ghost in self.ghosts if ghost.recording.task is recording.task]
        if any(ghost.recording is recording for ghost in kept):
            return
        kept = kept[-(MOST - 1) :]
        used = [ghost.color for ghost in kept]
        color = next(color for color in COLORS if color not in used)
        self.ghosts = (*kept, Ghost(recording, color))

    def clear(self) -> None:
        """Remove all rollouts."""
        self.ghosts, self.sample = (), ()

    @property
    def successes(self) -> int:
        """How many of the sample satisfy the formula."""
        return sum(recording.satisfied for recording in self.sample)
