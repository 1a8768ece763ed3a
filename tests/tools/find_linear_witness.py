"""Find a plan for each Linear task with z3, in exact rational arithmetic.

Development tool, not part of the test run: `python -m tests.tools.find_linear_witness [TASK ...]`.

Velocities are held for HOLD steps, so the trace is a polyline of knots p_0 .. p_N and
its point at every step is a rational combination of two of them. All implications are one-sided
(an atom's variable may be false where the atom holds), so that a model proves satisfaction:

- inside a circle: inside the 12-gon of the rational points (1,0), (4/5,3/5), (3/5,4/5), ... on it;
- outside a convex region: a segment keeps both knots, hence all its steps, on the far side of one
  edge of the rectangle, or of one of the circle's tangents at these 12 points;
- p U_[a:b] q: a recurrence w_k -> p_k and (q_k or w_{k+1}), w_b -> p_b and q_b.

Every region is shrunk (or, where it is avoided, grown) by MARGIN, so that float32 replays the
plan safely. rtamt judges the result.
"""

import sys
import time
from fractions import Fraction
from functools import singledispatchmethod
from typing import Any

import numpy as np
import z3

from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Not,
    Until,
    parse,
)
from scenes import Region, Scene, load_task, task_names
from tests.tools.witness import episode_length, judge, save_witness

HOLD = 4
STEP = Fraction(2, 5)  # [m] an axis and step, 2 m/s
MARGIN = Fraction(1, 100)  # [m]
THROTTLE = Fraction(49, 50)  # share of the speed that a plan may use
TIME_LIMIT = 600_000  # [ms] per task
DIRECTIONS = [
    (Fraction(x, 5), Fraction(y, 5))
    for x, y in (
        ((5, 0), (4, 3), (3, 4), (0, 5), (-3, 4), (-4, 3))
        + ((-5, 0), (-4, -3), (-3, -4), (0, -5), (3, -4), (4, -3))
    )
]  # unit vectors, counter-clockwise


