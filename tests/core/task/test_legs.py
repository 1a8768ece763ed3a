from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from core.task.legs import leg_text
from core.task.windows import TightLeg, leg_slack, tightest_leg, windows_of
from scenes import load_task
from studio.runs.tasks import build_task

FORMULA = "F_[0:90](A1) & F_[0:90](A2)"


@pytest.fixture(scope="module")
def task():
    return build_task(load_task("linear-07"), FORMULA)


def shortest(task, schedule, reserve=1.0):
    windows = windows_of(task.problem, jnp.asarray(schedule + (0,) * 6, jnp.int32))
    start = jnp.zeros(2)
    arguments = (task.problem, windows, start, reserve)
    return tightest_leg(*arguments), leg_slack(*arguments)


@pytest.mark.parametrize(
    ("schedule", "names", "has"),
    [((60, 63), "A1 to A2", 3), ((63, 60), "A2 to A1", 3), ((2, 80), "the start to A1", 2)],
)
def test_the_leg_that_lacks_most_is_named(task, schedule, names, has):
    leg, (slack, _) = shortest(task, schedule)
    text = leg_text(task, leg)
    assert text.startswith(f"{names} needs ")
    assert text.endswith(f" steps, has {has}")
    assert float(leg.available - leg.needed) == pytest.approx(float(slack.min()))


def test_two_places_at_once_are_a_conflict(task):
    leg, (_, shortfall) = shortest(task, (50, 50))
    assert shortfall > 50
    assert "due at once" in leg_text(task, leg)


def test_texts_are_taken_from_arrays(task):
    values: Any = [np.array([[value]]) for value in (0, 1, 22.3, 10.0, False, False)]
    legs = TightLeg(*values)
    assert leg_text(task, legs, (0, 0)) == "A1 to A2 needs 23 steps, has 10"
    ample = legs._replace(available=jnp.array([[40.0]]))
    assert "visits" in leg_text(task, ample, (0, 0))
