"""Steps, times, distances and regions in words."""

from dataclasses import dataclass

from core.quoting import LONGEST_FORMULA, shown
from core.stl import Atom, Formula, Not, quote_name, to_text, walk


@dataclass(frozen=True)
class Clock:
    """Steps with their times."""

    dt: float

    def step(self, step: int) -> str:
        """`step 37 (7.4 s)`."""
        return f"step {step} ({self._seconds(step)} s)"

    def steps(self, first: int, last: int) -> str:
        """`steps 37-41 (7.4-8.2 s)`, or a single step."""
        if first == last:
            return self.step(first)
        return f"steps {first}-{last} ({self._seconds(first)}-{self._seconds(last)} s)"

    def between(self, first: int, last: int) -> str:
        """`between steps 40 and 80 (8-16 s)`."""
        times = f"{self._seconds(first)}-{self._seconds(last)} s"
        return f"between steps {first} and {last} ({times})"

    def _seconds(self, step: int) -> str:
        return f"{step * self.dt:.6g}"


def metres(distance: float) -> str:
    """`0.12 m`; small distances to two digits."""
    if not distance:
        return "0 m"
    if distance < 1e-3:
        return "less than 1 mm"
    return f"{distance:.2f} m" if distance >= 0.095 else f"{distance:.2g} m"


def amount(formula: Formula, margin: float) -> str:
    """A margin of a state formula: in metres, or a bare number where it speaks of the state."""
    places = all(node.place for node in walk(formula) if isinstance(node, Atom))
    return metres(margin) if places else f"{margin:.2g}"


def quoted(formula: Formula) -> str:
    """Text of a formula, the middle of a long one left out."""
    return shown(to_text(formula), LONGEST_FORMULA)


def literal(formula: Formula) -> tuple[str, bool] | None:
    """Name and sign of a region or a negated region."""
    match formula:
        case Atom(name=name, place=True):
            return shown(quote_name(name)), True
        case Not(operand=Atom(name=name, place=True)):
            return shown(quote_name(name)), False
    return None


def breach(formula: Formula, when: str, short: float, several: bool) -> str:
    """What happened where a state formula failed, missing by `short` [m] at worst."""
    name, wanted = literal(formula) or ("", True)
    up_to = "up to " if several else ""
    place = f"{'during' if several else 'at'} {when}"
    if not name:
        return f"{quoted(formula)} did not hold {place}, missing by {up_to}{amount(formula, short)}"
    if wanted:
        return f"the robot was outside {name} {place}, {up_to}{metres(short)} away"
    return f"the robot was in {name} {place}, {up_to}{metres(short)} deep"


def miss(formula: Formula, when: str, short: float, nearest: str) -> str:
    """What did not happen where a state formula never held, nearest by `short` [m]."""
    name, wanted = literal(formula) or ("", True)
    if not name:
        closest = f"it came closest at {nearest}, missing by {amount(formula, short)}"
        return f"{quoted(formula)} never held {when}; {closest}"
    closest = f"the robot came closest at {nearest}, {metres(short)}"
    if wanted:
        return f"{name} was never reached {when}; {closest} away"
    return f"{name} was never left {when}; {closest} deep"


def demand(formula: Formula) -> str:
    """What a requirement of the state formula does when it is not met."""
    match literal(formula):
        case (_, True):
            return "requires it to be inside"
        case (_, False):
            return "forbids it"
    return "requires it"


def holding(formula: Formula) -> str:
    """`the robot was in B`."""
    name, wanted = literal(formula) or ("", True)
    if not name:
        return f"{quoted(formula)} held"
    return f"the robot was {'in' if wanted else 'outside'} {name}"


def arrival(formula: Formula) -> str:
    """`A was reached`."""
    name, wanted = literal(formula) or ("", True)
    if not name:
        return f"{quoted(formula)} held"
    return f"{name} was {'reached' if wanted else 'left'}"


def margin_at(formula: Formula, margin: float, when: str) -> str:
    """Where a literal holds by a margin [m]: `0.08 m from B5 at step 37 (7.4 s)`."""
    if literal(formula) is None:
        return f"{amount(formula, margin)} of {quoted(formula)} at {when}"
    name, wanted = literal(formula) or (quoted(formula), True)
    return f"{metres(margin)} {'inside' if wanted else 'from'} {name} at {when}"
