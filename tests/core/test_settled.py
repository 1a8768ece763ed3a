"""Times of a trace that had no schedule."""

import numpy as np

from core.settled import retimed, times_met
from core.stl import to_text
from tests.core.toy import CENTERS, disc_margins, toy_task


def trace(*names: str | None) -> np.ndarray:
    """Margins [17, 4] of a robot that jumps from disc to disc; None is the origin."""
    places = [(0.0, 0.0) if name is None else CENTERS[name] for name in names]
    return disc_margins(np.array(places + [(0.0, 0.0)] * (17 - len(places))))


def test_the_steps_at_which_goals_were_reached():
    task = toy_task("F_[0:9](B & F_[1:6](A)) & F_[2:12](C)")
    met = times_met(task, trace(None, "C", None, "B", None, "A", None, "C"))
    starts = {
        to_text(leaf.predicate): start
        for leaf, start, _ in task.grounding.decomposition.active_tasks(met)
    }
    assert starts == {"B": 3, "A": 5, "C": 7}


def test_what_was_never_reached_is_at_its_earliest():
    assert times_met(toy_task("F_[2:12](C)"), trace("A")) == (2,)


def test_only_missed_times_are_replaced():
    task = toy_task("F_[0:9](B) & F_[2:12](C)")
    goals = {to_text(leaf.predicate): leaf for leaf in task.grounding.subgoals}
    b, c = (goals[name].start.variables[0] for name in "BC")
    margins = trace(None, "B", None, None, "B", "C")
    given = [0, 0]
    given[b], given[c] = 4, 10
    wanted = [0, 0]
    wanted[b], wanted[c] = 4, 5
    assert retimed(task, tuple(given), margins) == tuple(wanted)
    given[c] = 5
    assert retimed(task, tuple(given), margins) == tuple(wanted)
