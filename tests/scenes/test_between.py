"""The least margin between steps against a fine brute force, on random shapes and traces."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from core.between import swept
from core.stl import Atom, Not, Or
from scenes import Region, Scene, load_task
from scenes.distances import margin_of
from studio.runs.tasks import build_task

FINE, TRACES, STEPS = 4000, 6, 10


def scene_of(robot: str, seed: int) -> Scene:
    """Random shapes, the second half of them thin."""
    random = np.random.default_rng(seed)
    kinds = {"linear": ("rectangle", "circle"), "quadrotor": ("box", "sphere", "cylinder")}[robot]
    regions = []
    for number in range(6):
        kind = kinds[number % len(kinds)]
        count = {"circle": 1, "sphere": 1, "cylinder": 2, "rectangle": 2, "box": 3}[kind]
        size = random.uniform(0.1, 0.8, count)
        if number >= 3:
            size[random.integers(count)] = 10 ** random.uniform(-3, -1)
        center = random.uniform(-1, 1, 2 if robot == "linear" else 3)
        regions.append(Region(f"R{number}", kind, tuple(center.tolist()), tuple(size.tolist())))
    formula = " & ".join(f"G_[0:{STEPS}](!R{i})" for i in range(6))
    demo = load_task(f"{robot}-demo")
    return replace(demo, regions=tuple(regions), formula=formula, horizon=STEPS)


@pytest.mark.parametrize("robot", ["linear", "quadrotor"])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_sweep_finds_what_brute_force_finds(robot, seed):
    scene = scene_of(robot, seed)
    task = build_task(scene, force=True)
    random = np.random.default_rng([seed, 7])
    states = random.normal(0, 1, (TRACES, STEPS + 1, task.robot.state_size)).astype(np.float32)
    formulas = [Not(Atom("R0")), Not(Atom("R3")), Not(Atom("R4")), Not(Atom("R5"))]
    formulas += [Atom("R1"), Or((Not(Atom("R4")), Atom("R0"))), Not(Atom("R2"))]
    found = swept(task, states, formulas)

    ends = np.asarray(task.robot.position(jnp.asarray(states)), float)[:, :, None]
    share = np.linspace(0, 1, FINE + 1)[:, None]
    positions = ends[:, :-1] + share * (ends[:, 1:] - ends[:, :-1])
    flat = positions.reshape(-1, positions.shape[-1])
    mu = {each.name: margin_of(each, flat).reshape(positions.shape[:3]) for each in scene.regions}
    brute = np.stack(
        [
            *(-mu[name] for name in ("R0", "R3", "R4", "R5")),
            mu["R1"],
            np.maximum(-mu["R4"], mu["R0"]),
            -mu["R2"],
        ],
        -1,
    ).min(2)
    travelled = np.linalg.norm(np.diff(ends[:, :, 0], axis=1), axis=-1)
    gap = (travelled / FINE)[..., None]
    part = (travelled / 16)[..., None]
    assert (found.value >= brute - gap - 1e-5).all()
    assert (found.value <= brute + part + 1e-5).all()
    cut = brute < -3e-4
    assert cut.any() and (brute > gap).any()
    assert (found.value[cut] < 0).all()
    assert (found.value[brute > gap + 1e-5] > 0).all()


def test_the_place_of_the_least_margin_is_on_the_way():
    scene = scene_of("linear", 3)
    task = build_task(scene, force=True)
    states = np.random.default_rng(0).normal(0, 1, (4, STEPS + 1, 2)).astype(np.float32)
    found = swept(task, states, [Not(Atom(f"R{i}")) for i in range(6)])
    for column, region in enumerate(scene.regions):
        share = found.share[:, :, column, None]
        positions = states[:, :-1] + share * np.diff(states, axis=1)
        values = -margin_of(region, positions.reshape(-1, 2)).reshape(4, STEPS)
        np.testing.assert_allclose(values, found.value[:, :, column], atol=1e-4)
