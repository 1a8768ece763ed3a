"""Predicates of the robot's state, as text: `v <= 1`, `|roll| <= 0.3`, `2*x - y >= 0.5`.

    side op side        op: <= or >= (also ≤, ≥)
    side                terms joined by + and -: NUMBER, NAME, NUMBER NAME or NUMBER * NAME;
                        one side may be |terms|, the other is a number then

Names are the robot's quantities (docs/predicates.md).
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.errors import allowed
from core.stl import Atom, Constant, Formula, Not, children, fold_constants, with_children
from core.task.inequalities import MOST, Inequality
from core.task.quantities import AXES, quantities_of
from envs import Robot
from scenes.regions import SceneError, check_name

LONGEST_TEXT = 200
LARGEST_NUMBER = 1e6
"""Of weights and bounds."""

_TERM = re.compile(
    r"\s*(?P<sign>[+-]?)\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*\*?\s*)?"
    r"(?P<name>[^\W\d]\w*)?\s*"
)


@dataclass(frozen=True)
class Predicate:
    """A named inequality.

    Attributes:
        name: The atom of the formulas that it interprets.
        text: The inequality.
    """

    name: str
    text: str

    def __post_init__(self):
        check_name(self.name)
        if ":" in self.name or ";" in self.name:
            raise SceneError(f"name: {self.name!r} must be without ':' and ';'")
        if not isinstance(self.text, str) or len(self.text) > LONGEST_TEXT:
            raise SceneError(f"must be text of at most {LONGEST_TEXT} characters, as in 'v <= 1'")


def check_predicates(predicates: Sequence[Predicate], robot: Robot) -> None:
    """Refuse predicates that do not fit a robot.

    Raises:
        SceneError: with the name of the predicate.
    """
    if len(predicates) > MOST:
        raise SceneError(f"predicates: {len(predicates)} are too many: at most {MOST} are allowed")
    for predicate in predicates:
        inequality_of(predicate, robot)


def inequality_of(predicate: Predicate, robot: Robot) -> Inequality:
    """The inequality of a predicate, checked against the quantities of a robot.

    Raises:
        SceneError: malformed, or with a name that the robot does not know.
    """
    try:
        return _read(predicate.text, [each.name for each in quantities_of(robot)])
    except SceneError as error:
        raise SceneError(f"predicates.{predicate.name}: {error}") from None


def is_positional(inequality: Inequality, robot: Robot) -> bool:
    """Whether the position alone decides an inequality."""
    return set(inequality.weights) <= set(AXES[: robot.position_size])


def relaxed(formula: Formula, names: frozenset[str], *, positive: bool = True) -> Formula:
    """A weaker formula without the atoms of some names: where they stand, nothing is asked.

    Args:
        formula: in negation normal form.
        names: of the atoms.
        positive: whether the formula stands under an even number of negations.
    """
    match formula:
        case Atom(name=name) | Not(operand=Atom(name=name)) if name in names:
            return Constant(positive)
        case Not(operand=operand):
            return Not(relaxed(operand, names, positive=not positive), span=formula.span)
    parts = tuple(relaxed(each, names, positive=positive) for each in children(formula))
    return with_children(formula, parts)


def without_state(formula: Formula, predicates: Sequence[Predicate], robot: Robot) -> Formula:
    """What a formula in negation normal form asks of the position alone, or less.

    Its atoms are regions and predicates of the position: a goal `A & slow` becomes `A`.
    """
    names = frozenset(
        each.name for each in predicates if not is_positional(inequality_of(each, robot), robot)
    )
    return fold_constants(relaxed(formula, names)) if names else formula


def positional_margins(
    predicates: Sequence[Predicate], robot: Robot, positions: np.ndarray
) -> dict[str, np.ndarray]:
    """Margins [P] of the predicates of the position alone at positions [P, d] in [m], by name."""
    found = {}
    for predicate in predicates:
        each = inequality_of(predicate, robot)
        if is_positional(each, robot):
            weight = np.array([each.weights.get(name, 0.0) for name in AXES[: robot.position_size]])
            left = positions @ weight + each.offset
            left = np.abs(left) if each.absolute else left
            gain = (1 if each.at_most else -1) / np.linalg.norm(weight)
            found[predicate.name] = gain * (each.bound - left)
    return found


def _read(text: str, names: Sequence[str]) -> Inequality:
    plain = text.replace("≤", "<=").replace("≥", ">=").replace("−", "-")
    sides = re.split(r"(<=|>=)", plain)
    if len(sides) != 3:
        raise SceneError(f"{text!r} must be one inequality with <= or >=, as in 'v <= 1'")
    left, sign, right = sides
    at_most = sign == "<="
    if right.strip().startswith("|"):
        left, right, at_most = right, left, not at_most
    inner = re.fullmatch(r"\s*\|([^|]*)\|\s*", left)
    weights, constant = _terms(left if inner is None else inner[1], text, names)
    others, bound = _terms(right, text, names)
    if inner is not None and others:
        raise SceneError(f"{text!r}: beside |...| stands a number alone")
    for name, value in others.items():
        weights[name] = weights.get(name, 0.0) - value
    weights = {name: value for name, value in weights.items() if value != 0}
    if not weights:
        raise SceneError(f"{text!r} speaks of no quantity. {allowed('', names)}")
    if inner is not None and bound < 0:
        raise SceneError(f"{text!r} compares an absolute value with a negative number")
    return Inequality(weights, constant, inner is not None, at_most, bound)


def _terms(side: str, text: str, names: Sequence[str]) -> tuple[dict[str, float], float]:
    """Weights of names, and the constant, of a side."""
    weights: dict[str, float] = {}
    constant, place = 0.0, 0
    while place < len(side) or not place:
        term = _TERM.match(side, place)
        name, number = (term["name"], term["number"]) if term else (None, None)
        if term is None or name is None and number is None or place and not term["sign"]:
            rest = side[place:].strip()
            raise SceneError(
                f"{text!r}: {rest!r} is no sum of numbers and names. {allowed(rest, names)}"
            )
        value = float(number or 1.0) * (-1 if term["sign"] == "-" else 1)
        if not math.isfinite(value) or abs(value) > LARGEST_NUMBER:
            raise SceneError(f"{text!r}: {number} is too large: at most {LARGEST_NUMBER:g}")
        if name is None:
            constant += value
        elif name in names:
            weights[name] = weights.get(name, 0.0) + value
        else:
            raise SceneError(f"unknown {name!r} in {text!r}. {allowed(name, names)}")
        place = term.end()
    return weights, constant
