"""Which margin of a trace decided the robustness of a formula.

Min and max choose: the robustness is the margin of one atom at one step, or its negative.
"""

from typing import NamedTuple

import numpy as np

CLOSE = 1e-6
"""Largest difference between a robustness and the margin that decided it [m]."""


class Deciding(NamedTuple):
    """Where a robustness comes from."""

    step: int
    atom: int
    """Index."""
    sign: int
    """1; -1 of a negated atom."""


def deciding_margin(robustness: float, margins: np.ndarray) -> Deciding | None:
    """The first margin of a trace [L + 1, A] that is as large as its robustness [m].

    None where there is none: the robustness may be a bound on what happens between the steps.
    """
    close = np.argwhere(np.abs(np.abs(margins) - abs(robustness)) < CLOSE)
    if not len(close):
        return None
    step, atom = (int(number) for number in close[0])
    return Deciding(step, atom, 1 if (margins[step, atom] >= 0) == (robustness >= 0) else -1)
