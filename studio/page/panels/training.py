"""Start, pause, resume and stop training, and watch its progress."""

import time
from functools import partial

import numpy as np
import viser
from viser import uplot

from core.methods import METHODS
from scenes import Scene
from studio.page import exact
from studio.page.editing.meaning import stale_text
from studio.page.panels.exact import exact_html
from studio.page.panels.fields import set_changed
from studio.page.panels.html import Html, note
from studio.page.panels.progress import share_done, status_html
from studio.page.session import Session
from studio.page.settings import EXACT, LARGEST_SEED, MODES
from studio.page.trainer import Phase, Point, Training

MOST_POINTS = 500
CURVE_PERIOD = 0.5
"""Minimum time between two drawings of the curve [s]."""

SERIES = (
    uplot.Series(label="epoch"),
    uplot.Series(label="training episodes [%]", stroke="#9dbfd9", width=1.5),
    uplot.Series(label="evaluation [%]", stroke="#1e6091", width=2.5),
)
METHOD_LABEL = {name: method.title for name, method in METHODS.items()}
METHOD_LABEL[EXACT] = "Exact (this start only)"
MODE_LABEL = {"studio": "studio (seconds)", "paper": "paper (as published)"}


class TrainingPanel:
    """Buttons, settings, progress, numbers and the learning curve."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._curve_drawn = 0.0
        self._curve: tuple[Point, ...] | None = None
        with gui.add_folder("Training"):
            self._train = gui.add_button("Train", icon=viser.Icon.PLAYER_PLAY)
            self._halt = gui.add_button_group("Training", ("Pause", "Stop"), visible=False)
            self._resume = gui.add_button_group("Halted", ("Resume", "Stop"), visible=False)
            self._longer = gui.add_button(
                "Train longer",
                icon=viser.Icon.PLAYER_TRACK_NEXT,
                color="gray",
                visible=False,
                hint="Continues from this policy, past the target, until the time limit.",
            )
            self._end = gui.add_button("Stop the search", color="gray", visible=False)
            self._drop = gui.add_button("Cancel the queued training", color="gray", visible=False)
            self._bar = gui.add_progress_bar(0, visible=False)
            self._status = Html(gui)
            self._plot = _curve_plot(gui)
            self._settings = SettingsControls(gui, session)
        for group in (self._halt, self._resume):
            _on_press(group, session)
        for button, act in (
            (self._train, session.train),
            (self._longer, session.train_longer),
            (self._end, session.exact.stop),
            (self._drop, partial(setattr, session, "queued", None)),
        ):
            _on_click(button, session, act)

    def draw(self, session: Session) -> None:
        """Show the latest snapshot."""
        training = session.training
        self._show_buttons(session, training)
        self._settings.draw(session)
        set_changed(
            self._bar,
            visible=training.phase not in (Phase.IDLE, Phase.LOADED),
            animated=training.running,
            color=_color(training),
            value=round(100 * share_done(training), 1),
        )
        problem = session.error or training.error or session.analyst.error
        searching = exact_html(session)
        self._status.show(searching + status_html(session) + _notes(session) + note(problem))
        self._draw_curve(training)

    def _show_buttons(self, session: Session, training: Training) -> None:
        wrong = bool(session.specification.error)
        exactly, queueing = session.exactly, training.busy
        trains = not queueing or (session.stale and session.queued is None)
        set_changed(
            self._train,
            label="Plan exactly" if exactly else "Train next" if queueing else "Train",
            visible=not session.exact.running if exactly else trains,
            disabled=wrong,
        )
        set_changed(self._end, visible=session.exact.running)
        set_changed(self._halt, visible=training.running)
        set_changed(self._resume, visible=training.phase is Phase.PAUSED)
        ended = training.phase in (Phase.DONE, Phase.STOPPED, Phase.LOADED, Phase.FAILED)
        set_changed(
            self._longer, visible=ended and training.weights is not None and not session.stale
        )
        set_changed(self._drop, visible=session.queued is not None)

    def _draw_curve(self, training: Training) -> None:
        now = time.monotonic()
        due = not training.running or now >= self._curve_drawn + CURVE_PERIOD
        if training.curve is self._curve or not due:
            return
        self._curve, self._curve_drawn = training.curve, now
        if len(training.curve) >= 2:
            self._plot.data = curve_data(training.curve)
        set_changed(self._plot, visible=len(training.curve) >= 2)


class SettingsControls:
    """Time limit, seed, mode and method of the next training."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        settings = session.settings
        with gui.add_folder("Settings", expand_by_default=False):
            self._limit = gui.add_number(
                "Time limit",
                settings.time_limit,
                min=1.0,
                max=3600.0,
                step=5.0,
                hint="Most seconds of training (it stops earlier at 99.5 % success) or of search.",
            )
            self._seed = gui.add_number(
                "Seed", session.document.scene.seed, min=0, max=LARGEST_SEED, step=1
            )
            self._mode = gui.add_dropdown("Mode", [MODE_LABEL[name] for name in MODES])
            labels = method_labels(session.document.scene)
            self._method = gui.add_dropdown("Method", labels)
            self._warm = gui.add_checkbox(
                "Begin with the robot's weights",
                settings.from_weights,
                hint="Otherwise, and in paper mode, training begins from scratch.",
            )

        @self._limit.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                seconds = min(max(float(event.target.value), 1.0), 3600.0)
                session.post(partial(setattr, settings, "time_limit", seconds))

        @self._seed.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                session.post(partial(settings.set_seed, event.target.value))

        @self._warm.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                session.post(partial(setattr, settings, "from_weights", bool(event.target.value)))

        for chooser in (self._mode, self._method):

            @chooser.on_update
            async def _(event: viser.GuiEvent) -> None:
                if event.client_id is not None:
                    session.post(self._choose)

        self._session = session

    def draw(self, session: Session) -> None:
        """Show the shared settings; locked while a training runs."""
        running, settings = session.training.busy, session.settings
        for control in (self._limit, self._seed, self._mode, self._method, self._warm):
            set_changed(control, disabled=running)
        exactly = session.exactly
        set_changed(self._warm, visible=session.planner.training is not None and not exactly)
        for control in (self._seed, self._mode):
            set_changed(control, visible=not exactly)
        set_changed(self._method, options=method_labels(session.document.scene))
        seed = session.document.scene.seed if settings.seed is None else settings.seed
        set_changed(self._seed, value=seed)
        set_changed(self._limit, value=settings.time_limit)

    def _choose(self) -> None:
        mode = next((m for m in MODES if MODE_LABEL[m] == self._mode.value), "")
        method = next((m for m in METHOD_LABEL if METHOD_LABEL[m] == self._method.value), "")
        self._session.settings.choose(mode, method)


