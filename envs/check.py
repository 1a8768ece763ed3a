"""Whether a robot keeps what `core` and `scenes` expect of it: `check_robot`.

    python -m envs.check NAME

Three stages, each of which needs the one before: what the robot says of itself, the shapes of
its functions under `jit` and `vmap`, and what they compute (`envs.check_motion`).

Dimensions: n state, m action, d position.
"""

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp

from core.errors import UserError
from core.task.protocols import Tuning
from core.task.quantities import quantities_of
from envs.check_motion import check_motion
from envs.finding import Finding
from envs.robot import Robot, Workspace

MEMBERS: dict[str, type | tuple[type, ...]] = {
    "name": str,
    "state_size": int,
    "action_size": int,
    "position_size": int,
    "dt": (int, float),
    "speed": (int, float),
    "lag": (int, float),
    "length": (int, float),
    "state_names": tuple,
    "action_names": tuple,
    "workspace": Workspace,
    "tuning": Tuning,
    "drawn_as": str,
}
"""Values that a robot brings, and their types."""

FUNCTIONS = ("rest", "place", "step", "position", "observe", "to_frame")

NODES = {2: 100_000, 3: 50_000}
"""Most nodes of a grid by dimension: a field for each subgoal and combination of doors is kept."""


def check_robot(robot: Robot) -> list[Finding]:
    """What is wrong with a robot, in words; nothing if it can be trained.

    Takes about ten seconds, most of it compilation; the simulator of a robot with true physics
    comes on top.
    """
    for stage in (_check_values, _check_shapes, check_motion):
        findings = list(stage(robot))
        if findings:
            return findings
    return []


def _check_values(robot: Robot) -> Iterator[Finding]:
    missing = [name for name in (*MEMBERS, "variants", *FUNCTIONS) if not hasattr(robot, name)]
    for name in missing:
        yield Finding(name, "is missing; `envs/robot.py` says what it is")
    wrong = [
        name
        for name, kind in MEMBERS.items()
        if name not in missing and not isinstance(getattr(robot, name), kind)
    ]
    for name in wrong:
        kind = MEMBERS[name]
        wanted = "number" if isinstance(kind, tuple) else kind.__name__
        yield Finding(name, f"is {getattr(robot, name)!r}; a {wanted} is wanted")
    if not missing and not wrong:
        yield from _check_numbers(robot)
        yield from _check_names(robot)
        yield from _check_workspace(robot)
        yield from _check_value_semantics(robot)


def _check_numbers(robot: Robot) -> Iterator[Finding]:
    for name in ("dt", "speed", "length"):
        if not 0 < getattr(robot, name) < math.inf:
            yield Finding(name, f"is {getattr(robot, name):g}; it must be positive")
    if not 0 <= robot.lag < math.inf:
        yield Finding("lag", f"is {robot.lag:g} steps; it must not be negative")
    for name in ("state_size", "action_size"):
        if getattr(robot, name) < 1:
            yield Finding(name, f"is {getattr(robot, name)}; it must be at least 1")
    if robot.position_size not in (2, 3):
        yield Finding("position_size", f"is {robot.position_size}; it must be 2 or 3")
    tuning = robot.tuning
    if not (tuning.violation < 0 < tuning.learning_rate):
        yield Finding("tuning", "violation must be negative, learning_rate positive")
    if min(tuning.epochs, tuning.model_epochs, tuning.evaluation_states) < 1:
        yield Finding("tuning", "epochs, model_epochs and evaluation_states must be at least 1")


def _check_names(robot: Robot) -> Iterator[Finding]:
    for names, size in (("state_names", "state_size"), ("action_names", "action_size")):
        given, wanted = len(getattr(robot, names)), getattr(robot, size)
        if given != wanted:
            yield Finding(names, f"has {given} names, but {size} is {wanted}")
    names = [each.name for each in quantities_of(robot)]
    unfit = [name for name in names if not name.isidentifier() or names.count(name) > 1]
    if unfit and hasattr(robot, "quantities"):
        yield Finding("quantities", f"{unfit[0]!r} must be a word, and be there once")
    for name, variant in robot.variants.items():
        if variant.name != robot.name or variant.position_size != robot.position_size:
            yield Finding("variants", f"{name!r} must keep the robot's name and position_size")


