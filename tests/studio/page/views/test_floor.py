"""Tools are bound to the floor that is there."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest

from scenes import blank
from studio.page.editing.editor import SELECT
from studio.page.views.floor import FloorView


@pytest.fixture
def session() -> Any:
    return SimpleNamespace(
        document=SimpleNamespace(scene=blank("linear", name="new")),
        editor=SimpleNamespace(tool=SELECT),
    )


class Floor:
    """Stands for the node: what is bound to it."""

    def __init__(self) -> None:
        self.drags, self.clicks = [], []
        self.remove_click_callback = self.clicks.remove

    def on_drag(self, _, modifier):
        return lambda callback: self.drags.append((modifier, callback)) or callback

    def remove_drag_callback(self, callback):
        self.drags = [bound for bound in self.drags if bound[1] is not callback]

    def on_click(self, callback):
        self.clicks.append(callback)
        return callback

    @property
    def modifiers(self):
        return [modifier for modifier, _ in self.drags]


def test_a_tool_is_bound_without_another_floor(session):
    server, floor = MagicMock(), Floor()
    server.scene.add_box.return_value = floor
    view = FloorView(server)
    view.draw(session)
    assert (floor.modifiers, floor.clicks) == (["shift"], [])
    drawn = server.scene.add_box.call_count
    for tool, clicks in (("circle", 0), ("polygon", 1), ("rectangle", 0)):
        session.editor.tool = tool
        view.draw(session)
        assert (floor.modifiers, len(floor.clicks)) == (["shift", None], clicks)
    session.editor.tool = SELECT
    view.draw(session)
    assert (floor.modifiers, floor.clicks) == (["shift"], [])
    assert server.scene.add_box.call_count == drawn


def test_another_arena_has_another_floor_with_the_tool_in_hand(session):
    server, first, second = MagicMock(), Floor(), Floor()
    server.scene.add_box.return_value = first
    view = FloorView(server)
    session.editor.tool = "polygon"
    view.draw(session)
    server.scene.add_box.return_value = second
    session.document.scene = blank("quadrotor", name="new")
    view.draw(session)
    for floor in (first, second):
        assert (floor.modifiers, len(floor.clicks)) == (["shift", None], 1)
