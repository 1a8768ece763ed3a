import pytest

from core.errors import UserError
from scenes import Region
from studio.page.panels.region_fields import as_kind, corners_text, read_corners


def test_corners_are_read_as_they_are_shown():
    points = ((0.0, 0.5), (1.0, -2.125), (3.0, 1.0))
    assert corners_text(points) == "0, 0.5; 1, -2.125; 3, 1"
    assert read_corners(corners_text(points)) == points
    assert read_corners(" 0 0.5;1,-2.125 ; 3, 1; ") == points


@pytest.mark.parametrize("text", ["", "1", "1, 2, 3; 4, 5", "a, b; 1, 2", "1, 2; ; 3, 4"])
def test_what_is_no_list_of_corners_is_told(text):
    with pytest.raises(UserError, match="corners: .* must be two numbers, as in 0, 0; 1, 0"):
        read_corners(text)


def test_a_shape_becomes_another_of_the_same_place_and_extent():
    box = Region("A", "box", (1.0, 2.0, 3.0), (0.5, 1.0, 1.5))
    prism = as_kind(box, "prism", 0.5)
    assert (prism.center, prism.size, prism.z) == (box.center, box.size, (1.5, 4.5))
    assert as_kind(prism, "box", 0.5) == box
    point = as_kind(box, "point", 0.5)
    assert (point.kind, point.center) == ("point", box.center)
    assert as_kind(point, "sphere", 0.5) == Region("A", "sphere", box.center, (0.5,))
