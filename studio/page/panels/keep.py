"""Files: projects, policies, rollouts and pictures, through the browser's downloads and uploads."""

import threading
import traceback
from functools import partial

import viser

from core.errors import UserError
from scenes import Scene
from studio.export.archives import read_policy_zip
from studio.export.filenames import safe_name
from studio.page.files import keeping
from studio.page.files.keeping import Export
from studio.page.files.projects import read_upload
from studio.page.files.shelf import Shelf
from studio.page.panels.html import Html, note
from studio.page.session import Session

ROLLOUT: dict[str, Export] = {
    "CSV": keeping.csv_file,
    "NPZ": keeping.npz_file,
    "HTML": keeping.html_file,
}
PICTURES: dict[str, Export] = {"Heatmap": keeping.heatmap_file, "Tree": keeping.tree_file}


UNSAVED = '<div class="tg tg-unsaved">● Unsaved changes</div>'


class KeepPanel:
    """Buttons, and below them the result of the last one."""

    def __init__(self, gui: viser.GuiApi, session: Session, shelf: Shelf) -> None:
        self._session, self._shelf = session, shelf
        self._said = ""
        self._making = threading.Lock()
        """Held while a file is made; more clicks meanwhile do nothing."""
        with gui.add_folder("Project"):
            self._unsaved = Html(gui)
            save = gui.add_button("Save project", icon=viser.Icon.DEVICE_FLOPPY)
            opened = gui.add_upload_button(
                "Open project (*.stl.toml)",
                icon=viser.Icon.FOLDER_OPEN,
                color="gray",
                mime_type=".toml",
            )
        with gui.add_folder("Policy"):
            bundle = gui.add_button("Export policy bundle", icon=viser.Icon.PACKAGE)
            loaded = gui.add_upload_button(
                "Load a run or bundle (*.zip)",
                icon=viser.Icon.UPLOAD,
                color="gray",
                mime_type=".zip",
            )
        with gui.add_folder("Rollout and pictures"):
            rollout = gui.add_button_group("Rollout", list(ROLLOUT))
            pictures = gui.add_button_group("Pictures", list(PICTURES))
        self._status = Html(gui)
        save.on_click(lambda event: self._save(event.client))
        bundle.on_click(self._export_bundle)
        for group, exports in ((rollout, ROLLOUT), (pictures, PICTURES)):
            group.on_click(partial(self._export_chosen, exports))
        opened.on_upload(lambda event: self._open(event.target.value))
        loaded.on_upload(lambda event: self._load(event.target.value))

    def draw(self, session: Session) -> None:
        """Show whether there are unsaved changes, and the last result."""
        modified = session.document.modified
        self._unsaved.show(UNSAVED if modified else "")
        self._status.show(self._said)

    def _save(self, client: viser.ClientHandle | None) -> None:
        """Save the scene as it is now; later edits stay unsaved."""
        document = self._session.document
        scene = document.scene
        if self._export(lambda _: keeping.project_file(scene), client):
            self._session.post(partial(document.mark_saved, scene))
            self._session.post(partial(self._shelf.keep, scene))

    def _export_bundle(self, event: viser.GuiEvent) -> None:
        self._export(keeping.bundle_file, event.client)

    def _export_chosen(self, exports: dict[str, Export], event: viser.GuiEvent) -> None:
        export = exports.get(event.target.value)
        if export is not None:
            self._export(export, event.client)

    def _export(self, export: Export, client: viser.ClientHandle | None) -> bool:
        """Make one file at a time on a viewer thread and send it; show the reason if that fails."""
        if client is None or not self._making.acquire(blocking=False):
            return False
        self._said = '<div class="tg tg-dim tg-kept">Preparing the file…</div>'
        try:
            name, content = export(self._session)
            client.send_file_download(name, content, save_immediately=True)
            self._said = f'<div class="tg tg-kept">✓ {name} ({_size(len(content))})</div>'
        except Exception as error:  # noqa: BLE001 - the page shows it and lives on
            self._fail("Export failed", error)
            return False
        finally:
            self._making.release()
        return True

    def _open(self, file: viser.UploadedFile) -> None:
        try:
            scene = read_upload(file.name, file.content)
        except Exception as error:  # noqa: BLE001
            self._fail("Could not open the file", error)
            return
        self._session.post(partial(self._session.leave, partial(self._show, scene)))
        self._said = f'<div class="tg tg-kept">✓ Opened {safe_name(file.name, "project")}</div>'

    def _show(self, scene: Scene) -> None:
        self._session.open(scene)
        self._shelf.keep(scene)

    def _load(self, file: viser.UploadedFile) -> None:
        shown = safe_name(file.name, "upload")
        self._said = f'<div class="tg tg-dim tg-kept">Reading {shown}…</div>'
        try:
            policy = read_policy_zip(file.name, file.content)
        except Exception as error:  # noqa: BLE001
            self._fail("Could not load the file", error)
            return
        self._session.post(
            partial(
                self._session.leave, partial(self._session.load, policy, f"the policy in {shown}")
            )
        )
        self._said = f'<div class="tg tg-kept">✓ Loaded {shown}</div>'

    def _fail(self, what: str, error: Exception) -> None:
        if isinstance(error, UserError):
            text = str(error)
        else:
            traceback.print_exc()
            text = f"{type(error).__name__}: {error}"
        self._said = note(f"{what}. {text}")


def _size(count: int) -> str:
    return f"{count / 1000:.0f} kB" if count < 10**6 else f"{count / 10**6:.1f} MB"