def _check_workspace(robot: Robot) -> Iterator[Finding]:
    workspace, size = robot.workspace, robot.position_size
    arena = workspace.arena
    if len(arena) != size:
        yield Finding("workspace", f"arena has {len(arena)} axes, but position_size is {size}")
        return
    if not all(-math.inf < low < high < math.inf for low, high in arena):
        yield Finding("workspace", f"arena {arena}: low must be below high on every axis")
        return
    if workspace.reach is not None and not _within(arena, workspace.reach):
        yield Finding("workspace", f"arena {arena} must lie within reach {workspace.reach}")
    extents = [high - low for low, high in arena]
    if not 0 < workspace.spacing <= min(extents) / 4:
        yield Finding(
            "workspace",
            f"spacing is {workspace.spacing:g} m; it must be positive and leave at least 5 nodes "
            f"on the shortest axis, {min(extents):g} m long",
        )
        return
    nodes = math.prod(math.ceil(extent / workspace.spacing) + 1 for extent in extents)
    if nodes > NODES.get(size, NODES[3]):
        yield Finding(
            "workspace",
            f"spacing {workspace.spacing:g} m makes a grid of {nodes:,} nodes; at most "
            f"{NODES[size]:,} are practical: about 80 an axis in the plane, 20 to 35 in space",
        )
    for name in ("clearance", "inset"):
        if not 0 <= getattr(workspace, name) < min(extents) / 4:
            yield Finding(
                "workspace",
                f"{name} is {getattr(workspace, name):g} m; it must be from 0 to a quarter of the "
                f"shortest axis, {min(extents):g} m",
            )
    if not max(extents) / 100 <= robot.length <= max(extents):
        yield Finding(
            "length",
            f"is {robot.length:g} m in an arena of {max(extents):g} m; a tenth of it is usual",
        )
    if robot.speed > max(extents) / 4:
        yield Finding("speed", f"is {robot.speed:g} m a step in an arena of {max(extents):g} m")


def _within(inner: tuple, outer: tuple) -> bool:
    """Whether one box, (low, high) an axis, lies in another."""
    pairs = zip(inner, outer, strict=False)
    return len(inner) == len(outer) and all(o[0] <= i[0] and i[1] <= o[1] for i, o in pairs)


def _check_value_semantics(robot: Robot) -> Iterator[Finding]:
    """Robots are static arguments of compiled functions: equal ones must count as one."""
    try:
        twin = replace(robot)  # pyright: ignore[reportArgumentType]
        same = hash(twin) == hash(robot) and twin == robot
    except TypeError as error:
        yield Finding("hash", f"make it a frozen dataclass of hashable fields: {error}")
        return
    if not same:
        yield Finding("hash", "a copy of it is not equal to it; make it a frozen dataclass")


def _check_shapes(robot: Robot) -> Iterator[Finding]:
    n, m, d = robot.state_size, robot.action_size, robot.position_size
    key = jax.random.key(0)
    state, action, position = (jnp.zeros(size, jnp.float32) for size in (n, m, d))
    vectors = jnp.zeros((2, 3, d))
    checks: list[tuple[str, tuple, tuple[int | None, ...]]] = [
        ("rest", (key, position), (n,)),
        ("place", (key, position), (n,)),
        ("step", (state, action), (n,)),
        ("position", (state,), (d,)),
        ("position", (jnp.zeros((4, n)),), (4, d)),
        ("observe", (state,), (None,)),
        ("to_frame", (state, vectors[0, 0]), (None,)),
        ("to_frame", (state, vectors), (2, 3, None)),
    ]
    if hasattr(robot, "named"):
        checks.append(("named", (state,), (len(quantities_of(robot)),)))
    broken: set[str] = set()
    for name, arguments, shape in checks:
        for finding in _check_call(getattr(robot, name), name, arguments, shape):
            if name not in broken:
                yield finding
            broken.add(name)


def _check_call(
    function: Callable[..., Any], name: str, arguments: tuple, shape: tuple[int | None, ...]
) -> Iterator[Finding]:
    """One call as compiled code makes it, alone and for several robots at once."""
    given = ", ".join(str(list(a.shape)) if a.ndim else "key" for a in arguments)
    try:
        alone = jax.eval_shape(jax.jit(function), *arguments)
        several = [jnp.stack([argument] * 5) for argument in arguments]
        batched = jax.eval_shape(jax.vmap(function), *several)
    except Exception as error:  # whatever the robot's code raises is the finding
        first = str(error).strip().split("\n")[0][:200]
        yield Finding(name, f"fails under jit or vmap for {given}: {type(error).__name__}: {first}")
        return
    wanted = str([*shape]).replace("None", "k")
    if not isinstance(alone, jax.ShapeDtypeStruct):
        yield Finding(name, f"returns {type(alone).__name__}; an array {wanted} is wanted")
    elif len(alone.shape) != len(shape) or any(
        size not in (None, found) for size, found in zip(shape, alone.shape, strict=True)
    ):
        yield Finding(name, f"returns shape {list(alone.shape)} for {given}; {wanted} is wanted")
    elif alone.dtype != jnp.float32:
        yield Finding(name, f"returns {alone.dtype}; float32 is wanted")
    else:
        assert batched.shape == (5, *alone.shape)


def main(names: list[str]) -> int:
    """Check robots by name, in all variants, and print what is found."""
    from envs import ENVS, make_robot  # noqa: PLC0415 - the package imports this module's friends

    faults = 0
    for name in names or ENVS:
        for variant in ("", *make_robot(name).variants):
            findings = check_robot(make_robot(name, variant))
            title = f"{name} {variant}".strip()
            for finding in findings:
                print(f"{title}: {finding}")
            if not findings:
                print(f"{title}: sound")
            faults += len(findings)
    return min(faults, 1)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except UserError as error:
        sys.exit(f"error: {error}")
