"""What weights are never trained on: a change here makes every reported figure worthless."""

import pytest

from scenes import load_task
from scenes.missions import FAMILIES, HELD_OUT, SHIPPED_HELD_OUT, SHIPPED_TRAINED, TRAINED
from studio.runs import missions
from studio.runs.missions import Mixture, RandomMissions, ShippedMissions


def test_families_and_tasks_are_held_out():
    assert set(HELD_OUT) == {"rooms", "s-bend", "chamber"}
    assert set(SHIPPED_HELD_OUT) == {"05", "09", "10", "demo"}
    assert set(TRAINED) | set(HELD_OUT) == set(FAMILIES) and not set(TRAINED) & set(HELD_OUT)
    assert not set(SHIPPED_TRAINED) & set(SHIPPED_HELD_OUT)


def test_a_source_draws_from_no_family_that_is_held_out(monkeypatch):
    """By default; a report names what is held out."""
    asked = []
    monkeypatch.setattr(
        missions, "mission", lambda robot, family, seed, *, shared: asked.append(family)
    )
    source = RandomMissions("linear", stream=0)
    mixture = Mixture((source,), (1.0,))
    for number in range(200):
        source(number)
        mixture(number)
    assert set(asked) == set(TRAINED)
    RandomMissions("linear", 0, families=HELD_OUT)(0)
    assert asked[-1] in HELD_OUT


@pytest.mark.parametrize("number", SHIPPED_HELD_OUT)
def test_no_version_of_a_held_out_task_is_drawn(monkeypatch, number):
    grounded = []

    class StopHereError(Exception):
        pass

    def record(scene, visits_extra, shared):
        assert visits_extra == 0
        grounded.append(scene.name)
        if len(grounded) == len(SHIPPED_TRAINED):
            raise StopHereError

    monkeypatch.setattr(missions, "build_task", record)
    with pytest.raises(StopHereError):
        ShippedMissions("linear", stream=0)(0)
    assert load_task(f"linear-{number}").name not in grounded
    assert grounded == [f"linear-{trained}" for trained in SHIPPED_TRAINED]
