"""Predicates of the robot's state as one text, and what counts between the steps."""

from collections.abc import Sequence
from functools import partial

import viser

from core.errors import UserError
from core.task.quantities import quantities_of
from scenes import Predicate, Scene, robot_of
from studio.page.figures.svg import escape
from studio.page.panels.fields import Typing, set_changed
from studio.page.panels.html import Html
from studio.page.session import Session

LONGEST_TEXT = 4000


class PredicateFields:
    """A text field `slow: v <= 1; high: z >= 2`, the names that there are, and a checkbox."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._shown = predicates_text(session.document.scene.predicates)
        with gui.add_folder("Predicates of the state"):
            self._field = gui.add_text("Predicates", self._shown)
            self._hint = Html(gui)
            self._between = gui.add_checkbox(
                "Also between steps",
                session.document.scene.between_steps,
                hint="What must always hold must hold between the steps, too",
            )
        self._typing = Typing[str]()

        @self._field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                self._typing.put(event.target.value[:LONGEST_TEXT])

        @self._between.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                session.post(partial(_ask_between, session, event.target.value))

    def draw(self, session: Session) -> None:
        """Apply what was typed when typing pauses; show what was changed elsewhere."""
        scene = session.document.scene
        if (typed := self._typing.take()) is not None:
            session.post(partial(take, session, typed))
            self._shown = predicates_text(scene.predicates)
        elif not self._typing.waits and predicates_text(scene.predicates) != self._shown:
            self._shown = self._field.value = predicates_text(scene.predicates)
        set_changed(self._between, value=scene.between_steps)
        self._hint.show(_names(scene))


def predicates_text(predicates: Sequence[Predicate]) -> str:
    """The predicates as one types them: `slow: v <= 1; high: z >= 2`."""
    return "; ".join(f"{each.name}: {each.text}" for each in predicates)


def read_predicates(text: str) -> tuple[Predicate, ...]:
    """The predicates of a text, separated by semicolons.

    Raises:
        UserError: a part without a colon, or with an unfit name.
    """
    found = []
    for part in filter(None, map(str.strip, text.split(";"))):
        name, colon, inequality = part.partition(":")
        if not colon:
            raise UserError(f"predicates: {part!r} must be a name and an inequality: slow: v <= 1")
        found.append(Predicate(name.strip(), inequality.strip()))
    return tuple(found)


def take(session: Session, text: str) -> None:
    """Make the predicates what a text says.

    Raises:
        UserError: the text is malformed, or does not fit the robot; nothing is changed.
    """
    predicates = read_predicates(text)
    if predicates != session.document.scene.predicates:
        session.document.set_predicates(predicates)


def _ask_between(session: Session, asked: bool) -> None:
    if asked != session.document.scene.between_steps:
        session.document.set_between_steps(asked)


def _names(scene: Scene) -> str:
    names = ", ".join(
        f"{each.name} [{each.unit}]" if each.unit else each.name
        for each in quantities_of(robot_of(scene))
    )
    return f'<div class="tg tg-dim tg-quantities">slow: v &lt;= 1 — of {escape(names)}</div>'
