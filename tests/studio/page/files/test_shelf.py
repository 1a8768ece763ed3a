"""The user's own scenes, kept from one start of the page to the next."""

import os
from dataclasses import replace

import pytest

from core.errors import UserError
from scenes import blank, load_task
from studio.page.files.shelf import MOST, Shelf

MISSION = blank("linear")


def named(name):
    return replace(MISSION, name=name)


def test_what_is_kept_is_there_at_the_next_start(tmp_path, evil_scene):
    shelf = Shelf(tmp_path / "scenes")
    for scene in (MISSION, evil_scene, named("../../etc")):
        shelf.keep(scene)
    assert Shelf(tmp_path / "scenes").scenes == shelf.scenes
    assert list(shelf.scenes)[0] == "../../etc"
    assert {path.name for path in tmp_path.iterdir()} == {"scenes"}


def test_a_scene_replaces_the_one_with_its_name(tmp_path):
    shelf = Shelf(tmp_path)
    for title in ("one", "other"):
        shelf.keep(replace(MISSION, title=title))
    assert [scene.title for scene in shelf.scenes.values()] == ["other"]
    assert Shelf(tmp_path).scenes == shelf.scenes


def test_a_shipped_task_is_kept_only_once_it_is_edited(tmp_path):
    shelf, task = Shelf(tmp_path), load_task("linear-08")
    shelf.keep(task)
    assert not shelf.scenes
    shelf.keep(replace(task, seed=task.seed + 1))
    assert list(shelf.scenes) == ["linear-08"]


def test_the_oldest_make_room(tmp_path):
    shelf = Shelf(tmp_path)
    names = [f"mission {number}" for number in range(MOST + 3)]
    for age, name in enumerate(names):
        shelf.keep(named(name))
        for path in tmp_path.iterdir():
            os.utime(path, ns=(0, path.stat().st_mtime_ns - age))
    assert list(shelf.scenes) == names[:2:-1]
    assert set(Shelf(tmp_path).scenes) == set(shelf.scenes)


def test_damaged_and_foreign_files_are_skipped(tmp_path):
    Shelf(tmp_path).keep(MISSION)
    (tmp_path / "broken.stl.toml").write_bytes(b"\xff")
    (tmp_path / "note.txt").write_text("mine")
    assert list(Shelf(tmp_path).scenes.values()) == [MISSION]


def test_a_folder_that_cannot_be_made_is_told_and_the_scene_is_listed(tmp_path):
    (tmp_path / "file").touch()
    shelf = Shelf(tmp_path / "file" / "scenes")
    with pytest.raises(UserError, match="cannot be made"):
        shelf.keep(MISSION)
    assert list(shelf.scenes.values()) == [MISSION]


def test_a_new_name_is_free():
    shelf = Shelf()
    for expected in ("new", "new-2", "new-3"):
        assert shelf.free_name("new") == expected
        shelf.keep(named(expected))
