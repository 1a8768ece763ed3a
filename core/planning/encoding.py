"""A formula as rows of a mixed-integer program over a trace (Raman et al. 2014).

The robustness r is one column. A formula is put in negation normal form, and every implication
goes one way: a column of a subformula may be positive only if its robustness on the trace is at
least r. So all solutions are sound, and the largest r is the largest robustness of a trace.

    A at k:       o_f - n_f . p_k >= r - M (1 - z)       for every facet f
    !A at k:      n_f . p_k - o_f >= r - M (1 - z_f)     z <= sum of z_f
    conjunction:  z <= z_i for each i                    disjunction:  z <= sum of z_i
    f U g:        u_k <= f_k, u_k <= g_k + u_{k+1}       its negation: e_k <= (!f)_k + e_{k-1}

Only the columns of atoms and facets are binary. What a formula asks of a step in any case needs
none; facets and atoms that no position in a step's box has with the least r have none either. So
the larger the least r, the smaller the program, and the tighter its relaxation.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from core.planning.outline import Facets, Sides
from core.planning.program import INFINITY, Program
from core.planning.reach import Literal
from core.planning.trace import Trace
from core.planning.values import negated
from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Not,
    Or,
    Until,
)

Truth = int | bool
"""A column that may be 1 only where something holds, or what is known of it."""


class Encoder:
    """Adds to a program what formulas ask of a trace."""

    def __init__(self, program: Program, trace: Trace, robustness: int, sides: Mapping[str, Sides]):
        """Encode into a program.

        Args:
            program: to which rows are added.
            trace: its columns of positions.
            robustness: its column r; the bounds are finite.
            sides: what stands for the regions.
        """
        self._program, self._trace, self._sides = program, trace, sides
        self._robustness = robustness
        self._least, self._most = program.lows[robustness], program.highs[robustness]
        self._known: dict[Literal, Truth] = {}
        self._clear: dict[tuple[str, tuple[int, ...]], list[Truth]] = {}

    def require(self, formula: Formula, certain: Iterable[Literal]) -> None:
        """Have a formula hold at step 0, and first what follows from it at certain steps."""
        for literal, step in sorted(certain, key=lambda each: each[1]):
            self._require_literal(literal, step)
            self._known[literal, step] = True
        self._require_one([self.holds(formula, 0)])

    def holds(self, formula: Formula, step: int) -> Truth:
        """Whether a formula in negation normal form holds at a step, with robustness r."""
        key = (formula, step)
        if key not in self._known:
            self._known[key] = self._made(formula, step)
        return self._known[key]

    def _made(self, formula: Formula, step: int) -> Truth:
        match formula:
            case Atom(name):
                return self._inside(self._sides[name].wanted, step)
            case Not(operand=Atom(name)):
                return self._any(self._outside(name, step))
            case And(operands=operands):
                return self._all([self.holds(each, step) for each in operands])
            case Or(operands=operands):
                return self._any([self.holds(each, step) for each in operands])
            case Always(interval=(a, b), operand=operand):
                return self._all([self.holds(operand, step + k) for k in range(a, b + 1)])
            case Eventually(interval=(a, b), operand=operand):
                return self._any([self.holds(operand, step + k) for k in range(a, b + 1)])
            case Until():
                return self._until(formula, step)
            case Not(operand=Until() as until):
                return self._released(until, step)
        raise TypeError(f"no encoding of {formula!r}")

    def _until(self, formula: Until, step: int) -> Truth:
        a, b = formula.interval
        held = [self.holds(formula.left, step + k) for k in range(b + 1)]
        until: Truth = False
        for k in range(b, a - 1, -1):
            here = self._any([self.holds(formula.right, step + k), until])
            until = self._all([held[k], here])
        return self._all([*held[:a], until])

    def _released(self, until: Until, step: int) -> Truth:
        """`!(f U_[a:b] g)`: at each step of the window !g, or !f by then."""
        a, b = until.interval
        fails, never = negated(until)
        failed: Truth = False
        parts = []
        for k in range(b + 1):
            failed = self._any([failed, self.holds(fails, step + k)])
            if k >= a:
                parts.append(self._any([failed, self.holds(never, step + k)]))
        return self._all(parts)

    def _all(self, parts: list[Truth]) -> Truth:
        if any(part is False for part in parts):
            return False
        columns = list(dict.fromkeys(part for part in parts if part is not True))
        if len(columns) <= 1:
            return columns[0] if columns else True
        both = self._program.column(0, 1)
        for column in columns:
            self._program.row({both: 1, column: -1}, -INFINITY, 0)
        return both

    def _any(self, parts: list[Truth]) -> Truth:
        if any(part is True for part in parts):
            return True
        columns = list(dict.fromkeys(part for part in parts if part is not False))
        if len(columns) <= 1:
            return columns[0] if columns else False
        either = self._program.column(0, 1)
        self._program.row({either: 1} | dict.fromkeys(columns, -1), -INFINITY, 0)
        return either

    def _require_literal(self, literal: Formula, step: int) -> None:
        match literal:
            case Atom(name):
                for normal, offset in zip(*self._sides[name].wanted, strict=True):
                    self._keep(-normal, -offset, step)
            case Not(operand=Atom(name)):
                self._require_one(self._outside(name, step, certain=True))

    def _require_one(self, parts: list[Truth]) -> None:
        if not any(part is True for part in parts):
            columns = [part for part in parts if part is not False]
            self._program.row(dict.fromkeys(columns, 1), 1, INFINITY)

    def _inside(self, facets: Facets, step: int) -> Truth:
        """Whether a step is inside a region: a column for all of its facets."""
        low, high = self._box(step)
        if (-facets.least(low, high) < self._least).any():
            return False
        cutting = facets.most(low, high) > -self._most
        if not cutting.any():
            return True
        chosen = self._program.column(0, 1, integer=True)
        for normal, offset in zip(*(part[cutting] for part in facets), strict=True):
            self._keep(-normal, -offset, step, chosen)
        return chosen

    def _outside(self, name: str, step: int, *, certain: bool = False) -> list[Truth]:
        """Ways to be outside a region at a step: a column for each facet.

        Where only one is left of what is certain, it is kept without a column.
        """
        span, facets = self._trace.span(step), self._sides[name].avoided
        if (name, span) not in self._clear:
            self._clear[name, span] = self._ways(facets, span, certain)
        return self._clear[name, span]

    def _ways(self, facets: Facets, span: tuple[int, ...], certain: bool) -> list[Truth]:
        boxes = [self._box(step) for step in span]
        least = np.min([facets.least(*box) for box in boxes], axis=0)
        if (least >= self._most).any():
            return [True]
        can = np.min([facets.most(*box) for box in boxes], axis=0) >= self._least
        normals, offsets = facets.normals[can], facets.offsets[can]
        alone = certain and len(normals) == 1
        ways: list[Truth] = []
        for normal, offset in zip(normals, offsets, strict=True):
            chosen = None if alone else self._program.column(0, 1, integer=True)
            for step in span:
                self._keep(normal, offset, step, chosen)
            ways.append(True if chosen is None else chosen)
        return ways

    def _keep(
        self, normal: np.ndarray, offset: float, step: int, chosen: int | None = None
    ) -> None:
        """Keep n . p - o >= r at a step: always, or where a column is chosen."""
        terms = self._trace.along(normal, step) | {self._robustness: -1.0}
        slack = 0.0
        if chosen is not None:
            low, high = self._box(step)
            lowest = float(np.minimum(normal * low, normal * high).sum()) - offset
            slack = max(self._most - lowest, 0.0)
            terms[chosen] = -slack
        self._program.row(terms, offset - slack, INFINITY)

    def _box(self, step: int) -> tuple[np.ndarray, np.ndarray]:
        return self._trace.boxes.low[step], self._trace.boxes.high[step]
