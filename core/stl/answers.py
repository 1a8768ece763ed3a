"""Answers to what other languages have: what is wrong with it, and what to write instead.

Each takes the match of a pattern of `foreign` and returns the problem, which follows the quoted
text, and the hint.
"""

import re
from collections.abc import Callable

from core.quoting import shown

Match = re.Match[str]
Answer = Callable[[Match], tuple[str, str]]

NAME = r"(?<!\w)[^\W\d]\w{0,80}"
PARENTHESIS = r"\([^()\n]{0,80}\)"
OPERAND = rf"(?:!\s*)?(?:{NAME}|{PARENTHESIS})"


def comparison(match: Match) -> tuple[str, str]:
    """`x > 3`."""
    typed = match[0].strip()
    if not re.search(r"\d", typed) and (equal := re.fullmatch(r"(\w+)\s*([=!])=\s*(\w+)", typed)):
        sign = "<->" if equal[2] == "=" else "xor"
        return "compares", f"write {equal[1]} {sign} {equal[3]}"
    return (
        "compares numbers; an atom is the name of a region",
        f"draw a region where {shown(typed)} holds and write its name",
    )


def open_interval(match: Match) -> tuple[str, str]:
    """`[0,5)`."""
    opening, low, unit, high, other, closing = match.groups()
    whole = not unit.strip() and not other.strip() and low.isdigit() and high.isdigit()
    problem = "is an interval without one of its ends or both; intervals are closed"
    if not whole:
        return problem, f"write [{low}{unit}:{high}{other}], with both ends"
    first, last = int(low) + (opening != "["), int(high) - (closing != "]")
    if first > last:
        return problem, "no step is left in it"
    both = f", or [{low}:{high}] with both ends" if (opening, closing) == ("(", ")") else ""
    return problem, f"write [{first}:{last}]{both}"


def next_step(match: Match) -> tuple[str, str]:
    """`X A`."""
    steps = match["steps"] or "1"
    return (
        "is the operator next, which is written with F",
        f"write F_[{steps}:{steps}]({_bare(match['operand'])})",
    )


def past(match: Match) -> tuple[str, str]:
    """`once_[0:10](A)`."""
    interval, operand = _interval(match[2]), _bare(match["operand"])
    after = "A" if operand == "B" else "B"
    return (
        "looks back; the operators look forward only",
        "begin with what comes first, as in "
        f"F_[0:50]({operand} & F{interval}({after})): {after} comes later",
    )


def since(match: Match) -> tuple[str, str]:
    """`A since B`."""
    left, right = _bare(match["left"]), _bare(match["right"])
    return (
        "looks back; the operators look forward only",
        f"begin with what comes first, as in F_[0:50]({right} & G{_interval(match[3])}({left}))",
    )


def release(match: Match) -> tuple[str, str]:
    """`A R B`."""
    left, right = _operand(match["left"]), _operand(match["right"])
    both, interval = _bare(match["right"]), _interval(match[3])
    start, stop = _bounds(interval)
    problem = "is the operator release, which is written with U and G"
    if not start:
        return problem, f"write ({right} U{interval} {left}) | G{interval}({both})"
    later = f"F_[{start}:{start}]({right} U_[0:{stop - start}] {left})"
    before = f"F_[0:{start - 1}]({_bare(match['left'])})"
    return problem, f"write {before} | {later} | G{interval}({both})"


def weak_until(match: Match) -> tuple[str, str]:
    """`A W B`."""
    left, right, interval = match["left"], match["right"], _interval(match[3])
    start, stop = _bounds(interval)
    throughout = f"G_[0:{stop}]({_bare(left)})" if start else f"G{interval}({_bare(left)})"
    return (
        "is the operator weak until, which is written with U and G",
        f"write ({_operand(left)} U{interval} {_operand(right)}) | {throughout}",
    )


def strong_release(match: Match) -> tuple[str, str]:
    """`A M B`."""
    left, right = _operand(match["left"]), _operand(match["right"])
    hint = f"write {right} U{_interval(match[3])} {left}"
    return "is the operator strong release, which is written with U", hint


