"""In a browser: a region that moves goes along with the playhead; its path is drawn and typed."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from core.methods.training import TrainingConfig
from core.task.problem import trace_margins
from scenes import Region, load_task
from scenes.motion import Motion, along
from studio.page import analyst
from studio.page.app import Studio
from studio.runs.recording import record
from studio.runs.tasks import build_task
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import wait_for_node, wait_for_text
from tests.studio.page.test_page_editing import shown_at
from tests.studio.waiting import wait_for

PATH = Motion((0, 20), ((0.0, 0.0), (3.0, -1.0)))
REGIONS = (
    Region("A", "circle", (3.0, 3.0), (0.6,)),
    Region("O", "rectangle", (0.0, 0.0), (0.6, 0.6), motion=PATH),
)
GONE = "() => !('/paths/line1' in (window.__viserSceneTree?.getState() ?? {}))"
FIELD = "xpath=//*[normalize-space(text())='Path']/following::input[1]"


@pytest.fixture
def studio(monkeypatch, small_algorithm):
    """A page with an obstacle that moves, where nothing is computed."""
    monkeypatch.setattr(analyst.Analyst, "observe", lambda *_: None)
    scene = replace(
        load_task("linear-demo"),
        formula="F_[0:30](A) & G_[0:30](!O)",
        regions=REGIONS,
        horizon=30,
        initial=Region("initial", "circle", (-3.0, -3.0), (0.3,)),
    )
    config = TrainingConfig(small_algorithm)
    studio = Studio(scene, None, "127.0.0.1", free_port(), lambda *_, **__: config)
    with running(studio):
        yield studio


def straight(scene):
    """A recording of a way round the obstacle, past (-3, 3)."""
    task = build_task(scene)
    steps = np.arange(task.padded_horizon + 1)
    up, right = np.minimum(0.4 * steps, 6.0), np.clip(0.4 * (steps - 15), 0.0, 6.0)
    states = np.stack([right - 3.0, up - 3.0], 1).astype(np.float32)
    margins = trace_margins(task.problem, jnp.asarray(states[:, None]))
    return record(task, None, states, np.zeros((len(steps) - 1, 2)), np.asarray(margins)[:, 0])


def test_a_moving_region_follows_the_playhead(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    for node in ("/scene/region1", "/paths/line1", "/paths/dots1/0", "/paths/dots1/1"):
        wait_for_node(page, node)
    assert shown_at(page, "/scene/region1")[:2] == pytest.approx((0.0, 0.0))
    recording = straight(studio.session.document.scene)
    session = studio.session

    def show(step):
        session.player.load(recording)
        session.player.seek(step)

    for step, place in ((10, (1.5, -0.5)), (20, (3.0, -1.0)), (5, (0.75, -0.25))):
        session.post(lambda step=step: show(step))
        assert wait_for(
            lambda place=place: np.allclose(shown_at(page, "/scene/region1")[:2], place, atol=1e-3)
        )
    assert np.allclose(shown_at(page, "/scene/region0")[:2], (3.0, 3.0))
    session.post(session.player.toggle)  # it plays on
    assert wait_for(lambda: shown_at(page, "/scene/region1")[0] > 1.5)


def test_a_path_is_typed_refused_and_taken_away(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    session = studio.session

    def motion():
        return session.document.region("O").motion

    session.post(lambda: session.editor.select("O"))
    page.wait_for_selector(FIELD, state="visible")
    assert wait_for(lambda: page.locator(FIELD).input_value() == "0: 0, 0; 20: 3, -1")
    page.locator(FIELD).fill("0: 0, 0; 30: 0")
    page.wait_for_selector("text=has 2 numbers; a waypoint is [step, x, y]")
    assert motion() == PATH
    page.locator(FIELD).fill("0: 1, 0; 10: 1, 2; 20: 1, 0")
    assert wait_for(lambda: motion() == Motion((0, 10, 20), ((0, 0), (0, 2), (0, 0))))
    wait_for_node(page, "/paths/dots1/2")
    assert wait_for(lambda: shown_at(page, "/scene/region1")[0] == pytest.approx(1.0))
    page.locator(FIELD).fill("0.1, 0 per step")
    assert wait_for(lambda: motion() == along([0.1, 0.0], 2))
    page.locator(FIELD).fill("")
    assert wait_for(lambda: motion() is None)
    assert wait_for(lambda: page.evaluate(GONE))
