"""Which samples of a trace a formula reads."""

from collections.abc import Sequence

import numpy as np

from core.stl.syntax import Atom, Formula, Interval, children, operand_windows


def samples_read(formula: Formula, steps: int, names: Sequence[str]) -> np.ndarray:
    """Samples on which the robustness at step 0 can depend, as its operators are written.

    Args:
        formula: its atoms are among the names.
        steps: of the trace.
        names: of the columns.

    Returns:
        Booleans [steps, A].
    """
    read = np.zeros((steps, len(names)), bool)
    pending = [(formula, Interval(0, 0))]
    while pending:
        node, window = pending.pop()
        if isinstance(node, Atom):
            read[window.start : window.stop + 1, names.index(node.name)] = True
        pending += zip(children(node), operand_windows(node, window), strict=True)
    return read
