"""The analyst simulates the map's cells when nothing else is asked of it."""

import numpy as np
import pytest

import studio.page.analyst as module
from core.methods import METHODS
from core.methods.training import TrainingConfig
from core.truth import nothing_simulated
from studio.page.analyst import Analyst
from studio.page.picture import MapView
from studio.page.trainer import Phase, Training
from tests.studio.waiting import Gate, wait_for


@pytest.fixture
def training(linear_task, small_algorithm):
    learner = METHODS["tgpo-star"].learner(linear_task, small_algorithm)
    weights, config = learner.weights(learner.fresh(seed=0)), TrainingConfig(small_algorithm)
    return Training(Phase.TRAINING, linear_task, config, weights=weights)


@pytest.fixture
def analyst(training):
    analyst = Analyst()
    analyst.observe(training)
    yield analyst
    assert analyst.close()


def whole(analyst: Analyst):
    """Whether all cells of the picture shown are simulated."""
    found = analyst.simulated
    return found is not None and found.picture is analyst.picture and found.truth.complete


simulate_picture = module.simulate_picture


def test_with_the_switch_on_all_cells_are_simulated(analyst):
    assert wait_for(lambda: analyst.picture is not None), analyst.error
    assert not whole(analyst)
    analyst.simulate(True)
    assert wait_for(lambda: whole(analyst)), analyst.error
    assert not np.isnan(analyst.simulated.truth.robustness).any()


def test_a_request_comes_between_two_batches(analyst, monkeypatch):
    gate = Gate(simulate_picture)
    monkeypatch.setattr(module, "simulate_picture", gate)
    analyst.simulate(True)
    assert gate.entered.acquire(timeout=120), analyst.error
    analyst.ask((20, 50, 15))
    gate.open.release()
    assert wait_for(lambda: analyst.answer is not None), analyst.error
    assert not whole(analyst)
    gate.open.release(100)
    assert wait_for(lambda: whole(analyst)), analyst.error


def test_what_belongs_to_another_picture_is_dropped(analyst):
    analyst.simulate(True)
    assert wait_for(lambda: whole(analyst)), analyst.error
    before = analyst.simulated
    analyst.choose_view(MapView(axes=(2, 0)))
    assert wait_for(lambda: analyst.simulated is not before), analyst.error
    assert analyst.simulated.picture is analyst.picture
    assert analyst.simulated.truth.heatmap.axes == (2, 0)
    assert wait_for(lambda: whole(analyst)), analyst.error
    analyst.forget()
    assert analyst.simulated is None


def test_the_same_question_is_not_asked_again(analyst, monkeypatch):
    asked = []
    monkeypatch.setattr(
        "studio.page.picture.simulate_more", lambda *given: asked.append(given[-1]) or given[-1]
    )
    assert wait_for(lambda: analyst.picture is not None), analyst.error
    first, other = analyst.picture, module.draw_picture(analyst.picture.subject, MapView(), None)
    truth = nothing_simulated(first.heatmap)
    known = truth._replace(robustness=np.ones_like(truth.robustness))
    simulate_picture(other, module.Simulated(first, known))
    assert asked[-1].complete
    moved = module.draw_picture(first.subject, MapView(), (-2.0, -2.0))
    simulate_picture(moved, module.Simulated(first, known))
    assert not asked[-1].simulated.any()


@pytest.mark.parametrize(("simulating", "watched"), [(False, True), (True, False)])
def test_nothing_is_simulated_that_nobody_sees(analyst, monkeypatch, simulating, watched):
    calls, idle = [], []
    monkeypatch.setattr(module, "simulate_picture", lambda *asked: calls.append(asked))
    assert wait_for(lambda: analyst.picture is not None), analyst.error
    analyst.watched = watched
    analyst.simulate(simulating)
    monkeypatch.setattr(analyst, "_count", idle.append)
    assert wait_for(lambda: len(idle) > 2)  # twice through all that is done when idle
    assert not calls


def test_what_cannot_be_simulated_is_said_once(analyst, monkeypatch, capsys):
    def broken(*asked):
        calls.append(asked)
        raise ValueError("no")

    calls = []
    monkeypatch.setattr(module, "simulate_picture", broken)
    analyst.simulate(True)
    assert wait_for(lambda: "ValueError: no" in analyst.error)
    analyst.ask((20, 50, 15))
    assert wait_for(lambda: analyst.answer is not None), analyst.error
    assert len(calls) == 1 and not analyst.simulating
