"""The formula editor: the formula is judged when typing pauses; errors show their position."""

from functools import partial

import viser

from core.decompose import advice, left_out
from core.stl import MAX_LENGTH, horizon, to_math
from studio.page.editing.specification import Specification
from studio.page.figures.svg import escape
from studio.page.panels.english import english_html
from studio.page.panels.html import Html, note
from studio.page.panels.palette import PalettePanel
from studio.page.session import Session


class FormulaPanel:
    """A text field; below it, the error or the formula in symbols, and the formula in English."""

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
        """Show the verdict; a formula from elsewhere is put into the field."""
        specification = session.specification
        if session.text != self._shown:
            self._shown = self._field.value = session.text
        verdict = note(specification.error) or _reading(specification)
        self._verdict.show(verdict + english_html(specification.scene))
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
        *([_count(branches, "branch variable")] if branches else []),
    ]
    asked, looks = specification.scene.horizon, horizon(decomposition.formula)
    warning = (
        f"The formula's horizon of {looks} steps exceeds T = {asked}; episodes last {looks} steps."
        if looks > asked
        else ""
    )
    doubts = [finding.words for finding in specification.findings]
    warnings = (warning, *doubts, *advice(decomposition.formula))
    remark = left_out(decomposition)
    return "".join(note(text, "warn") for text in warnings) + (
        f'<div class="tg"><div class="tg-mono" style="font-size:12px">'
        f"{escape(to_math(decomposition.formula))}</div>"
        f'<div class="tg-dim" style="margin-top:0.35em">✓ {" · ".join(facts)}</div>'
        + (f'<div class="tg-dim">{escape(remark)}.</div>' if remark else "")
        + "</div>"
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
