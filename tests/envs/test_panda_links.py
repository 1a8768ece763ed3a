"""The arm's links as obstacles meet them, against capsules in float64 NumPy."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.evaluation import trace_robustness
from core.task.problem import atom_margins, trace_margins
from envs import Panda
from scenes import Region, load_task
from studio.runs.tasks import build_task
from tests.envs.reference import (
    PANDA_HIGH,
    PANDA_LOW,
    PANDA_READY,
    panda_point,
    panda_tip,
)
from tests.scenes.geometry import margins_of

ARM = Panda(links=True)
CAPSULES = [
    (3, (0.0, 0.0, 0.333), (0.0, 0.0, 0.649), 0.07),  # upper arm, moved by joints 1 to 3
    (3, (0.0, 0.0, 0.649), (0.0825, 0.0, 0.649), 0.07),
    (5, (0.0, 0.0, 0.649), (0.0, 0.0, 1.033), 0.06),  # forearm, moved by joints 1 to 5
    (6, (0.0, 0.0, 1.033), (0.088, 0.0, 1.033), 0.06),
    (7, (0.088, 0.0, 1.033), (0.088, 0.0, 1.033 - 0.107 - 0.045), 0.05),
]
"""(joints that move it, ends with all joints at zero, radius), off Franka's drawing, in [m]."""


def _link_points(angles) -> list[tuple[np.ndarray, float]]:
    """Points [P, 3] on the axis of every capsule, and its radius."""
    moved = []
    for joints, begin, end, radius in CAPSULES:
        axis = np.linspace(begin, end, 200)
        moved.append((np.array([panda_point(angles, point, joints) for point in axis]), radius))
    return moved


def _postures(count: int) -> np.ndarray:
    return np.random.default_rng(8).uniform(PANDA_LOW, PANDA_HIGH, (count, 7))


def test_balls_cover_the_capsules_and_hardly_more():
    for posture in _postures(5):
        centers, radii = (np.asarray(part) for part in ARM.body(jnp.asarray(posture)))
        first = 0
        for (axis, radius), count in zip(_link_points(posture), (6, 3, 7, 3, 5), strict=True):
            mine, mine_radii = centers[first : first + count], radii[first : first + count]
            first += count
            away = np.linalg.norm(mine[:, None] - axis, axis=-1)
            assert away.min(1).max() < 1e-3, "balls lie on their capsule's axis"
            assert ((mine_radii >= radius) & (mine_radii <= radius + 0.009)).all()
            # a point of the capsule's mantle at s on the axis is in the ball at c
            # if (s - c)^2 + r^2 <= R^2
            reach = np.sqrt(mine_radii**2 - radius**2)
            assert (away <= reach[:, None] + 1e-5).any(0).all()
        assert first == len(centers)


def test_fingers_reach_beyond_the_hand():
    for posture in _postures(5):
        centers, radii = ARM.body(jnp.asarray(posture))
        hand = slice(-5, None)
        away = np.linalg.norm(np.asarray(centers[hand]) - panda_tip(posture), axis=-1)
        assert (away > np.asarray(radii[hand])).all()


def _task(variant: str, obstacle: Region):
    scene = load_task("panda-08")
    regions = tuple(obstacle if r.name == "B1" else r for r in scene.regions)
    return build_task(replace(scene, regions=regions, variant=variant))


def test_an_elbow_in_an_obstacle_violates_it_though_the_hand_does_not():
    """The ready posture, its elbow 22 cm behind the foot in a small ball."""
    elbow = panda_point(PANDA_READY, (0.0825, 0.0, 0.649), 3)
    tip = panda_tip(PANDA_READY)
    ball = Region("B1", "sphere", tuple(elbow.tolist()), (0.05,))
    assert np.linalg.norm(tip - elbow) > 0.4
    still = jnp.tile(jnp.asarray(PANDA_READY, jnp.float32), (101, 1, 1))
    found = {}
    for variant in ("", "links"):
        task = _task(variant, ball)
        margins = np.asarray(trace_margins(task.problem, still))
        column = task.grounding.atoms.index("B1")
        found[variant] = margins[0, 0]
        avoided = replace(task.grounding, decomposition=_only("G_[0:100](!B1)", task))
        verdict = trace_robustness(replace(task, grounding=avoided), margins)
        assert (verdict >= 0).all() == (variant == ""), (variant, verdict)
        np.testing.assert_allclose(verdict, -found[variant][column], atol=1e-6)
    np.testing.assert_allclose(found[""][column], 0.05 - np.linalg.norm(tip - elbow), atol=1e-5)
    assert 0.05 + 0.07 <= found["links"][column] <= 0.05 + 0.07 + 0.009
    others = np.arange(len(found[""])) != column
    np.testing.assert_array_equal(found["links"][others], found[""][others])  # goals and walls


def _only(text: str, task):
    from core.decompose import decompose
    from core.stl import parse

    return decompose(parse(text, names=task.grounding.atoms))


@pytest.mark.parametrize(
    "obstacle",
    [
        Region("B1", "box", (0.4, 0.1, 0.4), (0.1, 0.15, 0.2)),
        Region("B1", "cylinder", (0.3, -0.2, 0.5), (0.1, 0.3)),
        Region("B1", "sphere", (0.2, 0.2, 0.7), (0.15,)),
    ],
)
def test_margins_are_those_of_the_nearest_point_of_the_arm(obstacle):
    """To the balls' 9 mm; how deep the arm is in an obstacle is told by the balls alone."""
    task = _task("links", obstacle)
    column = task.grounding.atoms.index("B1")
    margins = jax.vmap(lambda q: atom_margins(task.problem, q)[0])
    postures = _postures(30)
    found = np.asarray(margins(jnp.asarray(postures, jnp.float32)))[:, column]
    for posture, margin in zip(postures, found, strict=True):
        links = [margins_of(obstacle, axis).max() + r for axis, r in _link_points(posture)]
        exact = max(*links, float(margins_of(obstacle, panda_tip(posture))))
        assert min(exact, 0.0) - 1e-5 <= margin <= exact + 0.0091, (posture, exact, margin)


def test_a_region_that_is_also_visited_is_the_end_effectors():
    scene = load_task("panda-08")
    formula = "F_[0:90](A1) & G_[0:30](!A1) & G_[0:100](!B1) & G_[0:100](!W1)"
    task = build_task(replace(scene, variant="links"), formula)
    names = task.grounding.atoms
    covered = {names[i] for i in np.flatnonzero(np.asarray(task.problem.on_body)[: len(names)])}
    assert covered == {"A2", "A3", "B1"}, "A1 is visited, W1 is a wall"
