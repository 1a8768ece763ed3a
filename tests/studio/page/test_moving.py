"""The robot is taken from where it plays and put somewhere else: session and analyst together."""

import numpy as np
import pytest

import studio.page.asking as module
from core.evaluation import trace_robustness
from core.methods import METHODS
from scenes import load_task
from studio.page.app import default_config
from studio.page.panels.plan import plan_html
from studio.page.session import Session
from studio.runs.bundle import Policy
from studio.runs.tasks import build_task
from tests.studio.waiting import Gate, ticked, wait_for

SCENE = load_task("linear-demo")
INSIDE_B, FREE = np.array([0.3, 0.3, 0.0]), np.array([-4.0, 4.0, 0.0])


@pytest.fixture
def session(disk_cache):
    """A session that plays the plan of the robot's weights."""
    session = Session(SCENE, None, default_config)
    session.analyst.watched = False
    assert ticked(session, lambda: session.player.recording is not None), session.analyst.error
    yield session
    session.close()


def drag(session, offset):
    """Take the robot, pull it along and let it go."""
    start = (0.0, 0.0, 0.1)
    half, end = (tuple(start + share * np.asarray(offset)) for share in (0.5, 1.0))
    for phase, point in (("start", start), ("update", half), ("end", end)):
        session.post(lambda phase=phase, point=point: session.hand.drag(phase, start, point))
        session.tick(0.0)


def move_to(session, step, place):
    """Put the robot at a place at the step after this one; what played before."""
    before = session.player.recording
    session.player.seek(step)
    drag(session, place - before.positions[step])
    return before


def answered(session, before):
    assert ticked(session, lambda: session.player.recording is not before), (
        session.error or session.analyst.error
    )
    return session.player.recording


def test_it_goes_on_from_there_and_the_whole_trace_is_judged(session):
    before = move_to(session, 12, FREE)
    assert session.hand.held.released and "Planning anew" in plan_html(session)
    after = answered(session, before)
    np.testing.assert_array_equal(after.states[:13], before.states[:13])
    np.testing.assert_allclose(after.positions[13], FREE, atol=1e-5)
    assert after.moves == (13,) and after.steps == before.steps
    assert after.robustness == trace_robustness(after.task, after.margins[:, None])[0]
    assert after.satisfied
    assert session.player.playing and 13 <= session.player.position < 20
    assert session.hand.held is None and not session.gallery.ghosts
    assert "Moved at step 13; planned anew in" in plan_html(session)
    again = answered(session, move_to(session, 20, after.positions[20] + 0.3))
    assert again.moves == (13, 21)


def test_after_an_obstacle_nothing_helps_and_the_page_says_so(session):
    after = answered(session, move_to(session, 12, INSIDE_B))
    assert not after.satisfied and session.analyst.answer.moved.falsified == 13
    text = plan_html(session)
    assert "Moved at step 13. Nothing can satisfy the formula any more: the robot" in text
    session.post(session.analyst.ask)  # a new plan begins anew
    assert answered(session, after).satisfied
    assert "Moved" not in plan_html(session)


def test_too_late_is_said_without_a_claim_of_proof(session):
    first = session.player.recording
    session.post(lambda: session.document.set_formula("F_[0:22](A2)"))
    assert answered(session, first).satisfied
    answered(session, move_to(session, 10, np.array([-4.5, -4.5, 0.0])))
    assert session.analyst.answer.moved.falsified is None
    assert "no continuation was found in" in plan_html(session)


def test_a_policy_that_was_loaded_plans_anew_too(session, small_algorithm):
    task = build_task(SCENE)
    learner = METHODS["tgpo-star"].learner(task, small_algorithm)
    weights = learner.weights(learner.fresh(0))
    policy = Policy(SCENE, "studio", "tgpo-star", 0, small_algorithm, weights, 0.5, 0.0, 1)
    shown = session.player.recording
    session.post(lambda: session.load(policy, "a file"))
    answered(session, shown)
    assert ticked(session, lambda: session.player.recording is not None)
    assert session.subject is session.training
    after = answered(session, move_to(session, 10, FREE))
    assert after.moves == (11,)
    assert "Moved at step 11" in plan_html(session)


def test_a_click_moves_nothing(session):
    before, answer = session.player.recording, session.analyst.answer
    assert session.player.playing
    drag(session, np.array([0.01, 0.0, 0.0]))
    assert session.hand.held is None and session.player.playing
    assert session.analyst.answer is answer and session.player.recording is before


def test_it_cannot_leave_the_workspace_nor_be_taken_at_the_end(session):
    before = session.player.recording
    session.player.seek(before.steps)
    assert not session.hand.can_take()
    drag(session, FREE)
    assert session.hand.held is None
    session.player.seek(5)
    session.hand.drag("start", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    session.hand.drag("update", (0.0, 0.0, 0.0), (50.0, -50.0, 0.0))
    held = session.hand.held
    assert held is not None
    assert held.position[:2].tolist() == [5.0, -5.0]


def test_an_answer_for_a_scene_that_has_changed_is_dropped(session, monkeypatch):
    gate = Gate(module.replan)
    monkeypatch.setattr(module, "replan", lambda *asked, **how: gate(*asked))
    before = move_to(session, 12, FREE)
    assert gate.entered.acquire(timeout=120)
    session.post(lambda: session.document.set_formula("F_[0:60](A1)"))
    assert ticked(session, lambda: session.specification.task is not before.task)
    gate.open.release()
    after = answered(session, before)
    assert after.task is session.specification.task and after.moves == ()
    assert session.hand.held is None


def test_a_rollout_of_another_scene_cannot_be_moved(session, monkeypatch):
    before = session.player.recording
    monkeypatch.setattr(session.analyst, "_answer", lambda *_: None)
    session.post(lambda: session.document.set_formula("F_[0:60](A1)"))
    assert ticked(session, lambda: session.specification.task is not before.task)
    assert wait_for(lambda: session.analyst._subject.task is not before.task)
    session.player.seek(5)
    drag(session, FREE)
    assert "the scene has changed since this rollout" in session.error
    assert session.hand.held is None
