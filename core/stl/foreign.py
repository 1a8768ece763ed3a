"""What other languages have and this one does not, and what to write instead.

Looked up once a text could not be read: the first entry of `_TABLE` that matches at the place of
the error answers. Operands are recognised if they are a name or a parenthesis without another.
"""

import re
from typing import NamedTuple

from core.stl.answers import (
    NAME,
    OPERAND,
    PARENTHESIS,
    Answer,
    call,
    comparison,
    conditional,
    edge,
    fixed,
    interval_in_words,
    leads_to,
    next_step,
    open_interval,
    operator_as_call,
    past,
    place_in_words,
    release,
    since,
    strong_release,
    unit_of_time,
    weak_until,
    weight,
)


class Foreign(NamedTuple):
    """A construct that is not of the language.

    Attributes:
        start: its first character, from 0.
        stop: the character behind it.
        problem: what is wrong with it.
        hint: what to write instead.
    """

    start: int
    stop: int
    problem: str
    hint: str


_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)"
_UNIT = r"[ ]?[a-zA-Zµ]*"
_BOUND = rf"\s*({_NUMBER})({_UNIT})\s*"
_INTERVAL = r"\s*_?\s*\{?\s*(\[[^\[\]\n]{0,40}\])?\s*\}?\s*"
_WRAPPER = r"(?:\\(?:math[a-z]+|text[a-z]*|operatorname)\s*\{\s*)?"
_TERM = rf"[-+]?\s*(?:\|[^|\n]{{1,60}}\||(?<![\w.])[\w.]+\s*(?:{PARENTHESIS})?|{PARENTHESIS})"
_SUM = rf"{_TERM}(?:\s*[-+*/^]\s*{_TERM}){{0,6}}"
_RELATION = r"(?:[<>]=?|[=!]=|=|[≤≥≠]|\\(?:leq?|geq?|neq?)(?![a-z]))"


def foreign(text: str, offset: int) -> Foreign | None:
    """Find what stands at a place of a text, if it is of another language.

    Args:
        text: a formula.
        offset: where it could not be read on, from 0.
    """
    low = max(0, offset - _REACH)
    for pattern, answer in _TABLE:
        for match in pattern.finditer(text, low, offset + _REACH):
            if match.start() <= offset < match.end():
                problem, hint = answer(match)
                return Foreign(match.start(), match.end(), problem, hint)
    return None


_REACH = 200
"""Characters on both sides of the error that are looked at."""


def _binary(words: str, answer: Answer):
    operator = rf"{_WRAPPER}((?<![^\W_])(?:{words})(?![^\W_]))(?:\s*\}})?"
    return rf"(?P<left>{OPERAND})\s*{operator}{_INTERVAL}(?P<right>{OPERAND})?", answer


def _unary(words: str, answer: Answer):
    return rf"(?<!\w)({words})(?![^\W_]){_INTERVAL}(?P<operand>{OPERAND})?", answer


_CALLED = "(?i:eventually|finally|ev|always|globally|alw|until)|F|G|U"
_SOURCES: tuple[tuple[str, Answer], ...] = (
    (
        rf"(?<!\w)({_CALLED})\s*\(([^\[\]()]{{0,60}}),\s*[\[(]\s*(\d+)\s*[,:]\s*(\d+)\s*[\])]\s*\)",
        call,
    ),
    (
        rf"(?<!\w)((?i:and|or|implies|xor|iff|until))\s*\(\s*({NAME})\s*,\s*({NAME})\s*\)",
        operator_as_call,
    ),
    (rf"([\[(\]]){_BOUND}[:,;]{_BOUND}([)\[])", open_interval),
    (rf"([(\]]){_BOUND}[:,;]{_BOUND}([\])\[])", open_interval),
    (r"(?<=[\])&|])\s*\^\s*\{?\s*[\w.]+\}?", weight),
    (rf"{_SUM}\s*{_RELATION}\s*{_SUM}", comparison),
    _unary(r"(?i:once|historically|previous(?:ly)?|prev|yesterday|past)", past),
    (r"(?<!\w)([OHPY])(?=\s*_?\s*\{?\s*\[)" + _INTERVAL + rf"(?P<operand>{OPERAND})?", past),
    _binary(r"(?i:since|backto)|S", since),
    _binary(r"(?i:releases?)|R|V", release),
    _binary(r"(?i:unless|weak[ _]?until)|W", weak_until),
    _binary(r"(?i:strong[ _]?release)|M", strong_release),
    (
        rf"(?:(?<!\w){_WRAPPER}(?:X|(?i:next)|N|wX)(?![^\W_])(?:\s*\}})?|[○◯]|\\(?:bigcirc|circ|next))"
        rf"\s*_?\s*[\[{{]?\s*(?P<steps>\d+)?(?:\s*[:,]\s*\d+)?\s*[\]}}]?\s*(?P<operand>{OPERAND})?",
        next_step,
    ),
    (rf"(?P<left>{OPERAND})\s*(?:~>|(?i:leads\s?to)(?!\w))\s*(?P<right>{OPERAND})", leads_to),
    (rf"(?<!\w)(?i:if)\s+(?P<left>{OPERAND})(?:\s+(?i:then))?", conditional),
    _unary(r"(?i:ris(?:e|ing)(?:_?edge)?|posedge|fall(?:ing)?(?:_?edge)?|negedge)", edge),
    (
        rf"(?<!\w)((?i:in|inside|reach|visit|at|go\s?to|stay(?:\s+in)?|avoid|outside|never|leave))"
        rf"\s*({OPERAND})",
        place_in_words,
    ),
    (
        r"(?i:between)\s+(\d+)\s+(?:and|to)\s+(\d+)|(?i:within|before|for|until)\s+(\d+)",
        interval_in_words,
    ),
    (
        r"(?<![\d.])(\d+(?:\.\d*)?|\.\d+)\s*((?i:msec|milli\w*|sec\w*|min\w*|steps?|h(?:ours?)?|m|us|µs|ns))(?!\w)",
        unit_of_time,
    ),
    (
        r"(?<!\w)[AE][FGX](?![^\W_])\s*(?:\(|[^\W\d])",
        fixed("has a quantifier over paths", "a formula is about one run: leave out A and E"),
    ),
    (r"\^", fixed("is written for xor and for and", "write xor or &")),
    (r"[*·]", fixed("is no operator", "write & for and")),
    (r"\+", fixed("is no operator", "write | for or")),
    (r"/\*", fixed("is a comment without an end", "close it with */")),
    (r"--", fixed("is no operator", "a comment begins with # or //")),
    (r"\d[eE]\d+|(?<=\d)[eE]\d+", fixed("is part of a power of ten", "write the number out")),
    (
        r"(?<!\w)(?i:then|while|when|whenever|the|must|should|robot|every|after|before)(?!\w)",
        fixed(
            "is a word of a sentence, not of a formula",
            "a formula looks like F_[0:50](A) & G_[0:50](!B)",
        ),
    ),
)
_TABLE = tuple((re.compile(pattern), answer) for pattern, answer in _SOURCES)
