"""A baseline on the page, without a browser: trained, rolled out, exported, opened again."""

from dataclasses import replace

import pytest

from core.controller import NO_SCHEDULES
from core.errors import UserError
from core.methods import METHODS
from core.methods.training import TrainingConfig
from scenes import load_task, robot_of
from studio.page.files import keeping
from studio.page.files.keeping import load_policy
from studio.page.panels.progress import status_html
from studio.page.session import Session
from studio.page.settings import Settings
from studio.page.trainer import Phase
from tests.studio.waiting import ticked

SCENE = load_task("linear-01")


@pytest.fixture
def make_session(disk_cache):
    """Makes sessions whose button trains a method for an epoch; all are closed at the end."""
    made = []

    def make(method: str, scene=SCENE) -> Session:
        preset = METHODS[method].preset("studio", robot_of(scene))
        small = replace(preset, hidden=(8,), environments=16, minibatches=2, evaluation_states=8)
        config = TrainingConfig(small, method, epochs=1, evaluate_every=1)
        made.append(Session(scene, None, lambda scene, limit: config))
        return made[-1]

    yield make
    for session in made:
        session.close()


def test_it_is_trained_shown_and_kept(make_session, tmp_path):
    session = make_session("grad")
    session.train()
    assert ticked(session, lambda: session.training.phase in (Phase.DONE, Phase.FAILED))
    assert session.training.phase is Phase.DONE, session.training.error
    assert session.training.chains is None and session.training.obstacle == ""

    def answered():  # the map of the robot's weights may have been on its way
        shown, share = session.analyst.picture, session.analyst.share
        if session.player.recording is None or shown is None or share is None:
            return False
        return shown.subject.controller.search is None

    assert ticked(session, answered), session.analyst.error
    with pytest.raises(UserError, match=NO_SCHEDULES):
        keeping.heatmap_file(session)
    assert keeping.csv_file(session).content
    name, content = keeping.bundle_file(session)
    (tmp_path / name).write_bytes(content)
    policy = load_policy(tmp_path / name)
    assert (policy.method, policy.mode, policy.scene) == ("grad", "studio", SCENE)

    session.load(policy, "the file")
    assert ticked(session, lambda: session.analyst.picture is not None), session.analyst.error
    assert session.training.phase is Phase.LOADED


def test_a_formula_that_it_does_not_know_is_told(make_session):
    session = make_session("f-mdp", load_task("linear-08"))
    session.train()
    assert ticked(session, lambda: session.training.phase is Phase.FAILED)
    assert "holds a third layer" in session.training.error


@pytest.mark.parametrize("method", METHODS)
def test_every_method_can_be_chosen(method):
    settings = Settings()
    settings.choose("studio", method)
    chosen = settings.applied(TrainingConfig(None), SCENE) if method != "tgpo-star" else None
    assert settings.method == method
    assert chosen is None or (chosen.method, chosen.algorithm.mode_name) == (method, "studio")


def test_what_training_will_do_is_said_before_it_begins(make_session):
    session = make_session("grad")
    session.settings.choose("studio", "cem")
    assert "for the formula as a whole, from scratch" in status_html(session)
    session.settings.choose("studio", "tgpo")
    assert "as a whole" not in status_html(session)
