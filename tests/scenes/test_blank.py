import numpy as np
import pytest

from core.errors import UserError
from envs import VARIANTS
from scenes import blank, format_scene, parse_scene, workspace_of
from studio.runs.findings import findings_of
from studio.runs.tasks import build_task

ROBOTS = [(robot, variant) for robot, variants in VARIANTS.items() for variant in ("", *variants)]


@pytest.mark.parametrize(("robot", "variant"), ROBOTS)
def test_a_blank_scene_is_a_mission_without_doubts(robot, variant):
    scene = blank(robot, variant)
    assert parse_scene(format_scene(scene), "here") == scene
    assert (scene.robot, scene.variant) == (robot, variant)
    assert findings_of(scene) == ()
    low, high = np.array(workspace_of(scene).arena).T
    for region in (*scene.regions, scene.initial):
        assert (region.center - region.half_extents >= low).all()
        assert (region.center + region.half_extents <= high).all()


def test_it_can_be_grounded():
    assert len(build_task(blank("linear")).grounding.subgoals) == 1


def test_an_unknown_robot_is_told():
    with pytest.raises(UserError, match="robot: unknown 'linaer'. Allowed: linear, "):
        blank("linaer")
