"""MJX, brax and native MuJoCo simulate the same ant. Two compilations, half a minute each."""

import copy
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.task.physics import physics_of
from envs import Ant, make_robot
from envs.ant.compiled import CompiledPhysics
from envs.ant.gait import shipped_gait
from envs.ant.model import POSITIONS, STANDING, STATE, SUBSTEPS, ant_model, has_fallen
from envs.ant.native import NativePhysics
from envs.check_motion import check_physics

COUNT = 16
ROOT = Path(__file__).parents[2]
COMPILED = pytest.mark.parametrize("name", ["mjx", "brax"])


@pytest.fixture(scope="module")
def simulators(disk_cache) -> dict[str, Any]:
    found = {name: physics_of(Ant(simulator=name)) for name in ("native", "mjx", "brax")}
    for physics in found.values():
        assert physics is not None
        physics.warm_up(COUNT)
    return found


def _standing(random: np.random.Generator) -> np.ndarray:
    states = np.tile(STANDING, (COUNT, 1))
    half = random.uniform(-np.pi, np.pi, COUNT) / 2
    states[:, 3], states[:, 6] = np.cos(half), np.sin(half)
    return states


def _walked(physics, length: float) -> tuple[float, int]:
    """Mean distance [m] in three seconds towards waypoints ahead, and how many ants fell."""
    random = np.random.default_rng(2)
    angle = random.uniform(-np.pi, np.pi, COUNT)
    ahead = np.stack([np.cos(angle), np.sin(angle)], -1)
    states, fell = _standing(random), np.zeros(COUNT, bool)
    for _ in range(60):
        states = physics.step(states, length / Ant().reach * ahead)
        fell |= has_fallen(states)
    return float((states[~fell, :2] * ahead[~fell]).sum(1).mean()), int(fell.sum())


def test_each_variant_has_its_simulator(simulators):
    for name, kind in {"native": NativePhysics, "mjx": CompiledPhysics}.items():
        assert isinstance(simulators[name], kind)
    for name, physics in simulators.items():
        assert physics_of(make_robot("ant", name)) is physics


@pytest.mark.parametrize("name", ["native", "mjx", "brax"])
def test_they_keep_what_core_expects_of_them(name, simulators):
    assert list(check_physics(make_robot("ant", name), _standing(np.random.default_rng(3)))) == []


def test_the_same_torques_lead_along_the_same_path(simulators):
    """Ten physics steps; physics amplifies rounding, so that later only statistics agree."""
    random = np.random.default_rng(1)
    one = other = _standing(random)
    for _ in range(2):
        torques = random.uniform(-1, 1, (COUNT, 8))
        one = simulators["native"].torque_step(one, torques)
        other = simulators["mjx"].torque_step(other, torques)
    np.testing.assert_allclose(other[:, :3], one[:, :3], atol=1e-5)


def test_brax_in_the_air_is_mujoco_with_explicit_damping(simulators):
    """To float32, without contacts; MuJoCo's implicit damping differs a thousand times as much."""
    import mujoco

    random = np.random.default_rng(4)
    states, torques = _standing(random), random.uniform(-1, 1, (COUNT, 8))
    states[:, 2] = 5.0
    states[:, POSITIONS:] = random.normal(size=(COUNT, STATE - POSITIONS))
    found = simulators["brax"].torque_step(states, torques)
    implicit = simulators["native"].torque_step(states, torques)
    library: Any = mujoco
    model = copy.copy(ant_model())
    model.opt.disableflags |= library.mjtDisableBit.mjDSBL_EULERDAMP
    for row, (state, torque) in enumerate(zip(states, torques, strict=True)):
        data = library.MjData(model)
        data.qpos[:], data.qvel[:], data.ctrl[:] = state[:POSITIONS], state[POSITIONS:], torque
        library.mj_step(model, data, SUBSTEPS)
        expected = np.concatenate([data.qpos, data.qvel])
        np.testing.assert_allclose(found[row], expected, atol=5e-6)
    assert np.abs(found - implicit).max() > 1e-2


def test_the_gait_walks_as_far_in_mjx(simulators):
    """Three seconds towards waypoints at full reach: mean distance within a tenth."""
    expected, _ = _walked(simulators["native"], 0.7)
    found, fell = _walked(simulators["mjx"], 0.7)
    assert fell <= 2
    assert found == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize(("length", "most_falls"), [(0.7, 4), (0.25, 1)])
def test_the_gait_walks_nearly_as_far_in_brax(simulators, length, most_falls):
    """Softer contacts cost speed: seen 0.81 to 0.87 of native's distance over three seeds, and of
    16 ants 1 to 2 down at full reach, none at a walk."""
    expected, _ = _walked(simulators["native"], length)
    found, fell = _walked(simulators["brax"], length)
    assert fell <= most_falls
    assert 0.75 < found / expected < 0.95


@COMPILED
def test_a_lost_row_stays_alone(name, simulators):
    states, torques = _standing(np.random.default_rng(3)), np.zeros((COUNT, 8))
    whole = simulators[name].torque_step(states, torques)
    states[4, 17] = np.nan
    broken = simulators[name].torque_step(states, torques)
    assert np.isnan(broken[4]).all()
    np.testing.assert_array_equal(np.delete(broken, 4, 0), np.delete(whole, 4, 0))


def test_a_step_after_the_warm_up_compiles_nothing():
    """A simulator that stands still, compiled in no time; the real ones are made alike."""
    import jax

    compiled = []

    def listen(event: str, duration_secs: float, **_: Any) -> None:
        if "backend_compile" in event:
            compiled.append(duration_secs)

    still = CompiledPhysics(lambda state, torques: state + 0 * torques.sum(), shipped_gait(), 0.7)
    states, actions = np.tile(STANDING, (3, 1)), np.ones((3, 2))
    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        still.warm_up(3)
        assert compiled  # the listener hears
        compiled.clear()
        after = still.step(states, actions)
        assert compiled == []
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)
    np.testing.assert_allclose(after, states)


def test_standard_output_is_for_results():
    """Importing MJX prints a line; it goes to standard error."""
    code = "from envs import make_robot\nfrom core.task.physics import physics_of\n"
    code += "physics_of(make_robot('ant', 'mjx'))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert done.stdout == ""
