"""Explains in words why a schedule leaves too little time to travel."""

import math

import numpy as np

from core.stl import to_text
from core.task.task import Task
from core.task.windows import TightLeg


def leg_text(task: Task, legs: TightLeg, at: tuple[int, ...] = ()) -> str:
    """Say what a leg lacks: `A1 to A2 needs 23 steps, has 10`.

    If the leg is long enough, the schedule violates a requirement on repeated visits.

    Args:
        task: the grounded task.
        legs: of one schedule, or of an array of them.
        at: index of the schedule in the arrays.
    """
    leg = TightLeg(*(np.asarray(entry)[at] for entry in legs))
    goals = [to_text(goal.predicate) for goal in task.grounding.subgoals]
    names = ("the start" if leg.source < 0 else goals[int(leg.source)], goals[int(leg.target)])
    if leg.conflict:
        return f"{names[0]} and {names[1]} are due at once, but do not meet"
    if leg.barred:
        return f"{names[1]} is due while it is forbidden"
    has, needs = math.floor(leg.available), math.ceil(leg.needed)
    if needs <= has:
        return "the visits are too few or too far apart"
    return f"{names[0]} to {names[1]} needs {needs} steps, has {has}"
