"""Where state formulas hold: against a dense grid of positions."""

import numpy as np
import pytest
from hypothesis import given, settings

from core.stl import Formula, conjunction, fold_constants, negation_normal_form, parse
from core.task.feasibility.places import Geometry, Places
from tests.strategies import ATOMS, state_formulas

CENTER = np.array([[0.0, 0.0], [1.0, 0.5], [0.2, 0.1]])
HALF = np.array([[1.0, 0.8], [0.3, 0.6], [0.4, 0.3]])
SPACING = 0.02
AXIS = np.arange(-3, 3, SPACING)
GRID = np.stack(np.meshgrid(AXIS, AXIS, indexing="ij"), -1).reshape(-1, 2)


def margin(i, positions):
    excess = np.abs(positions - CENTER[i]) - HALF[i]
    outside = np.linalg.norm(np.maximum(excess, 0), axis=1)
    return -(outside + np.minimum(excess.max(1), 0))


PLACES = Places(ATOMS, CENTER - HALF, CENTER + HALF, np.linalg.norm(HALF, axis=1), margin, 1e-6)


def normal(text: str) -> Formula:
    return negation_normal_form(parse(text, names=ATOMS))


@settings(max_examples=150, deadline=None)
@given(state_formulas(2, constants=False))
def test_the_best_margin_is_bounded(formula: Formula):
    formula = negation_normal_form(fold_constants(formula))
    geometry = Geometry(PLACES)
    best = geometry.best(formula)
    dense = geometry.margins_of(formula, GRID).max()
    assert best.bound >= dense - 1e-9
    if best.bound < -1e-6:
        assert best.reached <= best.bound
    elif np.isfinite(best.reached) and best.reached > 1e-6:
        assert dense > -SPACING


@settings(max_examples=100, deadline=None)
@given(state_formulas(2, constants=False), state_formulas(1, constants=False))
def test_gaps_are_never_too_large(first: Formula, second: Formula):
    first, second = (negation_normal_form(fold_constants(each)) for each in (first, second))
    geometry = Geometry(PLACES)
    inside = [GRID[geometry.margins_of(each, GRID) >= 0] for each in (first, second)]
    points = [each[:: len(each) // 60 + 1] for each in inside]
    if not all(map(len, points)):
        return  # nowhere
    between = np.abs(points[0][:, None] - points[1][None])
    ways = np.concatenate([between, np.linalg.norm(between, axis=-1, keepdims=True)], -1)
    gaps = geometry.gaps(first, second)
    covered = (ways[:, :, None] >= gaps - 1e-9).all(-1).any(-1)
    assert covered.all()


@pytest.mark.parametrize(
    ("text", "sign"),
    [
        ("A & B", 1),
        ("B & C", -1),  # 0.1 m apart
        ("C & !A", -1),  # C lies inside A
        ("A & !C", 1),
        ("!A & !B & !C", 1),
        ("A & !A", 0),
        ("(A & !A) | C", 1),
        ("(A & !A) | (C & !A)", 0),
    ],
)
def test_signs_by_hand(text, sign):
    best = Geometry(PLACES).best(normal(text))
    if sign > 0:
        assert best.reached > 0
    elif sign < 0:
        assert best.bound < 0
    else:
        assert best.reached <= 0 <= best.bound


def test_a_single_start_replaces_the_last_region():
    geometry = Geometry(PLACES).beginning_at(np.array([2.0, 2.0]))
    assert geometry.best(conjunction((normal("A"), normal("C")))).bound < 0
    assert geometry.gaps(normal("A"), normal("C"))[0] == pytest.approx(
        [1.0, 1.2, np.hypot(1.0, 1.2)], abs=1e-4
    )
    assert geometry.gaps(normal("A"), normal("B")).max() == 0
