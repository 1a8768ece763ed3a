"""The path of the selected region as one text.

    0: 0, 0; 20: 3, 0        at step 0 its centre is at (0, 0), at step 20 at (3, 0)
    0.1, 0 per step          it goes on for ever from where it is
                             empty: it stands

The text is applied when typing pauses. A text that cannot be read stays, with the reason beside it.
"""

from collections.abc import Sequence
from functools import partial

import viser

from core.errors import UserError
from core.quoting import shown
from scenes import Region, SceneError
from scenes.motion import Motion, along, through
from studio.page.panels.fields import Typing, set_changed
from studio.page.panels.html import Html, note
from studio.page.session import Session

ENDLESS = "per step"
"""Follows a velocity."""

LONGEST_TEXT, LONGEST_PART = 4000, 40

EXAMPLE = "as in 0: 0, 0; 20: 3, 0"


class PathField:
    """Shown while a region is selected that is not the initial set."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._field = gui.add_text(
            "Path", "", hint="0: 0, 0; 20: 3, 0 or 0.1, 0 per step; empty: it stands", visible=False
        )
        self._problem = Html(gui)
        self._wrong = ""
        self._shown: tuple[str, str] = ("", "")
        self._typing = Typing[tuple[str, str]]()
        self._name = ""

        @self._field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                self._typing.put((self._name, event.target.value[:LONGEST_TEXT]))

    def draw(self, session: Session) -> None:
        """Apply what was typed when typing pauses; show what was changed elsewhere."""
        region = session.editor.selected if session.editor.selection else None
        if (typed := self._typing.take()) is not None:
            session.post(partial(self.apply, session, *typed))
        self._name = "" if region is None else region.name
        set_changed(self._field, visible=region is not None)
        current = (self._name, "" if region is None else path_text(region))
        if not self._typing.waits and current != self._shown:
            self._shown, self._wrong = current, ""
            self._field.value = current[1]
        self._problem.show(note(self._wrong, "warn"))

    def apply(self, session: Session, name: str, text: str) -> None:
        """Give a region the path of a text, or say what is wrong with it."""
        document = session.document
        if name not in document.scene.region_names:
            return
        region = document.region(name)
        try:
            motion, begins = read_path(text, region)
            self._wrong = ""
            if (motion, begins) != (region.motion, region.center):
                document.set_motion(name, motion, begins)
        except UserError as error:
            self._wrong = str(error)


def path_text(region: Region) -> str:
    """The path of a region as it is typed; empty if it stands."""
    motion = region.motion
    if motion is None:
        return ""
    if motion.velocity is not None:
        return f"{_numbers(motion.velocity)} {ENDLESS}"
    places = motion.waypoints(region.center)
    return "; ".join(f"{step}: {_numbers(place)}" for step, place in places)


def read_path(text: str, region: Region) -> tuple[Motion | None, tuple[float, ...]]:
    """How a region moves by a text like `path_text`, and where its centre begins [d] [m].

    Raises:
        UserError: malformed, or not of the region's dimension.
    """
    text = text.strip().strip(";").strip()
    if not text:
        return None, region.center
    if text.endswith(ENDLESS):
        velocity = _read(text.removesuffix(ENDLESS), "path", "0.1, 0 per step")
        return along(velocity, region.dimension), region.center
    waypoints = []
    for part in text.split(";"):
        step, colon, place = part.partition(":")
        field = f"path: {shown(repr(part.strip()), LONGEST_PART)}"
        if not colon:
            raise SceneError(f"{field} must be a step, a colon and a position, {EXAMPLE}")
        if not step.strip().isascii() or not step.strip().isdecimal():
            raise SceneError(f"{field}: the step must be a whole number from 0 on, {EXAMPLE}")
        waypoints.append([int(step), *_read(place, field, EXAMPLE)])
    return through(waypoints, region.dimension)


def _read(text: str, field: str, example: str) -> list[float]:
    try:
        return [float(each) for each in text.replace(",", " ").split()]
    except ValueError:
        given = shown(repr(text.strip()), LONGEST_PART)
        raise SceneError(f"{field}: {given} must be numbers, {example}") from None


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.9g}" for value in values)
