"""The rollout on screen: verdict, tasks over time, and the playhead."""

from functools import partial

import viser

from core.between import between_sentence
from studio.page.figures.svg import escape
from studio.page.figures.timeline import timeline_svg
from studio.page.panels.html import Html, note
from studio.page.panels.plan import plan_html
from studio.page.playing.player import SPEEDS, Player
from studio.page.server.clicks import ClickField
from studio.page.session import Session
from studio.runs.recording import Recording
from studio.theme import BAD, GOOD

RESTART, TOGGLE, BACK, FORTH = "restart", "toggle", "back", "forth"


class RolloutPanel:
    """Verdict, tasks over time, and transport controls."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._recording: Recording | None = None
        self._stale, self._plan = Html(gui), Html(gui)
        self._verdict = Html(gui)
        self._clicks = ClickField(gui, lambda value: session.post(partial(_press, session, value)))
        self._slider = gui.add_slider("Step", min=0, max=1, step=1, initial_value=0, visible=False)
        self._transport = Html(gui)

        @self._slider.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                session.post(partial(session.player.seek, event.target.value))

    def draw(self, session: Session) -> None:
        """Show the recording and follow the playhead."""
        player = session.player
        self._stale.show(note(session.analyst.stale if player.recording else "", "warn"))
        self._plan.show(plan_html(session))
        if player.recording is not self._recording:
            self._load(player.recording)
        if self._recording is None:
            self._verdict.show(_invitation(session))
            self._transport.show("")
            return
        self._transport.show(self._controls(player))
        step = int(player.position)
        if self._slider.value != step:
            self._slider.value = step

    def _load(self, recording: Recording | None) -> None:
        self._recording = recording
        self._slider.visible = recording is not None
        if recording is not None:
            self._slider.max = recording.steps
            self._verdict.show(
                f'<div class="tg tg-verdict">{verdict_html(recording)}'
                f"{timeline_svg(recording)}</div>"
            )

    def _controls(self, player: Player) -> str:
        name = "❚❚ Pause" if player.playing else "▶ Play"
        speeds = "".join(
            self._button(f"{speed}×", str(speed), pressed=speed == player.speed) for speed in SPEEDS
        )
        return (
            f'<div class="tg"><div class="tg-transport">{self._button("↺ Restart", RESTART)}'
            f"{self._button('◂', BACK)}{self._button(name, TOGGLE)}{self._button('▸', FORTH)}"
            f'<span class="tg-gap"></span>'
            f'<span class="tg-dim">Speed</span>{speeds}</div></div>'
        )

    def _button(self, label: str, value: str, *, pressed: bool | None = None) -> str:
        state = "" if pressed is None else f' aria-pressed="{str(pressed).lower()}"'
        script = escape(self._clicks.script(f"'{value}'"))
        return f'<button type="button"{state} onclick="{script}">{escape(label)}</button>'


def verdict_html(recording: Recording) -> str:
    """Badge, robustness, the schedule, and what failed first."""
    word, color = ("Satisfied", GOOD) if recording.satisfied else ("Violated", BAD)
    variables = recording.task.grounding.decomposition.variables
    schedule = ", ".join(
        f"{variable.name} = {value}"
        for variable, value in zip(variables, recording.schedule, strict=True)
    )
    color_of_why = "inherit" if recording.satisfied else BAD
    why = escape(recording.diagnosis.sentence)
    remark = f'<div class="tg-why" style="color:{color_of_why}">{why}</div>'
    remark += _between(recording) + _detour(recording)
    return (
        f'<div style="margin-bottom:0.4em"><span class="tg-badge" style="background:{color}">'
        f"{word}</span> &nbsp;robustness {recording.robustness:+.2f} m"
        f'<span class="tg-mono tg-dim" style="float:right;font-size:12px">{escape(schedule)}</span>'
        f"{remark}</div>"
    )


def _invitation(session: Session) -> str:
    if session.analyst.busy:
        text = "Rolling out…"
    else:
        text = "Train, then click a cell of the heatmap to roll out its schedule."
    return f'<div class="tg tg-dim">{text}</div>'


def _between(recording: Recording) -> str:
    """What a rollout that satisfies the formula at its steps does between them."""
    found = recording.between
    text = between_sentence(found) if recording.satisfied else ""
    if not text:
        return ""
    color = "inherit" if found.holds else BAD
    return f'<div class="tg-between" style="color:{color}">{escape(text)}.</div>'


def _detour(recording: Recording) -> str:
    """Note that the formula holds although tasks of this schedule do not."""
    if not recording.satisfied:
        return ""
    missed = [outcome.predicate for outcome in recording.outcomes if outcome.worst < 0]
    if not missed:
        return ""
    text = f"The formula holds, although {', '.join(missed)} did not hold when scheduled."
    return f'<div class="tg-dim">{escape(text)}</div>'


def _press(session: Session, value: str) -> None:
    """Act on a transport button; unknown values are ignored."""
    if value == RESTART:
        session.player.restart()
    elif value == TOGGLE:
        session.player.toggle()
    elif value in (BACK, FORTH):
        session.player.step(1 if value == FORTH else -1)
    elif value in map(str, SPEEDS):
        session.player.speed = int(value)
