import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from envs import ENVS
from scenes import (
    Region,
    Scene,
    SceneError,
    demo_names,
    format_scene,
    load_scene,
    load_task,
    parse_scene,
    save_scene,
    task_names,
)
from tests.scenes.outlines import planar, spatial

TEXT = """
format = 1
name = "demo"
title = "A demonstration"
robot = "linear"
horizon = 100
seed = 1007
formula = "F_[0:90](A1)"

[initial]
kind = "rectangle"
center = [-3.0, -3.0]
size = [0.7, 0.7]

[regions.A1]
kind = "circle"
center = [1.0, 2.0]
size = [0.6]
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("format = 1", "format = 2", "format: 2 is not known; this program reads format = 1"),
        ("format = 1", "format = true", "format: True is not known"),
        ("format = 1", "", "format: is missing"),
        ('robot = "linear"', 'robot = "linaer"', "robot: unknown 'linaer'. Allowed: linear, uni"),
        ('robot = "linear"', "robot = []", "robot: [] must be text"),
        ("center = [1.0, 2.0]", "center = [nan, 2.0]", "regions.A1.center: nan must be finite"),
        ("center = [-3.0, -3.0]", "center = [inf, 2.0]", "initial.center: inf must be finite"),
        (
            "center = [1.0, 2.0]",
            'center = [1.0, "2"]',
            "regions.A1.center[1]: '2' must be a number",
        ),
        ("center = [1.0, 2.0]", "center = 1.0", "regions.A1.center: 1.0 must be a list"),
        ("center = [1.0, 2.0]", "center = [1.0]", "regions.A1.center: [1.0] has 1 numbers"),
        ("seed = 1007", "seed = 2026-01-02", "seed: datetime.date(2026, 1, 2) must be an integer"),
        ("size = [0.6]", "", "regions.A1.size: this field is missing"),
        ("size = [0.7, 0.7]", "", "initial.size: this field is missing"),
        ('kind = "circle"', 'kind = "disc"', "regions.A1.kind: unknown 'disc'. Allowed: "),
        ("size = [0.6]", "size = [0.6]\nradius = 1", "regions.A1.radius: unknown. Allowed: "),
        ("seed = 1007", "seed = 1007\nhorizn = 3", "horizn: unknown. Allowed: horizon, "),
        ("horizon = 100", "horizon = 0", "horizon: 0 must be an integer from 1 to 10000"),
        ("horizon = 100", "horizon = 10.0", "horizon: 10.0 must be an integer"),
        ("seed = 1007", "seed = -1", "seed: -1 must be an integer from 0 to"),
        ("seed = 1007", "seed = true", "seed: True must be an integer"),
        ('title = "A demonstration"', 'title = ""', "title: '' must be non-empty text"),
        ('"F_[0:90](A1)"', "3", "formula: 3 must be text"),
        ('"F_[0:90](A1)"', f'"{"x" * 10_001}"', "formula: 10,001 characters are too many"),
        ("[regions.A1]", "[regions.' A']", "regions. A.name: ' A' must be printable"),
        ("[regions.A1]", "[[regions]]", "regions: [{'kind': 'circle', "),
        ("[initial]", "initial = 3\n[other]", "other: unknown"),
        ("seed = 1007", f"seed = {'9' * 5000}", "not valid TOML: "),
        ("seed = 1007", f"seed = {'[' * 5000}{']' * 5000}", "not valid TOML: "),
        ("format = 1", "format = = 1", "not valid TOML: Invalid value (at line 2"),
        (
            'kind = "circle"\ncenter = [1.0, 2.0]\nsize = [0.6]',
            'kind = "sphere"\ncenter = [1.0, 2.0, 0.0]\nsize = [0.6]',
            "regions.A1: a sphere has dimension 3, but the regions of the robot 'linear' have",
        ),
        (
            'kind = "rectangle"\ncenter = [-3.0, -3.0]\nsize = [0.7, 0.7]',
            'kind = "sphere"\ncenter = [-3.0, -3.0, 0.0]\nsize = [0.7]',
            "initial: a sphere has dimension 3",
        ),
    ],
)
def test_a_flaw_is_reported_with_the_file_and_the_field(tmp_path, old, new, message):
    path = tmp_path / "scene.stl.toml"
    assert old in TEXT
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "field", ["name", "title", "robot", "horizon", "seed", "formula", "initial"]
)
def test_each_missing_field_is_named(field):
    lines = format_scene(parse_scene(TEXT, "here")).splitlines()
    if field == "initial":
        start = lines.index("[initial]")
        del lines[start : start + 4]
    else:
        lines = [line for line in lines if not line.startswith(f"{field} =")]
    with pytest.raises(SceneError) as caught:
        parse_scene("\n".join(lines), "here")
    assert str(caught.value) == f"here: {field}: this field is missing"


def test_a_name_given_twice_is_refused_in_toml_and_in_python():
    twice = TEXT + '[regions.A1]\nkind = "circle"\ncenter = [0, 0]\nsize = [1]\n'
    with pytest.raises(SceneError, match="here: not valid TOML: Cannot declare .*A1.* twice"):
        parse_scene(twice, "here")
    scene = parse_scene(TEXT, "here")
    with pytest.raises(SceneError, match=r"regions\.A1: this name is given twice"):
        dataclasses.replace(scene, regions=scene.regions * 2)


def test_unreadable_files_are_refused(tmp_path):
    cases = {"missing.toml": "No such file", ".": "Is a directory", "binary.toml": "not UTF-8"}
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    for name, reason in cases.items():
        with pytest.raises(SceneError, match=f"cannot be read: {reason}"):
            load_scene(tmp_path / name)
    huge = tmp_path / "huge.toml"
    huge.write_text("#" * 250_001)
    with pytest.raises(SceneError, match="larger than 250,000 characters"):
        load_scene(huge)


@pytest.mark.parametrize("task", task_names() + demo_names())
def test_a_shipped_task_survives_saving(task, tmp_path):
    scene = load_task(task)
    save_scene(scene, tmp_path / "copy.toml")
    assert load_scene(tmp_path / "copy.toml") == scene


NUMBERS = st.floats(-1000, 1000, allow_nan=False)
SIZES = st.floats(1e-6, 1000)
LINES = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\r"), min_size=1)


@settings(max_examples=150, deadline=None)
@given(
    name=st.text(min_size=1, max_size=40).filter(lambda t: t.isprintable() and t == t.strip()),
    text=LINES.filter(lambda t: t.strip() and t == t.strip("\n") and len(t) < 80),
    center=st.tuples(NUMBERS, NUMBERS),
    size=SIZES,
    color=st.sampled_from([None, "#a0B1c2"]),
)
def test_any_scene_survives_its_toml(name, text, center, size, color):
    name = name.translate({ord(c): "q" for c in "\"'`\\"})
    region = Region(name, "circle", center, (size,), color)
    initial = Region("initial", "rectangle", center, (size, 1.0))
    scene = Scene(text, text, "unicycle", text, 7, 0, (region,), initial)
    assert parse_scene(format_scene(scene), "here") == scene


def test_a_failed_save_leaves_the_old_file_and_no_litter(tmp_path, monkeypatch):
    path = tmp_path / "scene.toml"
    scene = parse_scene(TEXT, "here")
    save_scene(scene, path)
    before = path.read_bytes()

    def full_disk(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(SceneError, match="scene.toml: cannot be written: No space left on device"):
        save_scene(dataclasses.replace(scene, seed=1), path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["scene.toml"]


def test_saving_into_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(SceneError, match="cannot be written: No such file"):
        save_scene(parse_scene(TEXT, "here"), tmp_path / "nowhere" / "scene.toml")


def test_tasks_are_found_from_any_folder(tmp_path):
    program = "import scenes; print(scenes.load_task('unicycle-10').name)"
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    result = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": root},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stdout.strip() == "unicycle-10", result.stderr


def test_unknown_tasks_and_robots_list_the_known_ones():
    with pytest.raises(SceneError, match="task: unknown 'linear-8'. Allowed: linear-08"):
        load_task("linear-8")
    with pytest.raises(SceneError, match="task: unknown '../linear-08'"):
        load_task("../linear-08")
    with pytest.raises(SceneError, match="robot: unknown 'car'"):
        task_names("car")


def test_each_robot_has_its_ten_tasks_and_a_demo():
    for robot in ENVS:
        assert task_names(robot) == [f"{robot}-{n:02d}" for n in range(1, 11)]
        assert demo_names(robot) == [f"{robot}-demo"]


def test_a_variant_is_kept_and_checked():
    scene = dataclasses.replace(load_task("panda-01"), variant="links")
    assert parse_scene(format_scene(scene), "here") == scene
    assert "variant" not in format_scene(load_task("panda-01"))
    for variant in ("link", 0, ["links"]):
        with pytest.raises(SceneError, match="variant: unknown .* of 'panda'. Allowed: links"):
            dataclasses.replace(scene, variant=variant)
    with pytest.raises(SceneError, match="of 'linear'. Allowed: none"):
        dataclasses.replace(load_task("linear-01"), variant="links")


@pytest.mark.parametrize("robot", ["linear", "quadrotor"])
def test_regions_of_every_kind_are_kept(robot):
    scene, random = load_task(f"{robot}-demo"), np.random.default_rng(0)
    regions = planar(random)
    if scene.dimension == 3:
        regions = [spatial(region, 0.5, 2.0) for region in regions]
    named = tuple(dataclasses.replace(r, name=f"A{i}") for i, r in enumerate(regions))
    for initial in (*regions, Region("initial", "point", (0.0, 1.0, 2.0)[: scene.dimension])):
        start = dataclasses.replace(initial, name="initial")
        whole = dataclasses.replace(scene, regions=named, initial=start, formula="true")
        assert parse_scene(format_scene(whole), "here") == whole


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('kind = "polygon"', "regions.A1.points: this field is missing"),
        ('kind = "polygon"\npoints = [[0, 0], [1, "1"]]', "regions.A1.points[1][1]: '1' must be"),
        ('kind = "polygon"\npoints = [[0, 0]]', "regions.A1.points: 1 corners; a polygon has from"),
        ('kind = "polygon"\npoints = []\nsize = [1]', "regions.A1.size: a polygon is given by poi"),
        ('kind = "point"\ncenter = [0, 0]', "regions.A1: a point can only be the initial set"),
        ('kind = "union"\nparts = [3]', "regions.A1.parts[0]: must be a table"),
        ('kind = "union"\nparts = [{ kind = "disc" }]', "regions.A1.parts[0].kind: unknown 'disc'"),
        (
            'kind = "union"\nparts = [{ kind = "circle", center = [0, 0] }]',
            "regions.A1.parts[0].size: this field is missing",
        ),
        (
            'kind = "circle"\ncenter = [0, 0]\nsize = [1]\nangle = 30',
            "regions.A1.angle: a circle has none; it is given by center, size",
        ),
    ],
)
def test_flaws_of_other_kinds_are_reported_with_their_place(table, message):
    plain = 'kind = "circle"\ncenter = [1.0, 2.0]\nsize = [0.6]'
    with pytest.raises(SceneError) as caught:
        parse_scene(TEXT.replace(plain, table), "here")
    assert message in str(caught.value)


def test_the_documented_file_is_one():
    text = (Path(__file__).parents[2] / "docs/scene-files.md").read_text(encoding="utf-8")
    scene = parse_scene(text.split("```toml\n")[1].split("```")[0], "docs")
    assert scene.arena == ((0.0, 15.0), (0.0, 10.0))
    assert {region.kind for region in scene.regions} == {"circle", "polygon", "rectangle"}
