"""What the analyst does first while a region is dragged and requests never end."""

import time
from dataclasses import replace

import pytest

import studio.page.analyst as module
from core.methods.training import TrainingConfig
from studio.page.analyst import Analyst
from studio.page.picture import MapView
from studio.page.trainer import Phase, Training
from tests.studio.waiting import wait_for


@pytest.fixture
def training(linear_task, small_algorithm):
    """Weights are only handed on here, so anything stands for them."""
    config = TrainingConfig(small_algorithm)
    return Training(Phase.LOADED, linear_task, config, epoch=1, weights=object())


@pytest.fixture
def done(monkeypatch):
    """Names of what an analyst did, in order; requests come without end."""
    done: list[str] = []

    def answer(self, subject, request):
        done.append("answer")
        time.sleep(0.001)
        self._request = module._Request()
        self._wake.set()

    monkeypatch.setattr(Analyst, "_answer", answer)
    monkeypatch.setattr(module, "draw_picture", lambda *_: done.append("map"))
    monkeypatch.setattr(Analyst, "_count", lambda *_: done.append("starts"))
    return done


def test_a_map_that_is_due_waits_for_one_answer_at_most(training, done, monkeypatch):
    monkeypatch.setattr(module, "PERIOD", 0.0)
    analyst = Analyst()
    analyst.ask()
    analyst.observe(training)
    analyst.ask()
    for view in range(4):  # each wants another map
        analyst.choose_view(MapView(fixed=((0, view),)))
        assert wait_for(lambda count=view: done.count("map") > count), analyst.error
    before = done.count("answer")
    assert wait_for(lambda: done.count("answer") > before)
    assert analyst.close()
    assert ("map", "map") not in zip(done, done[1:], strict=False)


def test_starts_are_tried_once_the_scene_stands(training, done, monkeypatch):
    monkeypatch.setattr(module, "REST", 1e6)
    analyst = Analyst()
    analyst.observe(training)
    assert wait_for(lambda: "map" in done), analyst.error
    time.sleep(0.3)
    assert "starts" not in done
    monkeypatch.setattr(module, "REST", 0.0)
    assert wait_for(lambda: "starts" in done), analyst.error
    assert analyst.close()


def test_another_epoch_is_no_other_scene(training, done):
    analyst = Analyst()
    analyst.observe(training)
    since = analyst._since
    analyst.observe(replace(training, epoch=2, weights=object()))
    assert analyst._since == since > 0
    assert analyst.close()


def test_whoever_waits_is_told_of_an_answer(training, done):
    told: list[bool] = []
    analyst = Analyst(lambda: told.append(True))
    analyst.observe(training)
    assert wait_for(lambda: bool(told)), analyst.error
    assert analyst.close()
