"""A tour in three steps for first-time users, and the page's theme."""

from contextlib import suppress
from pathlib import Path

import viser

from studio.page.panels.fields import set_changed
from studio.page.panels.html import Html
from studio.page.session import Session
from studio.theme import BRAND

STEPS = (
    ("Say what the robot should do",
     "Pick a task here, or edit its formula and drag its regions. "
     "<i>F</i> means eventually, <i>G</i> always. The tree below shows the decomposition."),
    ("Train, and read the heatmap",
     "On the right, <b>Train</b> learns a policy in seconds. The heatmap shows how the critic "
     "rates each schedule: brighter is better."),
    ("Click a cell, watch the rollout",
     "The robot carries out that schedule; the bars below the scene show when each task held. "
     "Drag the robot away, and it plans anew from there. "
     "Save and export under <b>Files</b> on the right."),
)  # fmt: skip


class TourPanel:
    """The steps, at the top of the page until dismissed."""

    def __init__(self, gui: viser.GuiApi, session: Session, seen: Path | None) -> None:
        self._seen = seen
        self._step: int | None = None if seen is None or seen.exists() else 0
        self._text = Html(gui)
        self._buttons = gui.add_button_group("", ("Next", "Dismiss"), visible=False)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent) -> None:
            dismissed = event.target.value == "Dismiss"
            session.post(self._dismiss if dismissed else self._next)

    def draw(self, session: Session) -> None:
        """Show the current step."""
        set_changed(self._buttons, visible=self._step is not None)
        self._text.show("" if self._step is None else _step_html(self._step))

    def begin(self) -> None:
        """Show the first step."""
        self._step = 0

    def _next(self) -> None:
        if self._step is None or self._step + 1 == len(STEPS):
            self._dismiss()
        else:
            self._step += 1

    def _dismiss(self) -> None:
        self._step = None
        if self._seen is not None:
            with suppress(OSError):
                self._seen.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                self._seen.touch()


def add_page_options(gui: viser.GuiApi, session: Session, tour: TourPanel) -> None:
    """The theme switch, and a button that restarts the tour."""
    with gui.add_folder("Page", expand_by_default=False):
        dark = gui.add_checkbox("Dark theme", False)
        again = gui.add_button("Show the tour", icon=viser.Icon.ROUTE_2, color="gray")

    @dark.on_update
    async def _(_) -> None:
        set_theme(gui, dark=bool(dark.value))

    @again.on_click
    async def _(_) -> None:
        session.post(tour.begin)


def set_theme(gui: viser.GuiApi, *, dark: bool) -> None:
    """Set the theme of the viewer's controls; the page's colours follow it."""
    gui.configure_theme(show_logo=False, show_share_button=False, brand_color=BRAND, dark_mode=dark)


def _step_html(step: int) -> str:
    title, text = STEPS[step]
    return (
        f'<div class="tg"><div class="tg-note tg-tour"><div class="tg-title">'
        f"{step + 1} of {len(STEPS)} · {title}</div><div>{text}</div></div></div>"
    )
