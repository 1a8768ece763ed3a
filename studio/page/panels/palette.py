"""Building blocks for formulas: operators, region names, and the robot's examples."""

import json
from functools import lru_cache, partial

import viser

from core.stl import quote_name
from scenes import Scene, load_task, task_names
from studio.page.figures.svg import escape
from studio.page.panels.fields import set_changed
from studio.page.panels.html import Html
from studio.page.session import Session

OPERATORS = (
    ("◇ F", "F_[0:{T}]()", "eventually: at some step of the interval"),
    ("□ G", "G_[0:{T}]()", "always: at every step of the interval"),
    ("U", " U_[0:{T}] ", "until: the left side holds until the right side does"),
    ("∧", " & ", "and"),
    ("∨", " | ", "or"),
    ("¬", "!", "not"),
    ("→", " -> ", "implies"),
)
CHOOSE = "choose…"

INSERT = (
    "const f=document.querySelector('textarea.mantine-Textarea-input'),t={text};"
    "if(document.activeElement!==f){{f.focus();"
    "f.setSelectionRange(f.value.length,f.value.length);}}"
    "document.execCommand('insertText',false,t);"
    "if(t.endsWith('()')){{const c=f.selectionStart-1;f.setSelectionRange(c,c);}}"
)
"""Types into the editor at its cursor, so that the browser's own undo covers it."""


class PalettePanel:
    """Buttons that type into the editor, and the shipped formulas over these regions."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._buttons = Html(gui)
        self._examples = gui.add_dropdown("Example", list[str]([CHOOSE]), initial_value=CHOOSE)

        @self._examples.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                session.post(partial(_take, session, event.target.value))

    def draw(self, session: Session) -> None:
        """Follow the regions."""
        scene = session.document.scene
        self._buttons.show(palette_html(scene))
        offered = (CHOOSE, *examples(scene.robot, scene.region_names))
        if self._examples.options != offered:
            self._examples.options = offered
        if self._examples.value != CHOOSE:
            self._examples.value = CHOOSE
        visible = len(offered) > 1
        set_changed(self._examples, visible=visible)


def palette_html(scene: Scene) -> str:
    """Buttons for the operators, over the scene's horizon, and for the region names."""
    operators = "".join(
        _key(label, text.replace("{T}", str(scene.horizon)), hint)
        for label, text, hint in OPERATORS
    )
    names = "".join(_key(name, quote_name(name), "") for name in scene.atom_names)
    return f'<div class="tg tg-palette"><div class="tg-chips">{operators}{names}</div></div>'


def examples(robot: str, names: tuple[str, ...]) -> dict[str, str]:
    """Formulas of the robot's shipped tasks that need no other regions, by their labels."""
    return {
        f"{scene.name} · {scene.title.partition(': ')[2] or scene.title}": scene.formula
        for scene in _shipped(robot)
        if set(scene.region_names) <= set(names)
    }


@lru_cache
def _shipped(robot: str) -> tuple[Scene, ...]:
    return tuple(load_task(name) for name in task_names(robot))


def _take(session: Session, example: str) -> None:
    scene = session.document.scene
    formula = examples(scene.robot, scene.region_names).get(example)
    if formula is not None:
        session.edit(formula)


def _key(label: str, text: str, hint: str) -> str:
    script = escape(INSERT.format(text=json.dumps(text)))
    return (
        f'<button type="button" title="{escape(hint)}" onmousedown="event.preventDefault()" '
        f'onclick="{script}">{escape(label)}</button>'
    )
