"""Whether the invariants of a trace hold between its steps, by how much at least, and where.

Three numbers, all of the strict reading of the task's formula (`core.between.strict`):

- the *strict robustness*, what decides where a scene asks for `between_steps`;
- the *margin* between the steps, which leaves goals out of account: what is asked at a step counts
  as met or as missed, whatever its margin, so that the least margin of the invariants decides,
  for the choice among disjuncts and times that leaves them the most. Where goals are missed all
  the same, they are granted. Infinite where nothing is asked between steps;
- where it is attained.

Dimensions: R rollouts, T steps, C what is asked, n state, A atoms.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from core.between.strict import Asked, Strict, strict_formula
from core.between.sweep import Sweep, look, swept
from core.monitor.signals import Signals
from core.monitor.witness import decisive
from core.monitor.wording import amount, literal, quoted
from core.stl import Atom, Formula, robustness, to_text
from core.task.task import Task

CERTAIN = 1e9
"""Margin of what counts as met, whatever its own [m]."""

FINE = 64
"""Parts of a stretch around the least margin, looked at again to tell it exactly."""


@dataclass(frozen=True)
class Between:
    """What a trace does between its steps.

    Attributes:
        margin: Least margin of the invariants [m]; infinite if nothing is asked.
        invariant: The state formula that has it; None if nothing is asked.
        step: It is attained between this step and the next.
        share: Part of the step that has gone by then.
        position: Of the robot there [m].
    """

    margin: float
    invariant: Formula | None = None
    step: int = 0
    share: float = 0.0
    position: tuple[float, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the invariants hold between the steps, too."""
        return self.margin >= 0

    def document(self) -> dict[str, object]:
        """As JSON values."""
        if self.invariant is None:
            return {"holds": True, "margin": None}
        return {
            "holds": self.holds,
            "margin": self.margin,
            "invariant": to_text(self.invariant),
            "steps": [self.step, self.step + 1],
            "position": list(self.position),
        }


def strict_robustness(task: Task, states: np.ndarray) -> np.ndarray:
    """Robustness [R] of the strict reading on traces [R, T + 1, n], all of them finite."""
    if not len(states):
        return np.zeros(0)
    strict = strict_formula(task.formula)
    seen = _seen(task, strict, states)
    return np.asarray(robustness(strict.formula, seen.columns, strict.names))


def between_margins(task: Task, states: np.ndarray) -> np.ndarray:
    """Least margins [R] between the steps of traces [R, T + 1, n] (see `Between`) [m]."""
    strict = strict_formula(task.formula)
    if not strict.invariants or not len(states):
        return np.full(len(states), np.inf)
    margins, _ = _judged(strict, _seen(task, strict, states))
    return margins


def between(task: Task, states: np.ndarray) -> Between:
    """What a trace [T + 1, n] does between its steps."""
    strict = strict_formula(task.formula)
    if not strict.invariants or not np.isfinite(states).all():
        return Between(np.inf)
    seen = _seen(task, strict, states[None])
    margins, columns = _judged(strict, seen)
    if np.isinf(margins[0]):
        return Between(np.inf)
    witness = decisive(strict.formula, 0, Signals(columns[0], strict.names))
    assert isinstance(witness.literal, Atom)
    invariant = strict.asked[witness.literal.name].predicate
    share = seen.sweep.share[0, witness.step, strict.invariants.index(invariant)]
    return _closest(task, states, invariant, witness.step, float(share))


def between_sentence(found: Between) -> str:
    """What is said of a trace that satisfies the formula at its steps."""
    if found.invariant is None:
        return ""
    if found.holds:
        least = amount(found.invariant, found.margin)
        return (
            f"It holds between the steps, too, by {least} at least: {quoted(found.invariant)} "
            f"{_where(found)}"
        )
    return f"Satisfied at every step; {breach_text(found)}"


def breach_text(found: Between) -> str:
    """`between steps 14 and 15 it cuts B1 by 0.07 m at (3.2, 4.1)`, of what does not hold."""
    assert found.invariant is not None
    depth = amount(found.invariant, -found.margin)
    name, wanted = literal(found.invariant) or ("", True)
    if not name:
        what = f"it breaks {quoted(found.invariant)}"
    else:
        what = f"it {'leaves' if wanted else 'cuts'} {name}"
    when, place = _where(found).rsplit(" at ", 1)
    return f"{when} {what} by {depth} at {place}"


def _where(found: Between) -> str:
    place = ", ".join(f"{each:.1f}" for each in found.position)
    return f"between steps {found.step} and {found.step + 1} at ({place})"


class _Seen(NamedTuple):
    columns: np.ndarray  # [R, T + 1, C] values of what is asked [m]
    sweep: Sweep  # of the invariants


def _seen(task: Task, strict: Strict, states: np.ndarray) -> _Seen:
    states = np.asarray(states)[:, : task.horizon + 1]
    asked = list(strict.asked.values())
    times = np.arange(states.shape[1])
    at_steps = look(task, states, times, [each.predicate for each in asked]).values
    sweep = swept(task, states, strict.invariants)
    columns = np.array(at_steps)
    for i, each in enumerate(strict.invariants):
        column = asked.index(Asked(each, True))
        columns[:, :-1, column] = sweep.value[..., i]
    return _Seen(columns, sweep)


def _judged(strict: Strict, seen: _Seen) -> tuple[np.ndarray, np.ndarray]:
    """Least margins [R] of the invariants, and the columns [R, T + 1, C] that give them."""
    at_steps = [i for i, each in enumerate(strict.asked.values()) if not each.throughout]
    weighed = seen.columns.astype(float)
    weighed[..., at_steps] = np.where(weighed[..., at_steps] >= 0, CERTAIN, -CERTAIN)
    missed = np.asarray(robustness(strict.formula, weighed, strict.names)) <= -CERTAIN
    for i in at_steps:
        weighed[missed, :, i] = CERTAIN
    margins = np.asarray(robustness(strict.formula, weighed, strict.names))
    return np.where(margins >= CERTAIN, np.inf, margins), weighed


def _closest(
    task: Task, states: np.ndarray, invariant: Formula, step: int, share: float
) -> Between:
    """The least margin of a step, looked for finely around where it was seen."""
    before, after = np.float64(states[step]), np.float64(states[step + 1])
    width, margin = 1.0, np.inf
    for _ in range(3):
        width = width / 8
        shares = np.clip(share + np.linspace(-width, width, FINE + 1), 0.0, 1.0)
        states_between = before + shares[:, None] * (after - before)
        found = look(task, states_between, step + shares, (invariant,))
        best = int(found.values[:, 0].argmin())
        if found.values[best, 0] < margin:
            margin, share = float(found.values[best, 0]), float(shares[best])
    state = np.float32(before + share * (after - before))
    position = np.asarray(task.robot.position(state))  # pyright: ignore[reportArgumentType]
    return Between(margin, invariant, step, share, tuple(float(each) for each in position))
