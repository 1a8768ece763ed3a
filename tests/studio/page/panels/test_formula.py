"""Below the formula: its reading, and what stands in its way."""

from dataclasses import replace

from scenes import load_task
from studio.page.editing.specification import specify
from studio.page.panels.formula import _reading


def test_doubts_stand_above_the_reading():
    specification = specify(load_task("linear-08"), "F_[0:90](A1) & (!A2) U_[0:80] A2")
    shown = _reading(specification)
    assert "tg-warn" in shown and "A2 and !A2 are wanted at once" in shown
    assert shown.index("wanted at once") < shown.index("time variables")
    alone = _reading(replace(specification, findings=()))
    assert "time variables" in alone and "wanted at once" not in alone


def reading(formula: str) -> str:
    return _reading(specify(load_task("linear-07"), formula))


def test_an_until_whose_sides_exclude_each_other_is_said_to():
    assert "`F_[0:30](A1)`" in reading("(!A1) U_[0:30] A1")
    assert "boundary" not in reading("(!A2) U_[0:30] A1")


def test_visits_that_are_left_out_are_named():
    assert "Repeated visits are planned without" in reading("G_[0:60](F_[0:20](A1))")
    assert "Repeated visits" not in reading("F_[0:60](A1)")
