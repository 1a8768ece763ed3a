"""Start and stop, and how learning goes."""

import math
import time
from functools import partial

import numpy as np
import viser
from viser import uplot

from core.training import TrainingConfig
from studio.meaning import stale_text
from studio.panels.html import Html, note
from studio.session import Session
from studio.worker import Point, Stage, Training

MOST_POINTS = 500
CURVE_PERIOD = 0.5
"""Least time between two drawings of the curve [s]."""

SERIES = (
    uplot.Series(label="epoch"),
    uplot.Series(label="training episodes [%]", stroke="#9dbfd9", width=1.5),
    uplot.Series(label="evaluation [%]", stroke="#1e6091", width=2.5),
)


class TrainingPanel:
    """Button, progress, numbers and the learning curve."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._curve_drawn = 0.0
        self._curve: tuple[Point, ...] | None = None
        with gui.add_folder("Training"):
            self._limit = gui.add_number(
                "Time limit",
                session.time_limit,
                min=1.0,
                max=3600.0,
                step=5.0,
                hint="Most seconds to train; ends earlier at 99.5 % success.",
            )
            self._train = gui.add_button("Train", icon=viser.Icon.PLAYER_PLAY)
            self._stop = gui.add_button(
                "Stop", icon=viser.Icon.PLAYER_STOP, color="red", visible=False
            )
            self._bar = gui.add_progress_bar(0, visible=False)
            self._status = Html(gui)
            self._plot = gui.add_uplot(
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

        @self._train.on_click
        async def _(_) -> None:
            session.post(session.train)

        @self._stop.on_click
        async def _(_) -> None:
            session.post(session.trainer.stop)

        @self._limit.on_update
        async def _(event: viser.GuiEvent) -> None:
            session.post(partial(setattr, session, "time_limit", float(event.target.value)))

    def draw(self, session: Session) -> None:
        """Show the latest snapshot."""
        training = session.training
        _set(self._train, visible=not training.running, disabled=bool(session.specification.error))
        _set(self._stop, visible=training.running)
        _set(self._limit, disabled=training.running)
        _set(
            self._bar,
            visible=training.stage is not Stage.IDLE,
            animated=training.running,
            color=_color(training),
        )
        self._bar.value = round(100 * _share(training), 1)
        problem = session.error or training.error or session.analyst.error
        self._status.show(_status(training) + _stale(session) + note(problem))
        self._draw_curve(training)

    def _draw_curve(self, training: Training) -> None:
        now = time.monotonic()
        due = not training.running or now >= self._curve_drawn + CURVE_PERIOD
        if training.curve is self._curve or not due:
            return
        self._curve, self._curve_drawn = training.curve, now
        if len(training.curve) >= 2:
            self._plot.data = curve_data(training.curve)
        _set(self._plot, visible=len(training.curve) >= 2)


def curve_data(curve: tuple[Point, ...]) -> tuple[np.ndarray, ...]:
    """Epochs and both success rates in percent, at most `MOST_POINTS` of them, the ends kept."""
    chosen = np.unique(np.linspace(0, len(curve) - 1, min(len(curve), MOST_POINTS)).round())
    points = [curve[int(i)] for i in chosen]
    return (
        np.array([point.epoch for point in points], float),
        np.array([100 * point.batch_success for point in points]),
        np.array([100 * point.success for point in points]),
    )


def _set(handle, **properties) -> None:
    """Send only the properties that change."""
    for name, value in properties.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)


def _share(training: Training) -> float:
    """Share of the budget that is used, 1 once training has ended."""
    config = training.config
    if config is None or training.stage is Stage.COMPILING:
        return 0.0
    if training.stage is Stage.DONE:
        return 1.0
    return min(1.0, max(training.epoch / config.epochs, training.seconds / config.time_limit))


def _color(training: Training) -> str:
    return {Stage.DONE: "green", Stage.FAILED: "red", Stage.STOPPED: "gray"}.get(
        training.stage, "blue"
    )


def _status(training: Training) -> str:
    sentence = _sentence(training)
    cards = ""
    if training.epoch:
        success = training.success
        latest = training.curve[-1].batch_success if success is None else success
        rate = training.env_steps / max(training.seconds, 1e-6)
        cards = "".join(
            f'<div class="tg-card"><b>{value}</b><span>{name}</span></div>'
            for value, name in (
                (f"{100 * latest:.1f} %", "success"),
                (f"{training.epoch}", "epochs"),
                (f"{training.seconds:.1f} s", "training"),
                (f"{rate / 1000:.0f} k", "steps / s"),
            )
        )
        cards = f'<div class="tg-cards" style="margin-top:0.4em">{cards}</div>'
    return f'<div class="tg tg-training"><div>{sentence}</div>{cards}</div>'


def _sentence(training: Training) -> str:
    config = training.config
    match training.stage:
        case Stage.IDLE:
            return (
                '<span class="tg-dim">Learns a policy and a critic for the formula, '
                "usually in 10–40 s.</span>"
            )
        case Stage.COMPILING:
            waited = time.monotonic() - training.began
            return f"Preparing the programs… {waited:.0f} s (once for each robot)"
        case Stage.TRAINING if config is not None:
            return f"Training… {_remaining(training, config)} left at most{_goal(config)}"
        case Stage.STOPPED:
            return "Stopped. The best policy so far is kept."
        case Stage.FAILED:
            return "Training failed."
        case _:
            reached = config is not None and (training.success or 0) >= config.target
            return "Done." if reached else "Done: the limit was reached before the target."


def _remaining(training: Training, config: TrainingConfig) -> str:
    if math.isfinite(config.time_limit):
        return f"{max(0.0, config.time_limit - training.seconds):.0f} s"
    return f"{config.epochs - training.epoch:,} epochs"


def _goal(config: TrainingConfig) -> str:
    return f"; ends at {100 * config.target:g} % success" if config.target <= 1 else ""


def _stale(session: Session) -> str:
    return note(stale_text(session.stale_reasons), "warn")