class Encoder:
    """The constraints that a formula puts on the knots of a scene's plan."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.solver: Any = z3.SolverFor("QF_LRA")
        self.segments = -(-episode_length(scene) // HOLD)
        self.knots: list[tuple[Any, Any]] = [
            (z3.Real(f"x{i}"), z3.Real(f"y{i}")) for i in range(self.segments + 1)
        ]
        self.known: dict[Any, Any] = {}
        self._move()

    def _move(self) -> None:
        for knot, value in zip(self.knots[0], self.scene.initial.center, strict=True):
            self.solver.add(knot == _exact(value))
        reach = _exact(STEP * HOLD * THROTTLE)
        for before, after in zip(self.knots, self.knots[1:], strict=False):
            for a, b in zip(before, after, strict=True):
                self.solver.add(b - a <= reach, a - b <= reach)

    def holds(self, formula: Formula, step: int) -> Any:
        """A variable that implies that the formula holds at a step."""
        key = (formula, step)
        if key not in self.known:
            self.known[key] = z3.Bool(f"h{len(self.known)}")
            self.solver.add(z3.Implies(self.known[key], self._meaning(formula, step)))
        return self.known[key]

    @singledispatchmethod
    def _meaning(self, formula: Formula, step: int) -> Any:
        raise NotImplementedError(f"no encoding of {formula}")

    @_meaning.register
    def _(self, formula: And, step: int) -> Any:
        return z3.And([self.holds(operand, step) for operand in formula.operands])

    @_meaning.register
    def _(self, formula: Eventually, step: int) -> Any:
        return z3.Or([self.holds(formula.operand, k) for k in _steps(formula, step)])

    @_meaning.register
    def _(self, formula: Always, step: int) -> Any:
        return z3.And([self.holds(formula.operand, k) for k in _steps(formula, step)])

    @_meaning.register
    def _(self, formula: Until, step: int) -> Any:
        window = _steps(formula, step)
        before = [self.holds(formula.left, k) for k in range(step, window[0])]
        until = self._both(formula, window[-1])
        for k in reversed(window[:-1]):
            here = z3.Or(self.holds(formula.right, k), until)
            until = self._named(z3.And(self.holds(formula.left, k), here))
        return z3.And([*before, until])

    @_meaning.register
    def _(self, formula: Atom, step: int) -> Any:
        x, y = self._point(step)
        return z3.And([a * x + b * y <= c for a, b, c in _inner(self._region(formula.name))])

    @_meaning.register
    def _(self, formula: Not, step: int) -> Any:
        assert isinstance(formula.operand, Atom)
        segment = min(step // HOLD, self.segments - 1)
        return self._clear(formula.operand.name, segment)

    def _clear(self, name: str, segment: int) -> Any:
        """A variable that implies that a whole segment stays outside a region."""
        key = (name, "segment", segment)
        if key not in self.known:
            ends = self.knots[segment : segment + 2]
            far = [
                z3.And([a * x + b * y >= c for x, y in ends])
                for a, b, c in _outer(self._region(name))
            ]
            self.known[key] = self._named(z3.Or(far))
        return self.known[key]

    def _both(self, formula: Until, step: int) -> Any:
        return self._named(z3.And(self.holds(formula.left, step), self.holds(formula.right, step)))

    def _named(self, meaning) -> Any:
        name: Any = z3.FreshBool()
        self.solver.add(z3.Implies(name, meaning))
        return name

    def _point(self, step: int) -> tuple[Any, ...]:
        segment, part = divmod(step, HOLD)
        if part == 0:
            return self.knots[segment]
        share = _exact(Fraction(part, HOLD))
        pairs = zip(self.knots[segment], self.knots[segment + 1], strict=True)
        return tuple(a + share * (b - a) for a, b in pairs)

    def _region(self, name: str) -> Region:
        return self.scene.regions[self.scene.region_names.index(name)]


def _steps(formula: Eventually | Always | Until, step: int) -> range:
    return range(step + formula.interval.start, step + formula.interval.stop + 1)


def _exact(value) -> Any:
    fraction = Fraction(str(value)) if isinstance(value, float) else Fraction(value)
    return z3.Q(fraction.numerator, fraction.denominator)


def _inner(region: Region):
    """Half-planes a x + b y <= c whose intersection lies in the region."""
    cx, cy = (Fraction(str(value)) for value in region.center)
    size = [Fraction(str(value)) - MARGIN for value in region.size]
    if region.kind == "rectangle":
        sides = [((1, 0), size[0]), ((-1, 0), size[0]), ((0, 1), size[1]), ((0, -1), size[1])]
    else:
        pairs = zip(DIRECTIONS, DIRECTIONS[1:] + DIRECTIONS[:1], strict=True)
        normals = [((v[1] - u[1], u[0] - v[0]), u) for u, v in pairs]  # of the edge u v
        sides = [(n, size[0] * (n[0] * u[0] + n[1] * u[1])) for n, u in normals]
    return [(_exact(a), _exact(b), _exact(c + a * cx + b * cy)) for (a, b), c in sides]


def _outer(region: Region):
    """Half-planes a x + b y >= c each of which lies outside the region."""
    cx, cy = (Fraction(str(value)) for value in region.center)
    size = [Fraction(str(value)) + MARGIN for value in region.size]
    if region.kind == "rectangle":
        sides = [((1, 0), size[0]), ((-1, 0), size[0]), ((0, 1), size[1]), ((0, -1), size[1])]
    else:
        sides = [(direction, size[0]) for direction in DIRECTIONS]
    return [(_exact(a), _exact(b), _exact(c + a * cx + b * cy)) for (a, b), c in sides]


def solve(scene: Scene) -> np.ndarray | None:
    """Actions [N, 2] in [-1, 1], each held for HOLD steps, or None."""
    encoder = Encoder(scene)
    encoder.solver.set("timeout", TIME_LIMIT)
    encoder.solver.add(encoder.holds(parse(scene.formula), 0))
    verdict = encoder.solver.check()
    print(f"{scene.name}: {verdict}", end=" ", flush=True)
    if verdict != z3.sat:
        return None
    model: Any = encoder.solver.model()
    knots = np.array(
        [[float(model.eval(value, True).as_fraction()) for value in knot] for knot in encoder.knots]
    )
    return np.diff(knots, axis=0) / float(STEP * HOLD)


def main(tasks: list[str]) -> None:
    """Solve, judge and store."""
    for task in tasks or task_names("linear"):
        scene, started = load_task(task), time.monotonic()
        actions = solve(scene)
        value = -np.inf
        if actions is not None:
            value = judge(scene, scene.initial.center, np.repeat(actions, HOLD, axis=0))
            save_witness(task, scene.initial.center, actions, HOLD)
        print(f"robustness {value:.3f}, {time.monotonic() - started:.0f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
