"""Uploaded project files, and autosaved copies that survive a crash.

Autosave keeps a session's scene in the user's state folder:

    $XDG_STATE_HOME/tgpo-studio/autosave/<session>/lock
                                                   000001.stl.toml ... the latest versions

A session holds its lock as long as its process lives, however it ends. A folder whose lock is
free was left by a session that ended without `close`: its content can be recovered.
"""

import re
import secrets
import shutil
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout
from platformdirs import user_state_path

from core.errors import UserError
from core.task.grounding import MAX_ATOMS
from scenes import Scene, load_scene, parse_scene, save_scene
from scenes.toml import LARGEST_FILE
from studio.export.filenames import safe_name

SUFFIX = ".stl.toml"
VERSIONS = 5
"""Versions of a scene that a session keeps."""

SESSIONS = 20
"""Ended sessions that are kept; the oldest are removed."""

_SESSION = re.compile(r"[0-9]{8}-[0-9]{6}-[0-9a-f]{8}")
_VERSION = re.compile(rf"([0-9]{{6,}}){re.escape(SUFFIX)}")


class ProjectError(UserError):
    """A project that cannot be opened or saved."""


def read_upload(name: str, content: bytes) -> Scene:
    """Check and read a project file that a client sent.

    Args:
        name: as given by the client; only displayed.
        content: all bytes of the file.

    Raises:
        UserError: too large, not a project, or one that this program cannot use.
    """
    shown = safe_name(name, "upload")
    if not name.lower().endswith(".toml"):
        raise ProjectError(f"{shown}: not a project file; its name must end in {SUFFIX}")
    if len(content) > LARGEST_FILE:
        raise ProjectError(
            f"{shown}: {len(content):,} bytes are too many: at most {LARGEST_FILE:,}"
        )
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ProjectError(f"{shown}: not UTF-8 text") from error
    scene = parse_scene(text, shown)
    if len(scene.regions) > MAX_ATOMS:
        raise ProjectError(
            f"{shown}: {len(scene.regions)} regions; a scene has at most {MAX_ATOMS}"
        )
    return scene


def state_folder() -> Path:
    """The user's state folder of this program, on Linux below $XDG_STATE_HOME."""
    return user_state_path("tgpo-studio", appauthor=False)


@dataclass(frozen=True)
class Recoverable:
    """The latest readable version of what a session left.

    Attributes:
        session: its name.
        scene: what it was editing.
        saved_at: seconds since the epoch.
    """

    session: str
    scene: Scene
    saved_at: float


class Autosave:
    """Keeps the scene of this session until `close`."""

    def __init__(self, folder: Path | None = None) -> None:
        """Begin a session.

        Args:
            folder: of all sessions; by default the user's.

        Raises:
            ProjectError: the folder cannot be written.
        """
        self.root = state_folder() / "autosave" if folder is None else folder
        self.session = f"{time.strftime('%Y%m%d-%H%M%S')}-{secrets.token_hex(4)}"
        self.folder = self.root / self.session
        self._saved: Scene | None = None
        self._version = 0
        try:
            self.root.mkdir(mode=0o700, parents=True, exist_ok=True)
            self.folder.mkdir(mode=0o700)
            # Held for the session, whichever of the page's threads begins and ends it.
            self._lock = FileLock(self.folder / "lock", thread_local=False)
            self._lock.acquire()
        except OSError as error:
            raise ProjectError(
                f"{self.root}: autosave is off; the folder cannot be written: {error.strerror}"
            ) from error
        _remove_oldest(self.root)

    def save(self, scene: Scene) -> bool:
        """Write a version, unless nothing has changed; returns whether it was written.

        Raises:
            UserError: the disk is full or gone; earlier versions stay.
        """
        if scene == self._saved:
            return False
        save_scene(scene, self.folder / f"{self._version + 1:06d}{SUFFIX}")
        self._version += 1
        self._saved = scene
        for path in _versions(self.folder)[:-VERSIONS]:
            with suppress(OSError):
                path.unlink()
        return True

    def clear(self) -> None:
        """Delete the versions: the work was saved elsewhere."""
        for path in _versions(self.folder):
            with suppress(OSError):
                path.unlink()
        self._saved = None

    def close(self, *, keep: bool = False) -> None:
        """End the session; with `keep`, its scene can be recovered (unsaved work)."""
        if not keep or self._version == 0:
            shutil.rmtree(self.folder, ignore_errors=True)
        self._lock.release()


def recoverable(folder: Path | None = None) -> tuple[Recoverable, ...]:
    """What ended sessions have left, latest first."""
    root = state_folder() / "autosave" if folder is None else folder
    found = []
    for session in _left(root):
        latest = _latest(session)
        if latest is not None:
            found.append(latest)
    return tuple(sorted(found, key=lambda each: each.saved_at, reverse=True))


def discard(session: str, folder: Path | None = None) -> None:
    """Remove what an ended session has left.

    Args:
        session: its name; looked up among those that exist, never made into a path.
        folder: of all sessions; by default the user's.

    Raises:
        ProjectError: there is no such session, or it is still running.
    """
    root = state_folder() / "autosave" if folder is None else folder
    for path in _left(root):
        if path.name == session:
            shutil.rmtree(path, ignore_errors=True)
            return
    raise ProjectError(f"no ended session {safe_name(session)!r} to discard")


def _latest(session: Path) -> Recoverable | None:
    """The newest readable version; damaged and foreign files are skipped."""
    for path in reversed(_versions(session)):
        try:
            return Recoverable(session.name, load_scene(path), path.stat().st_mtime)
        except (UserError, OSError):
            continue
    return None


def _versions(session: Path) -> list[Path]:
    """Files of a session, oldest first."""
    found = []
    with suppress(OSError):
        found = [path for path in session.iterdir() if _VERSION.fullmatch(path.name)]
    return sorted(found, key=lambda path: int(path.name.split(".")[0]))


def _left(root: Path) -> list[Path]:
    """Folders of sessions that have ended, oldest first."""
    if not root.is_dir():
        return []
    sessions = [path for path in root.iterdir() if _SESSION.fullmatch(path.name)]
    ended = [path for path in sessions if not path.is_symlink() and path.is_dir()]
    return sorted(path for path in ended if _is_free(path / "lock"))


def _is_free(path: Path) -> bool:
    """Whether nobody holds a lock: a missing file is free, one that is out of reach is not."""
    if not path.exists():
        return True
    try:
        with FileLock(path, blocking=False):
            return True
    except (Timeout, OSError):
        return False


def _remove_oldest(root: Path) -> None:
    for path in _left(root)[:-SESSIONS]:
        shutil.rmtree(path, ignore_errors=True)
