"""One thing that is wrong with a robot."""

from typing import NamedTuple


class Finding(NamedTuple):
    """What `check_robot` reports.

    Attributes:
        member: the robot's member that is at fault.
        message: what is wrong with it, what was found and what is wanted.
    """

    member: str
    message: str

    def __str__(self) -> str:
        return f"{self.member}: {self.message}"
