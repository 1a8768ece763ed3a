"""The menu of tasks, in quick hands."""

import pytest

from scenes import load_task
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
