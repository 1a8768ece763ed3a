"""What a user can save, as files in memory, and what can be opened again.

Every function reads the session at one moment and may run on any thread: scenes, policies,
recordings and pictures are never mutated.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from core.controller import NO_SCHEDULES
from core.errors import UserError
from scenes import Scene, format_scene
from studio.export.archives import LARGEST_UPLOAD, ArchiveError, bundle_zip, read_policy_zip
from studio.export.filenames import download_name
from studio.export.marks import Mark
from studio.export.pictures import heatmap_png, tree_png
from studio.export.tables import RolloutTable, rollout_csv, rollout_npz, rollout_table
from studio.page.files.movie import rollout_html
from studio.page.files.projects import SUFFIX
from studio.page.session import Session
from studio.runs.bundle import Policy, bundle_folder, load_bundle
from studio.runs.recording import Recording


class Download(NamedTuple):
    """A file for the browser."""

    name: str
    content: bytes


Export = Callable[[Session], Download]


def project_file(scene: Scene) -> Download:
    """A scene with its formula."""
    return Download(download_name(scene.name, suffix=SUFFIX), format_scene(scene).encode())


def bundle_file(session: Session) -> Download:
    """The policy bundle, zipped."""
    policy = session.policy()
    name = download_name(policy.scene.name, "policy", suffix=".zip")
    return Download(name, bundle_zip(policy))


def csv_file(session: Session) -> Download:
    """The rollout on screen as a table."""
    recording = _recording(session)
    return Download(_named(recording, "rollout", ".csv"), rollout_csv(_table(recording)))


def npz_file(session: Session) -> Download:
    """The rollout on screen for NumPy."""
    recording = _recording(session)
    return Download(_named(recording, "rollout", ".npz"), rollout_npz(_table(recording)))


def html_file(session: Session) -> Download:
    """The rollout on screen as a web page that needs no server."""
    recording = _recording(session)
    return Download(_named(recording, "rollout", ".html"), rollout_html(session, recording))


def heatmap_file(session: Session) -> Download:
    """The critic's heatmap."""
    picture, recording = session.analyst.picture, session.player.recording
    if picture is None:
        raise UserError("There is no heatmap yet. Train first, or load a policy.")
    if picture.subject.controller.search is None:
        raise UserError(f"There is no heatmap to export. {NO_SCHEDULES}")
    task = picture.subject.task
    marks = [Mark(picture.choice, "#ffffff", "the critic's choice")]
    if recording is not None and recording.task is task:
        marks.append(Mark(recording.schedule, "#ff5d2e", "the rollout shown"))
    title = f"{task.name}: the critic after {picture.subject.epoch} epochs"
    image = heatmap_png(picture.heatmap, task.grounding.decomposition, title=title, marks=marks)
    return Download(download_name(task.name, "heatmap", suffix=".png"), image)


def tree_file(session: Session) -> Download:
    """The decomposition."""
    decomposition, scene = session.specification.decomposition, session.document.scene
    if decomposition is None:
        raise UserError("There is no tree: the formula has an error.")
    image = tree_png(decomposition, title=scene.title or scene.name)
    return Download(download_name(scene.name, "tree", suffix=".png"), image)


def load_policy(path: Path) -> Policy:
    """The policy of a run or a bundle (a folder or a zip file).

    Raises:
        UserError: there is none.
    """
    if not path.is_file():
        return load_bundle(bundle_folder(path))
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_UPLOAD + 1)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read: {error.strerror}") from error
    return read_policy_zip(path.name, content)


def _recording(session: Session) -> Recording:
    recording = session.player.recording
    if recording is None:
        raise UserError("There is no rollout yet. Train, then click a cell of the heatmap.")
    return recording


def _named(recording: Recording, what: str, suffix: str) -> str:
    return download_name(recording.task.name, what, suffix=suffix)


def _table(recording: Recording) -> RolloutTable:
    return rollout_table(
        recording.task,
        recording.schedule,  # pyright: ignore[reportArgumentType]
        recording.states,
        recording.actions,
        recording.margins,
        moves=recording.moves,
    )
