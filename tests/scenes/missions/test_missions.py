"""Random missions: sound, varied, and the same in every process."""

import hashlib
import re
import subprocess
import sys
from itertools import product

import numpy as np
import pytest

from core.decompose import Decomposition, Kind, decompose
from core.errors import UserError
from core.stl import atom_names, parse
from core.task.grounding import ground
from envs import ENVS
from scenes import Region, Scene, format_scene, load_task, parse_scene, robot_of, workspace_of
from scenes.distances import margin_of
from scenes.layouts import half_extents, separation
from scenes.missions import FAMILIES, HELD_OUT, TRAINED, draw, measures, mission_steps
from scenes.missions.outlines import circle, rectangle
from scenes.missions.placing import separations
from scenes.missions.shapes import varied
from scenes.shared import require_shared

COUNT = 1000
"""Missions a robot."""


def _drawn(robot: str, count: int) -> list[Scene]:
    """That many missions, of all families in turn."""
    scenes, families = [], list(FAMILIES)
    for number in range(2 * count):
        if len(scenes) == count:
            return scenes
        try:
            scenes.append(draw(robot, families[number % len(families)], number))
        except UserError:
            continue
    raise AssertionError(f"{robot}: more than half of the draws fail")


def _extremes(region: Region) -> list[np.ndarray]:
    """A box's corners, and the farthest points along the axes of anything round."""
    center, half = np.array(region.center), half_extents(region)
    if region.kind in ("rectangle", "box"):
        return [center + np.array(signs) * half for signs in product((-1, 1), repeat=half.size)]
    return [center + sign * row for row in np.diag(half) for sign in (-1, 1)]


def _margin(region: Region, point: np.ndarray) -> float:
    """Distance in [m] from a point [d] to the region's boundary, negative outside."""
    return float(margin_of(region, np.array([point]))[0])


def _decomposed(scene: Scene) -> Decomposition:
    return decompose(parse(scene.formula, dt=robot_of(scene).dt, names=scene.region_names))


@pytest.mark.parametrize("robot", ENVS)
def test_missions_parse_decompose_and_fit(robot):
    kinds: set[str] = set()
    for scene in _drawn(robot, COUNT):
        assert parse_scene(format_scene(scene), scene.name) == scene
        require_shared(scene)
        low, high = np.array(workspace_of(scene).arena).T
        grounding = ground(_decomposed(scene), scene.region_names, scene.horizon)
        assert grounding.horizon <= mission_steps(robot)
        assert len(grounding.subgoals) >= 1 and len(grounding.closed_sets()) <= 8
        doors = [atom_names(grounding.constraints[i].predicate) for i in grounding.doors]
        assert not {name[0] for names in doors for name in names} & set("OW"), scene.name
        kinds |= {task.kind.value for task in (*grounding.subgoals, *grounding.constraints)}
        forbidden = [r for r in scene.regions if r.name[0] in "OWD"]
        for point in _extremes(scene.initial):
            assert (low <= point).all() and (point <= high).all(), scene.name
            assert all(_margin(region, point) < 0 for region in forbidden), scene.name
        for region in scene.regions:
            if region.name[0] in "AK":
                center = np.array(region.center)
                assert ((low < center) & (center < high)).all()
                assert all(_margin(other, center) < 0 for other in forbidden), scene.name
    assert kinds == {kind.value for kind in Kind}


def test_all_sorts_of_formulas_are_drawn():
    sorts = {
        "chain": r"F_\[\S+\]\((\w+|G_\S+) & F_",
        "stay": r"F_\[\S+\]\(G_",
        "fixed stay": r"(^|[(& ])G_\[\S+\]\(A\d\)",
        "zone": r"G_\[\S+\]\(Z\)",
        "order": r"\(!A\d\) U_",
        "door": r"\(!D\d\) U_",
        "branch": r"\) \| F_",
        "choice of regions": r"A\d \| A\d",
        "patrol": r"G_\[\S+\]\(F_",
        "closed until later": r"G_\[\S+\]\(!A\d\)",
        "response": r"G_\[\S+\]\(A\d -> F_",
        "lockout": r"G_\[\S+\]\(A\d -> G_\[\S+\]\(!",
        "one clause for all obstacles": r"G_\[\S+\]\(!\w+ & !\w+",
    }
    formulas = [scene.formula for scene in _drawn("linear", 300)]
    found = {name: sum(bool(re.search(s, f)) for f in formulas) for name, s in sorts.items()}
    assert min(found.values()) >= 5, found


@pytest.mark.parametrize("robot", ["quadrotor", "panda"])
def test_in_space_all_kinds_of_regions_are_drawn(robot):
    regions = [region for scene in _drawn(robot, 60) for region in scene.regions]
    for letter in "AO":
        kinds = {region.kind for region in regions if region.name[0] == letter}
        assert kinds == {"sphere", "box", "cylinder", "prism", "union"}
    heights = {round(region.center[2], 1) for region in regions if region.name[0] == "A"}
    assert len(heights) > 3


@pytest.mark.parametrize("robot", ENVS)
def test_gaps_are_from_barely_passable_to_wide(robot):
    scale = measures(robot)
    widths = [FAMILIES["gaps"](scale, np.random.default_rng(seed)).passage for seed in range(200)]
    assert scale.tight <= min(widths) < scale.tight + 0.1 * (scale.wide - scale.tight)
    assert scale.wide >= max(widths) > scale.wide - 0.1 * (scale.wide - scale.tight)