def method_labels(scene: Scene) -> tuple[str, ...]:
    """What can be chosen as the method for a scene."""
    return tuple(
        label for name, label in METHOD_LABEL.items() if name != EXACT or exact.offered(scene)
    )


def curve_data(curve: tuple[Point, ...]) -> tuple[np.ndarray, ...]:
    """Epochs and both success rates in percent, at most `MOST_POINTS` of them, ends included."""
    chosen = np.unique(np.linspace(0, len(curve) - 1, min(len(curve), MOST_POINTS)).round())
    points = [curve[int(i)] for i in chosen]
    return (
        np.array([point.epoch for point in points], float),
        np.array([100 * point.batch_success for point in points]),
        np.array([100 * point.success for point in points]),
    )


def _curve_plot(gui: viser.GuiApi) -> viser.GuiUplotHandle:
    return gui.add_uplot(
        data=(np.array([0.0, 1.0]),) + (np.array([0.0, 0.0]),) * 2,
        series=SERIES,
        scales={
            "x": uplot.Scale(time=False),
            "y": uplot.Scale(auto=False, range=(0.0, 100.0)),
        },
        height=132,
        padding=(10, 14, 0, 0),
        visible=False,
    )


def _on_press(group: viser.GuiButtonGroupHandle, session: Session) -> None:
    """Connect the buttons of a group."""
    actions = {
        "Pause": session.trainer.pause,
        "Resume": session.trainer.proceed,
        "Stop": session.trainer.stop,
    }

    @group.on_click
    async def _(event: viser.GuiEvent) -> None:
        action = actions.get(event.target.value)
        if action is not None:
            session.post(action)


def _on_click(button: viser.GuiButtonHandle, session: Session, act) -> None:
    @button.on_click
    async def _(_) -> None:
        session.post(act)


def _color(training: Training) -> str:
    colors = {Phase.DONE: "green", Phase.FAILED: "red", Phase.STOPPED: "gray"}
    return {**colors, Phase.PAUSED: "yellow"}.get(training.phase, "blue")


def _notes(session: Session) -> str:
    queued = session.queued
    waiting = "" if queued is None else f"Next: {queued.scene.name}, when this training ends."
    obstacle = session.training.obstacle
    shown = note(obstacle[:1].upper() + obstacle[1:], "warn")
    return note(waiting, "warn") + shown + note(stale_text(session.stale_reasons), "warn")
