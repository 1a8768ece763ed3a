"""Bounds of intervals: whole steps, or seconds and milliseconds that fall on a step.

Arithmetic is exact (rational numbers), so that 0.3 s is three steps of 0.1 s.
"""

from fractions import Fraction

# Largest bound in steps; keeps horizons, and hence traces, within reason.
MAX_STEPS = 1_000_000
_MAX_DIGITS = 40
_SECONDS = {"s": Fraction(1), "ms": Fraction(1, 1000)}


class BoundError(ValueError):
    """A bound that is not a step; the parser adds the place."""

    def __init__(self, problem: str, hint: str = ""):
        super().__init__(problem)
        self.hint = hint


def steps(number: str, unit: str | None, dt: float | None) -> int:
    """Convert a bound to steps.

    Args:
        number: decimal digits, with an optional sign and fraction.
        unit: None for steps, `s` or `ms`.
        dt: duration of a step [s]; needed for units.
    """
    shown = f"{number} {unit}" if unit else number
    if len(number) > _MAX_DIGITS:
        raise BoundError(f"a number of {len(number)} characters is too long for a bound")
    value = Fraction(number)
    if value < 0:
        raise BoundError(f"the bound {shown} is negative", "[a:b] needs 0 <= a <= b")
    count = _whole_steps(value, shown) if unit is None else _in_steps(value, unit, shown, dt)
    if count > MAX_STEPS:
        raise BoundError(f"the bound {shown} is too large", f"at most {MAX_STEPS} steps")
    return count


def _whole_steps(value: Fraction, shown: str) -> int:
    if value.denominator != 1:
        below = value.numerator // value.denominator
        raise BoundError(
            f"the bound {shown} is not a whole number of steps",
            f"the nearest are {below} and {below + 1}; for seconds, write {shown} s",
        )
    return value.numerator


def _in_steps(value: Fraction, unit: str, shown: str, dt: float | None) -> int:
    if dt is None:
        raise BoundError(
            f"the bound {shown} needs the robot's time step", "without it, bounds are in steps"
        )
    step = Fraction(str(dt)) / _SECONDS[unit]
    below, remainder = divmod(value, step)
    if remainder:
        lower, upper = (
            f"{_decimal(count * step)} {unit} ({count} {'step' if count == 1 else 'steps'})"
            for count in (below, below + 1)
        )
        raise BoundError(
            f"the bound {shown} is not a multiple of the time step {_decimal(step)} {unit}",
            f"the nearest are {lower} and {upper}",
        )
    return int(below)


def _decimal(value: Fraction) -> str:
    return f"{float(value):.12g}"
