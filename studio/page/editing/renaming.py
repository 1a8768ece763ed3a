"""Other names for a region in the text of a formula; the rest of the text stays as typed."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

from core.stl import (
    Atom,
    Formula,
    FormulaError,
    Span,
    children,
    parse,
    quote_name,
    to_text,
    walk,
    with_children,
)

_QUOTED = r'"[^"\n]*"|\'[^\'\n]*\''
_NO_OPERATOR = r"(?!\s*(?:_\s*)?(?:\{\s*)?\[)"  # an F before an interval is not a name


def rename_in_formula(
    text: str,
    old: str,
    new: str,
    *,
    names: Sequence[str],
    dt: float | None,
    horizon: int | None = None,
) -> str:
    """Replace a name wherever it refers to the region.

    If the text is a valid formula, its tree decides which words are names; if not (yet), every
    word and every quoted word that equals the name is replaced.

    Args:
        text: the formula as typed.
        old: a name of `names`.
        new: the new name.
        names: names of all regions before the change.
        dt: duration of a step [s].
        horizon: of the scene [steps].
    """
    try:
        formula = parse(text, dt=dt, names=names, horizon=horizon)
    except FormulaError:
        return _replace_words(text, old, quote_name(new))
    wanted = _renamed(formula, old, new)
    after = [new if name == old else name for name in names]
    for candidate in _spelled(text, formula, old, quote_name(new)):
        if _means(candidate, wanted, names=after, dt=dt, horizon=horizon):
            return candidate
    return to_text(wanted)


def spread_in_formula(
    text: str,
    old: str,
    parts: Sequence[str],
    *,
    names: Sequence[str],
    dt: float | None,
    horizon: int | None = None,
) -> str:
    """Write `(A | A2)` wherever a formula refers to the region A that was taken apart.

    A text that is no formula stays as it is.

    Args:
        text: the formula as typed.
        old: a name of `names`.
        parts: names of the regions that it has become; the first may be the old name.
        names: names of all regions before the change.
        dt: duration of a step [s].
        horizon: of the scene [steps].
    """
    try:
        formula = parse(text, dt=dt, names=names, horizon=horizon)
    except FormulaError:
        return text
    after = (*(name for name in names if name != old), *parts)
    spelled = f"({' | '.join(map(quote_name, parts))})"
    for candidate in _spelled(text, formula, old, spelled):
        try:
            parse(candidate, dt=dt, names=after, horizon=horizon)
        except FormulaError:
            continue
        return candidate
    return text


def _renamed(formula: Formula, old: str, new: str) -> Formula:
    if formula == Atom(old):
        return Atom(new)
    return with_children(formula, tuple(_renamed(part, old, new) for part in children(formula)))


def _spelled(text: str, formula: Formula, old: str, spelled: str) -> tuple[str, str]:
    """The formula's text with a name spelled otherwise wherever it refers to the region.

    Also with spaces, in case the spelling would merge with its neighbour: `A_1U_[0:5](B)`.
    """
    spans = {node.span for node in walk(formula) if node == Atom(old) and node.span is not None}
    return _replaced(text, spans, spelled), _replaced(text, spans, f" {spelled} ")


def _replaced(text: str, spans: Iterable[Span], spelled: str) -> str:
    for start, stop in sorted(spans, reverse=True):
        text = text[:start] + spelled + text[stop:]
    return text


def _means(text: str, wanted: Formula, **options: Any) -> bool:
    try:
        return parse(text, **options) == wanted
    except FormulaError:
        return False


def _replace_words(text: str, old: str, spelled: str) -> str:
    word = rf"(?<![\w\\]){re.escape(old)}(?!\w){_NO_OPERATOR}"

    def replaced(found: re.Match[str]) -> str:
        written = found[0]
        if written[0] in "\"'":
            return spelled if written[1:-1] == old else written
        return spelled if quote_name(old) == old else written

    return re.sub(rf"{_QUOTED}|{word}", replaced, text)