def _digest() -> str:
    scenes = [*_drawn("unicycle", 20), *_drawn("quadrotor", 20)]
    return hashlib.sha256("".join(map(format_scene, scenes)).encode()).hexdigest()


def test_another_process_draws_the_same():
    code = "from tests.scenes.missions.test_missions import _digest; print(_digest())"
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert shown.stdout.strip() == _digest()


def test_robot_family_and_seed_make_a_mission():
    first = draw("linear", "open", 1)
    assert draw("linear", "open", 1) == first
    others = [draw("linear", "open", 2), draw("linear", "gaps", 1), draw("unicycle", "open", 1)]
    assert all(other.regions != first.regions for other in others)


def test_what_is_unknown_is_named():
    with pytest.raises(UserError, match=r"family: unknown 'opne'.*open"):
        draw("linear", "opne", 0)
    with pytest.raises(UserError, match="robot: unknown 'car'"):
        draw("car", "open", 0)


@pytest.mark.parametrize("robot", ENVS)
def test_missions_are_as_long_as_shipped_tasks(robot):
    scene = load_task(f"{robot}-01")
    assert mission_steps(robot) >= max(scene.horizon, _decomposed(scene).horizon)
    assert mission_steps(robot) % 16 == 0


def test_distances_are_those_between_two_regions():
    random = np.random.default_rng(0)

    def region(name: str) -> Region:
        center, size = random.uniform(-3, 3, 2), random.uniform(0.2, 1.5, 2)
        kind = ("circle", "rectangle")[random.integers(2)]
        given = size[:1] if kind == "circle" else size
        return Region(name, kind, tuple(center.tolist()), tuple(given.tolist()))

    others = [region(f"O{i}") for i in range(20)]
    for _ in range(20):
        outline = region("A")
        found = separations(outline, np.array([outline.center]), others)[0]
        np.testing.assert_allclose(found, [separation(outline, other) for other in others])


@pytest.mark.parametrize("robot", ENVS)
def test_trained_families_vary_and_held_out_ones_do_not(robot):
    scenes = [scene for scene in _drawn(robot, 120) if scene.name.split("-")[1] in TRAINED]
    regions = [region for scene in scenes for region in scene.regions]
    kinds = {region.kind for region in regions}
    assert {"union", "polygon" if scenes[0].dimension == 2 else "prism"} <= kinds
    assert any(region.angle for region in regions)
    assert any(scene.initial.kind == "point" for scene in scenes)
    own = np.ptp(workspace_of(load_task(f"{robot}-01")).arena, axis=1)
    scales = [np.ptp(scene.arena, axis=1) / own for scene in scenes if scene.arena is not None]
    assert 0.2 < len(scales) / len(scenes) < 0.5
    assert np.std([scale[0] / scale[1] for scale in scales]) > 0.1
    for family in HELD_OUT:
        scene = next(s for s in map(lambda n: _or_none(robot, family, n), range(50)) if s)
        assert scene.arena is None and "->" not in scene.formula
        assert not {r.kind for r in scene.regions} & {"union", "polygon", "prism", "point"}
        assert not any(region.angle for region in scene.regions)


def _or_none(robot: str, family: str, seed: int) -> Scene | None:
    try:
        return draw(robot, family, seed)
    except UserError:
        return None


def test_held_out_families_are_drawn_as_ever():
    """Reported figures are about these missions: another digest makes them incomparable."""
    scenes = [_or_none(robot, family, n) for robot in ENVS for family in HELD_OUT for n in range(4)]
    text = "".join(format_scene(scene) for scene in scenes if scene is not None)
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == "20440bdc7e838152"


def test_shapes_lie_in_their_outlines():
    random, edge = np.random.default_rng(3), np.linspace(-1.2, 1.2, 41)
    points = np.stack(np.meshgrid(edge, edge), -1).reshape(-1, 2) + (1.0, 2.0)
    for number in range(80):
        box = rectangle("A", (0.2, 1.8), (1.5, 2.5))
        outline = box if number % 2 else circle("A", (1.0, 2.0), 0.8)
        region = varied(outline, random, polygons=True)
        inside = margin_of(region, points) > 1e-6
        assert inside.any() and (margin_of(outline, points)[inside] > -1e-6).all()
        assert varied(outline, random, polygons=False).kind in ("rectangle", "union")


def test_distances_to_other_shapes_are_never_too_large():
    random = np.random.default_rng(5)
    for number in range(30):
        other = varied(rectangle("O", (-1, 1), (-0.7, 0.7)), random, polygons=True)
        outline = (
            circle("A", (0.0, 0.0), 0.3) if number % 2 else rectangle("A", (-0.3, 0.3), (-0.2, 0.2))
        )
        positions = random.uniform(-3, 3, (20, 2))
        found = separations(outline, positions, [other, circle("P", (9.0, 9.0), 1.0)])
        assert found.shape == (20, 2)
        for position, distance in zip(positions, found.min(1), strict=True):
            ends = np.array(_extremes(outline.at(position.tolist())))
            assert distance <= -margin_of(other, ends).max() + 1e-9