def edge(match: Match) -> tuple[str, str]:
    """`rise(A)`."""
    name = _bare(match["operand"])
    before, after = (f"!{name}", name) if match[1][0].lower() in "rp" else (name, f"!{name}")
    return (
        "asks for a change between two steps",
        f"write {before} & F_[1:1]({after}), true at the step before the change",
    )


def call(match: Match) -> tuple[str, str]:
    """`Eventually(A, [0,30])`."""
    letter = {"e": "F", "f": "F", "u": "U"}.get(match[1][0].lower(), "G")
    operands = [_bare(part) for part in re.findall(OPERAND, match[2]) if part]
    interval = f"_[{match[3]}:{match[4]}]"
    problem = "is a call of a function; the interval stands behind the operator"
    if letter == "U":
        left, right = (*map(_operand, operands), "A", "B")[:2]
        return problem, f"write {left} U{interval} {right}"
    return problem, f"write {letter}{interval}({operands[0] if operands else 'A'})"


def operator_as_call(match: Match) -> tuple[str, str]:
    """`And(A, B)`."""
    sign = {"and": "&", "or": "|", "implies": "->", "xor": "xor", "iff": "<->", "until": "U"}
    left, right = match[2], match[3]
    hint = f"write {left} {sign[match[1].lower()]} {right}"
    return "is a call of a function; operators stand between their operands", hint


def place_in_words(match: Match) -> tuple[str, str]:
    """`avoid O`."""
    name = match[2].strip("() ")
    negative = match[1].lower().split()[0] in {"avoid", "outside", "never", "leave"}
    return (
        "says where in words; an atom is the name of a region alone",
        f"write {'!' if negative else ''}{name}",
    )


def unit_of_time(match: Match) -> tuple[str, str]:
    """`5 min`."""
    number, unit = match[1], match[2].lower()
    problem = f"has the unit {shown(match[2])}; the units are s and ms"
    if unit.startswith("step"):
        return problem, f"numbers without a unit are steps: write {number}"
    if unit.startswith(("us", "µs", "ns", "micro", "nano")):
        return problem, "a step is longer than that"
    factor = {"m": 60, "h": 3600}.get(unit[0], 1)
    if unit.startswith(("ms", "msec", "milli")):
        return problem, f"write {number} ms"
    return problem, f"write {float(number) * factor:g} s"


def weight(match: Match) -> tuple[str, str]:
    """`^w1`."""
    return "is a weight; formulas have none", f"leave out {shown(match[0].strip())}"


def interval_in_words(match: Match) -> tuple[str, str]:
    """`between 0 and 30`."""
    first, last = (match[1], match[2]) if match[1] else ("0", match[3])
    return (
        "gives an interval in words",
        f"write it behind the operator, as in F_[{first}:{last}](A)",
    )


def fixed(problem: str, hint: str) -> Answer:
    """The same answer to every match; `{}` in the hint is what was typed."""
    return lambda match: (problem, hint.replace("{}", shown(match[0].strip())))


def _bare(operand: str | None) -> str:
    """An operand without its parentheses; `A` for none."""
    inner = (operand or "A").strip()
    return inner[1:-1].strip() if inner.startswith("(") else inner


def _operand(operand: str | None) -> str:
    """An operand that can stand beside U."""
    inner = _bare(operand)
    return inner if re.fullmatch(r"\w+", inner) else f"({inner})"


def _interval(typed: str | None) -> str:
    return "_" + re.sub(r"\s*[,;]\s*", ":", typed) if typed else "_[0:50]"


def _bounds(interval: str) -> tuple[int, int]:
    """Bounds in whole steps; (0, 0) if they are not."""
    found = re.fullmatch(r"_\[\s*(\d+)\s*:\s*(\d+)\s*\]", interval)
    return (int(found[1]), int(found[2])) if found else (0, 0)


def leads_to(match: Match) -> tuple[str, str]:
    """`A ~> B`."""
    left, right = match["left"], match["right"]
    hint = f"write G_[0:50]({_operand(left)} -> F_[0:50]({_bare(right)}))"
    return "is the operator leads to, which is written with G and F", hint


def conditional(match: Match) -> tuple[str, str]:
    """`if A then B`."""
    hint = f"write {_operand(match['left'])} -> ..."
    return "is an implication in words", hint
