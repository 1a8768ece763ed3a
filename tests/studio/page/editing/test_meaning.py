"""Which edits make a training stale."""

from dataclasses import replace

import pytest

from scenes import load_task
from studio.page.editing.document import Document
from studio.page.editing.meaning import differences
from tests.studio.page.editing.draft import scene


@pytest.mark.parametrize(
    ("edit", "stale"),
    [
        (lambda d: d.set_formula("F_[0:11](A1) & G_[0:20](!B)"), ("the formula",)),
        (lambda d: d.set_formula("F_[0:10](A1) & ("), ("the formula",)),
        (lambda d: d.delete("B"), ("the formula",)),
        (lambda d: d.move("A1", (0, 1)), ("region A1",)),
        (lambda d: d.resize("B", (1, 1)), ("region B",)),
        (lambda d: d.set_initial(center=(0, -1)), ("the initial set",)),
        (lambda d: d.set_horizon(21), ("the horizon",)),
        (lambda d: d.replace(replace(d.scene, robot="unicycle"), "robot"), ("the robot",)),
        (lambda d: d.set_horizon(5), ()),  # the formula looks 20 steps ahead anyway
        (lambda d: d.set_formula("◇[0,10]A1 and always[0,20] not B"), ()),
        (lambda d: d.set_formula("F_[0 s:2 s](A1) & G_[0:20](!B)"), ()),
        (lambda d: d.rename("A1", "B2"), ()),
        (lambda d: d.move("C", (0, 1)), ()),
        (lambda d: d.delete("C"), ()),
        (lambda d: d.add("circle", (0, 0), (1,)), ()),
        (lambda d: d.recolor("A1", "#ffffff"), ()),
        (lambda d: d.set_title("Other"), ()),
        (lambda d: d.set_seed(99), ()),
    ],
)
def test_what_makes_a_training_stale(document, edit, stale):
    edit(document)
    assert document.scene != scene()
    assert differences(scene(), document.scene) == stale
    assert document.matches(scene()) == (not stale)
    document.undo()
    assert document.matches(scene())


def test_operators_without_an_upper_bound_follow_the_horizon():
    trained = replace(scene(), formula="F A1 & G !B")
    assert differences(trained, replace(trained, horizon=21)) == ("the horizon",)
    assert differences(trained, replace(trained, formula="F_[0:20](A1) & G_[0:20](!B)")) == ()
    assert differences(trained, replace(trained, formula="F A1")) == ("the formula",)


def test_another_variant_of_the_robot_makes_a_training_stale():
    trained = load_task("panda-demo")
    assert differences(trained, replace(trained, variant="links")) == ("the robot",)
    assert differences(replace(trained, variant="links"), trained) == ("the robot",)


def test_regions_of_a_wrong_formula_count_as_used():
    wrong = replace(scene(), formula="F_[0:1](")
    document = Document(wrong)
    document.move("C", (0, 1))
    assert differences(wrong, document.scene) == ("region C",)
    document.delete("C")
    assert differences(wrong, document.scene) == ("the regions",)
