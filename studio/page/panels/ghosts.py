"""The legend of the rollouts on screen, and random starts with their success count."""

from functools import partial

import viser

from studio.page.asking import SAMPLE
from studio.page.figures.svg import escape
from studio.page.panels.html import Html
from studio.page.panels.plan import alternatives
from studio.page.playing.gallery import Gallery
from studio.page.server.clicks import ClickField
from studio.page.session import Session
from studio.runs.recording import Recording
from studio.theme import BAD, GOOD

CLEAR, RANDOM, FOLLOW, START = "clear", "random", "follow", "start"
PLAN = "plan "


class GhostsPanel:
    """A chip for each rollout; a click on one plays it."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._legend = Html(gui)
        self._clicks = ClickField(gui, lambda value: session.post(partial(self._press, value)))

    def draw(self, session: Session) -> None:
        """Show the gallery."""
        if session.player.recording is None:
            self._legend.show("")
            return
        self._legend.show(
            f'<div class="tg"><div class="tg-transport">{self._buttons(session)}</div>'
            f'<div class="tg-legend">{self._chips(session.gallery, session.player.recording)}'
            f"{sample_html(session.gallery)}</div>{self._plans(session)}</div>"
        )

    def _chips(self, gallery: Gallery, shown: Recording) -> str:
        return "".join(
            self._button(
                f'<span class="tg-dot" style="background:{ghost.color}"></span>'
                f"{escape(ghost.label)} {verdict_mark(ghost.recording)}",
                str(index),
                pressed=ghost.recording is shown,
                css="tg-chip",
            )
            for index, ghost in enumerate(gallery.ghosts)
        )

    def _plans(self, session: Session) -> str:
        """A chip for each kind of plan, where there is more than one."""
        chips = "".join(
            self._button(
                f"{escape(name)} {verdict_mark(plan)}",
                f"{PLAN}{index}",
                pressed=plan is session.player.recording,
                css="tg-chip tg-kind",
            )
            for index, (name, plan) in enumerate(alternatives(session))
        )
        if not chips:
            return ""
        return f'<div class="tg-legend"><span class="tg-dim">Plans</span>{chips}</div>'

    def _buttons(self, session: Session) -> str:
        return (
            self._button(f"{SAMPLE} random starts", RANDOM)
            + self._button("Choose the start", START, pressed=session.choosing_start)
            + self._button("Follow", FOLLOW, pressed=session.following)
            + '<span class="tg-gap"></span>'
            + self._button("Clear", CLEAR)
        )

    def _button(self, label: str, value: str, *, pressed: bool | None = None, css: str = "") -> str:
        state = "" if pressed is None else f' aria-pressed="{str(pressed).lower()}"'
        script = escape(self._clicks.script(f"'{value}'"))
        return f'<button type="button" class="{css}"{state} onclick="{script}">{label}</button>'

    def _press(self, value: str) -> None:
        """Act on a button; unknown values are ignored."""
        session, ghosts = self._session, self._session.gallery.ghosts
        if value == CLEAR:
            session.gallery.clear()
        elif value == RANDOM:
            session.analyst.ask_sample()
        elif value == FOLLOW:
            session.following = not session.following
        elif value == START:
            session.choosing_start = not session.choosing_start
        elif value.startswith(PLAN):
            index, plans = value.removeprefix(PLAN), alternatives(session)
            if index.isdecimal() and len(index) < 3 and int(index) < len(plans):
                session.player.load(plans[int(index)][1])
        elif value.isdecimal() and len(value) < 3 and int(value) < len(ghosts):
            session.player.load(ghosts[int(value)].recording)


def sample_html(gallery: Gallery) -> str:
    """How many random starts succeeded."""
    if not gallery.sample:
        return ""
    count, successes = len(gallery.sample), gallery.successes
    color = GOOD if successes == count else BAD
    return (
        f'<div class="tg-sample" style="color:{color}">{successes} of {count} random starts '
        "satisfy the formula</div>"
    )


def verdict_mark(recording: Recording) -> str:
    """A tick or a cross."""
    word, color = ("✓", GOOD) if recording.satisfied else ("✗", BAD)
    return f'<b style="color:{color}">{word}</b>'
