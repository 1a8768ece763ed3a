"""The critic over its time variables; a click on a cell rolls that schedule out."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import viser

from core.controller import NO_SCHEDULES
from core.decompose import Variable
from core.task.legs import leg_text
from core.truth import Truth
from studio.export.marks import TOLERANCE, Mark
from studio.page.figures.curve import curve_svg
from studio.page.figures.heatmap import Drawing, heatmap_svg
from studio.page.figures.svg import escape
from studio.page.figures.truth import truth_svg
from studio.page.panels.html import Html, note
from studio.page.panels.map_options import MapOptions
from studio.page.panels.truth import press, switch_html, truth_keys, truth_line, truth_of
from studio.page.picture import Picture
from studio.page.server.clicks import ClickField
from studio.page.session import Session
from studio.page.trainer import Training

CHOICE, SHOWN = "#ffffff", "#ff5d2e"


class HeatmapPanel:
    """Heatmap or curve with its options, and the critic's choice."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._drawn: tuple | None = None
        with gui.add_folder("Critic: value of each schedule"):
            self._clicks = ClickField(gui, lambda value: session.post(partial(self._click, value)))
            self._options = MapOptions(gui, session)
            self._stale = Html(gui)
            self._sides = ClickField(
                gui, lambda value: session.post(partial(press, session.analyst, value))
            )
            self._switch = Html(gui)
            self._map = Html(gui)
            self._best = gui.add_button("Find a plan", icon=viser.Icon.ROUTE, visible=False)

        @self._best.on_click
        async def _(_) -> None:
            session.post(session.analyst.ask)

    def draw(self, session: Session) -> None:
        """Show the newest picture of the current training."""
        training = session.subject
        self._stale.show(note(session.analyst.stale if session.analyst.picture else "", "warn"))
        picture, recording = current_picture(session), session.player.recording
        analyst = session.analyst
        current = (picture, recording, awaited(training), analyst.view)
        current = (*current, analyst.simulating, analyst.simulated)
        if current == self._drawn:
            return
        self._drawn = current
        self._best.visible = picture is not None
        searched = picture is not None and picture.subject.controller.search is not None
        self._options.show(picture if searched else None)
        switch = switch_html(self._sides, simulating=analyst.simulating)
        self._switch.show(switch if searched else "")
        if picture is None:
            self._map.show(f'<div class="tg tg-dim">{awaited(training)}</div>')
            return
        shown = None if recording is None else recording.schedule_for(picture.subject.task)
        truth = truth_of(analyst, picture) if searched else None
        self._map.show(self._content(picture, truth, shown))

    def _content(self, picture: Picture, truth: Truth | None, shown: tuple[int, ...] | None) -> str:
        task = picture.subject.task
        heatmap = picture.heatmap if truth is None else truth.heatmap
        if picture.subject.controller.search is None:
            return f'<div class="tg tg-dim">{NO_SCHEDULES}</div>'
        variables = task.grounding.decomposition.variables
        if not heatmap.axes:
            return '<div class="tg tg-dim">The formula has no time variables.</div>'
        marks = [Mark(picture.choice, CHOICE, "the critic's choice")]
        if shown is not None:
            marks.append(Mark(shown, SHOWN, "the rollout shown"))

        def reason(row: int, column: int) -> str:
            return "" if heatmap.legs is None else leg_text(task, heatmap.legs, (row, column))

        drawing = Drawing(
            self._clicks.script(_clicked_cell(picture, truth)),
            marks,
            None if picture.subject.chains is None else np.asarray(picture.subject.chains),
            reason,
        )
        if truth is not None:
            drawn = truth_svg(truth, variables, drawing)
        else:
            draw = heatmap_svg if len(heatmap.axes) > 1 else curve_svg
            drawn = draw(heatmap, variables, drawing)
        return f'<div class="tg tg-map">{drawn}{_caption(picture, truth, variables)}</div>'

    def _click(self, value: str) -> None:
        """Roll out the cell `axes column row`; values that do not fit the picture are ignored."""
        picture = current_picture(self._session)
        if picture is None:
            return
        schedule = clicked_schedule(picture, value)
        if schedule is not None:
            self._session.analyst.ask(schedule)


def current_picture(session: Session) -> Picture | None:
    """The newest picture, unless it is of a scene that was edited since."""
    picture = session.analyst.picture
    current = picture is not None and picture.subject.task is session.subject.task
    return picture if current else None


def awaited(training: Training) -> str:
    """What stands where the map will be."""
    if training.weights is not None:
        return "Being drawn…"
    return "Shown after the first epoch…" if training.running else "Appears in training."


def clicked_schedule(picture: Picture, value: str) -> tuple[int, ...] | None:
    """Schedule of a cell, sent as `axes column row`; None if the heatmap has no such cell."""
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


def _clicked_cell(picture: Picture, truth: Truth | None) -> str:
    """JavaScript for what is sent of the cell `column`, `row`: always one of the whole map."""
    axes = ",".join(str(axis) for axis in picture.heatmap.axes)
    if truth is None:
        return f"'{axes} '+column+' '+row"
    return f"'{axes} '+{truth.columns.tolist()}[column]+' '+{truth.rows.tolist()}[row]"


def _caption(picture: Picture, truth: Truth | None, variables: Sequence[Variable]) -> str:
    heatmap = picture.heatmap
    others = [i for i in range(len(variables)) if i not in heatmap.axes]
    lines = ["Click a cell to roll out its schedule."]
    if others:
        fixed = ", ".join(f"{variables[i].name} = {picture.choice[i]}" for i in others)
        lines.append(f"In the critic's choice, {fixed}.")
    keys = [] if truth is None else truth_keys(truth)
    keys += [
        f'<span style="color:{SHOWN}">◯</span> shown',
        f'<span style="color:#868e96">◯</span> critic\'s choice (epoch {picture.subject.epoch})',
    ]
    if picture.subject.chains is not None and len(heatmap.axes) > 1:
        keys.append("· chains")
    if (heatmap.shortfall > TOLERANCE).any():
        keys.append("▨ too little time to travel")
    unbroken = [f'<span style="white-space:nowrap">{key}</span>' for key in keys]
    found = "" if truth is None else f'<div class="tg-truth">{truth_line(truth)}</div>'
    return (
        f'<div class="tg-readout">&nbsp;</div>{found}'
        f'<div class="tg-dim">{escape(" ".join(lines))}<br>'
        f"{' &nbsp; '.join(unbroken)}</div>"
    )
