"""The task that fails most often: traces by hand."""

import numpy as np
import pytest

from core.failures import _between, _commonest, failure_text
from tests.core.toy import CENTERS, disc_margins, toy_task

STEPS = 17


def standing(*spots: str) -> np.ndarray:
    """Margins [R, STEPS, 4] of rollouts that stand in a disc each, or at the origin."""
    places = np.array([CENTERS.get(spot, (0.0, 0.0)) for spot in spots])
    return disc_margins(np.repeat(places[:, None], STEPS, axis=1))


def test_the_subgoal_that_is_never_reached():
    task = toy_task("F_[0:9](A) & F_[0:9](B) & G_[0:9](!D)")
    failure = _commonest(task, standing("A", "A", "D"), np.array([[3, 7], [5, 9], [2, 8]]))
    assert failure is not None
    assert (failure.task, failure.share, failure.step) == (1, 1.0, 8)
    assert failure_text(task, failure) == (
        "what stands in the way: Subgoal 2 (B) fails in 100% of the rollouts, "
        "usually from step 8 on"
    )


def test_an_invariant_counts_from_its_first_breach():
    task = toy_task("F_[0:9](A) & G_[2:9](!A)")
    failure = _commonest(task, standing("A", "A", "-"), np.array([[3], [4], [5]]))
    assert failure is not None
    assert (failure.task, failure.step) == (1, 2)
    assert failure.share == pytest.approx(2 / 3)


def test_only_the_chosen_branch_counts():
    task = toy_task("F_[0:9](A) | F_[0:9](B)")
    branch = [v.kind for v in task.grounding.decomposition.variables].index("branch")
    schedules = np.full((1, 3), 4)
    schedules[0, branch] = 1
    assert _commonest(task, standing("B"), schedules) is None
    schedules[0, branch] = 0
    assert _commonest(task, standing("B"), schedules) is not None


def test_numbers_that_are_not_finite_fail():
    task = toy_task("F_[0:9](A)")
    failure = _commonest(task, np.full((2, STEPS, 4), np.nan), np.array([[3], [3]]))
    assert failure is not None and failure.share == 1.0


def test_what_fails_between_the_steps_where_that_counts():
    """Past D, whose radius is 0.6 m, from one side to the other at step 5."""
    task = toy_task("F_[0:9](!A) & G_[2:9](!D)")
    x, y = CENTERS["D"]
    places = np.array([(x - 1.0, y)] * 6 + [(x + 1.0, y)] * (STEPS - 6))[None]
    given = task, disc_margins(places), np.array([[3]])
    assert _commonest(*given) is None
    failure = _commonest(*given, _between(task, places))
    assert failure is not None and (failure.task, failure.step) == (1, 5)
