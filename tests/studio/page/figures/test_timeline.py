import xml.etree.ElementTree as ET

import numpy as np
import pytest

from core.decompose import Kind
from studio.page.figures.timeline import grouped, runs, timeline_svg
from studio.runs.recording import Outcome, Recording


def outcome(margin, start, end, kind=Kind.STAY, predicate="A"):
    return Outcome("Subgoal 1", predicate, kind, start, end, np.asarray(margin, float))


@pytest.mark.parametrize(
    ("margin", "expected"),
    [
        ([1, 1, 1, 1, 1], [(1, 3, True)]),
        ([1, -1, -1, 0, 1], [(1, 2, False), (3, 3, True)]),
        ([-1, -1, -1, -1, 1], [(1, 3, False)]),
    ],
)
def test_runs_cover_the_window(margin, expected):
    assert runs(outcome(margin, 1, 3)) == expected


def test_broken_invariants_get_a_row_of_their_own():
    fine = [outcome([1] * 5, 0, 4, Kind.INVARIANT, name) for name in "BC"]
    broken = outcome([1, 1, -1, 1, 1], 0, 4, Kind.INVARIANT, "D")
    assert grouped([fine[0], broken, fine[1]]) == [fine, [broken]]


def test_subgoals_never_share_a_row():
    assert len(grouped([outcome([1] * 5, 0, 4), outcome([1] * 5, 0, 4)])) == 2


def test_the_drawing_is_well_formed(linear_task):
    outcomes = (outcome([1] * 6, 0, 2), outcome([1, 1, -1, 1, 1, 1], 1, 5, predicate="<b>"))
    states, actions, margins = np.zeros((6, 2)), np.zeros((5, 2)), np.zeros((6, 8))
    recording = Recording(
        linear_task, (1, 2, 3), states, actions, margins, np.zeros((6, 3)), -1.0, outcomes
    )
    root = ET.fromstring(timeline_svg(recording))
    colors = [n.attrib["fill"] for n in root.iter() if n.tag.endswith("rect")]
    assert colors == ["#2b8a3e", "#2b8a3e", "#c92a2a", "#2b8a3e"]


def test_moves_are_marked(linear_task):
    states, actions, margins = np.zeros((6, 2)), np.zeros((5, 2)), np.zeros((6, 8))
    outcomes = (outcome([1] * 6, 0, 2),)
    recording = Recording(
        linear_task, (1,), states, actions, margins, np.zeros((6, 3)), 1.0, outcomes, (2, 4)
    )
    root = ET.fromstring(timeline_svg(recording))
    marks = [node for node in root.iter() if node.attrib.get("class") == "tg-moved"]
    assert [mark[0].text for mark in marks] == [
        "the robot was moved at step 2",
        "the robot was moved at step 4",
    ]
