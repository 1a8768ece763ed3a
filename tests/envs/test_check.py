"""`check_robot` passes the shipped robots and names what is wrong with broken ones."""

from dataclasses import dataclass, field, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.task.protocols import Tuning
from envs import ENVS, VARIANTS, Linear, Workspace, make_robot
from envs.check import check_robot, main
from envs.check_motion import check_physics

SHIPPED = [
    *((name, "") for name in ENVS if name != "panda"),
    *((name, variant) for name in ENVS if name != "ant" for variant in VARIANTS[name]),
]
"""The panda with `links` is the panda with one check more, and costs ten seconds; the ant's
simulators are held to the same in `test_ant_simulators`."""


@pytest.mark.parametrize(("name", "variant"), SHIPPED)
def test_shipped_robots_are_sound(name, variant, disk_cache):
    assert [str(finding) for finding in check_robot(make_robot(name, variant))] == []


ARENA = ((-5.0, 5.0), (-5.0, 5.0))
VALUES: list[tuple[dict[str, Any], str]] = [
    ({"dt": 0.0}, "dt: is 0; it must be positive"),
    ({"speed": -1.0}, "speed: is -1; it must be positive"),
    ({"speed": "fast"}, "speed: is 'fast'; a number is wanted"),
    ({"lag": -1.0}, "lag: is -1 steps; it must not be negative"),
    ({"length": 0.01}, "length: is 0.01 m in an arena of 10 m; a tenth of it is usual"),
    ({"position_size": 4}, "position_size: is 4; it must be 2 or 3"),
    ({"action_size": 0}, "action_size: is 0; it must be at least 1"),
    ({"state_names": ("x [m]",)}, "state_names: has 1 names, but state_size is 2"),
    ({"action_names": ("v", "w", "z")}, "action_names: has 3 names, but action_size is 2"),
    ({"workspace": ARENA}, f"workspace: is {ARENA!r}; a Workspace is wanted"),
    ({"workspace": Workspace(ARENA[:1], 0.1)}, "arena has 1 axes, but position_size is 2"),
    ({"workspace": Workspace(((5.0, -5.0), ARENA[0]), 0.1)}, "low must be below high on every"),
    ({"workspace": Workspace(ARENA, 4.0)}, "spacing is 4 m; it must be positive and leave at"),
    ({"workspace": Workspace(ARENA, 0.01)}, "makes a grid of 1,002,001 nodes; at most 100,000"),
    ({"workspace": Workspace(ARENA, 0.1, clearance=3.0)}, "clearance is 3 m; it must be from 0"),
    ({"workspace": Workspace(ARENA, 0.1, reach=((-4.0, 5.0), ARENA[1]))}, "must lie within reach"),
    ({"workspace": Workspace(ARENA, 0.1, inset=-0.1)}, "inset is -0.1 m; it must be from 0 to"),
    ({"tuning": Tuning(violation=1.0)}, "tuning: violation must be negative"),
    ({"tuning": Tuning(epochs=0)}, "tuning: epochs, model_epochs and evaluation_states must"),
    ({"drawn_as": None}, "drawn_as: is None; a str is wanted"),
]


@pytest.mark.parametrize(
    ("quantities", "message"),
    [
        (("x [m]", "x [m]"), "quantities: 'x' must be a word, and be there once"),
        (("x [m]", "y-speed [m/s]"), "quantities: 'y-speed' must be a word"),
        (("x [m]",), "named: returns shape [2]"),
    ],
)
def test_named_quantities_are_words_and_as_many_as_values(quantities, message):
    @dataclass(frozen=True)
    class Naming(Linear):
        quantities: tuple[str, ...] = ()

        def named(self, state):
            return state

    findings = [str(finding) for finding in check_robot(Naming(quantities=quantities))]
    assert any(message in finding for finding in findings), findings


@pytest.mark.parametrize(("changed", "message"), VALUES)
def test_a_wrong_value_is_named(changed, message):
    findings = [str(finding) for finding in check_robot(replace(Linear(), **changed))]
    assert any(message in finding for finding in findings), findings


def test_what_is_missing_is_named():
    class Nothing:
        name = "nothing"

    missing = {f.member for f in check_robot(Nothing())}  # pyright: ignore[reportArgumentType]
    assert {"step", "rest", "observe", "workspace", "tuning", "variants", "dt"} <= missing
    assert "name" not in missing


@dataclass(frozen=True)
class Unhashable(Linear):
    gains: list = field(default_factory=list)


class Anonymous(Linear):
    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)


class Renamed(Linear):
    @property
    def variants(self):
        return {"other": replace(Linear(), name="other")}


class FlatRest(Linear):
    def rest(self, key, position):
        return jnp.zeros(3)


class Branching(Linear):
    def step(self, state, action):
        return state + action if action[0] > 0 else state


class OneState(Linear):
    def position(self, state):
        return state[:2]


class Wholes(Linear):
    def place(self, key, position):
        return jnp.zeros(2, jnp.int32)


class Pairs(Linear):
    def step(self, state, action):
        return state, action


class FlatVectors(Linear):
    def to_frame(self, state, vectors):
        return vectors.reshape(-1)


