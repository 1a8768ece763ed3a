"""The formula's editor: judged when the typing pauses, with the place of an error."""

from functools import partial

import viser

from core.stl import MAX_LENGTH, horizon, to_math
from studio.editing.specification import Specification
from studio.figures.svg import escape
from studio.panels.html import Html, note
from studio.panels.palette import PalettePanel
from studio.session import Session


class FormulaPanel:
    """A text field, and below it the error or the formula in symbols."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._shown = session.text
        self._field = gui.add_text("Formula", session.text, multiline=True)
        self._verdict = Html(gui)
        self._palette = PalettePanel(gui, session)

        @self._field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                text = event.target.value[: MAX_LENGTH + 1]
                session.post(partial(self._typed, session, text))

    def draw(self, session: Session) -> None:
        """Show the verdict; a formula that was not typed here goes into the field."""
        specification = session.specification
        if session.text != self._shown:
            self._shown = self._field.value = session.text
        self._verdict.show(note(specification.error) or _reading(specification))
        self._palette.draw(session)

    def _typed(self, session: Session, text: str) -> None:
        self._shown = text
        session.edit(text)


def _reading(specification: Specification) -> str:
    task = specification.task
    if task is None:
        return ""
    decomposition = task.grounding.decomposition
    times = sum(variable.kind == "time" for variable in decomposition.variables)
    branches = len(decomposition.variables) - times
    facts = [
        f"{task.horizon} steps ({task.horizon * task.robot.dt:g} s)",
        _count(times, "time variable"),
        *([_count(branches, "choice")] if branches else []),
    ]
    asked, looks = specification.scene.horizon, horizon(decomposition.formula)
    warning = (
        f"The formula looks {looks} steps ahead, past T = {asked}: an episode lasts {looks} steps."
        if looks > asked
        else ""
    )
    return note(warning, "warn") + (
        f'<div class="tg"><div class="tg-mono" style="font-size:12px">'
        f"{escape(to_math(decomposition.formula))}</div>"
        f'<div class="tg-dim" style="margin-top:0.35em">✓ {" · ".join(facts)}</div></div>'
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
