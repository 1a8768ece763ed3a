"""Files to keep: rollouts as CSV and npz, pictures, and their names."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image

from core.decompose import decompose
from core.errors import UserError
from core.heatmap import Heatmap
from core.stl import parse, robustness
from core.task.task import Task
from envs import ENVS
from studio.export.filenames import LONGEST, download_name, safe_name
from studio.export.pictures import PictureError, heatmap_png, tree_png
from studio.export.tables import RolloutTable, rollout_csv, rollout_npz, rollout_table
from studio.page.figures.heatmap import Mark
from tests.core.toy import CENTERS, RADIUS, toy_task

STEPS = 16


@pytest.fixture(scope="module")
def task() -> Task:
    found = toy_task("F_[2:6](A & F_[0:4](B)) & G_[0:16](!D)", STEPS)
    return replace(found, name="draft", problem=replace(found.problem, robot=ENVS["linear"]))


@pytest.fixture(scope="module")
def table(task: Task) -> RolloutTable:
    """A walk to A, then B; longer than the task, as programs give it."""
    rng = np.random.default_rng(0)
    states = np.cumsum(rng.normal(0, 0.3, (STEPS + 9, 2)), axis=0).astype(np.float32)
    states[4], states[6] = CENTERS["A"], CENTERS["B"]
    actions = rng.normal(0, 2, (STEPS + 8, 2)).astype(np.float32)
    offsets = states[:, None] - np.array(list(CENTERS.values()))
    margins = np.full((STEPS + 9, 32), -1e3, np.float32)
    margins[:, : len(CENTERS)] = RADIUS - np.linalg.norm(offsets, axis=-1)
    return rollout_table(task, np.array([4, 2, 0, 0]), states, actions, margins)


def test_csv_read_back_gives_the_rollout(table):
    text = rollout_csv(table).decode("utf-8")
    header, *rows = csv.reader(io.StringIO(text))
    assert header[:5] == ["time [s]", "state x [m]", "state y [m]", "action v", "action w"]
    assert header[5:9] == [f"margin {name} [m]" for name in CENTERS]
    assert header[9] == "robustness F_[2:6](A & F_[0:4](B)) & G_[0:16](!D) [m]"
    values = np.array([[float(cell or "nan") for cell in row] for row in rows])
    assert values.shape == (STEPS + 1, len(header))
    action = np.vstack([table.action, [[np.nan, np.nan]]])
    expected = (table.time[:, None], table.state, action, table.margins, table.robustness)
    np.testing.assert_allclose(values, np.concatenate(expected, axis=1), rtol=1e-8)
    assert values[:3, 0].tolist() == [0, 0.2, 0.4]
    assert rows[-1][3:5] == ["", ""]


def test_npz_read_back_without_pickle_gives_the_rollout(table, task):
    found = np.load(io.BytesIO(rollout_npz(table)), allow_pickle=False)
    for name in ("time", "state", "action", "margins", "robustness", "schedule"):
        np.testing.assert_array_equal(found[name], getattr(table, name))
    for name in ("state_names", "action_names", "region_names", "subformulas", "variable_names"):
        assert tuple(found[name]) == getattr(table, name)
    assert str(found["task"]) == "draft"
    formula = parse(str(found["formula"]), names=CENTERS)
    assert formula == task.formula
    value = robustness(formula, found["margins"], tuple(found["region_names"]))
    assert found["robustness"][0, 0] == value
    assert bool(found["satisfied"]) == (value >= 0)


def test_a_table_holds_the_episode_and_what_was_carried_out(table):
    assert len(table.state) == len(table.time) == STEPS + 1
    assert table.action.shape == (STEPS, 2)
    assert np.abs(table.action).max() == 1
    assert table.schedule.tolist() == [4, 2]
    assert table.variable_names == ("t1", "t2")
    assert table.margins.shape == (STEPS + 1, len(CENTERS))
    decided = np.isfinite(table.robustness).sum(axis=0)
    named = dict(zip(table.subformulas, decided.tolist(), strict=True))
    assert named["A"] == named["!D"] == 17
    assert named["A & F_[0:4](B)"] == 13
    assert named["F_[2:6](A & F_[0:4](B))"] == 7
    assert decided[0] == 1


def test_headers_are_never_spreadsheet_formulas(table):
    evil = replace(table, region_names=("=1+1", "+A,B", '@"x"', "-1"))
    header = next(csv.reader(io.StringIO(rollout_csv(evil).decode())))
    assert header[5:9] == [f"margin {name} [m]" for name in evil.region_names]
    assert not any(cell[0] in "=+-@" for cell in header)


@given(st.text(max_size=200) | st.text("./\\:.-_ aA\0\n", max_size=30))
@example("../../etc/passwd")
@example("..\\..\\boot.ini")
@example("C:\\Windows\\x")
@example("con.txt")
@example("a" * 500)
@example("\u202egpj.exe")
@example("")
def test_safe_names_stay_in_their_folder(text):
    name = safe_name(text)
    assert 1 <= len(name) <= LONGEST
    assert set(name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-")
    assert ".." not in name
    assert name[0] not in "-." and name[-1] not in "-."
    assert safe_name(name) == name


def test_safe_names_keep_what_they_can():
    assert safe_name("linear-08 first try.toml") == "linear-08-first-try.toml"
    assert safe_name("Größe é") == "Groe-e"
    assert safe_name("日本") == "untitled"
    assert safe_name("NUL.csv", "rollout") == "rollout"
    assert download_name("linear-08", "../roll out", suffix=".csv") == "linear-08-roll-out.csv"
    assert len(download_name("x" * 99, "y" * 99, suffix=".stl.toml")) <= LONGEST + 9


NESTED = decompose(parse("F_[0:9](A & F_[2:5](B)) & G_[0:20](!C) & F_[0:3](D)"))


def critic(axes: tuple[int, ...], short: bool = True) -> Heatmap:
    first = np.arange(10) if axes else np.zeros(1, int)
    second = np.arange(2, 6) if len(axes) > 1 else np.zeros(1, int)
    values = np.add.outer(np.sin(second), np.cos(first))
    shortfall = (np.add.outer(second, first) > 9) * 2.0 * short
    return Heatmap(axes, first, second, values, shortfall, np.array([1, 2, 3, 0, 0, 0, 0, 0]))


def opened(data: bytes) -> Image.Image:
    image = Image.open(io.BytesIO(data))
    image.load()
    assert image.format == "PNG"
    return image


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(opened(data).convert("RGB"))


def count(image: np.ndarray, color: str) -> int:
    wanted = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)])
    return int((np.abs(image.astype(int) - wanted).max(-1) < 12).sum())


def test_the_heatmap_shows_map_marks_chains_and_what_is_ruled_out():
    plain = pixels(heatmap_png(critic((0, 1), short=False), NESTED, title="critic"))
    assert plain.shape[0] > 500 and plain.shape[1] > 800
    # Both ends of the colour map are there, in the map and in its bar.
    assert count(plain, "#440154") > 100
    assert count(plain, "#fde725") > 100
    assert count(plain, "#ff00ff") == 0
    marks = [Mark((3, 4, 0), "#ff00ff", "shown")]
    marked = pixels(heatmap_png(critic((0, 1), short=False), NESTED, title="critic", marks=marks))
    assert count(marked, "#ff00ff") > 50
    ruled_out = pixels(heatmap_png(critic((0, 1)), NESTED, title="critic"))
    assert count(ruled_out, "#8a8f98") > 1000 > count(plain, "#8a8f98")
    chains = np.array([[5, 3, 0], [6, 4, 0]])
    both = heatmap_png(critic((0, 1), short=False), NESTED, title="", marks=marks, chains=chains)
    none = heatmap_png(
        critic((0, 1), short=False), NESTED, title="", marks=marks, chains=chains[:0]
    )
    assert (pixels(both) != pixels(none)).any()


def test_one_variable_gives_a_curve_and_none_an_explanation():
    curve = heatmap_png(critic((1,)), NESTED, title="c", marks=[Mark((0, 4, 0), "#ff00ff", "m")])
    assert count(pixels(curve), "#ff00ff") > 50
    with pytest.raises(PictureError, match="no time variables"):
        heatmap_png(critic(()), NESTED, title="critic")


def test_the_tree_shows_kinds_and_names():
    image = pixels(tree_png(NESTED, title="tree"))
    assert count(image, "#1e6091") > 100  # reach
    assert count(image, "#8a4b22") > 100  # invariant
    assert count(image, "#c2255c") > 100  # time variables
    assert count(image, "#0b7285") == 0  # no stay


def test_pictures_carry_the_formula_and_take_names_as_text():
    found = decompose(parse(r'F_[0:9]("$\frac{x}$ <b>") & F_[0:3](é)'))
    for data in (
        heatmap_png(critic((0, 1)), found, title=r"$\x$", marks=[Mark((1, 2), "#ff0000", "$_^$")]),
        tree_png(found, title=r"$\x$"),
    ):
        text = opened(data).info
        assert text["Title"] == r"$\x$"
        assert parse(str(text["Description"])) == found.formula


def test_a_tree_too_large_for_a_picture_is_refused():
    found = decompose(parse(" & ".join(f"G_[{n}:{n + 1}](A)" for n in range(1, 638, 2))))
    with pytest.raises(UserError, match="320 nodes; a picture can show at most 300"):
        tree_png(found, title="tree")
