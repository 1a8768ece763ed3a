import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from core.decompose import decompose
from core.heatmap import Heatmap
from core.stl import parse
from core.truth import Truth
from studio.page.figures.heatmap import LEFT, PLOT, TALL, TOP, Drawing
from studio.page.figures.truth import (
    BADLY,
    BARELY,
    NEARLY,
    WELL,
    robustness_range,
    truth_pixels,
    truth_svg,
)

VARIABLES = decompose(parse("F_[0:3](A) & F_[10:12](B)")).variables
NAN, INF = np.nan, np.inf


def make(robustness, values=None, shortfall=None):
    robustness = np.asarray(robustness, float)
    rows, columns = (np.arange(size) for size in robustness.shape)
    values = np.zeros_like(robustness) if values is None else np.asarray(values, float)
    short = np.zeros_like(robustness) if shortfall is None else np.asarray(shortfall, float)
    axes = (0, 1) if rows.size > 1 else (0,)
    heatmap = Heatmap(axes, columns, 10 + rows, values, short, np.zeros(8, np.int32))
    return Truth(heatmap, rows, columns, np.zeros((*robustness.shape, 8), np.int32), robustness)


def lightness(color):
    """Relative luminance (Rec. 709) of a colour in 0..255, gamma undone."""
    return (np.asarray(color) / 255) ** 2.2 @ [0.2126, 0.7152, 0.0722]


def test_the_worst_satisfying_cell_is_darker_than_the_best_failing_one():
    contrast = (lightness(BADLY) + 0.05) / (lightness(BARELY) + 0.05)
    assert contrast > 1.8
    assert lightness(WELL) < lightness(BARELY) < lightness(BADLY) < lightness(NEARLY)


def test_colours_tell_verdict_and_robustness_and_unknown_cells_are_empty():
    drawn = truth_pixels(make([[0.0, 0.4, NAN], [-2.0, -1e-9, -INF]]))
    assert drawn[1, 0].tolist() == [*BARELY, 255]
    assert drawn[1, 1].tolist() == [*WELL, 255]
    assert drawn[1, 2, 3] == 0
    assert drawn[0, 0].tolist() == drawn[0, 2].tolist() == [*BADLY, 255]
    assert drawn[0, 1].tolist() == [*NEARLY, 255]


@pytest.mark.parametrize("robustness", [[[NAN, NAN]], [[-INF, -INF]], [[0.0, 0.0]]])
def test_what_says_little_is_drawn(robustness):
    truth = make(robustness)
    low, high = robustness_range(truth)
    assert low < 0 < high
    ET.fromstring(truth_svg(truth, VARIABLES, Drawing()))


def test_crosses_stand_on_what_the_critic_ranks_wrongly():
    """Two of the cells that leave time satisfy; the critic's two best are another pair."""
    truth = make([[1, -1, -1], [1, -1, 1]], [[5, 4, 1], [3, 9, 0]], [[0, 0, 0], [0, 9, 9]])
    drawn = truth_svg(truth, VARIABLES, Drawing())
    (crosses,) = [n for n in ET.fromstring(drawn).iter() if n.attrib.get("class") == "tg-wrong"]
    found = re.findall(r"M([\d.]+) ([\d.]+)l([\d.]+)", crosses[0].attrib["d"])
    middles = [(float(x) + float(arm) / 2, float(y) + float(arm) / 2) for x, y, arm in found]
    expected = [(LEFT + PLOT / 2, TOP + TALL * 3 / 4), (LEFT + PLOT / 6, TOP + TALL / 4)]
    np.testing.assert_allclose(middles, expected, atol=0.1)


def test_the_read_out_says_what_simulation_found():
    drawn = truth_svg(make([[0.25, -1.5], [NAN, -INF]]), VARIABLES, Drawing())
    (cells,) = [n for n in ET.fromstring(drawn).iter() if n.attrib.get("class") == "tg-cells"]
    assert cells.attrib["data-robustness"].split(",") == [
        "satisfied with robustness 0.250 m",
        "fails with robustness -1.500 m",
        "not simulated yet",
        "fails: the simulation broke down",
    ]
