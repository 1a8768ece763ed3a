import math

import pytest

from scenes import Region, SceneError
from scenes.regions import SHAPES


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "circel"}, "kind: unknown 'circel'. Allowed: circle, "),
        ({"kind": []}, "kind: unknown"),
        ({"center": (0.0, math.nan)}, "center: nan must be finite"),
        ({"center": (0.0, -math.inf)}, "center: -inf must be finite"),
        ({"center": (0.0, 2e3)}, "center: 2000.0 must be finite and at most 1000 m"),
        ({"center": (10**400, 0)}, "must be finite and at most"),
        ({"center": (1.0,)}, "center: [1.0] has 1 numbers; a circle needs (x, y)"),
        ({"center": (1.0, 2.0, 3.0)}, "has 3 numbers; a circle needs (x, y)"),
        ({"center": "12"}, "center: '12' is not a list of numbers"),
        ({"center": ("1", 2)}, "center: '1' is not a number"),
        ({"center": (True, 2)}, "center: True is not a number"),
        ({"size": (0.0,)}, "size: [0.0] must be positive"),
        ({"size": (-1.0,)}, "size: [-1.0] must be positive"),
        ({"size": (1.0, 1.0)}, "a circle needs (radius)"),
        ({"color": "red"}, "color: 'red' is not of the form '#rrggbb'"),
        ({"color": "#12345g"}, "is not of the form"),
        ({"color": "#123456\n"}, "is not of the form"),
        ({"name": ""}, "name: '' must be non-empty text"),
        ({"name": 3}, "name: 3 must be non-empty text"),
        ({"name": "x" * 41}, "is longer than 40"),
        ({"name": " A"}, "without quotes, backslashes or spaces at the ends"),
        ({"name": 'a"b'}, "without quotes"),
        ({"name": "a\nb"}, "must be printable"),
    ],
)
def test_flaws_are_refused_with_the_field_and_what_is_allowed(changes, message):
    fields = {"name": "A", "kind": "circle", "center": (0.0, 1.0), "size": (1.0,)} | changes
    with pytest.raises(SceneError) as caught:
        Region(**fields)
    assert message in str(caught.value)


def test_numbers_become_floats_and_regions_hash():
    region = Region("A", "box", [1, 2, 3], [1, 1, 1], "#00ff7F")  # type: ignore[arg-type]
    assert region.center == (1.0, 2.0, 3.0)
    assert all(isinstance(value, float) for value in region.center + region.size)
    assert region.dimension == SHAPES["box"].dimension == 3
    assert len({region, Region("A", "box", (1, 2, 3), (1, 1, 1), "#00ff7F")}) == 1


@pytest.mark.parametrize("name", ["A", "B_1", "Küche", "pick up", "F", "<b>", "障害物"])
def test_names_that_a_formula_can_quote_are_accepted(name):
    assert Region(name, "circle", (0, 0), (1,)).name == name
