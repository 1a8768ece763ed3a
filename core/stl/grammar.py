r"""The concrete syntax of formulas, and which names can stand in it without quotes.

`F`, `G` and `U` are operators only where an interval follows, so that regions may bear these
names: in `F_[70:80](F)` the first F is the operator and the second the region.
"""

import re
from functools import cache

from lark import Lark

# What follows an operator's letter: `_[`, `[`, `_{[`; spaces anywhere.
_INTERVAL = r"(?=\s*(?:_\s*)?(?:\{\s*)?\[)"
_WORD_END = r"(?![^\W_])"
_MACRO_END = r"(?![A-Za-z])"
_KEYWORDS = "and|or|not|implies|true|false|eventually|always|until"

# `A_1`, `A_{1}` and `A_{goal}` carry a subscript; a `U_[` right behind it is the operator.
_SUBSCRIPT = rf"[A-Za-z]+_(?:[0-9]+(?=U{_INTERVAL})|\{{\s*\w+\s*\}})"
_PLAIN_NAME = rf"(?!(?i:{_KEYWORDS})(?:(?!\w)|{_INTERVAL}))(?!(?:F|G|U){_INTERVAL})[^\W\d_]\w*"

GRAMMAR = r"""
start: implication

?implication: disjunction (IMPLIES implication)?
?disjunction: conjunction (OR conjunction)*
?conjunction: until (AND until)*
?until: unary (UNTIL interval unary)?
?unary: NOT unary                 -> negation
      | EVENTUALLY interval unary -> eventually
      | ALWAYS interval unary     -> always
      | LPAR implication RPAR     -> parentheses
      | NAME                      -> name
      | QUOTED                    -> quoted
      | LATEX_TEXT                -> latex_text
      | TRUE                      -> true
      | FALSE                     -> false

interval: SUBSCRIPT? LSQB bound SEPARATOR bound RSQB
        | SUBSCRIPT LBRACE LSQB bound SEPARATOR bound RSQB RBRACE
bound: NUMBER UNIT?

EVENTUALLY.2: /(?:F|(?i:eventually)|\\math[a-z]+\s*\{\s*F\s*\})<INTERVAL>/
            | /(?i:eventually)(?!\w)|[◇◊⋄]|\\(?:Diamond|diamond|lozenge)<MACRO_END>/
ALWAYS.2: /(?:G|(?i:always)|\\math[a-z]+\s*\{\s*G\s*\})<INTERVAL>/
        | /(?i:always)(?!\w)|[□◻]|\\(?:Box|square)<MACRO_END>/
UNTIL.2: /(?:U|(?i:until)|\\math[a-z]+\s*\{\s*U\s*\})<INTERVAL>/
       | /(?i:until)(?!\w)/
AND.2: /\\?&&?|\/\\|∧|\\(?:land|wedge)<MACRO_END>|(?i:and)(?!\w)/
OR.2: /\|\|?|\\\/|∨|\\(?:lor|vee)<MACRO_END>|(?i:or)(?!\w)/
NOT.2: /[!~¬]|\\(?:neg|lnot)<MACRO_END>|(?i:not)(?!\w)/
IMPLIES.2: /->|=>|[→⇒⟹]|\\(?:to|implies|rightarrow|Rightarrow)<MACRO_END>|(?i:implies)(?!\w)/
TRUE.2: /⊤|\\top<MACRO_END>|(?i:true)(?!\w)/
FALSE.2: /⊥|\\bot<MACRO_END>|(?i:false)(?!\w)/

NAME: /<SUBSCRIPT_NAME>|<PLAIN_NAME>/
QUOTED: /"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'/
LATEX_TEXT: /\\(?:text|mathrm|mathit|mathsf|mathtt|texttt)\s*\{[^{}\n]*\}/
NUMBER: /[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)/
UNIT: /(?:ms|s)(?!\w)/
SEPARATOR: ":" | ","
SUBSCRIPT: "_"
LPAR: "("
RPAR: ")"
LSQB: "["
RSQB: "]"
LBRACE: "{"
RBRACE: "}"

// Spaces, and what a formula pasted from LaTeX brings along.
%ignore /[\s\u200b\ufeff]+/
%ignore /\$+|\\[,;:!\s]|\\(?:quad|qquad|left|right|bigl?|bigr|Bigl?|Bigr)(?![A-Za-z])/
"""


@cache
def formula_parser() -> Lark:
    """Return the LALR parser, built on first use."""
    parts = {
        "<INTERVAL>": _INTERVAL,
        "<MACRO_END>": _MACRO_END,
        "<SUBSCRIPT_NAME>": _SUBSCRIPT,
        "<PLAIN_NAME>": _PLAIN_NAME,
    }
    grammar = GRAMMAR
    for placeholder, pattern in parts.items():
        grammar = grammar.replace(placeholder, pattern)
    return Lark(grammar, parser="lalr", lexer="contextual", propagate_positions=True)


def join_subscript(name: str) -> str:
    """Drop the underscore of a numeric subscript: `A_1` and `A_{1}` are `A1`."""
    name = re.sub(r"_\{\s*(\w+)\s*\}\Z", r"_\1", name)
    return re.sub(r"\A([A-Za-z]+)_([0-9]+)\Z", r"\1\2", name)


def is_plain_name(name: str) -> bool:
    """Whether the name means itself when it is written without quotes."""
    return re.fullmatch(_PLAIN_NAME, name) is not None and join_subscript(name) == name
