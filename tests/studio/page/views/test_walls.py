import numpy as np
import pytest

from envs import ENVS
from scenes import Region, load_task, task_names
from studio.page.views.walls import hall, inner_face, wall_faces, wall_of

LIMITS = ((0.0, 4.0), (-1.0, 1.0), (0.0, 2.0))


@pytest.mark.parametrize("task", task_names("panda") + task_names("quadrotor"))
def test_the_walls_of_the_tasks_are_seen_as_walls(task):
    scene = load_task(task)
    assert set(wall_faces(scene)) == {f"W{i}" for i in range(1, 7)}
    inside = hall(scene.regions, ENVS[scene.robot].workspace.arena)
    for (low, high), (least, most) in zip(inside, ENVS[scene.robot].workspace.arena, strict=True):
        assert least <= low < high <= most


def test_there_are_none_in_the_plane():
    assert wall_faces(load_task("linear-01")) == {}


@pytest.mark.parametrize(
    "region",
    [
        Region("B", "box", (2.0, 0.0, 1.0), (0.3, 1.5, 1.5)),  # across the hall, not at its side
        Region("B", "box", (0.0, 0.0, 1.0), (0.3, 0.5, 1.5)),  # at a side, not all of it
        Region("B", "box", (2.0, 0.0, 1.0), (3.0, 2.0, 2.0)),  # everything
        Region("B", "cylinder", (0.0, 0.0, 1.0), (3.0, 3.0)),
    ],
    ids=["across", "part", "everything", "round"],
)
def test_other_regions_are_not(region):
    assert wall_of(region, LIMITS) is None


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1, 1])
def test_a_face_looks_into_the_hall(axis, side):
    center, size = np.array([2.0, 0.0, 1.0]), np.array([3.0, 2.0, 2.0])
    low, high = LIMITS[axis]
    size[axis] = 0.25
    center[axis] = low if side < 0 else high
    region = Region("W", "box", tuple(center), tuple(size))
    wall = wall_of(region, LIMITS)
    assert wall is not None
    assert wall == (axis, side, center[axis] - side * 0.25)
    corners, triangles = inner_face(wall, hall([region], LIMITS))
    assert set(corners[:, axis]) == {wall.level}
    middle = np.array([sum(ends) / 2 for ends in LIMITS])
    for a, b, c in corners[triangles]:
        assert np.cross(b - a, c - a) @ (middle - a) > 0
