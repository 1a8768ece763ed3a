from types import SimpleNamespace
from typing import Any, cast

import pytest

from studio.page.playing.player import Player


@pytest.fixture
def player():
    task = SimpleNamespace(robot=SimpleNamespace(dt=0.2))
    player = Player()
    player.load(cast(Any, SimpleNamespace(task=task, steps=10)))
    player.speed = 1
    return player


def test_plays_in_the_robots_time(player):
    player.tick(100.0)
    player.tick(100.5)
    assert player.position == pytest.approx(2.5)


def test_speed_multiplies(player):
    player.speed = 4
    player.tick(0.0)
    player.tick(0.25)
    assert player.position == pytest.approx(5.0)


def test_stops_at_the_end_and_plays_again_from_the_start(player):
    player.tick(0.0)
    player.tick(99.0)
    assert (player.position, player.playing) == (10.0, False)
    player.toggle()
    assert (player.position, player.playing) == (0.0, True)


def test_a_pause_takes_no_time(player):
    player.tick(0.0)
    player.tick(0.2)
    player.toggle()
    player.tick(50.0)
    player.toggle()
    player.tick(100.0)
    player.tick(100.2)
    assert player.position == pytest.approx(2.0)


@pytest.mark.parametrize(("step", "position"), [(4, 4.0), (-3, 0.0), (99, 10.0)])
def test_seeking_stands_still_within_the_recording(player, step, position):
    player.seek(step)
    player.tick(0.0)
    player.tick(1.0)
    assert (player.position, player.playing) == (position, False)


def test_without_a_recording_nothing_moves():
    player = Player()
    player.toggle()
    player.seek(3)
    player.tick(0.0)
    player.tick(1.0)
    assert (player.position, player.playing) == (0.0, False)
