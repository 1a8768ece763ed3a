from types import SimpleNamespace

import pytest

from core.errors import UserError
from core.stl import sentences
from scenes import Predicate, load_task, scene_formula
from studio.page.editing.document import Document
from studio.page.panels.predicates import predicates_text, read_predicates, take

SLOW = Predicate("slow", "v <= 1")


@pytest.fixture
def session():
    return SimpleNamespace(document=Document(load_task("unicycle-demo")))


def test_a_text_is_predicates():
    predicates = (SLOW, Predicate("a b", "|theta| <= 0.3"))
    assert read_predicates(predicates_text(predicates)) == predicates
    assert read_predicates(" ; slow :  v <= 1 ;") == (SLOW,)
    assert read_predicates("") == ()


def test_a_text_adds_changes_and_removes(session):
    take(session, "slow: v <= 1")
    assert session.document.scene.predicates == (SLOW,)
    take(session, "slow: v <= 2")
    assert session.document.scene.predicates == (Predicate("slow", "v <= 2"),)
    assert session.document.undo() == "change the predicates"
    assert session.document.scene.predicates == (SLOW,)
    take(session, "")
    assert session.document.scene.predicates == ()


@pytest.mark.parametrize("text", ["slow", "slow: vel <= 1", "A1: v <= 1", "slow: v < 1"])
def test_what_is_wrong_changes_nothing(session, text):
    take(session, "slow: v <= 1")
    with pytest.raises(UserError, match="predicates"):
        take(session, text)
    assert session.document.scene.predicates == (SLOW,)


def test_what_a_training_depends_on(session):
    take(session, "slow: v <= 1")
    session.document.set_formula("F_[0:50](A1 & slow)")
    trained = session.document.scene
    assert session.document.matches(trained)
    take(session, "slow: v <= 1; fast: v >= 2")  # the formula does not name it
    assert session.document.matches(trained)
    take(session, "slow: v <= 2")
    assert not session.document.matches(trained)
    take(session, "slow: v <= 1")
    session.document.set_between_steps(True)
    assert not session.document.matches(trained)


def test_a_region_is_renamed_beside_predicates(session):
    take(session, "slow: v <= 1")
    session.document.set_formula("F_[0:50](A1 & slow)")
    session.document.rename("A1", "home")
    assert session.document.scene.formula == "F_[0:50](home & slow)"
    with pytest.raises(UserError, match="already the name of a predicate"):
        session.document.rename("home", "slow")


def test_english_does_not_go_into_a_speed(session):
    take(session, "slow: v <= 1")
    session.document.set_formula("F_[0:50](A1 & !slow) & G_[0:50](slow)")
    said = " ".join(sentences(scene_formula(session.document.scene)))
    assert "in A1 and not slow" in said and "stay slow" in said and "in slow" not in said
