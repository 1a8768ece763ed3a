import threading

import pytest

from core.errors import UserError
from scenes import load_task, save_scene
from studio.page import app
from studio.page.app import FIRST_TASK, Studio, default_config, opened_scene, serve
from tests.studio.conftest import free_port
from tests.studio.waiting import wait_for


def test_the_arguments_choose_the_scene(tmp_path):
    path = tmp_path / "mine.stl.toml"
    save_scene(load_task("unicycle-03"), path)
    assert opened_scene(None, None).name == FIRST_TASK
    assert opened_scene("linear-02", None).name == "linear-02"
    assert opened_scene(None, str(path)).robot == "unicycle"


@pytest.mark.parametrize(
    ("task", "scene", "text"),
    [
        ("nope", None, "unknown 'nope'"),
        (None, "missing.stl.toml", "cannot be read"),
        ("linear-01", "a.toml", "not both"),
    ],
)
def test_wrong_arguments_are_errors(task, scene, text):
    with pytest.raises(UserError, match=text):
        opened_scene(task, scene)


def test_the_button_trains_the_studios_own_method():
    config = default_config(load_task("unicycle-03"), 42.0)
    assert (config.time_limit, config.seed) == (42.0, 1007)
    assert config.algorithm.share_mcmc > 0


def test_serve_says_where_and_ends_on_an_interrupt(monkeypatch, capsys):
    port = free_port()

    def interrupted(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(Studio, "run", interrupted)
    serve(task="linear-01", port=port, open_browser=False)
    assert f"http://127.0.0.1:{port}" in capsys.readouterr().out
    serve(task="linear-01", port=port, open_browser=False)


def test_the_browser_is_opened_on_request(monkeypatch):
    opened = []
    monkeypatch.setattr(app.webbrowser, "open", opened.append)
    monkeypatch.setattr(Studio, "run", lambda self: wait_for(lambda: bool(opened)))
    port = free_port()
    serve(task="linear-01", port=port)
    assert opened == [f"http://127.0.0.1:{port}"]


def test_a_defect_of_one_panel_is_shown_and_the_others_are_drawn(capsys):
    studio = Studio(load_task("linear-01"), None, "127.0.0.1", free_port())
    drawn = threading.Event()

    class Broken:
        def draw(self, session):
            raise ZeroDivisionError("oh")

    class Fine:
        def draw(self, session):
            drawn.set()

    studio._drawables = [Broken(), Fine()]
    loop = threading.Thread(target=studio.run)
    loop.start()
    assert drawn.wait(10)
    assert wait_for(lambda: studio.session.error == "Broken: ZeroDivisionError: oh")
    studio.close()
    loop.join(10)
    assert not loop.is_alive()
    assert capsys.readouterr().err.count("Traceback") == 1
