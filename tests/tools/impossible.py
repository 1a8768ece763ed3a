"""Random missions whose answer z3 knows, and what is said of them before training.

    python -m tests.tools.impossible [COUNT] [SEED]

Missions of the robot `linear` among rectangles, short enough for z3 to decide over the reals
whether some start and some actions satisfy the formula. None that is possible may be called
impossible; of the impossible ones, the share that is proved and the share that is at least
warned of are printed.
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import z3

from core.stl import (
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
    horizon,
    parse,
    to_text,
)
from core.task.feasibility import Finding
from scenes import Region, Scene, load_task
from studio.runs.findings import findings_of

STEP = Fraction(2, 5)
"""Of `linear`, along each axis [m]."""

PATIENCE = 20_000
"""Of z3 for a mission [ms]."""

NAMES = ("A", "B", "C", "O")


class Exact:
    """The traces of a scene as constraints over the reals; a boundary is in and out."""

    def __init__(self, scene: Scene, formula: Formula):
        self._regions = {region.name: region for region in scene.regions}
        self._solver: Any = z3.SolverFor("QF_LRA")
        self._solver.set("timeout", PATIENCE)
        count = horizon(formula) + 1
        self._points = [(z3.Real(f"x{k}"), z3.Real(f"y{k}")) for k in range(count)]
        self._known: dict[Any, Any] = {}
        self._solver.add(_inside(scene.initial, self._points[0]))
        for before, after in zip(self._points, self._points[1:], strict=False):
            for a, b in zip(before, after, strict=True):
                self._solver.add(b - a <= _exact(STEP), a - b <= _exact(STEP))
        self._solver.add(self._holds(formula, 0, True))

    def possible(self) -> bool | None:
        """Whether some trace satisfies the formula; None if z3 has no patience."""
        answer = self._solver.check()
        return None if answer == z3.unknown else answer == z3.sat

    def _holds(self, formula: Formula, k: int, sign: bool) -> Any:
        key = (formula, k, sign)
        if key not in self._known:
            self._known[key] = self._meaning(formula, k, sign)
        return self._known[key]

    def _meaning(self, formula: Formula, k: int, sign: bool) -> Any:
        every, some = (z3.And, z3.Or) if sign else (z3.Or, z3.And)
        match formula:
            case Constant(value=value):
                return z3.BoolVal(value == sign)
            case Atom(name=name):
                place = _inside if sign else _outside
                return place(self._regions[name], self._points[k])
            case Not(operand=operand):
                return self._holds(operand, k, not sign)
            case And(operands=operands):
                return every([self._holds(each, k, sign) for each in operands])
            case Or(operands=operands):
                return some([self._holds(each, k, sign) for each in operands])
            case Implies(left=left, right=right):
                return some([self._holds(left, k, not sign), self._holds(right, k, sign)])
            case Always(interval=(a, b), operand=operand):
                return every([self._holds(operand, k + i, sign) for i in range(a, b + 1)])
            case Eventually(interval=(a, b), operand=operand):
                return some([self._holds(operand, k + i, sign) for i in range(a, b + 1)])
            case Until(interval=(a, b), left=left, right=right):
                ways = [
                    every(
                        [self._holds(right, k + end, sign)]
                        + [self._holds(left, k + i, sign) for i in range(end + 1)]
                    )
                    for end in range(a, b + 1)
                ]
                return some(ways)
        raise TypeError(f"not a formula: {formula}")


def _exact(value: Any) -> Any:
    fraction = Fraction(str(value)) if isinstance(value, float) else Fraction(value)
    return z3.Q(fraction.numerator, fraction.denominator)


def _inside(region: Region, point: Any) -> Any:
    sides = zip(point, region.center, region.size, strict=True)
    exact = [(p, Fraction(str(c)), Fraction(str(h))) for p, c, h in sides]
    return z3.And([z3.And(p >= _exact(c - h), p <= _exact(c + h)) for p, c, h in exact])


def _outside(region: Region, point: Any) -> Any:
    sides = zip(point, region.center, region.size, strict=True)
    exact = [(p, Fraction(str(c)), Fraction(str(h))) for p, c, h in sides]
    return z3.Or([z3.Or(p <= _exact(c - h), p >= _exact(c + h)) for p, c, h in exact])


def random_scene(seed: int) -> Scene:
    """A mission of a number; about half of them are possible."""
    random = np.random.default_rng(seed)
    regions = tuple(_region(random, name) for name in NAMES)
    initial = replace(_region(random, "A"), name="initial")
    formula = to_text(_mission(random))
    return replace(
        load_task("linear-01"),
        name=f"random-{seed}",
        formula=formula,
        regions=regions,
        initial=initial,
        horizon=20,
    )


def _region(random: np.random.Generator, name: str) -> Region:
    center = tuple(float(c) for c in random.integers(-20, 21, 2) / 10)
    size = tuple(float(h) for h in random.integers(2, 10, 2) / 10)
    return Region(name, "rectangle", center, size)


def _mission(random: np.random.Generator) -> Formula:
    """Two to four random sentences."""
    sentences = [_sentence(random, 2) for _ in range(random.integers(2, 5))]
    return And(tuple(sentences))


def _interval(random: np.random.Generator, most: int) -> Interval:
    a = int(random.integers(0, most // 2))
    return Interval(a, a + int(random.integers(1, most - a)))


def _state(random: np.random.Generator) -> Formula:
    names = random.permutation(NAMES)
    first = Atom(str(names[0]))
    match random.integers(0, 6):
        case 0:
            return Not(first)
        case 1:
            return And((first, Not(Atom(str(names[1])))))
        case 2:
            return Or((first, Atom(str(names[1]))))
        case 3:
            return And((first, Atom(str(names[1]))))
    return first


def _sentence(random: np.random.Generator, depth: int) -> Formula:
    goal = _state(random) if depth == 0 or random.random() < 0.6 else _sentence(random, depth - 1)
    avoid = Not(Atom(str(random.choice(NAMES))))
    interval = _interval(random, 8)
    match random.integers(0, 9):
        case 0:
            return Always(interval, avoid)
        case 1:
            return Until(interval, avoid, goal)
        case 2:
            return Or(
                (Eventually(interval, goal), Eventually(_interval(random, 6), _state(random)))
            )
        case 3:
            return Always(interval, Eventually(_interval(random, 5), _state(random)))
        case 4:
            return Not(Until(interval, avoid, _state(random)))
        case 5:
            return Eventually(interval, And((_state(random), goal)))
        case 6:
            return Always(interval, Implies(_state(random), Eventually(interval, goal)))
        case 7:
            return Eventually(interval, Always(Interval(0, 3), _state(random)))
    return Eventually(interval, goal)


@dataclass(frozen=True)
class Case:
    """A mission with both answers."""

    scene: Scene
    possible: bool
    findings: tuple[Finding, ...]
    seconds: float

    @property
    def proved(self) -> bool:
        """Whether it is called impossible."""
        return any(finding.proved for finding in self.findings)


def cases(seeds: range) -> Iterator[Case]:
    """Missions that z3 decides, with what is found of them."""
    for seed in seeds:
        scene = random_scene(seed)
        answer = Exact(scene, parse(scene.formula, names=scene.region_names)).possible()
        if answer is not None:
            began = time.process_time()
            findings = findings_of(scene)
            yield Case(scene, answer, findings, time.process_time() - began)


def main(count: int, seed: int) -> int:
    """Print shares; the exit status is 1 if a possible mission was called impossible."""
    found = list(cases(range(seed, seed + count)))
    possible = [case for case in found if case.possible]
    impossible = [case for case in found if not case.possible]
    wrong = [case for case in possible if case.proved]
    proved = sum(case.proved for case in impossible)
    said = sum(bool(case.findings) for case in impossible)
    warned = sum(bool(case.findings) for case in possible)
    for case in wrong:
        print("WRONG", case.scene.name, case.scene.formula, *case.findings, sep="\n    ")
    for case in impossible:
        if not case.proved and "-v" in sys.argv:
            print("MISSED", case.scene.name, case.scene.formula, *case.findings, sep="\n    ")
    times = sorted(case.seconds for case in found[1:])
    print(f"{len(found)} of {count} missions decided by z3, seeds from {seed}")
    print(f"possible: {len(possible)}; called impossible: {len(wrong)}; warned of: {warned}")
    print(f"impossible: {len(impossible)}; proved: {proved}; proved or warned of: {said}")
    print(
        f"judged in {1e3 * times[len(times) // 2]:.1f} ms of one core (median), "
        f"{1e3 * times[-1]:.1f} at most"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    numbers = [int(argument) for argument in sys.argv[1:] if argument.isdigit()]
    sys.exit(main(*(numbers + [200, 0][len(numbers) :])))
