from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from core.heatmap import Heatmap
from studio.page.panels.heatmap import clicked_schedule


@pytest.fixture
def picture() -> Any:
    heatmap = Heatmap(
        (0, 2),
        np.arange(5, 9),
        np.arange(20, 23),
        np.zeros((3, 4)),
        np.zeros((3, 4)),
        np.array([6, 7, 21, 0, 0, 0, 0, 0]),
    )
    return cast(Any, SimpleNamespace(heatmap=heatmap, choice=(6, 7, 21)))


def test_a_cell_becomes_its_schedule(picture):
    assert clicked_schedule(picture, "0,2 3 1") == (8, 7, 21)
    assert clicked_schedule(picture, "0,2 0 2") == (5, 7, 22)


@pytest.mark.parametrize(
    "value",
    ["", "0,2", "0,1 0 0", "0,2 4 0", "0,2 0 3", "0,2 -1 0", "0,2 1", "0,2 1 1 1", "0,2 a b",
     "0,2 1e1 0", "0,2 99999999999999999999 0", "0,2 ² 0"],
)  # fmt: skip
def test_what_is_no_cell_of_this_map_is_ignored(picture, value):
    assert clicked_schedule(picture, value) is None
