"""The critic over its time variables; a click on a cell rolls that schedule out."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import viser

from core.decompose import Variable
from core.legs import leg_text
from studio.analyst import Picture
from studio.figures.curve import curve_svg
from studio.figures.heatmap import TOLERANCE, Drawing, Mark, heatmap_svg
from studio.figures.svg import escape
from studio.panels.html import Html, note
from studio.panels.map_options import MapOptions
from studio.server.clicks import ClickField
from studio.session import Session

CHOICE, SHOWN = "#ffffff", "#ff5d2e"


class HeatmapPanel:
    """Map or curve with its options, and the critic's choice."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._drawn: tuple | None = None
        with gui.add_folder("Critic: when to do what"):
            self._clicks = ClickField(gui, lambda value: session.post(partial(self._click, value)))
            self._options = MapOptions(gui, session)
            self._stale = Html(gui)
            self._map = Html(gui)
            self._best = gui.add_button(
                "Roll out the critic's choice", icon=viser.Icon.ROUTE, visible=False
            )

        @self._best.on_click
        async def _(_) -> None:
            session.post(session.analyst.ask)

    def draw(self, session: Session) -> None:
        """Show the newest picture of the present training."""
        picture, training = session.analyst.picture, session.training
        self._stale.show(note(session.analyst.stale if picture else "", "warn"))
        if picture is not None and picture.subject.task is not training.task:
            picture = None
        recording = session.player.recording
        current = (picture, recording, training.running, session.analyst.view)
        if current == self._drawn:
            return
        self._drawn = current
        self._best.visible = picture is not None
        self._options.show(picture)
        if picture is None:
            waiting = "Drawn after the first epoch…" if training.running else "Appears in training."
            self._map.show(f'<div class="tg tg-dim">{waiting}</div>')
            return
        shown = None if recording is None else recording.schedule
        self._map.show(self._content(picture, shown))

    def _content(self, picture: Picture, shown: tuple[int, ...] | None) -> str:
        heatmap, task = picture.heatmap, picture.subject.task
        variables = task.grounding.decomposition.variables
        if not heatmap.axes:
            return '<div class="tg tg-dim">The formula leaves no time to choose.</div>'
        marks = [Mark(picture.choice, CHOICE, "the critic's choice")]
        if shown is not None:
            marks.append(Mark(shown, SHOWN, "the rollout shown"))
        axes = ",".join(str(axis) for axis in heatmap.axes)

        def reason(row: int, column: int) -> str:
            return "" if heatmap.legs is None else leg_text(task, heatmap.legs, (row, column))

        drawing = Drawing(
            self._clicks.script(f"'{axes} '+column+' '+row"),
            marks,
            None if picture.subject.chains is None else np.asarray(picture.subject.chains),
            reason,
        )
        draw = heatmap_svg if len(heatmap.axes) > 1 else curve_svg
        drawn = draw(heatmap, variables, drawing)
        return f'<div class="tg tg-map">{drawn}{_caption(picture, variables)}</div>'

    def _click(self, value: str) -> None:
        """Roll out the cell `axes column row`; what does not fit the picture is ignored."""
        picture = self._session.analyst.picture
        if picture is None:
            return
        schedule = clicked_schedule(picture, value)
        if schedule is not None:
            self._session.analyst.ask(schedule)


def clicked_schedule(picture: Picture, value: str) -> tuple[int, ...] | None:
    """Schedule of a cell that a page sent as `axes column row`; None if the map has no such."""
    heatmap = picture.heatmap
    axes, *cell = value.split(" ")
    if axes != ",".join(str(axis) for axis in heatmap.axes) or len(cell) != 2:
        return None
    if not all(part.isdecimal() and len(part) < 6 for part in cell):
        return None
    column, row = int(cell[0]), int(cell[1])
    if column >= heatmap.first.size or row >= heatmap.second.size:
        return None
    count = len(picture.choice)
    return tuple(int(step) for step in heatmap.schedule_at(row, column)[:count])


def _caption(picture: Picture, variables: Sequence[Variable]) -> str:
    heatmap = picture.heatmap
    others = [i for i in range(len(variables)) if i not in heatmap.axes]
    lines = ["Click a cell to see that schedule carried out."]
    if others:
        fixed = ", ".join(f"{variables[i].name} = {picture.choice[i]}" for i in others)
        lines.append(f"The critic's choice has {fixed}.")
    keys = [
        f'<span style="color:{SHOWN}">◯</span> shown',
        f'<span style="color:#868e96">◯</span> critic\'s choice (epoch {picture.subject.epoch})',
    ]
    if picture.subject.chains is not None and len(heatmap.axes) > 1:
        keys.append("· chains")
    if (heatmap.shortfall > TOLERANCE).any():
        keys.append("▨ too little time to travel")
    return (
        f'<div class="tg-readout">&nbsp;</div><div class="tg-dim">{escape(" ".join(lines))}<br>'
        f"{' &nbsp; '.join(keys)}</div>"
    )
