import xml.etree.ElementTree as ET

import numpy as np
import pytest

from core.monitor import monitor_rows
from core.stl import parse
from studio.page.figures.monitor import UNDECIDED, monitor_html, pixels
from studio.page.figures.playhead import playhead_style
from tests.studio.runs.test_recording import GOOD, recorded


def row_of(text, margins, index):
    return monitor_rows(parse(text), np.asarray(margins, float)[:, None], ["A"])[index]


def test_colours_follow_sign_size_and_window():
    row = row_of("F_[1:3](A)", [-1, -0.1, 0.1, 1, 1], 1)
    red, faint_red, green, strong, outside = pixels(row, 4)[0].astype(int)
    assert red[0] > red[1]
    assert strong[1] > strong[0]
    assert green.sum() > strong.sum(), "a small robustness is paler"
    assert outside.min() > strong.max() - 60, "outside of the window colours are faint"
    assert outside.sum() > strong.sum()
    assert faint_red[0] > faint_red[1]


def test_steps_that_the_trace_does_not_decide_are_grey():
    row = row_of("F_[1:3](A)", [1, 1, 1, 1, 1], 0)
    drawn = pixels(row, 4)[0]
    assert drawn.shape == (5, 3)
    assert [tuple(color) == UNDECIDED for color in drawn.tolist()] == [False, False] + [True] * 3


@pytest.mark.parametrize("crash", [None, 30])
def test_the_table_is_well_formed_and_says_why(linear_task, crash):
    recording = recorded(linear_task, GOOD, crash=crash)
    html = monitor_html(recording, "go(step)")
    root = ET.fromstring(html)
    text = "".join(root.itertext())
    assert text.startswith("Satisfied" if crash is None else "Violated")
    images = [node for node in root.iter() if node.tag.endswith("image")]
    assert len(images) == len(recording.rows) > 5
    values = images[0].attrib["data-values"].split()
    assert float(values[0]) == pytest.approx(recording.robustness, abs=0.01)
    assert "go(step)" in images[0].attrib["onpointerdown"]


def test_one_style_moves_every_playhead(linear_task):
    assert "tg-playhead" in monitor_html(recorded(linear_task, GOOD), "")
    assert playhead_style(3.25) == "<style>.tg-playhead{--tg-step:3.25}</style>"
