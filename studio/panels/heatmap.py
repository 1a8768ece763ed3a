"""The critic over two time variables; a click on a cell rolls that schedule out."""

from collections.abc import Sequence
from functools import partial

import viser

from core.decompose import Variable
from core.task import Task
from studio.analyst import Picture, time_variables
from studio.clicks import ClickField
from studio.figures.heatmap import TOLERANCE, Mark, heatmap_svg
from studio.figures.svg import escape
from studio.panels.html import Html
from studio.session import Session

CHOICE, SHOWN = "#ffffff", "#ff5d2e"


class HeatmapPanel:
    """Map, choosers of the axes if there are more than two variables, and the critic's choice."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._task: Task | None = None
        self._drawn: tuple | None = None
        with gui.add_folder("Critic: when to do what"):
            self._clicks = ClickField(gui, lambda value: session.post(partial(self._click, value)))
            self._axes = tuple(
                gui.add_dropdown(label, list[str](["t1"]), visible=False)
                for label in ("Horizontal", "Vertical")
            )
            self._map = Html(gui)
            self._best = gui.add_button(
                "Roll out the critic's choice", icon=viser.Icon.ROUTE, visible=False
            )

        @self._best.on_click
        async def _(_) -> None:
            session.post(session.analyst.ask)

        for chooser in self._axes:

            @chooser.on_update
            async def _(event: viser.GuiEvent) -> None:
                if event.client_id is not None:
                    session.post(self._choose_axes)

    def draw(self, session: Session) -> None:
        """Show the newest picture of the present training."""
        picture, training = session.analyst.picture, session.training
        if picture is not None and picture.subject.task is not training.task:
            picture = None
        recording = session.player.recording
        current = (picture, recording, training.running, session.analyst.busy)
        if current == self._drawn:
            return
        self._drawn = current
        self._best.visible = picture is not None
        if picture is None:
            waiting = "Drawn after the first epoch…" if training.running else "Appears in training."
            self._map.show(f'<div class="tg tg-dim">{waiting}</div>')
            self._offer_axes(None)
            return
        self._offer_axes(picture.subject.task)
        if session.analyst.axes is None:
            self._show_axes(picture)
        shown = None if recording is None else recording.schedule
        self._map.show(self._content(picture, shown))

    def _content(self, picture: Picture, shown: tuple[int, ...] | None) -> str:
        variables = picture.subject.task.grounding.decomposition.variables
        if not variables:
            return '<div class="tg tg-dim">The formula leaves no time to choose.</div>'
        marks = [Mark(picture.choice, CHOICE, "the critic's choice")]
        if shown is not None:
            marks.append(Mark(shown, SHOWN, "the rollout shown"))
        axes = ",".join(str(axis) for axis in picture.heatmap.axes)
        script = self._clicks.script(f"'{axes} '+column+' '+row")
        drawing = heatmap_svg(picture.heatmap, variables, marks, script)
        return f'<div class="tg">{drawing}{_caption(picture, variables)}</div>'

    def _click(self, value: str) -> None:
        """Roll out the cell `axes column row`; what does not fit the picture is ignored."""
        picture = self._session.analyst.picture
        if picture is None:
            return
        schedule = clicked_schedule(picture, value)
        if schedule is not None:
            self._session.analyst.ask(schedule)

    def _offer_axes(self, task: Task | None) -> None:
        """Offer the time variables of a task, if there are more than two."""
        if task is self._task:
            return
        self._task = task
        times = () if task is None else time_variables(task)
        for chooser in self._axes:
            chooser.visible = len(times) > 2
            if times:
                chooser.options = [_name(task, index) for index in times]

    def _show_axes(self, picture: Picture) -> None:
        for chooser, axis in zip(self._axes, picture.heatmap.axes, strict=False):
            chooser.value = _name(picture.subject.task, axis)

    def _choose_axes(self) -> None:
        task = self._task
        if task is None:
            return
        index = {_name(task, i): i for i in time_variables(task)}
        first, second = (index[chooser.value] for chooser in self._axes)
        self._session.analyst.choose_axes((first,) if first == second else (first, second))


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
    axes = picture.heatmap.axes
    others = [i for i in range(len(variables)) if i not in axes]
    lines = ["Click a cell to see that schedule carried out."]
    if others:
        fixed = ", ".join(f"{variables[i].name} = {picture.choice[i]}" for i in others)
        lines.append(f"Here {fixed}, as the critic likes it best.")
    if (picture.heatmap.shortfall > TOLERANCE).any():
        lines.append("Grey: too little time to travel.")
    legend = (
        f'<span style="color:{SHOWN}">◯</span> shown &nbsp; '
        '<span style="color:#868e96">◯</span> critic\'s choice '
        f"(epoch {picture.subject.epoch})"
    )
    text = " ".join(escape(line) for line in lines)
    return f'<div class="tg-dim" style="margin-top:0.2em">{text}<br>{legend}</div>'


def _name(task: Task | None, index: int) -> str:
    return "" if task is None else task.grounding.decomposition.variables[index].name
