"""What a robot's functions compute, for `envs.check`: starts, steps, reach, true physics.

Dimensions: N states, n state, m action, d position, k steps.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np

from core.task.physics import physics_of
from core.task.protocols import BodiedRobot, farthest_of, has_body
from envs.finding import Finding
from envs.robot import Robot

COUNT = 64
"""States and actions that are tried."""

STEPS = 50
"""Of rollouts with random actions."""

PIECES, CANDIDATES, ROUNDS, KEPT = 4, 512, 12, 32
"""Of the search for the way that leads farthest: pieces of constant action, candidates of a
round, rounds, and candidates that the next round is drawn about."""


def check_motion(robot: Robot) -> Iterator[Finding]:
    """Findings of all checks that compute."""
    low, high = np.array(robot.workspace.arena, np.float32).T
    random = np.random.default_rng(0)
    inner = random.uniform(-0.25, 0.25, (COUNT, len(low))).astype(np.float32)
    inner[0] = 0.0  # where `_check_reach` begins
    wanted = (low + high) / 2 + (high - low) * inner  # in the inner half of the arena
    states = {}
    for name in ("rest", "place"):
        states[name], findings = _checked_starts(robot, name, wanted)
        yield from findings
        if findings:
            return
    yield from _check_step(robot, states["place"])
    yield from _check_views(robot, states["place"])
    yield from _check_farthest(robot, states["rest"])
    yield from _check_reach(robot, states["rest"][0])
    yield from check_physics(robot, states["rest"][:4])


def _checked_starts(
    robot: Robot, name: str, wanted: np.ndarray
) -> tuple[np.ndarray, list[Finding]]:
    """States [N, n] that `rest` or `place` makes at positions [N, d], and what is wrong there."""
    keys = jax.random.split(jax.random.key(1), len(wanted))
    once, again = _twice(getattr(robot, name), keys, wanted)
    if not np.array_equal(once, again, equal_nan=True):
        return once, [Finding(name, "gives another state for the same key and position")]
    if not np.isfinite(once).all():
        return once, [Finding(name, "gives numbers that are not finite")]
    away = np.linalg.norm(jax.jit(robot.position)(once) - wanted, axis=1)
    if np.quantile(away, 0.9) > max(robot.workspace.clearance / 3, 1e-3 * robot.length):
        off = f"puts the robot {np.median(away):.2g} m from the position that is asked for"
        return once, [Finding(name, off)]
    return once, []


def _twice(function: Callable[..., jax.Array], *arguments: Any) -> list[np.ndarray]:
    """Results for a batch of one program that runs twice.

    A function that makes another program the second time, from a number drawn while it is traced
    for instance, counts as one with another result: NaN.
    """
    lowered, other = (jax.jit(jax.vmap(partial(function))).lower(*arguments) for _ in range(2))
    program = lowered.compile()
    once, again = (np.asarray(program(*arguments)) for _ in range(2))
    return [once, again if lowered.as_text() == other.as_text() else np.full_like(again, np.nan)]


def _actions(robot: Robot, scale: float, *shape: int) -> jax.Array:
    key = jax.random.key(2)
    shape = (*shape, robot.action_size)
    return jax.random.uniform(key, shape, minval=-scale, maxval=scale)


def _check_step(robot: Robot, states: np.ndarray) -> Iterator[Finding]:
    actions = _actions(robot, 3.0, COUNT)
    once, again = _twice(robot.step, states, actions)
    if not np.array_equal(once, again, equal_nan=True):
        yield Finding("step", "gives another state for the same state and action")
        return
    if not np.isfinite(once).all():
        yield Finding("step", "gives numbers that are not finite for a placed robot")
        return
    clipped = jax.jit(jax.vmap(robot.step))(states, jnp.clip(actions, -1.0, 1.0))
    if not np.allclose(once, clipped, rtol=1e-4, atol=1e-5):
        yield Finding("step", "does not clip actions to [-1, 1]")
    sound = np.isfinite(_rolled_out(robot, states, _actions(robot, 1.0, STEPS, COUNT))).all(-1)
    if sound.mean() < 0.9:
        yield Finding(
            "step",
            f"leads to numbers that are not finite in {1 - sound.mean():.0%} of {COUNT} rollouts "
            f"of {STEPS} random actions",
        )


def _rolled_out(robot: Robot, states: np.ndarray, actions: jax.Array) -> np.ndarray:
    """Last states [N, n] after actions [k, N, m]."""

    def advance(state, action):
        return jax.vmap(robot.step)(state, action), None

    return np.asarray(jax.jit(lambda s, a: jax.lax.scan(advance, s, a)[0])(states, actions))


def _check_views(robot: Robot, states: np.ndarray) -> Iterator[Finding]:
    """`observe`, `to_frame`, and `body` where there is one."""
    seen = np.abs(jax.jit(jax.vmap(robot.observe))(states))
    if not np.isfinite(seen).all():
        yield Finding("observe", "gives numbers that are not finite")
    elif seen.size and np.quantile(seen.max(-1), 0.9) > 10:
        yield Finding("observe", f"gives numbers up to {seen.max():.3g}; about 1 is wanted")
    key, other_key = jax.random.split(jax.random.key(3))
    shape = (COUNT, robot.position_size)
    first, second = jax.random.normal(key, shape), jax.random.normal(other_key, shape)
    turn = jax.jit(jax.vmap(robot.to_frame))
    whole, parts = turn(states, first + 2 * second), turn(states, first) + 2 * turn(states, second)
    if not np.allclose(whole, parts, rtol=1e-3, atol=1e-3):
        yield Finding("to_frame", "is not linear in the vectors: it should turn or scale them")
    if has_body(robot):
        centers, radii = jax.jit(jax.vmap(cast(BodiedRobot, robot).body))(states)
        if centers.shape != (*radii.shape, robot.position_size):
            yield Finding("body", f"gives centres {centers.shape[1:]} and radii {radii.shape[1:]}")
        elif not (np.isfinite(centers).all() and (radii > 0).all()):
            yield Finding("body", "gives centres that are not finite, or radii that are not > 0")


def _check_farthest(robot: Robot, starts: np.ndarray) -> Iterator[Finding]:
    """The bound on what a step covers, where there is one: rollouts from rest keep it."""
    bound = np.array([farthest_of(robot, step) for step in range(STEPS)], float)
    if bound.shape != (STEPS, robot.position_size + 1) or np.isnan(bound).any():
        shape = f"{STEPS} steps of {robot.position_size + 1}"
        yield Finding("farthest", f"gives numbers of shape {bound.shape}; {shape} are wanted")
        return
    if (np.diff(bound, axis=0) < 0).any():
        yield Finding("farthest", "becomes smaller in later steps")
    if not np.isfinite(bound).any():
        return
    actions = jnp.sign(_actions(robot, 1.0, STEPS, COUNT))

    def advance(state, action):
        after = jax.vmap(robot.step)(state, action)
        return after, robot.position(after) - robot.position(state)

    change = np.abs(jax.jit(lambda s, a: jax.lax.scan(advance, s, a)[1])(starts, actions))
    with np.errstate(over="ignore"):  # of a robot that explodes
        whole = np.linalg.norm(change, axis=-1, keepdims=True)
    way = np.concatenate([change, whole], -1).max(1)
    if (way > bound + 1e-4 * robot.length).any():
        step = int((way > bound + 1e-4 * robot.length).any(1).argmax())
        yield Finding(
            "farthest",
            f"says {bound[step].round(4).tolist()} m for step {step}, but a rollout covers "
            f"{way[step].round(4).tolist()} m",
        )


def _check_reach(robot: Robot, start: np.ndarray) -> Iterator[Finding]:
    """A leg of D metres is planned to take D / speed + lag steps: can it be done in them?

    From rest in the middle of the arena along every axis, a quarter of the arena and three steps'
    worth of speed; the way is searched for by the cross-entropy method. Says the worst.
    """
    worst = (1.0, Finding("speed", ""))
    legs = []
    for axis, (low, high) in enumerate(robot.workspace.arena):
        for sign in (1.0, -1.0):
            for distance in ((high - low) / 4, 3 * robot.speed):
                direction = sign * np.eye(robot.position_size, dtype=np.float32)[axis]
                legs.append((distance, direction, math.ceil(distance / robot.speed + robot.lag)))
    longest = max(steps for _, _, steps in legs)
    search = jax.jit(partial(_farthest, robot, longest))
    for distance, direction, steps in legs:
        reached = float(search(start, direction, steps))
        if reached / distance < worst[0] - 1e-3:
            worst = (
                reached / distance,
                Finding(
                    "speed",
                    f"{distance:.2g} m along {_named(direction)} are planned as {steps} steps "
                    f"(distance / speed + lag), but {max(reached, 0.0):.2g} m is the farthest that "
                    "was found; lower `speed` or raise `lag`",
                ),
            )
    if worst[0] < 1.0:
        yield worst[1]


def _named(direction: np.ndarray) -> str:
    axis = int(np.abs(direction).argmax())
    return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"


def _farthest(robot: Robot, longest: int, start, direction, steps):
    """Largest displacement [m] along a direction [d] after so many steps from a state [n]."""
    origin = robot.position(start)

    def displacement(pieces):
        """Of actions [PIECES, m], each held for a part of the steps."""

        def advance(state, time):
            action = pieces[jnp.minimum(time * PIECES // steps, PIECES - 1)]
            return jnp.where(time < steps, robot.step(state, action), state), None

        state, _ = jax.lax.scan(advance, start, jnp.arange(longest))
        along = (robot.position(state) - origin) @ direction
        return jnp.where(jnp.isfinite(along), along, -jnp.inf)

    def improve(carry, key):
        mean, deviation, best = carry
        noise = jax.random.normal(key, (CANDIDATES, PIECES, robot.action_size))
        candidates = jnp.clip(mean + deviation * noise, -1.0, 1.0)
        reached = jax.vmap(displacement)(candidates)
        top, order = jax.lax.top_k(reached, KEPT)
        kept = candidates[order]
        return (kept.mean(0), kept.std(0) + 0.05, jnp.maximum(best, top[0])), None

    shape = (PIECES, robot.action_size)
    begin = (jnp.zeros(shape), jnp.ones(shape), jnp.float32(-jnp.inf))
    (_, _, best), _ = jax.lax.scan(improve, begin, jax.random.split(jax.random.key(5), ROUNDS))
    return best


def check_physics(robot: Robot, states: np.ndarray) -> Iterator[Finding]:
    """The simulator of true physics, where there is one: steps of four robots."""
    physics = physics_of(robot)
    if physics is None:
        return
    actions = np.asarray(_actions(robot, 1.0, len(states)))
    physics.warm_up(len(states))
    once, again = (np.asarray(physics.step(states, actions)) for _ in "12")
    if once.shape != states.shape:
        yield Finding("physics", f"gives shape {once.shape} for states {states.shape}")
        return
    if not np.array_equal(once, again, equal_nan=True):
        yield Finding("physics", "gives another state for the same state and action")
    if not np.isfinite(once).all():
        yield Finding("physics", "gives numbers that are not finite for robots at rest")
    position = jax.jit(robot.position)
    moved = np.linalg.norm(position(jnp.float32(once)) - position(states), axis=1)
    if moved.max() > 10 * robot.speed:
        yield Finding("physics", f"moves a robot at rest by {moved.max():.2g} m in a step")
    broken = states.copy()
    broken[1] = np.nan
    lost, others = np.asarray(physics.step(broken, actions)), np.arange(len(states)) != 1
    if np.isfinite(lost[1]).all() or not np.array_equal(lost[others], once[others]):
        yield Finding("physics", "a state of NaN must come back as NaN and disturb no other")
