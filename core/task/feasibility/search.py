"""Whether some choice of steps and alternatives leaves time for everything.

A disjunctive temporal problem: of two holds in conflict, one must end before the other begins,
by as many steps as the way takes; a hopeless hold must be empty. Options that contradict what is
known are dropped; where one is left it is taken; where several are left, each is tried.
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import combinations

from core.task.feasibility.bounds import Bounds, Constraint, apart
from core.task.feasibility.conflicts import Conflicts
from core.task.feasibility.obligations import Scope
from core.task.feasibility.travel import Travel

PATIENCE = 5_000
"""Looks at pairs of holds before a question is left open."""


class OpenQuestionError(Exception):
    """The search has lost its patience."""


@dataclass
class Search:
    """Searches for steps that meet the obligations.

    Attributes:
        conflicts: between the holds.
        travel: how long ways take.
    """

    conflicts: Conflicts
    travel: Travel
    _looks: int = 0
    _steps: dict[tuple[int, int, int], int] = field(default_factory=dict)

    def possible(self, kept: Collection[int] | None = None, *, scope: Scope = ()) -> bool:
        """Whether there is a solution, or the question stays open."""
        try:
            return self.solution(kept, scope=scope) is not None
        except OpenQuestionError:
            return True

    def solution(
        self,
        kept: Collection[int] | None = None,
        *,
        bounds: Bounds | None = None,
        scope: Scope = (),
    ) -> Bounds | None:
        """Bounds all of whose solutions meet the obligations; None if there are none.

        Args:
            kept: Holds that count; all unless given.
            bounds: On the steps; those of the formula unless given.
            scope: Alternatives that are chosen beforehand.

        Raises:
            OpenQuestionError: it takes too long to tell.
        """
        self._looks = 0
        holds = range(len(self.conflicts.obligations.holds)) if kept is None else kept
        counting = frozenset(i for i in holds if i not in self.conflicts.ignored)
        bounds = self.conflicts.bounds if bounds is None else bounds
        return self._solved(bounds, counting, scope)

    def least(self, i: int, j: int, bounds: Bounds) -> int:
        """Least steps from the end of a hold to the start of another one."""
        since = bounds.last(self.conflicts.obligations.holds[i].end)
        if (i, j, since) not in self._steps:
            gaps = self.conflicts.gaps(i, j)
            assert gaps is not None
            self._steps[i, j, since] = self.travel.steps(gaps, since)
        return self._steps[i, j, since]

    def _solved(
        self,
        bounds: Bounds,
        counting: frozenset[int],
        scope: Scope,
    ) -> Bounds | None:
        """Solve with the alternatives in `scope`."""
        open_pairs = self._pairs(counting, scope)
        propagated = self._propagated(bounds, open_pairs)
        if propagated is None:
            return None
        bounds, left = propagated
        if left:
            for option in self._options(bounds, left[0]):
                if bounds.allows(option):
                    found = self._solved(bounds.having(option), counting, scope)
                    if found is not None:
                        return found
            return None
        return self._chosen(bounds, counting, scope)

    def _chosen(self, bounds: Bounds, counting: frozenset[int], scope: Scope) -> Bounds | None:
        """Try the alternatives of the next choice that counts."""
        decided = dict(scope)
        for number, choice in enumerate(self.conflicts.obligations.choices):
            if number not in decided and set(choice.scope) <= set(scope):
                for value in range(len(choice.alternatives)):
                    found = self._solved(bounds, counting, (*scope, (number, value)))
                    if found is not None:
                        return found
                return None
        return bounds

    def _pairs(self, counting: frozenset[int], scope: Scope) -> list[tuple[int, int]]:
        """Holds that count and conflict; a hopeless one with itself."""
        holds, chosen = self.conflicts.obligations.holds, set(scope)
        active = [i for i in sorted(counting) if set(holds[i].scope) <= chosen]
        alone = [(i, i) for i in active if self.conflicts.hopeless(i)]
        pairs = combinations([i for i in active if (i, i) not in alone], 2)
        return alone + [pair for pair in pairs if self.conflicts.gaps(*pair) is not None]

    def _propagated(
        self, bounds: Bounds, pairs: list[tuple[int, int]]
    ) -> tuple[Bounds, list[tuple[int, int]]] | None:
        """Bounds with all that follows, and the pairs with several options left."""
        changed = True
        while changed:
            changed, left = False, []
            for pair in pairs:
                self._looks += 1
                if self._looks > PATIENCE:
                    raise OpenQuestionError
                options = self._options(bounds, pair)
                if any(map(bounds.implies, options)):
                    continue
                options = [option for option in options if bounds.allows(option)]
                if not options:
                    return None
                if len(options) == 1:
                    bounds, changed = bounds.having(options[0]), True
                else:
                    left.append(pair)
            pairs = left
        return bounds, pairs

    def _options(self, bounds: Bounds, pair: tuple[int, int]) -> list[Constraint]:
        i, j = pair
        one, other = (self.conflicts.obligations.holds[k] for k in pair)
        empty = [
            apart(hold.end, hold.start, 1)
            for hold in dict.fromkeys((one, other))
            if self.conflicts.can_be_empty(hold)
        ]
        if i == j:
            return empty
        orders = [
            apart(one.end, other.start, self.least(i, j, bounds)),
            apart(other.end, one.start, self.least(j, i, bounds)),
        ]
        return orders + empty
