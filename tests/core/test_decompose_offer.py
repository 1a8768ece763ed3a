"""What is offered instead of a formula that does not decompose: it does, and it is stronger."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.decompose import DecompositionError, decompose, stronger
from core.errors import UserError
from core.stl import horizon, parse, robustness, satisfied, to_text
from tests.strategies import ATOMS, formulas, nested_formulas, traces

FORMULAS = formulas(max_depth=4, constants=False) | nested_formulas(max_depth=4, constants=False)

OFFERED = {
    "G_[0:5000](F_[0:3](A))": "G_[0:5000](A)",
    "G_[0:999]((!D)U_[0:4](A))": "G_[0:999](G_[0:4](!D)) & G_[0:999](A)",
    "(F_[0:3](A))U_[0:999](B)": "G_[0:999](A) & F_[0:999](B)",
    "G_[0:999](F_[0:4](A) & F_[0:5](B))": "G_[0:999](A) & G_[0:999](B)",
}


def refused(formula) -> bool:
    try:
        decompose(formula)
    except DecompositionError:
        return True
    except UserError:
        return False
    return False


@pytest.mark.parametrize("text", OFFERED)
def test_the_offer_for_a_formula(text):
    formula = parse(text)
    assert refused(formula)
    offer = stronger(formula)
    assert offer is not None and to_text(offer) == OFFERED[text]


@pytest.mark.parametrize("text", ["F_[0:3](A & false)", "!((true)U_[0:3](true))"])
def test_nothing_is_offered_for_what_never_holds(text):
    assert stronger(parse(text)) is None


def test_no_offer_asks_for_a_name_and_its_negation_at_once():
    text = "F_[0:5](C) & G_[0:999](F_[0:3](A)) & G_[0:9](!A)"
    formula = parse(text)
    assert refused(formula)
    assert stronger(formula) is None


def test_offers_for_large_formulas_are_found_or_not_but_soon():
    clauses = [f"G_[0:499]((A | B) U_[0:{index}] C)" for index in range(1, 31)]
    assert stronger(parse(" & ".join(clauses[:3]))) is not None
    assert stronger(parse(" & ".join(clauses * 10))) is None


@settings(deadline=None, max_examples=250)
@given(FORMULAS, st.data())
def test_offers_decompose_and_imply_the_formula(formula, data):
    if not refused(formula):
        return
    offer = stronger(formula)
    if offer is None:
        return
    assert not refused(offer)
    length = max(horizon(formula), horizon(offer)) + 1
    for trace in data.draw(traces(length, batch=(20,))):
        assert robustness(offer, trace, ATOMS) <= robustness(formula, trace, ATOMS)


@pytest.mark.parametrize("text", OFFERED)
def test_offers_can_be_satisfied(text):
    """The law above would hold of offers that nothing satisfies."""
    offer = parse(OFFERED[text])
    traces = np.array([[1, 1, 1, -1], [1, -1, 1, -1], [-1, -1, -1, -1]], float)
    constant = [np.tile(margins, (horizon(offer) + 1, 1)) for margins in traces]
    assert any(satisfied(offer, trace, ("A", "B", "C", "D")) for trace in constant)
