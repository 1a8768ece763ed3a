"""Predicates of the state in scenes: their text, and that nothing takes them for regions."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.evaluation import verdicts
from core.monitor import diagnose
from core.stl import atom_names, robustness
from core.task.problem import atom_margins, trace_margins
from envs import ENVS
from scenes import (
    Predicate,
    Scene,
    SceneError,
    format_scene,
    inequality_of,
    load_task,
    parse_scene,
    scene_formula,
)
from studio.runs.findings import findings_of
from studio.runs.tasks import build_task

UNICYCLE = load_task("unicycle-demo")
SLOW = (
    Predicate("slow", "v <= 1"),
    Predicate("west", "x <= -1"),
    Predicate("ahead", "|theta| <= 1"),
)


def scene(formula: str, predicates: tuple[Predicate, ...] = SLOW, **fields) -> Scene:
    return replace(UNICYCLE, formula=formula, predicates=predicates, **fields)


@pytest.mark.parametrize(
    ("text", "weights", "offset", "absolute", "at_most", "bound"),
    [
        ("v <= 1", {"v": 1}, 0, False, True, 1),
        ("|theta| ≤ 0.3", {"theta": 1}, 0, True, True, 0.3),
        ("2*x - y + 0.5 >= .5e1", {"x": 2, "y": -1}, 0.5, False, False, 5),
        ("x + 1 <= 2 y", {"x": 1, "y": -2}, 1, False, True, 0),
        ("1 >= |v - 0.5|", {"v": 1}, -0.5, True, True, 1),
        ("-v<=-2", {"v": -1}, 0, False, True, -2),
    ],
)
def test_what_a_text_means(text, weights, offset, absolute, at_most, bound):
    found = inequality_of(Predicate("P", text), ENVS["unicycle"])
    assert found.weights == weights
    assert (found.offset, found.absolute, found.at_most, found.bound) == (
        *(offset, absolute, at_most),
        pytest.approx(bound),
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("vel <= 1", "unknown 'vel' in 'vel <= 1'. Allowed: v, x, y, theta"),
        ("v < 1", "must be one inequality with <= or >="),
        ("0 <= v <= 1", "must be one inequality"),
        ("3 <= 4", "speaks of no quantity"),
        ("x - x <= 1", "speaks of no quantity"),
        ("|v| <= -1", "compares an absolute value with a negative number"),
        ("|v| <= y", "beside |...| stands a number alone"),
        ("v*v <= 1", "is no sum of numbers and names"),
        ("x y <= 1", "is no sum of numbers and names"),
        ("<= 1", "is no sum of numbers and names"),
        ("1e9 v <= 1", "too large"),
    ],
)
def test_errors_say_what_is_allowed(text, words):
    with pytest.raises(SceneError) as error:
        scene("F_[0:9](A1)", (Predicate("slow", text),))
    assert str(error.value).startswith("predicates.slow: ") and words in str(error.value)


def test_names_are_given_once():
    with pytest.raises(SceneError, match=r"predicates\.A1: this name is given twice"):
        scene("F_[0:9](A1)", (Predicate("A1", "v <= 1"),))
    with pytest.raises(SceneError, match="at most 8 are allowed"):
        scene("F_[0:9](A1)", tuple(Predicate(f"P{i}", "v <= 1") for i in range(9)))


def test_a_file_keeps_predicates_and_others_have_none():
    kept = scene("G_[0:9](slow)", (*SLOW, Predicate("a b", "v >= -1")))
    assert parse_scene(format_scene(kept), "text") == kept
    assert "predicates" not in format_scene(UNICYCLE)
    with pytest.raises(SceneError, match=r"predicates\.slow"):
        parse_scene(format_scene(kept).replace('"v <= 1"', "3"), "text")


@pytest.fixture(scope="module")
def task():
    return build_task(scene("F_[0:50](A1 & slow) & G_[0:50](ahead | west) & F_[0:60](slow & west)"))


def test_margins_of_regions_stay_and_predicates_follow(task):
    plain = build_task(scene("F_[0:50](A1)", ()))
    for key in jax.random.split(jax.random.key(0), 5):
        state = task.robot.place(key, jnp.array([0.3, -2.0]))
        margin, gradient = atom_margins(task.problem, state)
        regions, region_gradient = atom_margins(plain.problem, state)
        count = len(UNICYCLE.regions)
        np.testing.assert_array_equal(margin[:count], regions[:count])
        np.testing.assert_array_equal(gradient[:count], region_gradient[:count])
        x, _, theta, v = np.asarray(state)
        expected = [1 - v, -1 - x, 1 - abs(theta)]
        np.testing.assert_allclose(margin[count : count + 3], expected, atol=1e-5)
        np.testing.assert_allclose(gradient[count : count + 3], [[0, 0], [-1, 0], [0, 0]])


def test_fields_know_the_position_alone(task):
    """The way to `A1 & slow` is that to A1; that to `slow & west` leads west."""
    same = build_task(scene("F_[0:50](A1) & F_[0:60](west)"))
    assert task.problem.formula.combinations == 2  # `ahead | west` is a door that bars no way
    fields, wanted = task.problem.data.fields, same.problem.data.fields
    np.testing.assert_array_equal(fields[:4], wanted[np.array([0, 0, 1, 1])])
    np.testing.assert_array_equal(task.problem.inside, same.problem.inside)
    assert (np.asarray(task.problem.inside[1, :, 0]) <= -1).all()
    nowhere = build_task(scene("F_[0:50](slow) & F_[0:60](A1)"))
    assert not np.asarray(nowhere.problem.data.fields[0, ..., 0]).any()


def test_verdicts_read_the_state(task):
    """Against margins written down here, on random walks."""
    random = np.random.default_rng(0)
    states = np.cumsum(random.normal(0, 0.2, (task.horizon + 1, 9, 4)), 0).astype(np.float32)
    margins = np.asarray(trace_margins(task.problem, jnp.asarray(states)))
    found = verdicts(task, states, margins)
    names, count = task.grounding.atoms, len(UNICYCLE.regions)
    own = np.stack([1 - states[..., 3], -1 - states[..., 0], 1 - np.abs(states[..., 2])], -1)
    plain = np.moveaxis(np.concatenate([margins[..., :count], own], -1), 0, 1)
    np.testing.assert_allclose(found, robustness(task.formula, plain, names), atol=1e-4)


def test_words_do_not_call_a_predicate_a_place(task):
    states = np.zeros((task.horizon + 1, 1, 4), np.float32)
    states[..., 2:] = 2.0
    margins = np.asarray(trace_margins(task.problem, jnp.asarray(states)))[:, 0]
    formula = scene_formula(scene("G_[0:9](slow)"))
    said = diagnose(formula, margins, task.grounding.atoms, 0.2).sentence
    assert "slow did not hold during steps 0-9" in said
    assert "missing by up to 1," in said and " m" not in said.replace(" missing", "")


@pytest.mark.parametrize(
    ("formula", "without"),
    [
        ("F_[0:2](A1 & slow)", "F_[0:2](A1)"),
        ("F_[0:2](A1 & !slow) & G_[0:50](slow)", "F_[0:2](A1)"),
        ("slow U_[0:2] A1", "F_[0:2](A1)"),
        ("F_[0:2](A1 | slow)", ""),
        ("G_[0:50](slow) & F_[3:3](!slow)", ""),
        ("!(west U_[0:9] (slow & A1))", ""),
        ("F_[0:50](slow -> ahead) & G_[0:9](west)", ""),
        ("(!slow) U_[0:5] (slow & ahead)", ""),
    ],
)
def test_proofs_take_no_predicate_for_a_region(formula, without):
    """What is said of a mission is what is said of it without them."""
    found = findings_of(scene(formula))
    assert found == (findings_of(scene(without)) if without else ())
    assert bool(found) == bool(without)


@pytest.mark.parametrize("robot", ENVS)
def test_every_robot_has_a_predicate_of_its_state(robot):
    text = {"linear": "x + y <= 9", "panda": "q4 <= -1.5"}.get(robot, "|vx| <= 1")
    text = "v <= 1" if robot == "unicycle" else text
    demo = load_task(f"{robot}-demo")
    name = demo.regions[0].name
    asked = replace(demo, formula=f"F_[0:60]({name} & P)", predicates=(Predicate("P", text),))
    assert atom_names(scene_formula(asked)) == (name, "P")
    found = build_task(asked)
    assert found.predicate_names == {"P"}
    start = found.robot.rest(jax.random.key(0), jnp.asarray(demo.initial.center))
    margin, _ = atom_margins(found.problem, start)
    assert np.isfinite(margin[len(demo.regions)])
