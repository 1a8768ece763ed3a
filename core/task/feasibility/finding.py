"""One thing that stands in the way of a mission."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Severity(Enum):
    """How sure a finding is."""

    PROVED = "proved"
    """No behaviour of the robot, from any start, satisfies the formula."""
    WARNING = "warning"
    """It may still be possible: for a part of the starts, or faster than planned."""


@dataclass(frozen=True)
class Finding:
    """What a user should know before training.

    Attributes:
        severity: Whether it is proved.
        words: One sentence, without its full stop.
        tasks: State formulas that it is about, as text.
    """

    severity: Severity
    words: str
    tasks: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{'impossible' if self.proved else 'warning'}: {self.words}"

    @property
    def proved(self) -> bool:
        """Whether the mission is impossible for certain."""
        return self.severity is Severity.PROVED


def refusal(findings: Iterable[Finding]) -> str:
    """Why a mission is not trained on, in words; empty if nothing is proved."""
    proved = [finding.words for finding in findings if finding.proved]
    return "impossible: " + "; ".join(proved) if proved else ""
