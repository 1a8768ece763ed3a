"""The decomposition: tree and table."""

import viser

from core.decompose import Decomposition
from studio.figures.tables import abbreviation_list, task_table
from studio.figures.tree import tree_svg
from studio.panels.html import Html
from studio.session import Session


class TreePanel:
    """Shows how the formula that was right last decomposes."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._drawn: tuple[Decomposition | None, bool] | None = None
        with gui.add_folder("Decomposition"):
            self._tree = Html(gui)
        with gui.add_folder("Tasks"):
            self._table = Html(gui)

    def draw(self, session: Session) -> None:
        """Redraw after an edit."""
        specification = session.specification
        current = (specification.decomposition, bool(specification.error))
        if current == self._drawn:
            return
        self._drawn = current
        decomposition, outdated = current
        if decomposition is None:
            self._tree.show('<div class="tg tg-dim">Appears once the formula is right.</div>')
            self._table.show("")
            return
        style = "opacity:0.4" if outdated else ""
        tree = f'{tree_svg(decomposition)}<div style="height:0.3em"></div>'
        names = abbreviation_list(decomposition)
        self._tree.show(f'<div class="tg tg-tree" style="{style}">{tree}{names}</div>')
        self._table.show(f'<div class="tg" style="{style}">{task_table(decomposition)}</div>')
