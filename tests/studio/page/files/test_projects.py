"""Uploads, and what survives a crash."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.errors import UserError
from core.task.grounding import MAX_ATOMS
from scenes import Region, format_scene, load_task
from scenes.toml import LARGEST_FILE
from studio.page.files import projects
from studio.page.files.projects import Autosave, ProjectError, discard, read_upload, recoverable

ROOT = Path(__file__).parents[4]
SCENE = load_task("linear-08")
TEXT = format_scene(SCENE).encode()


def left(folder: Path, *scenes, keep: bool = True) -> Autosave:
    """A session that saved these scenes and ended."""
    session = Autosave(folder)
    for scene in scenes:
        session.save(scene)
    session.close(keep=keep)
    return session


def test_an_upload_gives_the_scene():
    assert read_upload("mine.stl.toml", TEXT) == SCENE
    assert read_upload("MINE.TOML", b"\xef\xbb\xbf" + TEXT.replace(b"\n", b"\r\n")) == SCENE


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("policy.zip", TEXT, "policy.zip: not a project file"),
        ("a.toml", TEXT + b"#" * LARGEST_FILE, "bytes are too many: at most"),
        ("a.toml", b"\xff\xfe\x00", "a.toml: not UTF-8"),
        ("a.toml", b"= nonsense", "a.toml: not valid TOML"),
        ("a.toml", b"x = " + b"[" * 5000, "a.toml: not valid TOML"),
        ("a.toml", b"", "format"),
        ("a.toml", TEXT.replace(b"format = 1", b"format = 99"), "99 is not known"),
        ("a.toml", TEXT.replace(b'"linear"', b'"submarine"'), "unknown 'submarine'"),
        ("a.toml", TEXT.replace(b"horizon = 100", b"horizon = 1e9"), "horizon"),
        ("a.toml", TEXT.replace(b"0.6", b"nan"), "size"),
        ("../../../etc/x.toml", b"?", "^etc-x.toml: "),
    ],
)
def test_a_bad_upload_is_refused_with_its_reason(name, content, message):
    with pytest.raises(UserError, match=message):
        read_upload(name, content)


def test_an_upload_with_too_many_regions_is_refused():
    regions = [Region(f"A{n}", "circle", (0, 0), (1,)) for n in range(MAX_ATOMS + 1)]
    fits = replace(SCENE, regions=tuple(regions[:-1]))
    assert read_upload("a.toml", format_scene(fits).encode()) == fits
    many = format_scene(replace(SCENE, regions=tuple(regions))).encode()
    with pytest.raises(ProjectError, match=f"at most {MAX_ATOMS}"):
        read_upload("a.toml", many)


@given(st.text(max_size=60), st.binary(max_size=200))
def test_no_upload_raises_anything_but_a_user_error(name, content):
    with pytest.raises(UserError):
        read_upload(name + ".toml", content)


def test_what_a_session_left_is_recovered_and_discarded(tmp_path):
    edited = replace(SCENE, formula="F_[0:3](A1")
    session = left(tmp_path, SCENE, edited)
    (found,) = recoverable(tmp_path)
    assert (found.session, found.scene) == (session.session, edited)
    discard(session.session, tmp_path)
    assert recoverable(tmp_path) == ()
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_left_by_a_session_that_was_closed_or_saved_nothing(tmp_path):
    left(tmp_path, SCENE, keep=False)
    left(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_running_session_is_neither_listed_nor_discarded(tmp_path):
    session = Autosave(tmp_path)
    session.save(SCENE)
    assert recoverable(tmp_path) == ()
    with pytest.raises(ProjectError, match="no ended session"):
        discard(session.session, tmp_path)
    assert session.folder.is_dir()
    session.close(keep=True)
    assert len(recoverable(tmp_path)) == 1


def test_a_killed_process_leaves_its_scene(tmp_path):
    code = (
        "import sys, time; from pathlib import Path\n"
        "from scenes import load_task; from studio.page.files.projects import Autosave\n"
        "session = Autosave(Path(sys.argv[1])); session.save(load_task('linear-08'))\n"
        "print('saved', flush=True); time.sleep(60)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    environment = os.environ | {"JAX_PLATFORMS": "cpu"}
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == b"saved\n"
            assert recoverable(tmp_path) == ()
        finally:
            process.send_signal(signal.SIGKILL)
    assert [each.scene for each in recoverable(tmp_path)] == [SCENE]


def test_equal_scenes_are_written_once_and_old_versions_go(tmp_path):
    session = Autosave(tmp_path)
    assert session.save(SCENE)
    assert not session.save(SCENE)
    for seed in range(10):
        assert session.save(replace(SCENE, seed=seed))
    files = sorted(path.name for path in session.folder.iterdir())
    assert files == [f"{n:06d}.stl.toml" for n in range(7, 12)] + ["lock"]
    session.close(keep=True)
    assert recoverable(tmp_path)[0].scene.seed == 9


def test_a_torn_version_gives_way_to_the_one_before(tmp_path):
    session = left(tmp_path, SCENE, replace(SCENE, seed=3))
    newest = session.folder / "000002.stl.toml"
    newest.write_bytes(newest.read_bytes()[:100])
    (session.folder / "999999.stl.toml.bak").write_text("foreign")
    assert [each.scene for each in recoverable(tmp_path)] == [SCENE]
    (session.folder / "000001.stl.toml").unlink()
    assert recoverable(tmp_path) == ()


def test_a_full_disk_keeps_the_versions_before(tmp_path, monkeypatch):
    session = Autosave(tmp_path)
    session.save(SCENE)

    def full(*args):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(UserError, match="No space left"):
            session.save(replace(SCENE, seed=3))
    assert session.save(replace(SCENE, seed=4))
    session.close(keep=True)
    assert recoverable(tmp_path)[0].scene.seed == 4


def test_the_latest_session_comes_first_and_the_oldest_goes(tmp_path, monkeypatch):
    monkeypatch.setattr(projects, "SESSIONS", 2)
    names = []
    for day in range(1, 5):
        session = left(tmp_path, replace(SCENE, seed=day))
        dated = session.folder.rename(tmp_path / f"2025010{day}-120000-00000000")
        for path in dated.iterdir():
            os.utime(path, (1000 * day, 1000 * day))
        names.append(dated.name)
    assert [each.session for each in recoverable(tmp_path)] == names[:0:-1]
    assert [each.saved_at for each in recoverable(tmp_path)] == [4000, 3000, 2000]
    current = Autosave(tmp_path)
    assert [each.session for each in recoverable(tmp_path)] == names[:1:-1]
    current.close()


@pytest.mark.parametrize("name", ["", ".", "..", "../victim", "/etc", "20250101-120000-00000000"])
def test_discard_takes_no_paths(tmp_path, name):
    root = tmp_path / "autosave"
    session = left(root, SCENE)
    victim = tmp_path / "victim"
    victim.mkdir()
    with pytest.raises(ProjectError):
        discard(name, root)
    assert victim.is_dir() and session.folder.is_dir()


def test_links_in_the_folder_are_not_followed(tmp_path):
    root = tmp_path / "autosave"
    target = left(tmp_path / "elsewhere", SCENE).folder
    root.mkdir()
    (root / target.name).symlink_to(target)
    assert recoverable(root) == ()
    with pytest.raises(ProjectError):
        discard(target.name, root)
    assert target.is_dir()


def test_the_folder_follows_the_standard_and_is_private(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    session = Autosave()
    assert session.folder.parent == tmp_path / "tgpo-studio" / "autosave"
    assert session.folder.stat().st_mode & 0o777 == 0o700
    session.close()
    monkeypatch.setenv("HOME", str(tmp_path))
    for ignored in ("", "relative/path"):
        monkeypatch.setenv("XDG_STATE_HOME", ignored)
        assert projects.state_folder() == tmp_path / ".local" / "state" / "tgpo-studio"


def test_a_folder_that_cannot_be_made_is_explained(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ProjectError, match="autosave is off"):
        Autosave(tmp_path / "file" / "autosave")
    assert recoverable(tmp_path / "file" / "autosave") == ()


def test_a_session_may_end_in_another_thread_than_it_began_in(tmp_path):
    session = Autosave(tmp_path)
    session.save(SCENE)
    with ThreadPoolExecutor(1) as elsewhere:
        elsewhere.submit(session.close, keep=True).result()
    assert [each.session for each in recoverable(tmp_path)] == [session.session]


def test_a_lock_that_nobody_holds_or_that_is_missing_is_free(tmp_path):
    session = left(tmp_path, SCENE)
    assert len(recoverable(tmp_path)) == 1
    (session.folder / "lock").unlink(missing_ok=True)
    assert len(recoverable(tmp_path)) == 1
    (session.folder / "lock").mkdir()
    assert recoverable(tmp_path) == ()
