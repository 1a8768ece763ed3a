"""The decomposition: tree and table; leaves follow the rollout and highlight their regions."""

from functools import partial

import viser

from core.decompose import Decomposition
from core.stl import atom_names
from studio.page.figures.leaves import leaf_style
from studio.page.figures.svg import escape
from studio.page.figures.tables import abbreviation_list, task_table
from studio.page.figures.tree import tree_svg
from studio.page.panels.html import Html
from studio.page.server.clicks import ClickField
from studio.page.session import Session


class TreePanel:
    """Shows the decomposition of the last valid formula."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._drawn: tuple[Decomposition | None, bool] | None = None
        self._pinned = ""
        self._clicks = ClickField(gui, lambda value: session.post(partial(self._point, value)))
        self._session = session
        self._colors = Html(gui)
        with gui.add_folder("Decomposition"):
            self._tree = Html(gui)
        with gui.add_folder("Tasks"):
            self._table = Html(gui)

    def draw(self, session: Session) -> None:
        """Redraw after an edit."""
        specification = session.specification
        self._colors.show(_colors(session))
        current = (specification.decomposition, bool(specification.error))
        if current == self._drawn:
            return
        self._drawn = current
        self._pinned, session.highlighted = "", ()
        decomposition, outdated = current
        if decomposition is None:
            self._tree.show('<div class="tg tg-dim">Appears once the formula is valid.</div>')
            self._table.show("")
            return
        style = "opacity:0.4" if outdated else ""
        tree = f'{tree_svg(decomposition, self._handlers())}<div style="height:0.3em"></div>'
        names = abbreviation_list(decomposition)
        self._tree.show(f'<div class="tg tg-tree" style="{style}">{tree}{names}</div>')
        self._table.show(f'<div class="tg" style="{style}">{task_table(decomposition)}</div>')

    def _handlers(self) -> str:
        """Attributes by which a leaf reports the pointer: `enter 0,1`, `leave`, `pin`."""
        events = {"enter": "enter", "leave": "leave", "down": "pin"}
        scripts = {
            event: escape(self._clicks.script(f"'{word} '+this.dataset.tasks"))
            for event, word in events.items()
        }
        return " ".join(f'onpointer{event}="{script}"' for event, script in scripts.items())

    def _point(self, value: str) -> None:
        """Highlight a leaf's regions while the pointer is on it, or until it is clicked again."""
        word, _, leaf = value.partition(" ")
        if word == "pin":
            self._pinned = "" if leaf == self._pinned else leaf
        shown = leaf if word in ("enter", "pin") else self._pinned
        self._session.highlighted = leaf_regions(self._session.specification.decomposition, shown)


def leaf_regions(decomposition: Decomposition | None, leaf: str) -> tuple[str, ...]:
    """Regions that a leaf `0,1` mentions; none for anything that is not a leaf."""
    numbers = leaf.split(",")
    if decomposition is None or not all(n.isdecimal() and len(n) < 4 for n in numbers):
        return ()
    tasks = [int(n) for n in numbers if int(n) < len(decomposition.tasks)]
    names = [name for task in tasks for name in atom_names(decomposition.tasks[task].predicate)]
    return tuple(dict.fromkeys(names))


def _colors(session: Session) -> str:
    """Colours of the leaves at the playhead, if the rollout belongs to the tree shown."""
    player, decomposition = session.player, session.specification.decomposition
    recording = player.recording
    if recording is None or recording.task.grounding.decomposition is not decomposition:
        return ""
    return leaf_style(recording.task.grounding.decomposition, recording.status_at(player.position))
