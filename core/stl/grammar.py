r"""The concrete syntax of formulas, and which names can stand in it without quotes.

`F`, `G` and the short words of other dialects (`ev`, `alw`) are operators only where an interval
or an operand follows, so that regions may bear these names: in `F_[70:80](F)` and in `F F` the
first F is the operator and the second the region. No name stands before an operand otherwise.
The text is `plain` already.
"""

import re
from functools import cache

from lark import Lark

_MACRO_END = r"(?![A-Za-z])"
_DIAMOND = "◇◊⋄♢⬦⬨◆♦⟡"
_BOX = "□◻▢☐⬜◽▫■◼"
_MACROS = {
    "EVENTUALLY": "Diamond|diamond|lozenge|diamondsuit|meddiamond",
    "ALWAYS": "Box|square|Square|medsquare",
    "NOT": "neg|lnot|sim",
}
_WRAPPER = r"\\(?:text[a-z]*|math[a-z]+|operatorname\*?)"

# What begins an operand: a sign, or a word that is no binary operator.
_BINARY = "and|or|implies|until|iff|xor"
_WORD = rf"(?!(?i:{_BINARY})(?!\w))(?!U(?![^\W_]))[^\W\d_]"
_SIGN = (
    rf"[(!~¬∼\"'{{⊤⊥{_DIAMOND}{_BOX}]|<\s*>|\[\s*\]"
    rf"|\\(?:{'|'.join(_MACROS.values())}|top|bot){_MACRO_END}"
    rf"|{_WRAPPER}\s*\{{(?!\s*(?i:{_BINARY}|U)\s*\}})"
)
_OPERAND = rf"(?:\s*(?:{_SIGN})|\s+{_WORD})"
_JOINED_OPERAND = rf"\s*(?:{_SIGN}|{_WORD})"

# What follows an operator: `_[`, `[`, `_{[`, `_{<=`; or `_5`, `_{0,5}` before an operand.
_NUMBER = r"[+-]?(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)"
_COMPARISON = rf"(?:[<>]=?|[≤⩽≦≥⩾≧]|=<?|\\(?:leq?|leqslant|geq?|geqslant){_MACRO_END})"
_INTERVAL = rf"(?=\s*(?:[_^]\s*(?:\{{\s*)?(?:\[|{_COMPARISON})|(?:\{{\s*)?\[(?!\s*\])))"
_SUBSCRIPTED = (
    rf"(?=\s*[_^]\s*(?:{_NUMBER}{_OPERAND}|\{{\s*{_NUMBER}[^{{}}\n]{{0,60}}\}}{_JOINED_OPERAND}))"
)
# Letters may be joined: `GF(A)`.
_FOLLOWED = (
    rf"(?:{_INTERVAL}|{_SUBSCRIPTED}|(?=[FG]{{0,8}}(?:{_INTERVAL}|{_SUBSCRIPTED}|{_OPERAND})))"
)
_KEYWORDS = "and|or|not|implies|true|false|eventually|always|until"

# `A_1`, `A_{1}` and `A_{goal}` carry a subscript; a `U_[` right behind it is the operator.
_SUBSCRIPT = (
    rf"[A-Za-z]+_(?:[0-9]+(?=U{_INTERVAL})|\{{\s*(?:\w+|{_WRAPPER}\s*\{{\s*\w+\s*\}})\s*\}})"
)
_PLAIN_NAME = rf"(?!(?i:{_KEYWORDS})(?:(?!\w)|{_INTERVAL}))(?!(?:F|G|U){_INTERVAL})[^\W\d_]\w*"

