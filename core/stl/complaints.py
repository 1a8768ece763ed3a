"""Syntax errors in the words of the person who wrote the formula, not of the grammar."""

import re

from lark import Token
from lark.parsers.lalr_interactive_parser import InteractiveParser

from core.stl.errors import FormulaError

# What the parser would accept -> how a person would call it, in the order of mention.
_WORDS = {
    "NAME": "a name, true, false, '!', 'F_[a:b]', 'G_[a:b]' or '('",
    "AND": "an operator ('&', '|' or '->')",
    "UNTIL": "'U_[a:b]'",
    "LSQB": "an interval like [0:10]",
    "NUMBER": "a number of steps",
    "UNIT": "a unit (s or ms)",
    "SEPARATOR": "':' or ','",
    "RSQB": "']'",
    "RBRACE": "'}'",
    "RPAR": "')'",
    "$END": "the end of the formula",
}
_OPERATOR_BEFORE = re.compile(r"(?<![^\W_])([FGU])_?\s*\Z")
_UNBOUNDED = re.compile(r"inf|∞|\\infty|T\b|end", re.IGNORECASE)


def complain_about_token(text: str, token: Token, state: InteractiveParser) -> FormulaError:
    """Word the error for a token that cannot stand where it does."""
    accepted = state.accepts()
    at_end = token.type == "$END"
    offset = len(text.rstrip().rstrip("$").rstrip()) if at_end else int(token.start_pos or 0)
    problem = "the formula ends too early" if at_end else f"unexpected {_quote(str(token))}"
    opened = _open_parenthesis(state)
    if at_end and "RPAR" in accepted and opened is not None:
        problem = "a parenthesis is not closed"
    if token.type == "RPAR" and opened is None and "$END" in accepted:
        return FormulaError("this parenthesis closes none", text, offset)
    return FormulaError(
        problem,
        text,
        offset,
        expected=_expected(accepted),
        hint=_hint(text, token, offset, state, accepted),
    )


def complain_about_character(text: str, offset: int, state: InteractiveParser) -> FormulaError:
    """Word the error for a character that begins no token."""
    accepted = state.accepts()
    if text[offset] in "\"'" and "NAME" in accepted:
        return FormulaError("the quoted name is not closed", text, offset)
    token = Token("UNKNOWN", _word_at(text, offset))
    return FormulaError(
        f"unexpected {_quote(str(token))}",
        text,
        offset,
        expected=_expected(accepted),
        hint=_hint(text, token, offset, state, accepted),
    )


def _hint(text: str, token: Token, offset: int, state: InteractiveParser, accepted: set) -> str:
    operator = _OPERATOR_BEFORE.search(text, 0, offset)
    opened = _open_parenthesis(state)
    if "AND" in accepted:
        if token.type == "UNTIL":
            return "until does not chain; write parentheses around one of the two"
        if token.type == "NAME" and str(token) == "U":
            return "U is an operator only before an interval: U_[0:10]"
        if operator:
            return f"{operator[1]} is an operator only before an interval: {operator[1]}_[0:10]"
        if token.type == "LSQB":
            return "an interval stands only behind F, G or U, apart from the name before them"
    if "NUMBER" in accepted and _UNBOUNDED.match(text, offset):
        return "intervals are bounded"
    if token.type == "$END" and "RPAR" in accepted and opened is not None:
        return f"it was opened at line {opened.line}, column {opened.column}"
    return ""


def _expected(accepted: set[str]) -> str:
    return " or ".join(words for terminal, words in _WORDS.items() if terminal in accepted)


def _open_parenthesis(state: InteractiveParser) -> Token | None:
    """Find the innermost parenthesis that is still open."""
    stack = state.parser_state.value_stack
    # Tokens that no rule has consumed yet: the prefix of the rules under way.
    tokens = [item for item in stack if isinstance(item, Token) and item.type == "LPAR"]
    return tokens[-1] if tokens else None


def _quote(word: str) -> str:
    shown = word if len(word) <= 30 else f"{word[:27]}..."
    return f"'{shown}'" if shown.isprintable() else ascii(shown)


def _word_at(text: str, offset: int) -> str:
    """Return the character, or the LaTeX macro or number that begins with it."""
    match = re.compile(r"\\[A-Za-z]+|[0-9][\w.]*").match(text, offset)
    return match.group() if match else text[offset]
