"""What a user should know of regions that move before training.

- A goal that leaves the arena: ways are planned inside it.
- An obstacle that robot and region together may pass through from one step to the next: it is
  thinner than the way that they go in a step.
"""

import numpy as np

from core.monitor.wording import metres
from core.stl import Formula, horizon, literals, negation_normal_form, quote_name
from core.task.feasibility import Finding, Severity
from core.task.feasibility.thin import thickness
from scenes.places import places_of
from scenes.regions import Region
from scenes.scene import Scene, robot_of, workspace_of


def moving_findings(scene: Scene, formula: Formula) -> tuple[Finding, ...]:
    """Warnings of the regions of a scene that move.

    Args:
        scene: whose regions are meant.
        formula: what is asked.
    """
    named = set(literals(negation_normal_form(formula)))
    steps = max(scene.horizon, horizon(formula))
    found = []
    for region in scene.regions:
        if region.motion is None:
            continue
        if (region.name, True) in named:
            found += _leaving(scene, region, steps)
        if (region.name, False) in named and not scene.between_steps:
            found += _fast(scene, region)
    return tuple(found)


def _leaving(scene: Scene, region: Region, steps: int) -> list[Finding]:
    """That a goal lies wholly outside the arena at some steps."""
    assert region.motion is not None
    low, high = np.array(workspace_of(scene).arena, float).T
    center = region.center + region.motion.offset(np.arange(steps + 1))
    half = region.half_extents
    outside = ((center + half < low) | (center - half > high)).any(1)
    if not outside.any():
        return []
    first = int(outside.argmax())
    name = quote_name(region.name)
    words = (
        f"{name} has left the arena at step {first}, within which ways are planned"
        if first
        else f"{name} begins outside the arena, within which ways are planned"
    )
    return [Finding(Severity.WARNING, words, (name,))]


def _fast(scene: Scene, region: Region) -> list[Finding]:
    """That an obstacle may jump over the robot."""
    assert region.motion is not None
    places, speed = places_of(scene), region.motion.speed
    thick = thickness(places, places.names.index(region.name))
    robot = robot_of(scene)
    if not 0 < thick < robot.speed + speed:
        return []
    name = quote_name(region.name)
    words = (
        f"{name} is {metres(thick)} thick, but it moves up to {metres(speed)} a step and the robot "
        f"about {metres(robot.speed)}: one may go through the other between two steps, which the "
        "formula does not see; `between_steps = true` in the scene forbids that"
    )
    return [Finding(Severity.WARNING, words, (f"!{name}",))]
