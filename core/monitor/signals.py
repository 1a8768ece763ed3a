"""Signals of all subformulas of a formula along one trace.

Besides the robustness, a subformula f has at each step t the *failure step* V(f, t): the first
step by which f at t has failed whatever the signals of its atoms do afterwards, +inf if it holds.
With S(A, t) = t where mu_A(t) > 0 and +inf elsewhere,

    V(A, t) = t where mu_A(t) < 0, +inf elsewhere        V(!A, t) = S(A, t)
    V(f & g, t) = min(V(f, t), V(g, t))                  V(f | g, t) = max(V(f, t), V(g, t))
    V(G_[a:b] f, t) = min over the window of V(f, .)     V(F_[a:b] f, t) = max over it

which is the robustness of f where an atom stands for V(A) below an even number of negations and
for -S(A) below an odd number. Hence one evaluator serves both.

Dimensions: T steps, A atoms.
"""

from collections.abc import Sequence

import numpy as np

from core.stl import (
    Atom,
    Formula,
    Implies,
    Not,
    TraceError,
    children,
    horizon,
    robustness_signal,
    with_children,
)


class Signals:
    """Robustness of subformulas over time, each distinct one computed once."""

    def __init__(self, margins: np.ndarray, names: Sequence[str]):
        """Take one trace.

        Args:
            margins: [T, A] of the named regions in [m]; further columns are ignored.
            names: of the columns.

        Raises:
            TraceError: margins of another shape.
        """
        margins = np.asarray(margins, float)
        if margins.ndim != 2 or not len(margins) or margins.shape[1] < len(names):
            raise TraceError(
                f"the margins have shape {margins.shape}; expected [steps, atoms] with a column "
                f"for each of the {len(names)} names"
            )
        self.margins, self.names = margins, tuple(names)
        self._known: dict[Formula, np.ndarray] = {}

    def __getitem__(self, formula: Formula) -> np.ndarray:
        """Robustness at each step that the trace decides [max(0, T - horizon)]."""
        if formula not in self._known:
            self._known[formula] = self._computed(formula)
        return self._known[formula]

    def _computed(self, formula: Formula) -> np.ndarray:
        parts = children(formula)
        if not parts:
            return robustness_signal(formula, self.margins, self.names)
        signals = [self[part] for part in parts]
        length = min(map(len, signals))
        stand_ins = tuple(Atom(str(index)) for index in range(len(parts)))
        shallow = with_children(formula, stand_ins)
        if length <= horizon(shallow):
            return np.zeros(0)
        columns = np.stack([signal[:length] for signal in signals], axis=-1)
        return robustness_signal(shallow, columns, [atom.name for atom in stand_ins])


class FailureSignals:
    """Failure steps of subformulas; see the module."""

    def __init__(self, margins: np.ndarray, names: Sequence[str]):
        """Take one trace: margins [T, A] of the named regions."""
        margins = np.asarray(margins, float)
        steps = np.arange(len(margins), dtype=float)[:, None]
        margins = margins[:, : len(names)]
        columns = [np.where(margins < 0, steps, np.inf), np.where(margins > 0, -steps, -np.inf)]
        signed = [sign + name for sign in "+-" for name in names]
        self._signals = Signals(np.concatenate(columns, axis=1), signed)

    def __getitem__(self, formula: Formula) -> np.ndarray:
        """First step by which the formula has failed [max(0, T - horizon)]; +inf if it holds."""
        return self._signals[_by_polarity(formula, "+")]


def _by_polarity(formula: Formula, sign: str) -> Formula:
    """Prefix each atom with the sign of its place: `-` below an odd number of negations."""
    if isinstance(formula, Atom):
        return Atom(sign + formula.name)
    other = "-" if sign == "+" else "+"
    signs = [sign] * len(children(formula))
    if isinstance(formula, Not | Implies):
        signs[0] = other
    parts = tuple(map(_by_polarity, children(formula), signs))
    return with_children(formula, parts)
