"""Syntax errors in the words of the person who wrote the formula, not of the grammar."""

import re

from lark import Token
from lark.parsers.lalr_interactive_parser import InteractiveParser

from core.quoting import quoted, shown
from core.stl.errors import FormulaError
from core.stl.foreign import Foreign, foreign

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
_LONGEST_WORD = 30  # characters
_LONGEST_QUOTE = 60
_UNBOUNDED = re.compile(r"inf|∞|\\infty|T\b|end", re.IGNORECASE)


def complain_about_token(
    text: str, plain: str, token: Token, state: InteractiveParser
) -> FormulaError:
    """Word the error for a token that cannot stand where it does.

    Args:
        text: the formula as typed.
        plain: the text that was read, of the same length.
        token: one of `plain`.
        state: of the parser before the token.
    """
    accepted = state.accepts()
    at_end = token.type == "$END"
    offset = len(plain.rstrip()) if at_end else int(token.start_pos or 0)
    found = None if at_end else foreign(plain, offset)
    if found is not None:
        return _about_foreign(text, found)
    typed = text[offset : offset + len(token)]
    problem = (
        "the formula ends too early" if at_end else f"unexpected {quoted(typed, _LONGEST_WORD)}"
    )
    opened = _open_parenthesis(state)
    if at_end and "RPAR" in accepted and opened is not None:
        problem = "a parenthesis is never closed"
    if token.type == "RPAR" and opened is None and "$END" in accepted:
        return FormulaError("this ')' has no matching '('", text, offset)
    return FormulaError(
        problem,
        text,
        offset,
        expected=_expected(accepted),
        hint=_hint(plain, token, offset, state, accepted),
    )


def complain_about_character(
    text: str, plain: str, offset: int, state: InteractiveParser
) -> FormulaError:
    """Word the error for a character that begins no token."""
    accepted = state.accepts()
    if plain[offset] in "\"'" and "NAME" in accepted:
        return FormulaError("the quoted name has no closing quote", text, offset)
    found = foreign(plain, offset)
    if found is not None:
        return _about_foreign(text, found)
    token = Token("UNKNOWN", _word_at(text, offset))
    return FormulaError(
        f"unexpected {quoted(str(token), _LONGEST_WORD)}",
        text,
        offset,
        expected=_expected(accepted),
        hint=_hint(plain, token, offset, state, accepted),
    )


def _about_foreign(text: str, found: Foreign) -> FormulaError:
    typed = text[found.start : found.stop]
    start = found.start + len(typed) - len(typed.lstrip())
    typed = typed.strip()
    line = text.rfind("\n", 0, start) + 1
    columns = f"columns {start - line + 1}-{start - line + len(typed)}"
    problem = f"`{shown(typed, _LONGEST_QUOTE)}` ({columns}) {found.problem}"
    return FormulaError(problem, text, start, hint=found.hint)


def _hint(text: str, token: Token, offset: int, state: InteractiveParser, accepted: set) -> str:
    opened = _open_parenthesis(state)
    if "AND" in accepted:
        if token.type == "UNTIL":
            return "untils cannot be chained; put one of them in parentheses"
        if token.type == "LSQB":
            return "an interval can only follow F, G or U; put a space between a name and U"
        if token.type == "STOP" and "$END" not in accepted:
            return "operators stand between their operands: A & B"
    if "STOP" in accepted and "\n" in text[:offset].rstrip(" ")[-1:]:
        return "join the lines with &"
    if "STOP" in accepted and text[:offset].rstrip()[-1:] in {";", ".", ","}:
        return "there is one formula only; join the parts with &"
    if "NUMBER" in accepted and _UNBOUNDED.match(text, offset):
        return "leave the interval out to reach the scene's horizon"
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


def _word_at(text: str, offset: int) -> str:
    """Return the character, or the LaTeX macro or number that begins with it."""
    match = re.compile(r"\\[A-Za-z]+|[0-9][\w.]*").match(text, offset)
    return match.group() if match else text[offset]
