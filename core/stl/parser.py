"""From text to syntax tree.

    implication := disjunction ('->' implication)?
    disjunction := conjunction ('|' conjunction)*
    conjunction := until ('&' until)*
    until       := unary ('U' interval unary)?            no chaining without parentheses
    unary       := '!' unary | ('F' | 'G') interval unary | '(' implication ')'
                 | name | 'true' | 'false'
    interval    := '_'? '[' a (':' | ',') b ']'           closed, 0 <= a <= b

All spellings are in `grammar`. Names are plain (`A1`, `goal_left`) or quoted (`"the lobby"`);
a plain `A_1` is `A1`, unless the caller knows a name that is spelt `A_1`.
"""

import math
from collections.abc import Collection

from lark import Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from core.stl.build import MAX_DEPTH, Builder
from core.stl.complaints import complain_about_character, complain_about_token
from core.stl.errors import FormulaError
from core.stl.grammar import formula_parser
from core.stl.syntax import Formula

MAX_LENGTH = 10_000

__all__ = ["MAX_DEPTH", "MAX_LENGTH", "parse"]


def parse(text: str, *, dt: float | None = None, names: Collection[str] | None = None) -> Formula:
    """Read a formula.

    Args:
        text: at most `MAX_LENGTH` characters, with at most `MAX_DEPTH` operators and as many
            parentheses nested in one another.
        dt: duration of a step [s]; lets bounds be given in `s` and `ms`.
        names: the names that atoms may have; any, if None.

    Raises:
        FormulaError: with line, column, what was expected, and a caret.
    """
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
    return Builder(text, dt, names).build(_syntax_tree(text))


def _syntax_tree(text: str) -> Tree[Token]:
    state = formula_parser().parse_interactive(text)
    try:
        state.exhaust_lexer()
        return state.feed_eof()
    except UnexpectedToken as error:
        raise complain_about_token(text, error.token, state) from None
    except UnexpectedCharacters as error:
        raise complain_about_character(text, error.pos_in_stream, state) from None
