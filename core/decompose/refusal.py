"""Why a subformula cannot be kept up throughout a window."""

from core.stl import Eventually, Formula, Or

_ALLOWED = (
    "throughout a window (inside G, on the left of U, or on the right of a negated U) only state "
    "formulas, G, conjunctions of these, and, in a window of fixed length, F are possible"
)


def refusal(formula: Formula) -> str:
    """Say why, and what is possible instead."""
    match formula:
        case Eventually():
            reason = "F must recur in a window whose length depends on a time variable"
        case Or():
            reason = "the choice between temporal formulas would have to be made at every step"
        case _:
            reason = "until would need a time variable for every step"
    return f"{reason}; {_ALLOWED}"
