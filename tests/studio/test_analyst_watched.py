"""The analyst's thread while nobody looks at the page."""

import studio.analyst as module
from core.training import TrainingConfig
from studio.analyst import Analyst
from studio.worker import Stage, Training
from tests.studio.waiting import wait_for


def test_no_heatmap_is_drawn_that_nobody_sees(linear_task, small_algorithm, monkeypatch):
    drawn, rolled_out = [], []
    monkeypatch.setattr(module, "_draw", lambda *asked: drawn.append(asked))
    monkeypatch.setattr(Analyst, "_answer", lambda *asked: rolled_out.append(len(drawn)))
    analyst = Analyst()
    analyst.watched = False
    config = TrainingConfig(small_algorithm)
    # Weights are only handed on here, so anything stands for them.
    analyst.observe(Training(Stage.TRAINING, linear_task, config, epoch=1, parameters=object()))  # pyright: ignore[reportArgumentType]
    analyst.ask((0,))
    assert wait_for(lambda: bool(rolled_out)), analyst.error
    assert rolled_out[0] == 0
    assert not drawn
    analyst.watched = True
    analyst._request = None
    assert wait_for(lambda: bool(drawn)), analyst.error
    assert analyst.close()
