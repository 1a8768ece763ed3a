"""The role of a region in a formula, derived from the decomposition."""

from enum import Enum

from core.decompose import Decomposition, Kind, Subtask
from core.stl import literals


class Role(Enum):
    """How a region is drawn."""

    GOAL = "goal"
    OBSTACLE = "obstacle"
    DOOR = "door"
    """Must be avoided for a time that the schedule decides."""
    UNUSED = "unused"


def roles(names: tuple[str, ...], decomposition: Decomposition | None) -> dict[str, Role]:
    """Role of each region; a region that is a goal somewhere is a goal."""
    found = dict.fromkeys(names, Role.UNUSED)
    if decomposition is None:
        return found
    for task in decomposition.tasks:
        for name, positive in literals(task.predicate):
            role = _role(task, positive)
            if _rank(role) > _rank(found.get(name, Role.UNUSED)):
                found[name] = role
    return found


def _rank(role: Role) -> int:
    return (Role.UNUSED, Role.DOOR, Role.OBSTACLE, Role.GOAL).index(role)


def _role(task: Subtask, positive: bool) -> Role:
    if positive:
        return Role.GOAL
    fixed = task.start.variables == task.end.variables
    return Role.OBSTACLE if task.kind is Kind.INVARIANT and fixed else Role.DOOR
