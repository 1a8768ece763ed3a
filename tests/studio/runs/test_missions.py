"""Missions that can be solved in time, the same for the same number."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from core.errors import UserError
from scenes.missions import FAMILIES, mission_steps
from studio.runs import missions
from studio.runs.missions import (
    EASY,
    LEAST_SHARE,
    SHIPPED,
    Demanding,
    Mixture,
    RandomMissions,
    ShippedMissions,
    Source,
    mission,
)


@pytest.mark.parametrize("robot", ["linear", "panda"])
def test_missions_of_every_family_come_about(disk_cache, robot):
    for family in FAMILIES:
        drawn = mission(robot, family, 1)
        assert LEAST_SHARE <= drawn.share <= 1 and drawn.family == family
        assert drawn.task.padded_horizon == mission_steps(robot)
        assert drawn.scene.robot == robot


def test_missions_are_easy_and_hard(disk_cache):
    """About half of all leave time to a third of uniform schedules, a tenth to few."""
    families = ("doors", "open", "pillars")
    shares = np.array([mission("linear", f, s).share for f in families for s in range(10)])
    assert (shares > 0.3).mean() > 0.2
    assert (shares < 0.1).mean() > 0.1


def test_a_stream_and_a_number_make_a_mission(disk_cache):
    source = RandomMissions("linear", stream=1)
    again, other = RandomMissions("linear", 1)(2), RandomMissions("linear", 2)(2)
    first = source(2)
    assert again.scene == first.scene and again.share == first.share
    assert other.scene.regions != first.scene.regions
    assert source(3).scene.regions != first.scene.regions


def test_shipped_tasks_are_perturbed(disk_cache):
    source = ShippedMissions("linear", stream=1, numbers=("07", "08"))
    first, second = source(0), source(3)
    assert first.scene.name == "linear-07" and second.scene.name == "linear-08"
    assert first.family == SHIPPED and first.share > 0
    assert source(0).scene == first.scene and source(2).scene.regions != first.scene.regions
    with pytest.raises(UserError, match="task: unknown 'linear-11'"):
        ShippedMissions("linear", 1, numbers=("11",))(0)


def test_a_mixture_draws_by_weight():
    asked: list[tuple[str, int]] = []

    def source(name: str) -> Source:
        return lambda number: asked.append((name, number))  # type: ignore[return-value]

    mixture = Mixture((source("a"), source("b")), (0.25, 0.75))
    for number in [*range(400), *range(400)]:
        mixture(number)
    assert asked[:400] == asked[400:] and [number for _, number in asked[:400]] == list(range(400))
    assert 60 < sum(name == "a" for name, _ in asked[:400]) < 140


def test_where_nothing_can_be_solved_it_says_so(disk_cache, monkeypatch):
    monkeypatch.setattr(missions, "TRIES", 2)
    monkeypatch.setattr(missions, "LEAST_SHARE", 2.0)
    with pytest.raises(UserError, match="none of 2 draws of the family 'open' can be solved"):
        mission("linear", "open", 0)


def test_a_demanding_source_has_fewer_easy_missions():
    def source(number: int) -> Any:
        return SimpleNamespace(number=number, share=0.9 if number // 3 % 2 else 0.1)

    demanding: Any = Demanding(source, seed=4)
    drawn = [demanding(number) for number in range(200)]
    assert [one.number for one in drawn] == sorted({one.number for one in drawn})
    assert np.mean([one.share <= EASY for one in drawn]) > 0.6  # one half without it
    again: Any = Demanding(source, seed=4)
    assert again(17).number == drawn[17].number
