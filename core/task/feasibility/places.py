"""Where a state formula holds, and how far two such places are apart.

Regions are known by their margins (signed distances, hence 1-Lipschitz) and by the boxes around
them. Everything errs on one side: a place is never smaller, a gap never larger than stated.

- The *pieces* of a state formula are boxes, one of which contains every position that satisfies
  it: a clause of its disjunctive normal form gives the common part of the boxes of its atoms.
  Negated atoms cut nothing away.
- A piece is *thin* if a region is both wanted and avoided there: its boundary, at most.
- The *best margin* of a state formula f is the largest value of f over all positions, bounded by
  branch and bound: in a cell with centre c and half diagonal r it is at most f(c) + r.

Dimensions: A regions, d position, K pieces or pairs of them, P positions.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from core.stl import And, Atom, Formula, Not, Or, atom_names, robustness

MOST_PIECES = 32
"""A formula with more is taken to hold anywhere."""

MOST_CELLS = 1024
"""Cells that are refined at once; with more the question stays open."""

LEVELS = 14
"""Halvings of a cell."""


@dataclass(frozen=True, eq=False)
class Places:
    """The regions of a scene.

    Attributes:
        names: Of the regions, in the order of the columns.
        low: Low corners [A, d] of the boxes around them [m].
        high: High corners [A, d] [m].
        radius: Radii [A] of balls around the boxes' centres that contain them [m].
        margin: Of the i-th region at positions [P, d]: [P] [m].
        tolerance: What rounding may add to a margin [m].
    """

    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    radius: np.ndarray
    margin: Callable[[int, np.ndarray], np.ndarray]
    tolerance: float


class Best(NamedTuple):
    """Bounds on the largest margin of a state formula [m]."""

    reached: float
    """By some position; -inf if none was looked at."""
    bound: float
    """By no position."""


class Piece(NamedTuple):
    """A box that contains all positions of a clause."""

    low: np.ndarray  # [d]
    high: np.ndarray  # [d]
    atoms: frozenset[int]
    """Regions whose intersection it contains."""
    avoided: frozenset[int]
    """Regions of which it contains the outside."""

    @property
    def thin(self) -> bool:
        """Whether the clause asks for the inside and the outside of one region: its boundary."""
        return bool(self.atoms & self.avoided)


class Geometry:
    """Answers about state formulas over the regions; each is worked out once."""

    def __init__(self, places: Places):
        self.places = places
        self._index = {name: i for i, name in enumerate(places.names)}
        self._pieces: dict[Formula, list[Piece]] = {}
        self._best: dict[Formula, Best] = {}
        self._gaps: dict[tuple[Formula, Formula], np.ndarray] = {}

    def pieces(self, predicate: Formula) -> list[Piece]:
        """Boxes one of which contains any position that satisfies a state formula."""
        if predicate not in self._pieces:
            self._pieces[predicate] = self._made(predicate)
        return self._pieces[predicate]

    def gaps(self, first: Formula, second: Formula) -> np.ndarray:
        """Distances [K, d + 1] between pieces: along each axis, and in all [m].

        Whoever moves from one place to the other covers at least the distances of some row.
        """
        if (first, second) not in self._gaps:
            pairs = product(self.pieces(first), self.pieces(second))
            rows = [self._gap(one, other) for one, other in pairs]
            self._gaps[first, second] = self._gaps[second, first] = np.array(rows)
        return self._gaps[first, second]

    def best(self, predicate: Formula) -> Best:
        """Bounds on the largest margin; exact enough to tell its sign where that is clear."""
        if predicate not in self._best:
            self._best[predicate] = self._bounded(predicate)
        return self._best[predicate]

    def margins_of(self, predicate: Formula, positions: np.ndarray) -> np.ndarray:
        """Margins [P] of a state formula at positions [P, d]."""
        names = atom_names(predicate)
        margins = [self.places.margin(self._index[name], positions) for name in names]
        return np.asarray(robustness(predicate, np.column_stack(margins)[:, None], names))

    def beginning_at(self, start: np.ndarray) -> "Geometry":
        """The same with a tiny ball around a position [d] in place of the last region."""
        low, high = self.places.low.copy(), self.places.high.copy()
        tiny = 2 * self.places.tolerance
        low[-1], high[-1] = start - tiny, start + tiny
        radius = np.append(self.places.radius[:-1], tiny)

        def margin(i: int, positions: np.ndarray) -> np.ndarray:
            if i < len(low) - 1:
                return self.places.margin(i, positions)
            return tiny - np.linalg.norm(positions - start, axis=1)

        places = replace(self.places, low=low, high=high, radius=radius, margin=margin)
        return Geometry(places)

    def _made(self, predicate: Formula) -> list[Piece]:
        places = self.places
        match predicate:
            case Atom(name=name):
                i, slack = self._index[name], places.tolerance
                box = places.low[i] - slack, places.high[i] + slack
                return [Piece(*box, frozenset({i}), frozenset())]
            case Not(operand=Atom(name=name)):
                return [self._anywhere()._replace(avoided=frozenset({self._index[name]}))]
            case Or(operands=operands):
                pieces = [piece for operand in operands for piece in self.pieces(operand)]
            case And(operands=operands):
                pieces = [self._anywhere()]
                for operand in operands:
                    pairs = list(product(pieces, self.pieces(operand)))
                    if len(pairs) > MOST_PIECES:
                        return [self._anywhere()]
                    pieces = [_common(*pair) for pair in pairs]
            case _:
                raise TypeError(f"not a state formula in negation normal form: {predicate}")
        return pieces if len(pieces) <= MOST_PIECES else [self._anywhere()]

    def _anywhere(self) -> Piece:
        far = np.full(self.places.low.shape[1], np.inf)
        return Piece(-far, far, frozenset(), frozenset())

    def _gap(self, one: Piece, other: Piece) -> np.ndarray:
        axes = np.maximum(np.maximum(one.low - other.high, other.low - one.high), 0.0)
        whole = max(
            float(np.linalg.norm(axes)),
            *(self._apart(i, j) for i, j in product(one.atoms, other.atoms)),
            0.0,
        )
        return np.append(axes, whole)

    def _apart(self, i: int, j: int) -> float:
        """Distance of the balls around two regions [m]."""
        places = self.places
        centers = (places.low + places.high) / 2
        away = float(np.linalg.norm(centers[i] - centers[j]))
        return away - float(places.radius[i] + places.radius[j]) - 2 * places.tolerance

    def _bounded(self, predicate: Formula) -> Best:
        pieces = self.pieces(predicate)
        if any(not piece.atoms for piece in pieces):
            return Best(np.inf, np.inf)  # far from all regions
        emptiness = [float((piece.low - piece.high).max()) for piece in pieces]
        if min(emptiness) > 0:
            return Best(-np.inf, -min(emptiness) / 2)
        real = [piece for piece, empty in zip(pieces, emptiness, strict=True) if empty <= 0]
        boxes = [piece for piece in real if not piece.thin]
        thin = 0.0 if len(boxes) < len(real) else -np.inf
        if not boxes:
            return Best(-np.inf, thin)
        found = self._searched(
            predicate,
            np.array([(piece.low + piece.high) / 2 for piece in boxes]),
            np.array([(piece.high - piece.low) / 2 for piece in boxes]),
        )
        return Best(found.reached, max(found.bound, thin))

    def _searched(self, predicate: Formula, center: np.ndarray, half: np.ndarray) -> Best:
        """Branch and bound over cells with centres and half sides [K, d]."""
        tolerance = self.places.tolerance
        reached, settled = -np.inf, -np.inf
        for _ in range(LEVELS):
            value = self.margins_of(predicate, center)
            reached = max(reached, float(value.max()))
            bound = value + np.linalg.norm(half, axis=1)
            hopeful = bound >= -tolerance
            settled = max(settled, float(np.where(hopeful, -np.inf, bound).max()))
            if not hopeful.any():
                break
            if reached > tolerance or hopeful.sum() * 2 ** center.shape[1] > MOST_CELLS:
                settled = max(settled, float(bound.max()))
                break
            center, half = _halved(center[hopeful], half[hopeful])
        else:
            settled = np.inf
        return Best(reached, max(reached, settled))


def _common(one: Piece, other: Piece) -> Piece:
    low, high = np.maximum(one.low, other.low), np.minimum(one.high, other.high)
    return Piece(low, high, one.atoms | other.atoms, one.avoided | other.avoided)


def _halved(center: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The 2^d parts of each cell."""
    corners = np.array(list(product((-0.5, 0.5), repeat=center.shape[1])))
    parts = center[:, None] + corners * half[:, None]
    return parts.reshape(-1, center.shape[1]), np.repeat(half / 2, len(corners), axis=0)
