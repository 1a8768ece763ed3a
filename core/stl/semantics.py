r"""Quantitative semantics: how robustly a trace satisfies a formula.

With rho(f, t) the robustness of f at step t (paper Sec. 3; Donze and Maler 2010) and mu_A the
margin of atom A:

    rho(A, t)            = mu_A(t)                      rho(true, t) = +inf
    rho(!f, t)           = -rho(f, t)
    rho(f & g, t)        = min(rho(f, t), rho(g, t))
    rho(F_[a:b] f, t)    = max over t' in [t + a, t + b] of rho(f, t')
    rho(f U_[a:b] g, t)  = max over t' in [t + a, t + b] of
                               min(rho(g, t'), min over t'' in [t, t'] of rho(f, t''))

and f holds iff rho(f, 0) >= 0. An until is split where its window begins,

    f U_[a:b] g = G_[0:a-1] f  &  (f U_[0:b-a] g, a steps later),

and windows are taken over blocks (`algebra`), so that every operator takes linear time.

A formula is evaluated from the top down, each operand at the steps that are asked of it and at
no other (`operand_windows`): a sample that the formula does not read has no influence, not even
NaN or an infinite number. Where a sample that it does read is NaN, so is the robustness, and the
formula does not hold.

Dimensions: T steps of a trace, A atoms; leading axes are a batch. NumPy arrays give NumPy
arrays; JAX arrays give JAX arrays, under `jit` and `grad` too.
"""

from collections.abc import Callable, Sequence
from functools import reduce

import jax
import jax.numpy as jnp
import numpy as np

from core.errors import UserError
from core.quoting import listed
from core.stl.algebra import Algebra, Array, exact_algebra, smooth_algebra
from core.stl.normal_form import fold_constants
from core.stl.syntax import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    atom_names,
    children,
    horizon,
    operand_windows,
)

# From an atom or a constant, and a window, to its values at the steps of the window.
_Leaf = Callable[[Atom | Constant, Interval], Array]


_START = Interval(0, 0)


class TraceError(UserError):
    """A trace that cannot decide a formula."""


def robustness_signal(formula: Formula, margins: Array, names: Sequence[str]) -> Array:
    """Robustness at every step that the trace decides.

    Args:
        formula: its atoms are among the names.
        margins: [..., T, A] margins of the named regions; further columns are ignored.
        names: names of the columns.

    Returns:
        [..., T - horizon(formula)], of the margins' floating type.
    """
    margins = _checked(formula, margins, names)
    decided = Interval(0, margins.shape[-2] - horizon(formula) - 1)
    algebra = exact_algebra(margins)
    return _signal(formula, decided, _leaves(margins, names, algebra), algebra)


def robustness(formula: Formula, margins: Array, names: Sequence[str]) -> Array:
    """Robustness at step 0: [...] for margins [..., T, A]."""
    margins = _checked(formula, margins, names)
    algebra = exact_algebra(margins)
    return _signal(formula, _START, _leaves(margins, names, algebra), algebra)[..., 0]


def satisfied(formula: Formula, margins: Array, names: Sequence[str]) -> Array:
    """Whether the trace satisfies the formula at step 0: Booleans [...]."""
    return robustness(formula, margins, names) >= 0


def smooth_robustness(
    formula: Formula, margins: Array, names: Sequence[str], temperature: float | jax.Array
) -> Array:
    """Robustness at step 0 with every max and min replaced by log-sum-exp.

    max(x) becomes temperature * log(sum(exp(x / temperature))), and min its dual. The result
    tends to `robustness` as the temperature tends to 0, and its gradient reaches every step
    within the horizon; it is neither an upper nor a lower bound.

    Args:
        formula: its atoms are among the names.
        margins: [..., T, A], finite.
        names: names of the columns.
        temperature: > 0, in the unit of the margins.

    Returns:
        [...].
    """
    if isinstance(temperature, int | float) and not temperature > 0:
        raise ValueError(f"the temperature must be positive: {temperature}")
    margins = _checked(formula, margins, names)
    scaled = margins / temperature
    algebra = smooth_algebra(scaled)
    # Infinities have no place in sums of exponentials.
    leaves = _leaves(scaled, names, algebra)
    return _signal(fold_constants(formula), _START, leaves, algebra)[..., 0] * temperature


def check_trace(formula: Formula, margins: Array, names: Sequence[str]) -> None:
    """Refuse margins [..., T, A] that do not decide a formula.

    Raises:
        TraceError: margins of a wrong shape, an atom without margins, or too few steps.
    """
    check_columns(formula, margins, names)
    steps, ahead = np.shape(margins)[-2], horizon(formula)
    if steps <= ahead:
        raise TraceError(
            f"the trace has {steps} steps; the formula looks {ahead} steps ahead and needs at "
            f"least {ahead + 1}"
        )


def check_columns(formula: Formula, margins: Array, names: Sequence[str]) -> None:
    """Refuse margins of a wrong shape, or without a column for an atom of the formula."""
    shape = np.shape(margins)
    if len(shape) < 2 or shape[-1] < len(names):
        raise TraceError(
            f"the margins have shape {shape}; expected [..., steps, atoms] with a column for each "
            f"of the {len(names)} names"
        )
    unknown = [name for name in atom_names(formula) if name not in names]
    if unknown:
        raise TraceError(
            f"the trace has no margins for {listed(unknown)}; it has {listed(list(names))}"
        )


def _checked(formula: Formula, margins: Array, names: Sequence[str]) -> Array:
    """Margins as floating-point numbers, after checking that they decide the formula."""
    check_trace(formula, margins, names)
    if not isinstance(margins, jax.Array):
        margins = np.asarray(margins)
    if not jnp.issubdtype(margins.dtype, jnp.floating):
        margins = margins.astype(float)
    return margins


def _leaves(margins: Array, names: Sequence[str], algebra: Algebra) -> _Leaf:
    columns = {name: index for index, name in reversed(list(enumerate(names)))}

    def leaf(node: Atom | Constant, window: Interval) -> Array:
        first, last = window
        if isinstance(node, Atom):
            return margins[..., first : last + 1, columns[node.name]]
        value = np.inf if node.value else -np.inf
        return algebra.xp.full((*margins.shape[:-2], last - first + 1), value, margins.dtype)

    return leaf


def _signal(formula: Formula, window: Interval, leaf: _Leaf, algebra: Algebra) -> Array:
    """Values [..., W] of the formula at the W steps of a window."""
    below = [
        _signal(operand, inner, leaf, algebra)
        for operand, inner in zip(children(formula), operand_windows(formula, window), strict=True)
    ]
    match formula:
        case Constant() | Atom():
            return leaf(formula, window)
        case Not():
            return -below[0]
        case And():
            return reduce(algebra.meet, below)
        case Or():
            return reduce(algebra.join, below)
        case Implies():
            return algebra.join(-below[0], below[1])
        case Eventually(interval=(a, b)):
            return algebra.slide(below[0], b - a + 1)
        case Always(interval=(a, b)):
            return -algebra.slide(-below[0], b - a + 1)
        case Until(interval=interval):
            return _until(interval, below[0], below[1], algebra)
    raise TypeError(f"not a formula: {formula!r}")


def _until(interval: Interval, left: Array, right: Array, algebra: Algebra) -> Array:
    """The left side from the first step of the window on, the right side a steps later."""
    a, b = interval
    met = algebra.slide_until(left[..., a:], right, b - a + 1)
    if a == 0:
        return met
    held_before = -algebra.slide(-left[..., : met.shape[-1] + a - 1], a)
    return algebra.meet(held_before, met)