GRAMMAR = r"""
start: LABEL? equivalence STOP*

?equivalence: implication (IFF equivalence)?
?implication: exclusive (IMPLIES implication)?
?exclusive: disjunction (XOR disjunction)*
?disjunction: conjunction (OR conjunction)*
?conjunction: until (AND until)*
?until: unary (UNTIL interval? unary)?
?unary: NOT unary                  -> negation
      | EVENTUALLY interval? unary -> eventually
      | ALWAYS interval? unary     -> always
      | LPAR equivalence RPAR      -> parentheses
      | LBRACE equivalence RBRACE  -> parentheses
      | NAME                       -> name
      | QUOTED                     -> quoted
      | LATEX_TEXT                 -> latex_text
      | TRUE                       -> true
      | FALSE                      -> false

interval: SUBSCRIPT? _bracketed
        | SUBSCRIPT? LBRACE _bracketed RBRACE
        | SUBSCRIPT LBRACE _bounds RBRACE
        | SUBSCRIPT count
        | SUBSCRIPT COMPARISON count
        | SUBSCRIPT LBRACE COMPARISON bound RBRACE
_bracketed: LSQB _bounds RSQB
          | LSQB bound SEPARATOR open RPAR
_bounds: bound (SEPARATOR (bound | open))?
bound: NUMBER UNIT?
count: NUMBER -> bound
open: INFINITY

EVENTUALLY.2: /(?:F|<WRAPPER>\s+F|(?i:ev|finally)|<IN F|eventually|ev|finally>)<FOLLOWED>/
            | /(?i:eventually)(?:(?!\w)|<INTERVAL>)|[<DIAMOND>]|<\s*>|\\(?:<EVENTUALLY>)<MACRO_END>/
ALWAYS.2: /(?:G|<WRAPPER>\s+G|(?i:alw|globally)|<IN G|always|alw|globally>)<FOLLOWED>/
        | /(?i:always)(?:(?!\w)|<INTERVAL>)|[<BOX>]|\[\s*\]|\\(?:<ALWAYS>)<MACRO_END>/
UNTIL.2: /U(?![^\W_])|<WRAPPER>\s+U(?!\w)|(?i:until)(?:(?!\w)|<INTERVAL>)|<IN U|until>/
AND.2: /\\?&&?|\/\\|[∧⋀]|\\(?:land|wedge)<MACRO_END>|(?i:and)(?!\w)|<IN and>/
OR.2: /\|\|?|\\\/|[∨⋁]|\\(?:lor|vee)<MACRO_END>|(?i:or)(?!\w)|<IN or>/
NOT.2: /[!~¬∼]|\\(?:<NOT>)<MACRO_END>|(?i:not)(?!\w)|<IN not>/
IMPLIES.2: /--?>|==?>|[→⇒⟹⟶⊃]|(?i:implies)(?!\w)|<IN implies>/
         | /\\(?:to|implies|supset|(?:long|Long)?rightarrow|Rightarrow)<MACRO_END>/
IFF.2: /<--?>|<==?>|[↔⇔⟺⟷≡]|(?i:iff)(?!\w)|<IN iff>/
     | /\\(?:iff|equiv|(?:long|Long)?leftrightarrow|Leftrightarrow)<MACRO_END>/
XOR.2: /[⊕⊻]|\\(?:oplus|veebar)<MACRO_END>|(?i:xor)(?!\w)|<IN xor>/
TRUE.3: /⊤|\\top<MACRO_END>|(?i:true)(?!\w)|<IN true>/
FALSE.3: /⊥|\\bot<MACRO_END>|(?i:false)(?!\w)|<IN false>/

LABEL.3: /\A\s*(?:\\[A-Za-z]+(?:_\{?\w+\}?)?|[^\W\d]\w*)\s*(?::=|≔|:|=(?![=<>]))/
STOP: /[;.,]/
NAME: /<SUBSCRIPT_NAME>|<PLAIN_NAME>/
QUOTED: /"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'/
LATEX_TEXT: /<WRAPPER>\s*\{[^{}\n]*\}(?:\s*_\s*(?:[0-9]+|\{\s*\w+\s*\}))?/
NUMBER: /<NUMBER>/
INFINITY: /\+?\s*(?:∞|\\infty<MACRO_END>|(?i:inf|infty|infinity|end)(?!\w)|T(?!\w))/
COMPARISON: /<COMPARISON>/
UNIT: /(?:ms|s)(?!\w)|<WRAPPER>\s*\{\s*(?:ms|s)\s*\}/
SEPARATOR: /[:,;]|\.\./
SUBSCRIPT: /[_^]/
LPAR: "("
RPAR: ")"
LSQB: "["
RSQB: "]"
LBRACE: "{"
RBRACE: "}"

%ignore /\s+/
"""


@cache
def formula_parser() -> Lark:
    """Return the LALR parser, built on first use."""
    parts = {
        "<FOLLOWED>": _FOLLOWED,
        "<INTERVAL>": _INTERVAL,
        "<MACRO_END>": _MACRO_END,
        "<WRAPPER>": _WRAPPER,
        "<SUBSCRIPT_NAME>": _SUBSCRIPT,
        "<PLAIN_NAME>": _PLAIN_NAME,
        "<NUMBER>": _NUMBER,
        "<COMPARISON>": _COMPARISON,
        "<DIAMOND>": _DIAMOND,
        "<BOX>": _BOX,
        **{f"<{name}>": macros for name, macros in _MACROS.items()},
    }
    wrapped = r"<WRAPPER>\\s*\\{\\s*(?i:\1)\\s*\\}"
    grammar = re.sub(r"<IN ([^>]*)>", wrapped, GRAMMAR)
    for placeholder, pattern in parts.items():
        grammar = grammar.replace(placeholder, pattern.replace("/", r"\/"))
    return Lark(grammar, parser="lalr", lexer="contextual", propagate_positions=True)


def join_subscript(name: str) -> str:
    r"""Drop the underscore of a numeric subscript: `A_1` and `A_{1}` are `A1`."""
    name = re.sub(rf"_\{{\s*(?:{_WRAPPER}\s*\{{\s*)?(\w+)[\s}}]*\}}\Z", r"_\1", name)
    return re.sub(r"\A([A-Za-z]+)_([0-9]+)\Z", r"\1\2", name)


def is_plain_name(name: str) -> bool:
    """Whether the name means itself when it is written without quotes."""
    return re.fullmatch(_PLAIN_NAME, name) is not None and join_subscript(name) == name
