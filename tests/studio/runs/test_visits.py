"""How many visits are planned: none of two places at once, and no more than needed."""

from dataclasses import replace

import pytest

from scenes import load_task
from studio.runs.tasks import build_task
from studio.runs.visits import ENOUGH, room_for


def test_two_places_are_not_due_at_once(disk_cache):
    """With the least visits both would be due at step 60, and only then."""
    text = "G_[0:60](F_[0:60](A1)) & G_[0:60](F_[0:60](A2))"
    least = build_task(load_task("linear-07"), text, visits_extra=0)
    task = build_task(load_task("linear-07"), text)
    assert {(v.low, v.high) for v in least.grounding.decomposition.variables} == {(60, 60)}
    assert task.grounding.decomposition.visits_extra == 1
    assert room_for(least.problem).share == 0
    assert room_for(task.problem).share >= ENOUGH


def test_visits_that_leave_no_time_are_warned_of(disk_cache):
    """Two places a dozen steps apart, each of them every twenty steps."""
    text = "G_[30:80](F_[0:{0}](A1)) & G_[30:80](F_[0:{0}](A2))"
    hurried = build_task(load_task("linear-07"), text.format(20))
    note = hurried.notes[-1]
    assert note.startswith("at planning speed no schedule was found that leaves time")
    assert "from A1 to A2" in note or "from A2 to A1" in note
    assert not build_task(load_task("linear-07"), text.format(60)).notes


@pytest.mark.parametrize("text", ["G_[0:60](F_[0:60](A1))", "F_[0:60](A1) & F_[0:60](A2)"])
def test_no_more_visits_than_needed(disk_cache, text):
    task = build_task(load_task("linear-07"), text)
    assert task.grounding.decomposition.visits_extra == 0


def test_fifteen_alternatives_and_nine_times_are_a_mission(disk_cache):
    scene = load_task("linear-08")
    wide = " | ".join(f"(A{a} & !B{b})" for a in (1, 2, 3) for b in range(1, 6))
    text = f"F_[0:90]({wide}) & " + " & ".join(f"F_[{i}:90](A1)" for i in range(9))
    task = build_task(replace(scene, formula=text))
    assert task.grounding.sizes.variables == 16 and len(task.grounding.subgoals) == 10
