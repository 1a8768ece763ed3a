"""What is known of a scene's mission before training."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache

from core.errors import UserError
from core.task.feasibility import Finding, judge, refusal
from scenes import Scene, mission_of, scene_formula
from scenes.crossing import moving_findings

REMEMBERED = 32
"""Scenes whose findings are kept: an edit is judged by the page and again for its task."""


class ImpossibleError(UserError):
    """A mission that no behaviour of the robot can carry out."""


def findings_of(scene: Scene) -> tuple[Finding, ...]:
    """What stands in the way of a scene's mission, as far as that is known at once.

    Raises:
        UserError: a formula that is malformed.
    """
    return _judged(replace(scene, name="-", title="-", seed=0))


def require_possible(scene: Scene) -> tuple[Finding, ...]:
    """Warnings on a scene's mission.

    Raises:
        ImpossibleError: it is proved that it cannot be carried out.
        UserError: a formula that is malformed.
    """
    findings = findings_of(scene)
    if why := refusal(findings):
        raise ImpossibleError(why)
    return findings


@contextmanager
def offering_force() -> Iterator[None]:
    """Name the option that goes ahead, in the error of a mission that cannot be carried out."""
    try:
        yield
    except ImpossibleError as error:
        raise ImpossibleError(f"{error} (--force goes ahead all the same)") from error


@lru_cache(maxsize=REMEMBERED)
def _judged(scene: Scene) -> tuple[Finding, ...]:
    formula = scene_formula(scene)
    found = judge(mission_of(scene, formula))
    return (*found, *moving_findings(scene, formula)) if scene.moving else found
