"""Which holds cannot be met at once, and how far apart they are.

A hold *keeps company* with those that count wherever it counts and whose windows certainly
contain its window: they hold meanwhile. It is hopeless if no position satisfies it and its
company, and it conflicts with another if no position satisfies both and their company: then one
window must end before the other begins, by the time that the way takes.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from core.stl import Formula, conjunction
from core.task.feasibility.bounds import Bounds, apart
from core.task.feasibility.obligations import Hold, Obligations
from core.task.feasibility.places import Geometry


@dataclass(frozen=True, eq=False)
class Conflicts:
    """Of the obligations of a formula.

    Attributes:
        obligations: whose holds are meant; they are numbered.
        geometry: of the regions.
        bounds: on the steps, before anything is known of travel.
        strict: whether places that only touch count as apart: no robot stays on a boundary.
        ignored: holds that are taken to ask for nothing.
    """

    obligations: Obligations
    geometry: Geometry
    bounds: Bounds
    strict: bool
    ignored: frozenset[int] = frozenset()
    _company: dict[int, tuple[int, ...]] = field(default_factory=dict)
    _hopeless: dict[int, bool] = field(default_factory=dict)
    _gaps: dict[tuple[int, int], np.ndarray | None] = field(default_factory=dict)

    def beginning_at(self, start: np.ndarray) -> "Conflicts":
        """The same from a single position [d] of the initial set; what still holds is kept."""
        alone = {i for i in range(len(self.obligations.holds)) if 0 not in self.company(i)}
        return replace(
            self,
            geometry=self.geometry.beginning_at(start),
            _hopeless={i: known for i, known in self._hopeless.items() if i in alone},
            _gaps={pair: known for pair, known in self._gaps.items() if alone.issuperset(pair)},
        )

    def company(self, i: int) -> tuple[int, ...]:
        """A hold and those that keep company with it."""
        if i not in self._company:
            holds = self.obligations.holds
            found = [j for j in range(len(holds)) if j != i and self._covers(holds[j], holds[i])]
            self._company[i] = (i, *(j for j in found if j not in self.ignored))
        return self._company[i]

    def hopeless(self, i: int) -> bool:
        """Whether a hold can only be met by an empty window."""
        if i not in self._hopeless:
            self._hopeless[i] = self.apart(self.company(i))
        return self._hopeless[i]

    def gaps(self, i: int, j: int) -> np.ndarray | None:
        """Distances between two holds in conflict, as `Geometry.gaps`; None if they can meet."""
        key = (min(i, j), max(i, j))
        if key not in self._gaps:
            both = dict.fromkeys((*self.company(i), *self.company(j)))
            gaps = self.geometry.gaps(self.wanted(i), self.wanted(j))
            if not self._far(gaps) and not self.apart(tuple(both)):
                gaps = None
            self._gaps[key] = gaps
        return self._gaps[key]

    def wanted(self, i: int) -> Formula:
        """The state formula of a hold with its company."""
        return self.joint(self.company(i))

    def joint(self, holds: tuple[int, ...]) -> Formula:
        """The conjunction of some holds' state formulas."""
        predicates = [self.obligations.holds[i].predicate for i in holds]
        return conjunction(tuple(dict.fromkeys(predicates)))

    def apart(self, holds: tuple[int, ...]) -> bool:
        """Whether no position satisfies all of some holds."""
        best, tolerance = self.geometry.best(self.joint(holds)), self.geometry.places.tolerance
        return best.reached <= tolerance if self.strict else best.bound < -tolerance

    def can_be_empty(self, hold: Hold) -> bool:
        """Whether a window may be empty."""
        return self.bounds.allows(apart(hold.end, hold.start, 1))

    def _far(self, gaps: np.ndarray) -> bool:
        """Whether the pieces of two state formulas are apart, whichever two are looked at."""
        return not len(gaps) or float(gaps[:, -1].min()) > self.geometry.places.tolerance

    def _covers(self, other: Hold, hold: Hold) -> bool:
        within = hold.scope[: len(other.scope)] == other.scope
        return (
            within
            and self.bounds.implies(apart(other.start, hold.start, 0))
            and self.bounds.implies(apart(hold.end, other.end, 0))
        )
