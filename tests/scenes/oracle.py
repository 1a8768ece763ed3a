"""rtamt as the judge of a trace, through a translation that shares nothing with `core.stl`."""

import re

import numpy as np
import rtamt

_INTERVAL = r"_?\[\s*(\d+)\s*[:,]\s*(\d+)\s*\]"
_TOKEN = re.compile(rf"\s*(?:([FGU]){_INTERVAL}|([A-Za-z]\w*)|([()&|!]))")
_WORDS = {"&": " and ", "|": " or ", "!": " not ", "(": "(", ")": ")"}
_MARK = "close after the next operand"
_OPERATORS = {"F": "eventually", "G": "always"}


def to_rtamt(text: str) -> str:
    """Translate the canonical syntax without nested untils.

    rtamt's discrete Until asks rho1 on [t, t') only, ours on [t, t'], so `(p)U(q)` becomes
    `((p) until (p and q))`. Atoms get a prefix because rtamt refuses regions called F, G and H.
    """
    pieces, position = [], 0
    text = text.strip()
    while position < len(text):
        token = _TOKEN.match(text, position)
        assert token, f"cannot translate {text[position:]!r}"
        operator, low, high, name, symbol = token.groups()
        if operator == "U":
            opening = _opening(pieces)
            left = pieces[opening:]
            pieces[opening:] = [" (", *left, f" until[{low}:{high}] (", *left, " and ", _MARK]
        elif operator:
            pieces.append(f"{_OPERATORS[operator]}[{low}:{high}] ")
        elif name:
            pieces.append(f"(m_{name} >= 0)")
        else:
            pieces.append(_WORDS[symbol])
        position = token.end()
    return "".join(_close(pieces))


def rtamt_robustness(text: str, names, margins) -> float:
    """Robustness at step 0 of a formula on margins [T, A] of the named regions."""
    specification = rtamt.StlDiscreteTimeSpecification()
    for name in names:
        specification.declare_var(f"m_{name}", "float")
    specification.declare_var("out", "float")
    specification.spec = "out = " + to_rtamt(text)
    specification.parse()
    columns = np.asarray(margins, float).T
    data: dict = {"time": list(range(columns.shape[1]))}
    data |= {f"m_{name}": column.tolist() for name, column in zip(names, columns, strict=True)}
    return float(specification.evaluate(data)[0][1])


def _opening(pieces: list[str]) -> int:
    """Index at which the parenthesised operand that ends the list begins."""
    depth = 0
    for index in reversed(range(len(pieces))):
        depth += (pieces[index] == ")") - (pieces[index] == "(")
        if depth == 0:
            return index
    raise AssertionError("the left operand of an until must be in parentheses")


def _close(pieces: list[str]) -> list[str]:
    """Replace each mark by two parentheses after the parenthesised operand that follows it."""
    result, open_depths, depth = [], [], 0
    for piece in pieces:
        if piece == _MARK:
            open_depths.append(depth)
            continue
        result.append(piece)
        depth += (piece == "(") - (piece == ")")
        if open_depths and piece == ")" and depth == open_depths[-1]:
            open_depths.pop()
            result.append("))")
    return result
