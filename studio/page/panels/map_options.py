"""Which slice of the schedules the heatmap shows: axes, branches, and the other times."""

from collections.abc import Sequence
from functools import partial

import viser

from core.task.sizes import LARGEST
from core.task.task import Task
from studio.page.panels.fields import set_changed
from studio.page.picture import MapView, Picture, time_variables
from studio.page.session import Session

CRITIC = "critic's choice"
BEST, HAND = "best for each cell", "set by hand"
LONGEST = 34
"""Maximum length of an alternative in a menu, in characters."""


class MapOptions:
    """Menus and sliders; only those that the formula needs are shown."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._task: Task | None = None
        self._picture: Picture | None = None
        self._branches = _menus(gui, [""] * LARGEST.variables, [CRITIC])
        self._axes = _menus(gui, ["Horizontal", "Vertical"], [""])
        (self._others,) = _menus(gui, ["Other times"], [CRITIC, BEST, HAND])
        self._sliders = [
            gui.add_slider("", min=0, max=1, step=1, initial_value=0, visible=False)
            for _ in range(LARGEST.variables)
        ]
        for handle in [*self._axes, self._others, *self._sliders]:
            handle.on_update(partial(self._changed, False))
        for handle in self._branches:
            handle.on_update(partial(self._changed, True))

    def show(self, picture: Picture | None) -> None:
        """Offer the options of a picture's task, and show those of the picture."""
        task = None if picture is None else picture.subject.task
        self._picture = picture
        if task is not self._task:
            self._task = task
            self._offer()
        if picture is None or task is None:
            return
        axes, view = picture.heatmap.axes, self._session.analyst.view
        if view.axes is None:
            for menu, axis in zip(self._axes, axes, strict=False):
                set_changed(menu, value=_name(task, axis))
        rest = self._rest(picture)
        set_changed(self._others, visible=bool(rest))
        by_hand = self._others.value == HAND
        for index, slider in enumerate(self._sliders):
            set_changed(slider, visible=by_hand and index in rest)
            if index in rest and not by_hand:
                set_changed(slider, value=picture.choice[index])

    def _offer(self) -> None:
        """Fill the menus and sliders for a new task."""
        variables = () if self._task is None else self._task.grounding.decomposition.variables
        times = () if self._task is None else time_variables(self._task)
        for index, (menu, slider) in enumerate(zip(self._branches, self._sliders, strict=True)):
            variable = variables[index] if index < len(variables) else None
            branch = variable is not None and variable.kind == "branch"
            set_changed(menu, visible=branch)
            set_changed(slider, visible=False)
            if variable is None:
                continue
            if branch:
                menu.label = variable.name
                menu.options = [CRITIC, *_alternatives(variable.labels)]
                menu.value = CRITIC
            else:
                slider.label = variable.name
                slider.min, slider.max = variable.low, max(variable.high, variable.low + 1)
        set_changed(self._others, visible=False, value=CRITIC)
        for menu in self._axes:
            set_changed(menu, visible=len(times) > 2)
            if times:
                menu.options = [variables[index].name for index in times]

    def _rest(self, picture: Picture) -> tuple[int, ...]:
        """Time variables that matter in the picture's branches and are not on its axes."""
        task, axes = picture.subject.task, picture.heatmap.axes
        variables = task.grounding.decomposition.variables
        return tuple(
            index
            for index in time_variables(task)
            if index not in axes
            and all(picture.choice[branch] == value for branch, value in variables[index].guards)
        )

    async def _changed(self, branch: bool, event: viser.GuiEvent) -> None:
        if event.client_id is not None:
            self._session.post(partial(self._choose, branch))

    def _choose(self, branch: bool) -> None:
        """Request the slice that the controls show; another branch has its own axes."""
        picture, task = self._picture, self._task
        if picture is None or task is None:
            return
        variables = task.grounding.decomposition.variables
        fixed = []
        for index, variable in enumerate(variables):
            menu = self._branches[index]
            if variable.kind == "branch" and menu.value != CRITIC:
                fixed.append((index, menu.options.index(menu.value) - 1))
        mode = self._others.value
        axes = None if branch else self._chosen_axes(task)
        if mode == HAND and not branch:
            on_axes = picture.heatmap.axes if axes is None else axes
            rest = [index for index in time_variables(task) if index not in on_axes]
            fixed += [(index, int(self._sliders[index].value)) for index in rest]
        view = MapView(axes, tuple(fixed), mode == BEST)
        self._session.analyst.choose_view(view)

    def _chosen_axes(self, task: Task) -> tuple[int, ...] | None:
        if not self._axes[0].visible:
            return None
        index = {_name(task, i): i for i in time_variables(task)}
        first, second = (index[menu.value] for menu in self._axes)
        return (first,) if first == second else (first, second)


def _menus(gui: viser.GuiApi, labels: Sequence[str], options: Sequence[str]) -> list:
    return [gui.add_dropdown(label, list[str](options), visible=False) for label in labels]


def _alternatives(labels: Sequence[str]) -> list[str]:
    """Short, distinct texts for the alternatives."""
    return [
        f"{i}: {label if len(label) <= LONGEST else label[: LONGEST - 1] + '…'}"
        for i, label in enumerate(labels)
    ]


def _name(task: Task, index: int) -> str:
    return task.grounding.decomposition.variables[index].name
