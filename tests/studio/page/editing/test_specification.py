from dataclasses import replace

import pytest

from core.errors import UserError
from envs import ENVS
from scenes import load_task
from studio.page.editing.specification import edited, specify, with_text
from studio.page.views.bodies import BODIES
from studio.runs.tasks import build_task


def retyped(specification, text):
    return edited(specification, with_text(specification.scene, text))


@pytest.fixture(scope="module")
def right():
    return specify(load_task("linear-08"))


def test_the_scenes_own_formula_is_right(right):
    assert right.error == ""
    assert right.text == right.scene.formula
    assert [variable.name for variable in right.decomposition.variables] == ["t1", "t2", "t3"]


@pytest.mark.parametrize(
    "text", ["F_[0:90](A7)", "F_[0:90](A1", "G_[0:5](F_[0:3](A1)|G_[0:2](A2))", "F_[0:9](A1 & B1)"]
)
def test_a_wrong_formula_keeps_the_last_right_one(right, text):
    wrong = retyped(right, text)
    with pytest.raises(UserError) as error:
        build_task(right.scene, text)
    assert wrong.error == str(error.value)
    assert wrong.task is right.task
    assert wrong.text == text


def test_the_error_carries_the_caret(right):
    assert retyped(right, "F_[0:90](A7)").error.endswith("F_[0:90](A7)\n         ^")


def test_repairing_it_brings_the_new_task(right):
    repaired = retyped(retyped(right, "F_[0:90](A7)"), "F_[0:90](A2)")
    assert repaired.error == ""
    assert repaired.decomposition is not None
    assert len(repaired.decomposition.variables) == 1
    assert right.task is not repaired.task


def test_a_scene_may_open_with_a_wrong_formula():
    specification = specify(load_task("linear-08"), "F_[0:90](A7)")
    assert specification.task is None
    assert specification.decomposition is None
    assert "A7" in specification.error


def test_a_change_of_looks_keeps_the_task(right):
    region = replace(right.scene.regions[0], color="#123456")
    recoloured = replace(right.scene, title="x", regions=(region, *right.scene.regions[1:]))
    judged = edited(right, recoloured)
    assert judged.task is right.task
    assert judged.scene is recoloured


def test_a_change_of_shape_brings_a_new_task(right):
    region = replace(right.scene.regions[0], center=(0.0, 1.0))
    moved = replace(right.scene, regions=(region, *right.scene.regions[1:]))
    assert edited(right, moved).task is not right.task


@pytest.mark.parametrize("robot", ENVS)
def test_every_robot_has_a_body_and_a_demo_on_the_page(robot):
    assert ENVS[robot].drawn_as in BODIES
    demo = specify(load_task(f"{robot}-demo"))
    assert not demo.error
    assert demo.task is not None
    assert [v.kind for v in demo.task.grounding.decomposition.variables] == ["time", "time"]
