"""From text to syntax tree.

    equivalence := implication ('<->' equivalence)?
    implication := exclusive ('->' implication)?
    exclusive   := disjunction ('xor' disjunction)*
    disjunction := conjunction ('|' conjunction)*
    conjunction := until ('&' until)*
    until       := unary ('U' interval? unary)?            no chaining without parentheses
    unary       := '!' unary | ('F' | 'G') interval? unary | '(' equivalence ')'
                 | name | 'true' | 'false'
    interval    := '_'? '[' a (':' | ',') b ']'            closed, 0 <= a <= b

All spellings are in `grammar`. Names are plain (`A1`, `goal_left`) or quoted (`"the lobby"`);
a plain `A_1` is `A1`, unless the caller knows a name that is spelt `A_1`. `<->` and `xor` become
`->`, `&`, `|` and `!`; operators without an upper bound get one (see `reach`).
"""

import math
from collections.abc import Collection
from typing import NamedTuple

from lark import Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from core.stl.build import Builder
from core.stl.complaints import complain_about_character, complain_about_token
from core.stl.errors import FormulaError
from core.stl.grammar import formula_parser
from core.stl.limits import MAX_DEPTH
from core.stl.plain import plain
from core.stl.reach import NoRoomError, closed, open_operators
from core.stl.syntax import Always, Eventually, Formula

MAX_LENGTH = 10_000

__all__ = ["MAX_DEPTH", "MAX_LENGTH", "Reading", "parse", "read"]


class Reading(NamedTuple):
    """A formula as it was read."""

    formula: Formula
    notes: tuple[str, ...]
    """Sentences on what the text left open and how it was read."""


def parse(
    text: str,
    *,
    dt: float | None = None,
    names: Collection[str] | None = None,
    horizon: int | None = None,
) -> Formula:
    """Read a formula.

    Args:
        text: at most `MAX_LENGTH` characters, with at most `MAX_DEPTH` operators and as many
            parentheses nested in one another.
        dt: duration of a step [s]; lets bounds be given in `s` and `ms`.
        names: the names that atoms may have; any, if None.
        horizon: T [steps], how far operators without an upper bound reach; they are refused, if
            None.

    Raises:
        FormulaError: with line, column, what was expected, and a caret.
    """
    return read(text, dt=dt, names=names, horizon=horizon).formula


def read(
    text: str,
    *,
    dt: float | None = None,
    names: Collection[str] | None = None,
    horizon: int | None = None,
) -> Reading:
    """Read a formula, like `parse`, and say what was assumed."""
    if dt is not None and not (math.isfinite(dt) and dt > 0):
        raise ValueError(f"dt must be positive and finite: {dt}")
    if len(text) > MAX_LENGTH:
        raise FormulaError(
            f"the formula has {len(text)} characters; at most {MAX_LENGTH} are allowed",
            text,
            MAX_LENGTH,
        )
    if not text.strip():
        raise FormulaError("the formula is empty", text, 0, expected="a formula like F_[0:10](A)")
    builder = Builder(text, dt, names)
    formula, reach = _within(builder.build(_syntax_tree(text)), text, horizon)
    return Reading(formula, (*dict.fromkeys(builder.notes), *reach))


def _syntax_tree(text: str) -> Tree[Token]:
    readable = plain(text)
    state = formula_parser().parse_interactive(readable)
    try:
        state.exhaust_lexer()
        return state.feed_eof()
    except UnexpectedToken as error:
        raise complain_about_token(text, readable, error.token, state) from None
    except UnexpectedCharacters as error:
        raise complain_about_character(text, readable, error.pos_in_stream, state) from None


def _within(formula: Formula, text: str, horizon: int | None) -> tuple[Formula, list[str]]:
    """Give open operators their upper bounds, and say which."""
    operators = open_operators(formula)
    if not operators:
        return formula, []
    if horizon is None:
        letter, place = _letter(operators[0]), operators[0].span
        raise FormulaError(
            f"this {letter} has no upper bound",
            text,
            place.start if place else 0,
            hint=f"without a scene every interval must be bounded; write {letter}_[0:10]",
        )
    try:
        formula, intervals = closed(formula, horizon)
    except NoRoomError as error:
        letter, place = _letter(error.operator), error.operator.span
        raise FormulaError(
            f"this {letter} has no upper bound and no step left for it: the bounds given reach "
            f"step {error.used}, the scene's horizon is {horizon}",
            text,
            place.start if place else 0,
            hint=f"give {letter} an interval, or raise the horizon",
        ) from None
    found = dict.fromkeys(
        f"{_letter(operator)}_[{a}:{b}]"
        for operator in operators
        if operator.span
        for a, b in [intervals[operator.span]]
    )
    shared = ", which nested operators share"
    if all(b == horizon for _, b in intervals.values()):
        shared = ""
    return formula, [
        f"Operators without an upper bound reach to the scene's horizon, {horizon} steps{shared}: "
        f"{', '.join(found)}."
    ]


def _letter(operator: Formula) -> str:
    match operator:
        case Eventually():
            return "F"
        case Always():
            return "G"
    return "U"
