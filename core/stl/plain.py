r"""A formula's text with every character that has a plainer equal replaced by it.

The result has the same length, so that places in it are places in the text as typed. Comments,
spaces of LaTeX and invisible marks become spaces, `［０：５］` becomes `[0:5]`, `𝐅` becomes `F`.
What stands in quotes or in `\text{...}` stays, and so do letters other than F, G and U: they
may be a region's name.
"""

import re
from unicodedata import normalize

_INVISIBLE = "\u00ad\u200b\u200c\u200d\u200e\u200f\u2060\ufeff"
_WIDE = range(0xFF01, 0xFF5F)
_MATHEMATICAL = range(0x1D400, 0x1D800)
_OPERATORS = "FGU"


def _plain_characters() -> dict[int, str]:
    table = dict.fromkeys(map(ord, _INVISIBLE), " ")
    for code in (*_WIDE, *_MATHEMATICAL):
        plain = normalize("NFKC", chr(code))
        if len(plain) == 1 and plain.isascii() and (plain in _OPERATORS or not plain.isalpha()):
            table[code] = plain
    alike = {
        "\u2131": "F",  # script F
        "−‐‑–": "-",
        "∶：": ":",
        "，、": ",",
        "；": ";",
        "［〔【⟦": "[",
        "］〕】⟧": "]",
        "（": "(",
        "）": ")",
        "“”„«»＂": '"',
        "‘’＇": "'",
    }
    table |= {ord(each): plain for characters, plain in alike.items() for each in characters}
    return table


_PLAIN = _plain_characters()

# What stays as it is, then what is left out, then what is replaced character by character.
_PIECES = re.compile(
    r"""
    (?P<kept>
        "(?:[^"\\\n]|\\.)*"? | '(?:[^'\\\n]|\\.)*'?
        | \\(?:text[a-z]*|math[a-z]+|operatorname\*?)\s*\{[^{}\n]*\}
        | /\\ | \\/
    )
    | (?P<blank>
        //[^\n]* | \#[^\n]* | /\*.*?\*/
        | \$+ | \\[,;:!\s] | \\\\ | \\[()\[\]]
        | \\(?:quad|qquad|left|right|[bB]igg?[lr]?|displaystyle)(?![A-Za-z])
        | \\(?:begin|end)\s*\{[A-Za-z*]*\}
    )
    | (?P<unclosed>/\*.*)
    | (?P<other>.)
    """,
    re.VERBOSE | re.DOTALL,
)
_COMMENT = re.compile(r"//|#|/\*")
_MARK = re.compile(r"[^\n]")


def plain(text: str) -> str:
    """Replace what has a plainer equal; the length stays the same."""
    return _PIECES.sub(_replaced, text)


def one_line(text: str) -> str:
    """The text on one line, without its comments, which would swallow what follows."""
    kept = _PIECES.sub(lambda piece: " " if _COMMENT.match(piece[0]) else piece[0], text)
    return " ".join(kept.split())


def _replaced(piece: re.Match[str]) -> str:
    match piece.lastgroup:
        case "kept" | "unclosed":
            return piece[0]
        case "blank":
            return _MARK.sub(" ", piece[0])
    return piece[0].translate(_PLAIN)