class Unclipped(Linear):
    def step(self, state, action):
        return state + 0.4 * action


class Drifting(Linear):
    def step(self, state, action):
        noise = np.random.normal(size=2)  # drawn anew whenever a program is made
        return Linear.step(self, state, action) + 0.01 * noise


class Understated(Linear):
    def farthest(self, step):
        return tuple(bound / 2 for bound in Linear.farthest(self, step))


class Elsewhere(Linear):
    def rest(self, key, position):
        return jnp.asarray(position)[::-1] + 0.0


class Astray(Linear):
    def place(self, key, position):
        return position + jax.random.normal(key, (2,))


class Lost(Linear):
    def place(self, key, position):
        return position * jnp.nan


class Exploding(Linear):
    def step(self, state, action):
        return Linear.step(self, state, action) + state**9


class Loud(Linear):
    def observe(self, state):
        return 100.0 * jnp.ones(1) + state[:1]


class Bent(Linear):
    def to_frame(self, state, vectors):
        return jnp.abs(vectors)


class Slow(Linear):
    def step(self, state, action):
        return state + 0.1 * jnp.clip(action, -1.0, 1.0)


class OneWay(Linear):
    def step(self, state, action):
        return state + 0.4 * jnp.clip(action, -1.0, 1.0) * jnp.array([1.0, 0.0])


class Hollow(Linear):
    links = True

    def body(self, state):
        return jnp.stack([state, state]), jnp.zeros(2)


class Misshapen(Linear):
    links = True

    def body(self, state):
        return state, jnp.ones(3)


MOTION = [
    (Unhashable(), "hash: make it a frozen dataclass of hashable fields"),
    (Anonymous(), "hash: a copy of it is not equal to it"),
    (Renamed(), "variants: 'other' must keep the robot's name and position_size"),
    (FlatRest(), "rest: returns shape [3] for key, [2]; [2] is wanted"),
    (Branching(), "step: fails under jit or vmap for [2], [2]: TracerBoolConversionError"),
    (OneState(), "position: returns shape [2, 2] for [4, 2]; [4, 2] is wanted"),
    (Wholes(), "place: returns int32; float32 is wanted"),
    (Pairs(), "step: returns tuple; an array [2] is wanted"),
    (FlatVectors(), "to_frame: returns shape [12] for [2], [2, 3, 2]; [2, 3, k] is wanted"),
    (Unclipped(), "step: does not clip actions to [-1, 1]"),
    (Drifting(), "step: gives another state for the same state and action"),
    (Elsewhere(), "rest: puts the robot"),
    (Astray(), "place: puts the robot"),
    (Lost(), "place: gives numbers that are not finite"),
    (Exploding(), "rollouts of 50 random actions"),
    (Loud(), "observe: gives numbers up to 10"),
    (Bent(), "to_frame: is not linear in the vectors"),
    (Understated(), "farthest: says [0.2, 0.2, 0.28"),
    (Slow(), "speed: 2.5 m along +x are planned as 8 steps (distance / speed + lag), but 0.8 m"),
    (OneWay(), "along +y are planned as"),
    (replace(Linear(), speed=0.6), "speed: 1.8 m along +x are planned as 4 steps"),
    (Misshapen(), "body: gives centres (2,) and radii (3,)"),
    (Hollow(), "body: gives centres that are not finite, or radii that are not"),
]


@pytest.mark.parametrize(("robot", "message"), MOTION, ids=lambda value: type(value).__name__)
def test_a_broken_function_is_named(robot, message):
    findings = [str(finding) for finding in check_robot(robot)]
    assert any(message in finding for finding in findings), findings


@dataclass(frozen=True)
class Host(Linear):
    """Linear, with a simulator that may be broken."""

    fault: str = ""

    def physics(self):
        return HostPhysics(self.fault, np.random.default_rng(0))


@dataclass(frozen=True, eq=False)
class HostPhysics:
    fault: str
    random: np.random.Generator

    def warm_up(self, count):
        pass

    def step(self, states, actions):
        after = states + 0.4 * np.clip(actions, -1.0, 1.0)
        match self.fault:
            case "shape":
                return after[:, :1]
            case "noise":
                return after + self.random.normal(size=after.shape)
            case "finite":
                return after * np.inf
            case "far":
                return after + 100.0
            case "lost":
                return np.nan_to_num(after)
            case "spreads":
                return after + after.sum() * 0
        return after


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("", None),
        ("shape", "physics: gives shape (4, 1) for states (4, 2)"),
        ("noise", "physics: gives another state for the same state and action"),
        ("finite", "physics: gives numbers that are not finite for robots at rest"),
        ("far", "physics: moves a robot at rest by"),
        ("lost", "physics: a state of NaN must come back as NaN and disturb no other"),
        ("spreads", "physics: a state of NaN must come back as NaN and disturb no other"),
    ],
)
def test_a_broken_simulator_is_named(fault, message):
    found = [str(f) for f in check_physics(Host(fault=fault), np.zeros((4, 2), np.float32))]
    assert found == [] if message is None else any(message in f for f in found), found


def test_the_command_prints_what_is_found(capsys):
    assert main(["linear"]) == 0
    assert capsys.readouterr().out == "linear: sound\n"
