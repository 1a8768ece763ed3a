"""The analyst's thread while nobody looks at the page."""

import studio.page.analyst as module
from core.methods.training import TrainingConfig
from studio.page.analyst import Analyst
from studio.page.trainer import Phase, Training
from tests.studio.waiting import wait_for


def test_no_heatmap_is_drawn_that_nobody_sees(linear_task, small_algorithm, monkeypatch):
    drawn, rolled_out = [], []
    monkeypatch.setattr(module, "draw_picture", lambda *asked: drawn.append(asked))
    monkeypatch.setattr(Analyst, "_answer", lambda *asked: rolled_out.append(len(drawn)))
    analyst = Analyst()
    analyst.watched = False
    config = TrainingConfig(small_algorithm)
    # Weights are only handed on here, so anything stands for them.
    analyst.observe(Training(Phase.TRAINING, linear_task, config, epoch=1, weights=object()))
    analyst.ask((0,))
    assert wait_for(lambda: bool(rolled_out)), analyst.error
    assert rolled_out[0] == 0
    assert not drawn
    analyst.watched = True
    analyst._request = None
    assert wait_for(lambda: bool(drawn)), analyst.error
    assert analyst.close()
