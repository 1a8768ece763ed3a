import base64
import html
import io
import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from core.decompose import decompose
from core.heatmap import Heatmap
from core.stl import parse
from studio.page.figures import heatmap as figure
from studio.page.figures.colors import data_url, viridis
from studio.page.figures.curve import curve_svg
from studio.page.figures.heatmap import GREYED, Drawing, Mark, color_range, heatmap_svg, pixels
from studio.page.figures.readout import SCALE, cell_data
from studio.page.figures.ticks import ticks

VARIABLES = decompose(parse("F_[0:3](A) & F_[10:12](B)")).variables


def make(values, shortfall=None, axes=(0, 1)):
    values = np.asarray(values, float)
    first, second = np.arange(values.shape[1]), 10 + np.arange(values.shape[0])
    short = np.zeros_like(values) if shortfall is None else np.asarray(shortfall, float)
    return Heatmap(axes, first, second, values, short, np.zeros(8, np.int32))


SLOPE = make(np.arange(12.0).reshape(3, 4))


def test_the_largest_second_variable_is_on_top():
    drawn = pixels(SLOPE)
    assert drawn[0, -1].tolist() == viridis(np.array(1.0)).tolist()
    assert drawn[-1, 0].tolist() == viridis(np.array(0.0)).tolist()


def test_cells_too_short_to_travel_are_grey_and_do_not_set_the_range():
    map_ = make([[0.0, 1.0], [2.0, 900.0]], [[0, 0], [0.5, 40]])
    assert color_range(map_) == (0.0, 2.0)
    assert pixels(map_)[0, 1].tolist() == GREYED.tolist()


@pytest.mark.parametrize("values", [[[3.0, 3.0]], [[np.nan, np.nan]], [[np.inf, 1.0]]])
def test_flat_and_broken_values_are_drawn(values):
    low, high = color_range(make(values))
    assert low < high
    assert pixels(make(values)).shape == (1, 2, 3)


def test_the_picture_is_well_formed_and_names_its_axes():
    root = ET.fromstring(heatmap_svg(SLOPE, VARIABLES, Drawing("go('a&b')")))
    texts = [node.text for node in root.iter() if node.tag.endswith("text")]
    assert "t1  [steps]" in texts
    assert "t2  [steps]" in texts
    assert {"0", "1", "2", "3", "10", "11", "12"} <= set(texts)


def test_a_click_knows_its_cell():
    root = ET.fromstring(heatmap_svg(SLOPE, VARIABLES, Drawing("go(column, row)")))
    cells = next(node for node in root.iter() if node.attrib.get("class") == "tg-cells")
    handler = cells.attrib["onpointerdown"]
    assert "go(column, row)" in handler
    assert "box.width,4)" in handler
    assert "box.height,3)" in handler


def test_marks_lie_in_the_middle_of_their_cells():
    drawn = heatmap_svg(SLOPE, VARIABLES, Drawing(marks=[Mark((3, 10), "#123456", "here")]))
    [(x, y)] = {tuple(map(float, at)) for at in re.findall(r'cx="([\d.]+)" cy="([\d.]+)"', drawn)}
    assert x == pytest.approx(figure.LEFT + figure.PLOT * 3.5 / 4, abs=0.06)
    assert y == pytest.approx(figure.TOP + figure.TALL * 2.5 / 3, abs=0.06)


def test_one_variable_is_a_curve_and_none_is_nothing():
    one = make([[1.0, 2.0, 3.0]], [[0.0, 0.0, 9.0]], axes=(0,))
    root = ET.fromstring(curve_svg(one, VARIABLES, Drawing("go()", [Mark((1, 10), "#fff", "")])))
    texts = {node.text for node in root.iter() if node.tag.endswith("text")}
    assert "t1  [steps]" in texts
    assert "t2  [steps]" not in texts
    (line,) = [n.attrib["points"].split() for n in root.iter() if n.tag.endswith("polyline")]
    heights = [float(point.split(",")[1]) for point in line]
    assert heights == sorted(heights, reverse=True)
    (mark,) = [n for n in root.iter() if n.tag.endswith("circle")]
    assert float(mark.attrib["cy"]) == heights[1]
    assert heatmap_svg(make([[1.0]], axes=()), VARIABLES, Drawing()) == ""


def ruled_out(drawn):
    (path,) = [n for n in ET.fromstring(drawn).iter() if n.attrib.get("class") == "tg-ruled-out"]
    return path.attrib["d"]


def test_cells_without_time_to_travel_are_hatched():
    map_ = make(np.zeros((2, 4)), [[0, 5, 5, 0], [0, 0, 0, 0.5]])
    (hatched,) = re.findall(
        r"M([\d.]+) ([\d.]+)h([\d.]+)v([\d.]+)", ruled_out(heatmap_svg(map_, VARIABLES, Drawing()))
    )
    x, y, width, height = map(float, hatched)
    assert (x, width) == pytest.approx((figure.LEFT + figure.PLOT / 4, figure.PLOT / 2), abs=0.06)
    assert (y, height) == pytest.approx((figure.TOP + figure.TALL / 2, figure.TALL / 2), abs=0.06)


def test_the_read_out_holds_values_and_reasons():
    map_ = make([[1.0, 2.0], [3.0, 5.0]], [[0, 9], [9, 0]])
    data = dict(re.findall(r'data-(\w+)="([^"]*)"', cell_data(map_, ["t1", "t2"], 1.0, why)))
    share = [int(data["values"][4 * i : 4 * i + 4], 16) / SCALE for i in range(4)]
    low, high = float(data["low"]), float(data["high"])
    np.testing.assert_allclose([low + s * (high - low) for s in share], [1, 2, 3, 5], atol=1e-3)
    reasons = json.loads(html.unescape(data["reasons"]))
    codes = [int(data["reason"][3 * i : 3 * i + 3], 16) for i in range(4)]
    assert [reasons[code] for code in codes] == ["", "<0, 1>", "<1, 0>", ""]
    assert "<" not in data["reasons"]


def why(row, column):
    return f"<{row}, {column}>"


def test_chains_are_dots_one_for_each_cell():
    chains = np.array([[0, 10, 7], [0, 10, 9], [3, 12, 7]])
    drawn = heatmap_svg(SLOPE, VARIABLES, Drawing(chains=chains))
    assert drawn.count('r="1.5"') == 2


def test_a_data_url_holds_the_pixels():
    colors = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    encoded = data_url(colors).removeprefix("data:image/png;base64,")
    image = Image.open(io.BytesIO(base64.b64decode(encoded)))
    np.testing.assert_array_equal(np.asarray(image), colors)


@given(st.floats(-1e4, 1e4, allow_subnormal=False), st.floats(1e-3, 1e4), st.integers(2, 12))
def test_ticks_are_few_round_and_inside(low, span, most):
    high = low + span
    found = ticks(low, high, most)
    assert len(found) <= most
    assert all(low - 1e-9 * abs(low) <= tick <= high + 1e-9 * abs(high) for tick in found)
    steps = np.diff(found)
    assert np.allclose(steps, steps[0]) if len(steps) else True
    assert len(found) >= 1
