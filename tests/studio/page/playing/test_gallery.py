from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from core.errors import UserError
from scenes import Region
from studio.page.panels.ghosts import sample_html
from studio.page.playing.gallery import MOST, Gallery
from studio.page.views.start import met, start_at

TASK = SimpleNamespace(
    grounding=SimpleNamespace(decomposition=SimpleNamespace(variables=[SimpleNamespace(name="t1")]))
)


def rollout(value=0, task=TASK, satisfied=True) -> Any:
    return cast(
        Any,
        SimpleNamespace(
            task=task,
            schedule=(value,),
            satisfied=satisfied,
            schedule_for=lambda other: (value,) if other is task else None,
        ),
    )


def test_the_last_rollouts_are_kept_in_colours_of_their_own():
    gallery = Gallery()
    for value in range(MOST + 3):
        gallery.add(rollout(value))
    assert [ghost.label for ghost in gallery.ghosts] == [f"t1 = {v}" for v in range(3, MOST + 3)]
    assert len({ghost.color for ghost in gallery.ghosts}) == MOST


def test_a_rollout_is_kept_once_and_another_task_starts_anew():
    gallery, one = Gallery(), rollout()
    gallery.add(one)
    gallery.add(one)
    assert len(gallery.ghosts) == 1
    gallery.add(rollout(task=SimpleNamespace(grounding=TASK.grounding)))
    assert len(gallery.ghosts) == 1
    assert gallery.ghosts[0].recording is not one


def test_a_sample_counts_its_successes():
    gallery = Gallery()
    assert sample_html(gallery) == ""
    gallery.sample = (rollout(), rollout(satisfied=False), rollout())
    assert "2 of 3 random starts" in sample_html(gallery)
    gallery.clear()
    assert gallery.sample == ()


def test_the_start_is_where_the_ray_meets_the_floor_or_passes_the_centre():
    flat = Region("s", "rectangle", (1.0, 1.0), (0.5, 0.5))
    assert met(flat, np.array([0.0, 1.0, 2.0]), np.array([0.5, 0.0, -1.0])) == (1.0, 1.0)
    ball = Region("s", "sphere", (0.0, 0.0, 1.0), (0.5,))
    passing = met(ball, np.array([5.0, 0.2, 1.0]), np.array([-1.0, 0.0, 0.0]))
    np.testing.assert_allclose(passing, (0.0, 0.2, 1.0), atol=1e-9)


def test_a_click_beside_the_initial_set_is_refused():
    asked = []
    session = cast(
        Any,
        SimpleNamespace(
            choosing_start=True,
            subject=SimpleNamespace(task=TASK),
            player=SimpleNamespace(recording=rollout(7)),
            analyst=SimpleNamespace(choose_start=asked.append, ask=asked.append, answer=None),
        ),
    )
    flat = Region("s", "rectangle", (1.0, 1.0), (0.5, 0.5))
    down = np.array([0.0, 0.0, -1.0])
    with pytest.raises(UserError, match="initial set"):
        start_at(session, flat, np.array([3.0, 1.0, 2.0]), down)
    assert session.choosing_start
    start_at(session, flat, np.array([1.25, 1.0, 2.0]), down)
    assert asked == [(1.25, 1.0), (7,)]
    assert not session.choosing_start
    session.subject = SimpleNamespace(task=None)  # the formula was edited since the rollout
    start_at(session, flat, np.array([1.0, 1.0, 2.0]), down)
    assert asked[2:] == [(1.0, 1.0)]
