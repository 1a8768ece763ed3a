"""Predicates of tasks as indices into the extended margin vector."""

from collections.abc import Sequence

import numpy as np

from core.stl import Atom, Formula, Not
from core.task.clauses import clauses_of, exclude
from core.task.sizes import LARGEST, GroundingError, Sizes


class PredicateTable:
    """Numbers the atoms and, from `first` on, the compound predicates.

    Args:
        atoms: names in the order of the world's margin vector.
        first: index of the first compound predicate.
        predicates: state formulas in negation normal form.

    Raises:
        GroundingError: a predicate, or their number, is too large.
    """

    def __init__(self, atoms: tuple[str, ...], first: int, predicates: Sequence[Formula]):
        self._atoms = {name: i for i, name in enumerate(atoms)}
        self._first = first
        unique = list(dict.fromkeys(predicates))
        self._compounds = [each for each in unique if not _is_literal(each)]
        if len(self._compounds) > LARGEST.compounds:
            raise GroundingError(
                f"the formula has {len(self._compounds):,} different state formulas that are "
                f"neither a region nor a negated region, but at most {LARGEST.compounds} are "
                "supported"
            )
        self._clauses = {each: clauses_of(each, LARGEST.literals) for each in unique}
        self._exclude: dict[tuple[Formula, Formula], bool] = {}

    @property
    def count(self) -> int:
        """Number of compound predicates."""
        return len(self._compounds)

    @property
    def literals(self) -> int:
        """Most clauses of a compound predicate, or literals of a clause."""
        found = [self._clauses[each] for each in self._compounds]
        return max((max(len(clauses), *map(len, clauses)) for clauses in found), default=0)

    def index(self, predicate: Formula) -> tuple[int, int]:
        """Index into mu_ext, and sign."""
        match predicate:
            case Atom(name=name):
                return self._atoms[name], 1
            case Not(operand=Atom(name=name)):
                return self._atoms[name], -1
        return self._first + self._compounds.index(predicate), 1

    def exclude(self, left: Formula, right: Formula) -> bool:
        """Whether no position is inside of both predicates."""
        pair = left, right
        if pair not in self._exclude:
            self._exclude[pair] = exclude(self._clauses[left], self._clauses[right])
        return self._exclude[pair]

    def clauses(self, sizes: Sizes) -> tuple[np.ndarray, np.ndarray]:
        """Atom and sign of each literal of the compound predicates [P, L, L], padded with 0."""
        shape = (sizes.compounds, sizes.literals, sizes.literals)
        atom, sign = np.zeros(shape, np.int32), np.zeros(shape, np.float32)
        for i, compound in enumerate(self._compounds):
            for j, clause in enumerate(self._clauses[compound]):
                for k, (name, polarity) in enumerate(clause):
                    atom[i, j, k], sign[i, j, k] = self._atoms[name], polarity
        return atom, sign


def _is_literal(predicate: Formula) -> bool:
    return isinstance(predicate.operand if isinstance(predicate, Not) else predicate, Atom)
