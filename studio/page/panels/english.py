"""The formula read back in English, below the field it is typed into."""

from functools import lru_cache

from core.errors import UserError
from core.stl import sentences
from scenes import Scene, robot_of, scene_reading
from studio.page.figures.svg import escape
from studio.page.panels.html import note

MOST_SENTENCES = 100
"""Shown; a formula can have thousands of conjuncts."""

RULE = (
    "Times are those of the episode. What is 'later' counts from the moment before it; in "
    "parentheses and behind a colon times count from the moment before these."
)


@lru_cache(maxsize=16)
def english_html(scene: Scene) -> str:
    """One sentence for each conjunct, and what the text left open; empty if it cannot be read."""
    try:
        formula, notes = scene_reading(scene)
    except UserError:
        return ""
    said = sentences(formula, robot_of(scene).dt)
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in said[:MOST_SENTENCES])
    more = len(said) - MOST_SENTENCES
    if more > 0:
        items += f'<li class="tg-dim">{more} more</li>'
    return note(" ".join(notes), "info") + (
        f'<div class="tg"><ul class="tg-english" title="{escape(RULE)}">{items}</ul></div>'
    )
