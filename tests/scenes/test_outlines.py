"""Scenes as exact plans know them: the robot's stride, and plans judged by others."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.planning.exact import plan_exactly
from core.stl import parse, robustness
from core.task.protocols import stride_of
from envs import ENVS, Linear
from scenes import Predicate, Region, SceneError, load_task, scene_formula
from scenes.outlines import margins_of, setting_of
from tests.scenes.oracle import rtamt_robustness


def test_a_stride_is_what_a_step_does():
    robot = Linear(max_velocity=1.5)
    random = np.random.default_rng(0)
    states, actions = random.uniform(-3, 3, (20, 2)), random.uniform(-2, 2, (20, 2))
    after = jax.vmap(robot.step)(jnp.asarray(states), jnp.asarray(actions))
    expected = states + np.clip(actions, -1, 1) * np.array(robot.stride)
    assert np.asarray(after) == pytest.approx(expected, abs=1e-5)


def test_other_robots_are_refused():
    with pytest.raises(SceneError, match=r"not for 'unicycle'\. Allowed: linear$"):
        setting_of(load_task("unicycle-demo"))
    assert [name for name, robot in ENVS.items() if stride_of(robot)] == ["linear"]


@pytest.mark.parametrize(
    ("region", "why"),
    [
        (Region("A1", "polygon", points=((0, 0), (2, 0), (1.2, 1), (2, 2))), "A1 is not convex"),
        (Region("A1", "union", parts=(Region("a", "circle", (0, 0), (1,)),)), "A1 is a union"),
    ],
)
def test_shapes_without_an_outline_are_refused(region, why):
    scene = load_task("linear-demo")
    with pytest.raises(SceneError, match=f"circles, rectangles and convex polygons; {why}$"):
        setting_of(replace(scene, regions=(region, *scene.regions[1:])))


def test_predicates_of_the_state_are_refused():
    scene = replace(load_task("linear-demo"), predicates=(Predicate("west", "x <= 1"),))
    with pytest.raises(SceneError, match="no predicates of the state: west$"):
        setting_of(scene)


def test_a_plan_of_a_shipped_scene_is_as_robust_as_others_say():
    scene = replace(load_task("linear-demo"), formula="F_[5:20](A1) & (!A2)U_[0:25](A1)")
    found = plan_exactly(scene_formula(scene), setting_of(scene))
    assert found.positions is not None and found.robustness >= 0
    table = np.stack(list(margins_of(scene.regions, found.positions).values()), -1)
    names = scene.region_names
    assert found.robustness == pytest.approx(rtamt_robustness(scene.formula, names, table))
    assert found.robustness == pytest.approx(float(robustness(parse(scene.formula), table, names)))
    assert found.robustness <= found.bound + 1e-6
