"""Layouts that can be solved: the same for the same number, none that leaves no time."""

import numpy as np
import pytest

from core.errors import UserError
from core.methods.tgpo.algorithm import make_algorithm, many_layouts
from envs import ENVS, Linear
from scenes import Scene, load_task, robot_of, world_of
from studio.runs import layouts
from studio.runs.layouts import Drawing, held_out, randomized
from studio.runs.tasks import build_task
from tests.scenes.plans import leg_lengths, needed_speed

pytestmark = pytest.mark.optimised


def _drawing(scene: Scene, stream: int = 3) -> Drawing:
    algorithm = make_algorithm("studio", "tgpo-star", robot_of(scene))
    return Drawing(scene, build_task(scene), algorithm, stream)


def test_a_stream_and_a_number_make_a_layout(disk_cache):
    scene = load_task("quadrotor-08")
    drawing, other = _drawing(scene), _drawing(scene, 4)
    first = drawing.layout(2)[0]
    assert drawing.layout(2)[0] == first
    assert drawing.layout(3)[0] != first and other.layout(2)[0] != first
    assert first.regions[0].center != scene.regions[0].center


def test_layouts_of_the_training_are_not_those_of_the_report(disk_cache):
    scene = load_task("linear-07")
    task = build_task(scene)
    algorithm = many_layouts(make_algorithm("studio", "tgpo-star", Linear()))
    task = randomized(scene, task, algorithm, 1007)
    assert task.layouts is not None
    learnt = [task.layouts.training(number) for number in range(3)]
    reported = [layout.problem for layout in held_out(scene, task, algorithm, 3)]
    validated = [layout.problem for layout in task.layouts.held_out]
    centers = [np.asarray(p.center[0]) for p in (*learnt, *validated, *reported)]
    assert len({tuple(center.tolist()) for center in centers}) == 3 + layouts.VALIDATIONS + 3


def test_one_layout_needs_no_others(linear_task):
    algorithm = make_algorithm("studio", "tgpo-star", Linear())
    assert randomized(load_task("linear-08"), linear_task, algorithm, 0) is linear_task


@pytest.mark.parametrize("task", ["linear-05", "panda-05", "quadrotor-05"])
def test_layouts_leave_time_for_the_plan(disk_cache, monkeypatch, task):
    """By plans written by hand, on a grid of their own."""
    scene, drawn = load_task(task), []
    drawing = _drawing(scene)

    def build(scene, **visits):
        drawn.append(scene)
        return build_task(scene, **visits)

    monkeypatch.setattr(layouts, "build_task", build)
    speed, clearance = ENVS[scene.robot].speed, world_of(scene).clearance
    needed = []
    for number in range(3):
        layout = drawing.layout(number)[0]
        (lengths,) = leg_lengths(layout, [layout.initial.center], clearance)
        needed.append(needed_speed(layout, lengths))
    assert max(needed) <= speed, (needed, speed)
    assert len(drawn) > 3 or task != "quadrotor-05"


def test_a_layout_in_which_nothing_is_in_time_is_an_error(disk_cache, monkeypatch):
    monkeypatch.setattr(layouts, "TRIES", 3)
    monkeypatch.setattr(layouts, "LEAST_SHARE", 1e9)
    with pytest.raises(UserError, match="none of 3 perturbed layouts leaves time"):
        _drawing(load_task("linear-07")).layout(0)
