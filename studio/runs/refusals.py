"""What is said of a formula that does not decompose: the part as typed, and what to write."""

from core.decompose import DecompositionError, stronger
from core.errors import UserError
from core.quoting import LONGEST_FORMULA, shown
from core.stl import Formula, Span, one_line, to_text, walk

LONGEST_OFFER = 800
"""Characters; a longer formula is not offered."""


def refusal(error: DecompositionError, text: str, formula: Formula) -> UserError:
    """The error in the words of the text, with a stronger formula that decomposes if there is one.

    Args:
        error: what `decompose` raised.
        text: the formula as typed.
        formula: what was read from the text.
    """
    message = str(error)
    if error.span is not None:
        typed = one_line(text[slice(*error.span)])
        place = _place(text, error.span)
        normal = "" if error.formula in walk(formula) else _normal_form(error.formula)
        quote = shown(typed, LONGEST_FORMULA)
        message = f"cannot decompose `{quote}` ({place}){normal}: {error.reason}"
    offer = stronger(formula)
    if offer is not None and len(to_text(offer)) <= LONGEST_OFFER:
        message += f". Stronger, and it decomposes: {to_text(offer)}"
    return UserError(message)


def _normal_form(formula: Formula) -> str:
    """What was written with `->` or below a negation."""
    return f", that is `{shown(to_text(formula), LONGEST_FORMULA)}`"


def _place(text: str, span: Span) -> str:
    """`columns 3-9`, with the line where there is more than one."""
    start = text.rfind("\n", 0, span.start) + 1
    last = text.rfind("\n", 0, max(span.stop - 1, span.start)) + 1
    line = text.count("\n", 0, start) + 1
    if last > start:
        end = text.count("\n", 0, last) + 1
        return (
            f"line {line}, column {span.start - start + 1} to line {end}, column {span.stop - last}"
        )
    columns = f"columns {span.start - start + 1}-{span.stop - start}"
    return f"line {line}, {columns}" if "\n" in text.strip() else columns
