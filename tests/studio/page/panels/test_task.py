"""The menu of tasks, in quick hands and with one's own scenes."""

from dataclasses import replace

import pytest

from scenes import blank, load_task
from studio.page.files.shelf import Shelf
from studio.page.panels.task import TaskPanel
from studio.page.server.relied_upon import identifier_of
from studio.page.server.security import start_server
from studio.page.session import Session
from tests.studio.conftest import free_port
from tests.studio.waiting import wait_for
from tests.tools.attack.client import Tab


def test_only_the_last_choice_is_opened(monkeypatch):
    """Opening takes up to seconds; a burst of choices once had the page open each."""
    server = start_server("127.0.0.1", free_port(), "tasks")
    session = Session(load_task("linear-08"), None, lambda *_: pytest.fail("no training"))
    opened = []
    monkeypatch.setattr(session, "choose_task", opened.append)
    try:
        panel = TaskPanel(server.gui, session, Shelf())
        with Tab(server.get_port()) as tab:
            assert wait_for(lambda: len(server.get_clients()) == 1)
            for _ in range(50):
                for name in ("linear-01", "linear-02"):
                    tab.set(identifier_of(panel._menu), name)
            assert wait_for(lambda: session._changes.qsize() == 100)
        session.tick(0.0)
        assert opened == ["linear-02"]
    finally:
        session.close()
        server.stop()


@pytest.fixture
def menu():
    """Makes the panel of a session that begins with a scene, beside a shelf."""
    server = start_server("127.0.0.1", free_port(), "tasks")
    sessions = []

    def make(scene, shelf):
        session = Session(scene, None, lambda *_: pytest.fail("no training"))
        sessions.append(session)
        return session, TaskPanel(server.gui, session, shelf)

    yield make
    for session in sessions:
        session.close()
    server.stop()


def test_own_scenes_are_listed_first_and_opened(menu, evil_scene):
    shelf = Shelf()
    edited = replace(load_task("linear-08"), seed=5)
    for scene in (edited, evil_scene):
        shelf.keep(scene)
    session, panel = menu(load_task("linear-08"), shelf)
    panel.draw(session)
    options = panel._menu.options
    assert options[:2] == (evil_scene.name, "linear-08 (yours)")
    assert panel._menu.value == "linear-08"
    assert len(set(options)) == len(options)
    for label, scene in (
        ("linear-08 (yours)", edited),
        ("linear-08", load_task("linear-08")),
        (evil_scene.name, evil_scene),
    ):
        panel._choose(session, label)
        panel.draw(session)
        assert session.document.scene == scene
        assert panel._menu.value == label


def test_a_scene_that_is_kept_nowhere_is_listed_while_it_is_shown(menu):
    session, panel = menu(load_task("linear-08"), Shelf())
    session.open(blank("linear", name="mine"))
    panel.draw(session)
    assert (panel._menu.value, panel._menu.options[0]) == ("mine", "mine")
    session.choose_task("linear-07")
    panel.draw(session)
    assert "mine" not in panel._menu.options


def test_the_scene_that_the_page_began_with_can_be_opened_again(menu):
    first = replace(load_task("linear-08"), formula="F_[0:90](A1)")
    session, panel = menu(first, Shelf())
    panel.draw(session)
    label = panel._menu.value
    assert label != "linear-08"
    session.choose_task("linear-07")
    panel._choose(session, label)
    assert session.document.scene == first
