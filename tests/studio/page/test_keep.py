"""The files of the Keep tab, made from a plan without a browser, and its panels."""

import io
import json
import threading
import zipfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Event
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PIL import Image
from viser import UploadedFile

from core.errors import UserError
from scenes import blank as blank_scene
from scenes import load_task, parse_scene
from scenes.scene import format_scene
from studio.page.app import Studio
from studio.page.files import keeping, movie
from studio.page.files.keeping import load_policy
from studio.page.files.projects import Autosave, recoverable
from studio.page.files.shelf import Shelf
from studio.page.panels.keep import KeepPanel
from studio.page.panels.recovery import RecoveryPanel
from studio.page.server.security import start_server
from studio.page.session import Session
from tests.studio.conftest import free_port
from tests.studio.waiting import wait_for


@pytest.fixture(scope="module")
def shown(disk_cache):
    """A session on which a plan has played."""
    session = Session(load_task("linear-08"), None, lambda scene, limit: pytest.fail("no training"))

    def playing():
        session.tick(0.0)
        return session.player.recording is not None and session.analyst.picture is not None

    assert wait_for(playing)
    yield session
    session.close()


@pytest.fixture
def blank():
    session = Session(load_task("linear-08"), None, lambda scene, limit: pytest.fail("no training"))
    yield session
    session.close()


def test_the_demo_satisfies_its_formula(shown):
    assert shown.player.recording.satisfied


def test_every_export_can_be_read(shown, tmp_path):
    name, content = keeping.project_file(shown.document.scene)
    assert name == "linear-08.stl.toml"
    assert parse_scene(content.decode(), name) == shown.document.scene
    rows = keeping.csv_file(shown).content.decode().splitlines()
    assert len(rows) == shown.player.recording.steps + 2
    with np.load(io.BytesIO(keeping.npz_file(shown).content)) as arrays:
        assert arrays["satisfied"]
    for export in (keeping.heatmap_file, keeping.tree_file):
        assert Image.open(io.BytesIO(export(shown).content)).format == "PNG"
    name, content = keeping.bundle_file(shown)
    assert json.loads(zipfile.ZipFile(io.BytesIO(content)).read("metadata.json"))["robot"]
    (tmp_path / name).write_bytes(content)
    assert load_policy(tmp_path / name).scene == load_task("linear-08")


def test_two_recordings_at_once_do_not_take_each_others_port(shown, monkeypatch):
    found = threading.Barrier(2)

    def slow(host, port):
        free = is_free(host, port)
        if free:
            with suppress(threading.BrokenBarrierError):
                found.wait(0.5)
        return free

    is_free = movie.is_free
    monkeypatch.setattr(movie, "is_free", slow)
    with ThreadPoolExecutor(2) as pool:
        files = list(pool.map(keeping.html_file, [shown, shown]))
    assert all(b"__VISER_EMBED_DATA__" in file.content for file in files)


def test_the_recording_is_one_html_file_and_moves_nothing_on_the_page(shown):
    before = shown.player.position
    name, content = keeping.html_file(shown)
    assert name.endswith(".html")
    assert b"__VISER_EMBED_DATA__" in content
    assert shown.player.position == before


@pytest.mark.parametrize(
    ("export", "text"),
    [
        (keeping.csv_file, "no rollout yet"),
        (keeping.html_file, "no rollout yet"),
        (keeping.heatmap_file, "no heatmap yet"),
        (keeping.bundle_file, "no policy yet"),
    ],
)
def test_an_export_of_nothing_says_why(blank, export, text):
    with pytest.raises(UserError, match=text):
        export(blank)


def test_unsaved_work_of_a_crash_is_offered_and_recovered(tmp_path):
    crashed = Autosave(tmp_path)
    crashed.save(load_task("linear-03"))
    crashed.close(keep=True)  # what the system leaves when a process ends without close
    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port())
    panel = RecoveryPanel(studio._server.gui, studio.session, tmp_path)
    panel.draw(studio.session)
    assert panel._choice.visible
    panel._choose("Recover")
    assert studio.session.document.scene == load_task("linear-03")
    panel.draw(studio.session)
    assert not panel._choice.visible
    assert studio.session.document.modified
    assert recoverable(tmp_path) == ()  # this process holds it now
    panel.close()
    studio.close()
    (left,) = recoverable(tmp_path)
    assert left.scene == load_task("linear-03")


def test_recovering_over_unsaved_edits_asks_first(tmp_path):
    crashed = Autosave(tmp_path)
    crashed.save(load_task("linear-03"))
    crashed.close(keep=True)
    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port())
    session, panel = (
        studio.session,
        RecoveryPanel(studio._server.gui, studio.session, tmp_path),
    )
    session.document.set_formula("F_[0:90](A2)")
    panel._choose("Recover")
    assert session.leaving is not None
    assert session.document.scene.formula == "F_[0:90](A2)"
    session.confirm(False)
    assert recoverable(tmp_path)
    panel._choose("Recover")
    session.confirm(True)
    assert session.document.scene == load_task("linear-03")
    panel.close()
    studio.close()


def test_modified_work_is_saved_and_saved_work_is_not_kept(tmp_path):
    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port(), state=tmp_path)
    loop = threading.Thread(target=studio.run)
    loop.start()
    studio.session.post(lambda: studio.session.edit("F_[0:90](A2)"))
    autosaves = tmp_path / "autosave"
    assert wait_for(lambda: any(autosaves.rglob("*.stl.toml")))
    studio.close()
    loop.join(10)
    (left,) = recoverable(autosaves)
    assert left.scene.formula == "F_[0:90](A2)"


def test_one_file_is_made_at_a_time():
    """Clicks in quick succession once made as many files at once, on as many threads."""
    server, sent, go, made = start_server("127.0.0.1", free_port(), "keep"), [], Event(), []

    def export(_):
        made.append(1)
        go.wait(20)
        return keeping.Download("file.txt", b"content")

    download = SimpleNamespace(send_file_download=lambda name, *_, **__: sent.append(name))
    client = cast(Any, download)
    session = Session(load_task("linear-08"), None, lambda *_: pytest.fail("no training"))
    panel = KeepPanel(server.gui, session, Shelf())
    try:
        with ThreadPoolExecutor(4) as pool:
            results = [pool.submit(panel._export, export, client) for _ in range(4)]
            assert wait_for(lambda: sum(result.done() for result in results) == 3)
            go.set()
        assert sorted(result.result() for result in results) == [False, False, False, True]
        assert len(made) == len(sent) == 1
        assert panel._export(export, client)
    finally:
        session.close()
        server.stop()


def test_scenes_that_are_saved_or_opened_are_kept():
    server, shelf = start_server("127.0.0.1", free_port(), "keep"), Shelf()
    session = Session(
        blank_scene("linear", name="mine"), None, lambda *_: pytest.fail("no training")
    )
    client = cast(Any, SimpleNamespace(send_file_download=lambda *_, **__: None))
    panel = KeepPanel(server.gui, session, shelf)
    other = format_scene(blank_scene("unicycle", name="other")).encode()
    try:
        session.document.set_title("By hand")
        saved = session.document.scene
        panel._save(client)
        session.tick(0.0)
        assert not session.document.modified
        assert shelf.scenes == {"mine": saved}
        panel._open(UploadedFile("other.stl.toml", other))
        session.tick(0.0)
        assert list(shelf.scenes) == ["other", "mine"]
        assert session.document.scene == shelf.scenes["other"]
    finally:
        session.close()
        server.stop()
