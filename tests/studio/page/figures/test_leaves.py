import pytest

from core.monitor import LeafStatus
from studio.page.figures.leaves import joint_status, leaf_style
from studio.page.figures.tree import leaves, tree_svg
from studio.page.panels.tree import leaf_regions
from tests.studio.runs.test_recording import GOOD, recorded

PENDING, HOLDING, MET, VIOLATED = (
    LeafStatus.PENDING,
    LeafStatus.HOLDING,
    LeafStatus.MET,
    LeafStatus.VIOLATED,
)


@pytest.mark.parametrize(
    ("statuses", "joint"),
    [([MET, MET], MET), ([MET, HOLDING], HOLDING), ([PENDING, VIOLATED, MET], VIOLATED)],
)
def test_a_leaf_is_violated_with_the_first_and_met_with_the_last(statuses, joint):
    assert joint_status(statuses) is joint


def test_every_leaf_of_the_tree_can_be_coloured(linear_task):
    decomposition = linear_task.grounding.decomposition
    drawn = tree_svg(decomposition, 'onpointerdown="go()"')
    for tasks in leaves(decomposition):
        assert f'data-tasks="{",".join(map(str, tasks))}" onpointerdown="go()"' in drawn
    assert sorted(task for tasks in leaves(decomposition) for task in tasks) == list(
        range(len(decomposition.tasks))
    )


def test_colours_follow_the_rollout(linear_task):
    recording = recorded(linear_task, GOOD, crash=30)
    decomposition = linear_task.grounding.decomposition
    before, after = (leaf_style(decomposition, recording.status_at(p)) for p in (10.9, 1e9))
    assert before.count("#b2f2bb") == 0
    assert before.count("#ffc9c9") == 0
    assert after.count("#b2f2bb") == 3
    assert after.count("#ffc9c9") == 1


def test_a_leaf_names_its_regions(linear_task):
    decomposition = linear_task.grounding.decomposition
    found = [leaf_regions(decomposition, ",".join(map(str, t))) for t in leaves(decomposition)]
    assert found == [("A1",), ("A2",), ("A3",), ("B1", "B2", "B3", "B4", "B5")]
    for nonsense in ("", "x", "99", "-1", "1;2", "99999999"):
        assert leaf_regions(decomposition, nonsense) == ()
