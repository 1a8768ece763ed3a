"""Exact plans on the page: searched in the background, watched, stopped, played, and refused."""

import math
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest

from core.errors import UserError
from core.planning.exact import ExactPlan
from core.planning.watch import Watch
from scenes import Predicate, load_task
from studio.page import analyst
from studio.page.editing.specification import specify
from studio.page.exact import ExactPlanner, Search, offered
from studio.page.panels.exact import exact_html, progress_html, verdict_text
from studio.page.panels.plan import plan_html
from studio.page.panels.training import METHOD_LABEL, method_labels
from studio.page.session import Session
from studio.page.settings import EXACT
from tests.studio.waiting import ticked, wait_for

SCENE = replace(load_task("linear-demo"), formula="F_[0:25](A1) & G_[0:25](!B)", horizon=25)


@pytest.fixture(scope="module")
def task():
    found = specify(SCENE).task
    assert found is not None
    return found


@pytest.fixture
def planner():
    planner = ExactPlanner()
    yield planner
    assert planner.close()


@pytest.fixture
def session(monkeypatch):
    monkeypatch.setattr(analyst.Analyst, "observe", lambda *_: None)
    session = Session(SCENE, None, lambda *_: pytest.fail("no training"))
    session.settings.choose("studio", EXACT)
    yield session
    assert session.close()


def ended(planner):
    assert wait_for(lambda: not planner.running)
    return planner.search


def test_a_plan_is_found_proved_and_carried_out(planner, task):
    planner.start(task, SCENE, None, 60.0)
    search = ended(planner)
    assert search.plan.status == "optimal"
    assert search.recording.satisfied
    assert search.recording.robustness == pytest.approx(search.plan.robustness, abs=1e-4)
    assert search.recording.robustness <= search.plan.bound + 1e-4
    assert search.watch.bound == search.plan.bound
    assert verdict_text(search).startswith("Optimal: robustness 0.80 m, proved bound 0.80 m (")
    assert planner.news() is search
    assert planner.news() is None


def test_it_is_for_the_start_that_was_chosen(planner, task):
    planner.start(task, SCENE, (-3.0, -3.5), 60.0)
    assert ended(planner).recording.positions[0, :2] == pytest.approx((-3.0, -3.5))


def test_a_search_ends_when_it_is_stopped(planner):
    scene = load_task("linear-04")  # takes minutes
    planner.start(specify(scene).task, scene, None, 3600.0)
    planner.stop()
    search = ended(planner)
    assert search.plan.status in ("unknown", "feasible")
    assert verdict_text(search).startswith("Stopped")


def test_what_exact_plans_do_not_know_is_told(planner, task):
    unicycle = load_task("unicycle-demo")
    assert not offered(unicycle)
    assert METHOD_LABEL[EXACT] not in method_labels(unicycle)
    assert METHOD_LABEL[EXACT] in method_labels(SCENE)
    with pytest.raises(UserError, match="no predicates of the state: west"):
        planner.start(task, replace(SCENE, predicates=(Predicate("west", "x <= 0"),)), None, 1.0)
    assert planner.search is None


def test_the_button_searches_and_the_plan_is_played(session):
    assert session.exactly
    session.train()
    assert ticked(session, lambda: session.player.recording is not None)
    recording = session.exact.search.recording
    assert session.player.recording is recording
    assert "Optimal" in exact_html(session)
    assert "exact plan" in plan_html(session)
    session.document.move("A1", (-1.0, 3.0))
    assert "This was before region A1 changed." in exact_html(session)
    session.open(load_task("unicycle-demo"))
    assert not session.exactly
    assert (session.exact.search, exact_html(session)) == (None, "")


def search_with(status, bound=0.5, *, stopped=False, holds=True):
    watch = Watch()
    if stopped:
        watch.stop.set()
    plan = ExactPlan(status, None, 0.25, bound, 1.0)
    recording = SimpleNamespace(satisfied=holds, diagnosis=SimpleNamespace(sentence="Violated: B."))
    recording = recording if status == "feasible" else None
    return Search(SCENE, 60.0, time.monotonic(), watch, plan, recording)  # pyright: ignore


@pytest.mark.parametrize(
    ("search", "text"),
    [
        (search_with("infeasible", -math.inf), "Infeasible, proved: nothing from this start"),
        (search_with("feasible"), "The time limit of 60 s was reached. Best plan so far: robust"),
        (search_with("feasible", stopped=True), "Stopped. Best plan so far: robustness 0.25 m; pr"),
        (search_with("feasible", holds=False), "m; proved bound 0.50 m. Carried out: Violated: B."),
        (search_with("unknown"), "before a plan was found or excluded; proved bound 0.50 m."),
    ],
)
def test_how_a_search_has_ended(search, text):
    assert text in verdict_text(search)


def test_progress_tells_time_bound_and_gap():
    search = Search(SCENE, 60.0, 0.0, Watch(robustness=0.25, bound=0.75))
    html = progress_html(search, 12.3)
    for part in ("12 of 60 s", "0.25 m", "0.75 m", "0.50 m"):
        assert part in html
    assert "–" in progress_html(Search(SCENE, 60.0, 0.0, Watch()), 1.0)
    search.watch.stop.set()
    assert "Stopping" in progress_html(search, 13.0)
