"""A new mission, its title, horizon and arena, as a browser asks for them."""

import time
from types import SimpleNamespace

import pytest

from scenes import load_task, robot_of, workspace_of
from studio.page.figures.svg import escape
from studio.page.files.shelf import Shelf
from studio.page.panels import mission
from studio.page.panels.mission import MissionFields
from studio.page.panels.task import CHOOSE, ROBOTS, TaskPanel
from studio.page.server.relied_upon import identifier_of
from studio.page.server.security import start_server
from studio.page.session import Session
from studio.page.views.bodies import stage_of
from tests.studio.conftest import EVIL, free_port
from tests.studio.waiting import wait_for
from tests.tools.attack.client import Tab

LOW, HIGH = (-7.5, -5.0), (7.5, 5.0)


@pytest.fixture(scope="module")
def connected():
    """A server with a client that sends, a session, and the two panels."""
    server = start_server("127.0.0.1", free_port(), "missions")
    session = Session(load_task("linear-08"), None, lambda *_: pytest.fail("no training"))
    panels = TaskPanel(server.gui, session, Shelf()), MissionFields(server.gui, session)
    with Tab(server.get_port()) as tab:
        assert wait_for(lambda: len(server.get_clients()) == 1)
        yield SimpleNamespace(session=session, task=panels[0], fields=panels[1], tab=tab)
    session.close()
    server.stop()


@pytest.fixture
def client(connected, monkeypatch):
    """What a client sees of linear-08, freshly opened; what is typed counts at once."""
    monkeypatch.setattr(mission, "PAUSE", 0.0)
    connected.session.open(load_task("linear-08"))
    drawn(connected)
    return connected


def drawn(client):
    client.session.tick(time.monotonic())
    client.task.draw(client.session)
    client.fields.draw(client.session)
    return True


def send(client, field, value):
    client.tab.set(identifier_of(field), value)


def comes(client, condition):
    return wait_for(lambda: drawn(client) and condition())


def told(client):
    """What is said under the fields."""
    return client.fields._problem._content


def scene(client):
    return client.session.document.scene


@pytest.mark.parametrize("label", ROBOTS)
def test_a_new_mission_for_every_robot_and_variant(client, monkeypatch, label):
    opened = []
    monkeypatch.setattr(client.session, "open", opened.append)
    send(client, client.task._new, label)
    assert comes(client, lambda: opened)
    robot, variant = ROBOTS[label]
    assert (opened[0].robot, opened[0].variant) == (robot, variant)
    assert comes(client, lambda: client.task._new.value == CHOOSE)


def test_a_new_mission_waits_for_a_word_on_unsaved_edits(client):
    client.session.document.delete("B1")
    edited = scene(client)
    send(client, client.task._new, "unicycle")
    assert comes(client, lambda: client.session.leaving is not None)
    assert scene(client) == edited
    client.session.confirm(True)
    assert scene(client).robot == "unicycle"
    assert not client.session.unsaved
    assert client.session.specification.error == ""


def test_name_title_and_horizon_are_steps_of_the_history(client):
    before = scene(client)
    send(client, client.fields._plain["name"], "shelf")
    assert comes(client, lambda: scene(client).name == "shelf")
    send(client, client.fields._plain["title"], "Round the shelf")
    assert comes(client, lambda: scene(client).title == "Round the shelf")
    send(client, client.fields._plain["horizon"], 150.0)
    assert comes(client, lambda: scene(client).horizon == 150)
    for _ in range(3):
        client.session.undo()
    drawn(client)
    assert scene(client) == before
    assert client.fields._plain["title"].value == before.title
    assert client.fields._plain["horizon"].value == before.horizon


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("title", " ", "title: ' ' must be non-empty text"),
        ("title", "x" * 201, "title: 201 characters are too many: at most 200"),
        ("name", f"{EVIL}\n" * 9, "characters are too many: at most 80"),
        ("horizon", 0.0, "horizon: 0 must be an integer from 1 to 10000"),
    ],
)
def test_what_no_scene_can_have_is_refused_in_words(client, field, value, words):
    before = scene(client)
    control = client.fields._plain[field]
    shown = control.value
    send(client, control, value)
    assert comes(client, lambda: escape(words) in told(client))
    assert comes(client, lambda: control.value == shown)
    assert scene(client) == before


def test_the_arena_is_typed_and_the_floor_follows(client):
    low, high = client.fields._corners[2]
    send(client, low, list(LOW))
    send(client, high, list(HIGH))
    assert comes(client, lambda: scene(client).arena == ((-7.5, 7.5), (-5.0, 5.0)))
    (left, right), (front, back) = stage_of(scene(client)).floor
    assert (right - left) / (back - front) > 1.2
    assert client.fields._own.visible
    send(client, client.fields._own, True)
    assert comes(client, lambda: scene(client).arena is None)
    drawn(client)
    own = robot_of(scene(client)).workspace.arena
    assert (low.value, high.value) == tuple(zip(*own, strict=True))
    assert not client.fields._own.visible


def test_the_robots_own_arena_is_not_written_down(client):
    low, high = client.fields._corners[2]
    own = tuple(zip(*workspace_of(scene(client)).arena, strict=True))
    client.session.document.set_arena(((-7.5, 7.5), (-5.0, 5.0)))
    drawn(client)
    send(client, low, list(own[0]))
    send(client, high, list(own[1]))
    assert comes(client, lambda: scene(client).arena is None)


def test_an_arena_that_is_inside_out_is_refused(client):
    low, _ = client.fields._corners[2]
    shown = low.value
    send(client, low, [90.0, 0.0])
    assert comes(client, lambda: "low must be below high" in told(client))
    assert comes(client, lambda: low.value == shown)
    client.session.document.set_title("Something else")
    drawn(client)
    assert told(client) == ""


def pause_over(client, value):
    """The pause after a title was typed."""
    assert comes(client, lambda: "title" in client.fields._typed)
    assert comes(client, lambda: client.fields._typed["title"].value == value)
    client.fields._typed["title"] = client.fields._typed["title"]._replace(due=0.0)
    assert comes(client, lambda: not client.fields._typed)


def test_a_burst_of_typing_is_one_step(client, monkeypatch):
    monkeypatch.setattr(mission, "PAUSE", 1e9)
    before = scene(client)
    for length in range(1, 10):
        send(client, client.fields._plain["title"], "To a goal"[:length])
    pause_over(client, "To a goal")
    assert scene(client).title == "To a goal"
    client.session.undo()
    assert scene(client) == before


def test_what_was_typed_for_another_scene_is_dropped(client, monkeypatch):
    monkeypatch.setattr(mission, "PAUSE", 1e9)
    send(client, client.fields._plain["title"], "Late")
    assert comes(client, lambda: "title" in client.fields._typed)
    client.session.open(load_task("linear-07"))
    pause_over(client, "Late")
    assert scene(client) == load_task("linear-07")
