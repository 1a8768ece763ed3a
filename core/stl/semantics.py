r"""Quantitative semantics: how robustly a trace satisfies a formula.

With rho(f, t) the robustness of f at step t (paper Sec. 3; Donze and Maler 2010) and mu_A the
margin of atom A:

    rho(A, t)            = mu_A(t)                      rho(true, t) = +inf
    rho(!f, t)           = -rho(f, t)
    rho(f & g, t)        = min(rho(f, t), rho(g, t))
    rho(F_[a:b] f, t)    = max over t' in [t + a, t + b] of rho(f, t')
    rho(f U_[a:b] g, t)  = max over t' in [t + a, t + b] of
                               min(rho(g, t'), min over t'' in [t, t'] of rho(f, t''))

and f holds iff rho(f, 0) >= 0. An until takes linear time because, in any lattice,

    f U_[a:b] g = G_[0:a] f  &  F_[a:b] g  &  (f U g, a steps later),

where the unbounded until of a finite trace is one scan backwards,
u(t) = min(f(t), max(g(t), u(t + 1))).

Dimensions: T steps of a trace, A atoms; leading axes are a batch. NumPy arrays give NumPy
arrays; JAX arrays give JAX arrays, under `jit` and `grad` too.
"""

from collections.abc import Callable, Sequence
from functools import reduce

import jax
import jax.numpy as jnp
import numpy as np

from core.errors import UserError
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
    horizon,
)

# From the name of an atom, or from a constant, to its signal [..., T].
_Leaf = Callable[[Atom | Constant], Array]


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
    algebra = exact_algebra(margins)
    signal = _signal(formula, _leaves(margins, names, algebra), algebra)
    return signal[..., : margins.shape[-2] - horizon(formula)]


def robustness(formula: Formula, margins: Array, names: Sequence[str]) -> Array:
    """Robustness at step 0: [...] for margins [..., T, A]."""
    margins = _checked(formula, margins, names)
    decisive = margins[..., : horizon(formula) + 1, :]
    return robustness_signal(formula, decisive, names)[..., 0]


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
    scaled = margins[..., : horizon(formula) + 1, :] / temperature
    algebra = smooth_algebra(scaled)
    # Infinities have no place in sums of exponentials.
    leaves = _leaves(scaled, names, algebra)
    return _signal(fold_constants(formula), leaves, algebra)[..., 0] * temperature


def _checked(formula: Formula, margins: Array, names: Sequence[str]) -> Array:
    """Margins as floating-point numbers, after checking that they decide the formula."""
    if not isinstance(margins, jax.Array):
        margins = np.asarray(margins)
    if not jnp.issubdtype(margins.dtype, jnp.floating):
        margins = margins.astype(float)
    if margins.ndim < 2 or margins.shape[-1] < len(names):
        raise TraceError(
            f"margins have shape {margins.shape}; expected [..., steps, atoms] with a column for "
            f"each of the {len(names)} names"
        )
    unknown = [name for name in atom_names(formula) if name not in names]
    if unknown:
        raise TraceError(
            f"the trace has no margins for {', '.join(unknown)}; it has {', '.join(names)}"
        )
    if margins.shape[-2] <= horizon(formula):
        raise TraceError(
            f"the trace has {margins.shape[-2]} steps; the formula looks {horizon(formula)} steps "
            f"ahead and needs at least {horizon(formula) + 1}"
        )
    return margins


def _leaves(margins: Array, names: Sequence[str], algebra: Algebra) -> _Leaf:
    columns = {name: index for index, name in reversed(list(enumerate(names)))}

    def leaf(node: Atom | Constant) -> Array:
        if isinstance(node, Atom):
            return margins[..., columns[node.name]]
        value = np.inf if node.value else -np.inf
        return algebra.xp.full(margins.shape[:-1], value, margins.dtype)

    return leaf


def _signal(formula: Formula, leaf: _Leaf, algebra: Algebra) -> Array:
    """Values of the formula at the steps that the trace decides, counted from step 0."""

    def below(operand: Formula) -> Array:
        return _signal(operand, leaf, algebra)

    match formula:
        case Constant() | Atom():
            values = leaf(formula)
        case Not(operand=operand):
            values = -below(operand)
        case And(operands=operands):
            values = _meet_all([below(operand) for operand in operands], algebra)
        case Or(operands=operands):
            values = -_meet_all([-below(operand) for operand in operands], algebra)
        case Implies(left=left, right=right):
            values = -_meet_all([below(left), -below(right)], algebra)
        case Eventually(interval=interval, operand=operand):
            values = _eventually(interval, below(operand), algebra)
        case Always(interval=interval, operand=operand):
            values = _always(interval, below(operand), algebra)
        case Until(interval=interval, left=left, right=right):
            values = _until(interval, below(left), below(right), algebra)
        case _:
            raise TypeError(f"not a formula: {formula!r}")
    return values


def _meet_all(signals: list[Array], algebra: Algebra) -> Array:
    return reduce(algebra.meet, _of_common_length(signals))


def _eventually(interval: Interval, operand: Array, algebra: Algebra) -> Array:
    start, stop = interval
    return algebra.slide(operand[..., start:], stop - start + 1)


def _always(interval: Interval, operand: Array, algebra: Algebra) -> Array:
    return -_eventually(interval, -operand, algebra)


def _until(interval: Interval, left: Array, right: Array, algebra: Algebra) -> Array:
    left, right = _of_common_length([left, right])
    held_before = _always(Interval(0, interval.start), left, algebra)
    reached = _eventually(interval, right, algebra)
    unbounded = _unbounded_until(left[..., interval.start :], right[..., interval.start :], algebra)
    return _meet_all([held_before, reached, unbounded], algebra)


def _unbounded_until(left: Array, right: Array, algebra: Algebra) -> Array:
    def step(later: Array, now: Array) -> Array:
        return algebra.meet(now[0], algebra.join(now[1], later))

    pairs = algebra.xp.moveaxis(algebra.xp.stack([left, right]), -1, 0)  # [L, 2, ...]
    return algebra.scan_back(step, algebra.meet(left[..., -1], right[..., -1]), pairs[:-1])


def _of_common_length(signals: list[Array]) -> list[Array]:
    length = min(signal.shape[-1] for signal in signals)
    return [signal[..., :length] for signal in signals]
