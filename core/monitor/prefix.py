"""What the beginning of a trace decides, whatever follows."""

from collections.abc import Sequence

import numpy as np

from core.monitor.signals import FailureSignals
from core.stl import Formula, check_columns, fold_constants, horizon


def falsified_at(formula: Formula, margins: np.ndarray, names: Sequence[str]) -> int | None:
    """The first step by which a formula has failed, whatever its atoms do after the margins end.

    Unknown steps have the margin 0, at which neither an atom nor its negation fails. None does not
    promise that a robot can still satisfy the formula: atoms are taken to be free.

    Args:
        formula: its atoms are among the names.
        margins: [k + 1, A] of the beginning of a trace [m].
        names: of the columns.

    Raises:
        TraceError: margins of a wrong shape, or an atom without margins.
    """
    check_columns(formula, margins, names)
    known = np.asarray(margins, float)[:, : len(names)]
    ahead = max(0, horizon(formula) + 1 - len(known))
    trace = np.concatenate([known, np.zeros((ahead, known.shape[1]))])
    step = FailureSignals(trace, names)[fold_constants(formula)][0]
    return None if step == np.inf else int(max(step, 0))  # -inf: false from the start
