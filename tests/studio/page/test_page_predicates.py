"""Predicates of the state in a browser: typed, used in the formula, refused."""

from scenes import Predicate
from tests.studio.page.test_page import EDITOR, wait_for_text
from tests.studio.page.test_page_editing import scene, studio
from tests.studio.waiting import wait_for

__all__ = ["studio"]

FIELD = "xpath=//*[normalize-space(text())='Predicates']/following::input[1]"


def test_a_predicate_is_typed_used_and_refused(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    wait_for_text(page, ".tg-quantities", "x [m], y [m]")
    page.locator(FIELD).fill("west: x <= -0.5")
    assert wait_for(lambda: scene(studio).predicates == (Predicate("west", "x <= -0.5"),))
    page.locator(EDITOR).fill("F_[0:90](A1) & F_[0:40](A2 & west)")
    wait_for_text(page, ".tg-english", "in A2 and west")
    page.locator(FIELD).fill("west: speed <= 1")
    page.wait_for_selector("text=unknown 'speed' in 'speed <= 1'. Allowed: x, y")
    assert scene(studio).predicates == (Predicate("west", "x <= -0.5"),)
    assert page.locator(FIELD).input_value() == "west: speed <= 1"
