import pytest

from core.errors import UserError
from studio.page.panels.region_fields import corners_text, read_corners


def test_corners_are_read_as_they_are_shown():
    points = ((0.0, 0.5), (1.0, -2.125), (3.0, 1.0))
    assert corners_text(points) == "0, 0.5; 1, -2.125; 3, 1"
    assert read_corners(corners_text(points)) == points
    assert read_corners(" 0 0.5;1,-2.125 ; 3, 1; ") == points


@pytest.mark.parametrize("text", ["", "1", "1, 2, 3; 4, 5", "a, b; 1, 2", "1, 2; ; 3, 4"])
def test_what_is_no_list_of_corners_is_told(text):
    with pytest.raises(UserError, match="corners: .* must be two numbers, as in 0, 0; 1, 0"):
        read_corners(text)
