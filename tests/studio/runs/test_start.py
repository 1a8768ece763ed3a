"""What is said of an initial set before training; margins by hand."""

from dataclasses import replace

import pytest

from core.errors import UserError
from scenes import Region, load_task
from studio.runs.tasks import build_task


def scene(formula: str, center: tuple[float, float], half: float = 0.3):
    """An obstacle O of half side 0.6 at the origin, a disc A of radius 0.6 at (2, 2)."""
    regions = (
        Region("A", "circle", (2.0, 2.0), (0.6,)),
        Region("O", "rectangle", (0.0, 0.0), (0.6, 0.6)),
    )
    initial = Region("initial", "rectangle", center, (half, half))
    return replace(load_task("linear-01"), formula=formula, regions=regions, initial=initial)


AVOID = "F_[0:30](A) & G_[0:30](!O)"


@pytest.mark.parametrize(
    ("formula", "center", "message"),
    [
        (
            AVOID,
            (0.0, 0.0),
            "!O must hold from step 0, but all of the initial set is 0.3 m or",
        ),
        ("G_[0:30](A)", (0.0, -2.0), "A must hold from step 0"),
        ("(!O) U_[0:30] A", (0.0, 0.0), "!O must hold from step 0"),
    ],
)
def test_a_start_that_contradicts_the_formula_is_refused(formula, center, message):
    with pytest.raises(UserError, match=message):
        build_task(scene(formula, center))


def test_a_start_partly_in_an_obstacle_is_noted():
    """The set covers x in [0.3, 0.9]; with 9 positions across, those up to 0.6 lie in O."""
    (note,) = build_task(scene(AVOID, (0.6, 0.0))).notes
    assert note.startswith("about 44% of the initial set contradicts the formula: !O")


def test_a_start_outside_the_arena_is_noted():
    (note,) = build_task(scene(AVOID, (8.0, 8.0))).notes
    assert note.startswith("about 100% of the initial set lies outside the arena")
    assert "from [-5.0, -5.0] to [5.0, 5.0] m" in note


@pytest.mark.parametrize(
    ("formula", "center"),
    [
        (AVOID, (-2.0, -2.0)),
        ("F_[0:30](A) & G_[5:30](!O)", (0.0, 0.0)),
        ("F_[0:30](A) & (G_[0:30](!O) | G_[25:30](A))", (0.0, 0.0)),
    ],
)
def test_a_start_that_the_formula_allows_is_not_mentioned(formula, center):
    assert build_task(scene(formula, center)).notes == ()
