"""Typed documents: what is refused, and in which words."""

import math
from datetime import date
from typing import Annotated, Any, Literal

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Meta

from core.documents import LONGEST_SHOWN, typed
from core.errors import UserError


class Inner(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    sizes: tuple[Annotated[int, Meta(gt=0)], ...] = ()
    scale: float = 1.0


class Outer(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    seed: Annotated[int, Meta(ge=0, le=10)]
    name: str = ""
    share: Annotated[float, Meta(gt=0, le=9)] = 1.0
    count: Annotated[int, Meta(ge=0)] = 0
    limit: float | None = None
    fast: bool = False
    mode: Literal["studio", "paper"] = "studio"
    inner: Inner = Inner()
    rest: dict[str, Any] = {}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([], "[] must be a table"),
        ({}, "seed: this field is missing"),
        ({"sed": 3}, "sed: unknown. Allowed: seed, "),
        ({"seed": "x"}, "seed: 'x' must be an integer from 0 to 10"),
        ({"seed": True}, "seed: True must be an integer from 0 to 10"),
        ({"seed": 1.0}, "seed: 1.0 must be an integer from 0 to 10"),
        ({"seed": -1}, "seed: -1 must be an integer from 0 to 10"),
        ({"seed": date(2026, 1, 2)}, "seed: datetime.date(2026, 1, 2) must be an integer"),
        ({"seed": 1, "name": None}, "name: None must be text"),
        ({"seed": 1, "share": 0}, "share: 0 must be a number above 0 and at most 9"),
        ({"seed": 1, "share": math.nan}, "share: nan must be a number above 0 and at most 9"),
        ({"seed": 1, "count": -1}, "count: -1 must be an integer of at least 0"),
        ({"seed": 1, "limit": "1"}, "limit: '1' must be a number or null"),
        ({"seed": 1, "fast": 1}, "fast: 1 must be true or false"),
        ({"seed": 1, "mode": "fast"}, "mode: 'fast' must be 'paper' or 'studio'"),
        ({"seed": 1, "rest": []}, "rest: [] must be a table"),
        ({"seed": 1, "inner": 3}, "inner: 3 must be a table"),
        ({"seed": 1, "inner": {"size": 3}}, "inner.size: unknown. Allowed: sizes, scale"),
        (
            {"seed": 1, "inner": {"sizes": 3}},
            "inner.sizes: 3 must be a list, each entry an integer",
        ),
        ({"seed": 1, "inner": {"sizes": [1, 0]}}, "inner.sizes[1]: 0 must be an integer above 0"),
        ({"seed": 1, "inner": {"scale": True}}, "inner.scale: True must be a number"),
        ({"seed": 1, "a\n\x1b": 2}, r"a\n\x1b: unknown. "),
        ({"seed": 1, "a` - at `$.inner.x": 2}, "a` - at `$.inner.x: unknown. "),
    ],
)
def test_a_flaw_is_named_with_its_place_and_what_is_allowed(values, message):
    with pytest.raises(UserError) as caught:
        typed(values, Outer, "file: ")
    assert str(caught.value).startswith(f"file: {message}")


def test_sound_values_are_read():
    values = {"seed": 3, "share": 2, "inner": {"sizes": [1, 2]}, "rest": {"x": [None]}}
    read = typed(values, Outer)
    assert read == Outer(seed=3, share=2.0, inner=Inner((1, 2)), rest={"x": [None]})


def test_a_long_value_is_cut():
    with pytest.raises(UserError) as caught:
        typed({"seed": "x" * 10_000}, Outer)
    assert len(str(caught.value)) < LONGEST_SHOWN + 100


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)
FIELDS = [*Outer.__struct_fields__, *Inner.__struct_fields__]


@given(st.dictionaries(st.sampled_from(FIELDS) | st.text(max_size=20), ANYTHING, max_size=5))
def test_any_values_are_read_or_refused(values):
    for document in (values, {"seed": 1, "inner": values}):
        try:
            typed(document, Outer)
        except UserError as error:
            assert str(error)
