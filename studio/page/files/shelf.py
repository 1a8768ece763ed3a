"""The user's own scenes: those that were saved or opened last.

Copies of them stay in the user's state folder,

    $XDG_STATE_HOME/tgpo-studio/scenes/<hash of the scene's name>.stl.toml

so that the page can list them beside the shipped tasks.
"""

import hashlib
from contextlib import suppress
from pathlib import Path

from core.errors import UserError
from scenes import Scene, demo_names, load_scene, load_task, save_scene, task_names
from studio.page.files.projects import SUFFIX, ProjectError

MOST = 20
"""Scenes that are kept; the oldest are removed."""


class Shelf:
    """One scene for each name, the latest first."""

    def __init__(self, folder: Path | None = None) -> None:
        """Read what was kept; damaged and foreign files are skipped.

        Args:
            folder: of the copies; None keeps them as long as the program runs.
        """
        self._folder = folder
        self._scenes: dict[str, Scene] = {}
        for path in _latest(folder):
            with suppress(UserError):
                scene = load_scene(path)
                self._scenes.setdefault(scene.name, scene)

    @property
    def scenes(self) -> dict[str, Scene]:
        """The scenes by their names, the latest first."""
        return dict(self._scenes)

    def keep(self, scene: Scene) -> None:
        """Put a scene first, in place of one with the same name; not a task as it is shipped.

        Raises:
            UserError: it cannot be written, and is kept as long as the program runs.
        """
        if scene.name in (*task_names(), *demo_names()) and scene == load_task(scene.name):
            return
        others = [each for each in self._scenes.values() if each.name != scene.name]
        self._scenes = {each.name: each for each in (scene, *others[: MOST - 1])}
        if self._folder is not None:
            self._write(scene, self._folder)

    def free_name(self, name: str) -> str:
        """A name that no scene here has: `new`, `new-2`, ..."""
        names = (name, *(f"{name}-{number}" for number in range(2, MOST + 2)))
        return next(each for each in names if each not in self._scenes)

    def _write(self, scene: Scene, folder: Path) -> None:
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise ProjectError(f"{folder}: cannot be made: {error.strerror}") from error
        save_scene(scene, folder / f"{_hash(scene.name)}{SUFFIX}")
        for path in _latest(folder)[MOST:]:
            with suppress(OSError):
                path.unlink()


def _hash(name: str) -> str:
    """A file's name for a scene's, which may be any text."""
    return hashlib.sha256(name.encode()).hexdigest()[:16]


def _latest(folder: Path | None) -> list[Path]:
    """Scene files, the latest first; none where the folder cannot be read."""
    with suppress(OSError):
        if folder is not None and folder.is_dir():
            found = list(folder.glob(f"*{SUFFIX}"))
            return sorted(found, key=lambda path: path.stat().st_mtime_ns, reverse=True)
    return []
