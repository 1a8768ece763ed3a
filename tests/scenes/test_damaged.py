"""Project files that are costly or damaged: one error of ours, at once, of bounded length."""

import time

import pytest

from core import errors
from core.errors import UserError
from scenes import format_scene, load_scene, load_task, parse_scene

GOOD = format_scene(load_task("linear-08"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a." * 3_000 + "a = 1", "a key of 3,001 parts joined by dots; at most 8"),
        ('["a"' + ' . "b"' * 3_000 + "]", "a key of 3,001 parts"),
        ("x = { " + "a." * 3_000 + "a = 1 }", "a key of 3,001 parts"),
        ("a = " + "[" * 30_000, "not valid TOML"),
        ("a = " + "1" * 10_000, "not valid TOML"),
        ('"""' + '\\"""' * 60_000, "not valid TOML"),
        (GOOD.replace("size = [", "size = [1" + "0" * 400 + ", "), "a number too large to use"),
        (GOOD.replace("seed = 1007", "seed = " + "[" * 300 + "]" * 300), "must be an integer"),
        (GOOD.replace("seed = 1007", "seed = " + "9" * 4_000), "must be an integer from 0"),
        (GOOD.replace("[regions.A1]", f'[regions."{"x" * 100_000}"]'), "is longer than 40"),
        (GOOD.replace('"linear"', f'"{"x" * 100_000}"'), "robot: unknown"),
        (GOOD.replace("size = [0.6]", "size = [1e-320]"), "must be at least 1e-06 m"),
    ],
)
def test_a_damaged_project_is_refused(text, message):
    began = time.process_time()
    with pytest.raises(UserError, match=message) as refused:
        parse_scene(text, "mine.stl.toml")
    assert time.process_time() - began < 0.5
    assert len(str(refused.value)) <= errors.LONGEST_MESSAGE + 5


def test_a_file_without_end_is_refused():
    with pytest.raises(UserError, match="/dev/zero: larger than 250,000 characters"):
        load_scene("/dev/zero")


def test_dots_in_texts_and_numbers_are_no_parts():
    scene = load_task("linear-08")
    titled = GOOD.replace(scene.title, "e.g. a.b.c.d.e.f.g.h.i.j.k " + "1. 2. 3. 4. 5. 6. 7. 8. 9.")
    commented = titled + "# a.b.c.d.e.f.g.h.i.j.k\n"
    assert parse_scene(commented, "mine").regions == scene.regions
