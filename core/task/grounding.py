"""From a decomposition to padded arrays: the formula as data.

Every window bound is affine in the schedule t (the values of the time and branch variables):

    start_k(t) = <start_weight_k, t> + start_offset_k,     likewise end_k,

and task k applies only if t agrees with its guards. A task's predicate is an index into the
extended margin vector mu_ext = (mu of the atoms, mu of the compound predicates) and a sign: the
predicate holds where sign * mu_ext[index] >= 0. Compound predicates (state formulas that are not
literals) are kept in disjunctive normal form, max over clauses of min over signed atoms.

Dimensions: V variables, G subgoals, C constraints, A atoms, P compound predicates of at most
L x L literals, Q requirements, D doors, hence 2^D combinations of closed doors (see `sizes`).
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from core.decompose import Decomposition, Kind, Requirement, Subtask
from core.quoting import listed, quoted
from core.stl import Formula, atom_names
from core.task.predicates import PredicateTable
from core.task.sizes import GroundingError, Sizes, check_counts, sizes_for

MAX_ATOMS = 32
MAX_STEPS = 10_000
"""Steps of the longest episode."""
NEVER = 1e6
"""Start of a window that never opens [steps]."""


class TaskArrays(NamedTuple):
    """Windows and predicates of K padded tasks."""

    mask: np.ndarray  # [K] 1 for a task, 0 for padding
    predicate: np.ndarray  # [K] index into mu_ext
    sign: np.ndarray  # [K] +1 or -1
    start_weight: np.ndarray  # [K, V]
    start_offset: np.ndarray  # [K]
    end_weight: np.ndarray  # [K, V]
    end_offset: np.ndarray  # [K]
    guard: np.ndarray  # [K, V] value that the variable must have, -1 for any


class RequirementArrays(NamedTuple):
    """Padded requirements <weight, t> >= minimum on schedules (repeated visits)."""

    weight: np.ndarray  # [Q, V]
    minimum: np.ndarray  # [Q], -NEVER for padding
    guard: np.ndarray  # [Q, V]


class FormulaArrays(NamedTuple):
    """A grounded formula."""

    low: np.ndarray  # [V] smallest value of each variable
    high: np.ndarray  # [V] largest value
    variables: np.ndarray  # [] number of variables
    horizon: np.ndarray  # [] length of an episode [steps]
    subgoals: TaskArrays  # K = G
    constraints: TaskArrays  # K = C
    requirements: RequirementArrays
    clause_atom: np.ndarray  # [P, L, L] atom index of each literal
    clause_sign: np.ndarray  # [P, L, L] its sign, 0 for padding
    door: np.ndarray  # [C] 2^i for the i-th door, 0 for the others
    combinations: np.ndarray  # [] number of combinations of closed doors
    place: np.ndarray  # [G] index of the subgoal's predicate among those of all subgoals
    bars: np.ndarray  # [G, C] 1 if the constraint forbids the subgoal


@dataclass(frozen=True)
class Grounding:
    """Arrays of a formula, with the tasks they stand for (unpadded, in array order)."""

    decomposition: Decomposition
    atoms: tuple[str, ...]
    horizon: int
    """Length of an episode [steps]: max(T, horizon of the formula)."""
    arrays: FormulaArrays
    sizes: Sizes
    subgoals: tuple[Subtask, ...]
    constraints: tuple[Subtask, ...]
    doors: tuple[int, ...]

    def closed_sets(self) -> list[tuple[int, ...]]:
        """Constraints that act as obstacles, for each of the combinations of closed doors."""
        static = tuple(i for i in range(len(self.constraints)) if i not in self.doors)
        weights = self.arrays.door.astype(int)
        return [
            static + tuple(i for i in self.doors if weights[i] & combination)
            for combination in range(int(self.arrays.combinations))
        ]

    @cached_property
    def places(self) -> list[Formula]:
        """What the subgoals go to, each state formula once."""
        return _places(self.subgoals)


def ground(decomposition: Decomposition, atoms: tuple[str, ...], horizon: int) -> Grounding:
    """Pad the tasks of a decomposition.

    Args:
        decomposition: tasks and variables of the formula.
        atoms: names in the order of the world's margin vector; must contain the formula's.
        horizon: the scene's horizon T; the episode lasts max(T, horizon of the formula).

    Raises:
        GroundingError: more variables, tasks or predicates than the arrays hold, or too long an
            episode.
    """
    subgoals = tuple(t for t in decomposition.tasks if t.kind is not Kind.INVARIANT)
    constraints = tuple(t for t in decomposition.tasks if t.kind is Kind.INVARIANT)
    bounds = _bounds(decomposition)
    _check(decomposition, atoms)
    counts = {
        "variables": len(decomposition.variables),
        "subgoals": len(subgoals),
        "constraints": len(constraints),
        "requirements": len(bounds),
    }
    check_counts(counts)
    horizon = max(horizon, decomposition.horizon)
    table = PredicateTable(atoms, MAX_ATOMS, [task.predicate for task in (*subgoals, *constraints)])
    doors = _doors(constraints, decomposition, horizon)
    sizes = sizes_for(
        Sizes(
            **counts,
            compounds=table.count,
            literals=table.literals,
            doors=max(doors.values(), default=-1) + 1,
        )
    )
    clause_atom, clause_sign = table.clauses(sizes)
    door = np.zeros(sizes.constraints, np.float32)
    for index, rank in doors.items():
        door[index] = 2 ** min(rank, sizes.doors - 1)
    low, high = np.zeros(sizes.variables, np.int32), np.zeros(sizes.variables, np.int32)
    for i, variable in enumerate(decomposition.variables):
        low[i], high[i] = variable.low, variable.high
    places = _places(subgoals)
    place = np.zeros(sizes.subgoals, np.int32)
    place[: len(subgoals)] = [places.index(task.predicate) for task in subgoals]
    arrays = FormulaArrays(
        low,
        high,
        np.asarray(len(decomposition.variables), np.int32),
        np.asarray(horizon, np.int32),
        _task_arrays(subgoals, sizes.subgoals, sizes, table),
        _task_arrays(constraints, sizes.constraints, sizes, table),
        _requirement_arrays(bounds, sizes),
        clause_atom,
        clause_sign,
        door,
        np.asarray(2 ** len(set(door[door > 0])), np.int32),
        place,
        _bars(subgoals, constraints, sizes, table),
    )
    return Grounding(
        decomposition, tuple(atoms), horizon, arrays, sizes, subgoals, constraints, tuple(doors)
    )


def _places(subgoals: tuple[Subtask, ...]) -> list[Formula]:
    return list(dict.fromkeys(task.predicate for task in subgoals))


def _check(decomposition: Decomposition, atoms: tuple[str, ...]) -> None:
    for what, given, allowed in (
        ("regions", len(atoms), MAX_ATOMS),
        ("steps", decomposition.horizon, MAX_STEPS),
    ):
        if given > allowed:
            raise GroundingError(
                f"the formula needs {given:,} {what}, but at most {allowed:,} are supported; "
                "shorten the formula or split the mission"
            )
    unknown = set(atom_names(decomposition.formula)) - set(atoms)
    if unknown:
        raise GroundingError(
            f"unknown region {quoted(min(unknown))} in the formula. "
            f"Available: {listed(sorted(atoms))}"
        )


def _doors(
    constraints: tuple[Subtask, ...], decomposition: Decomposition, horizon: int
) -> dict[int, int]:
    """Indices of the constraints that are doors, and which door each belongs to.

    A predicate is one door, however many windows it has; predicates of equal windows share one.
    """
    indices = [i for i, task in enumerate(constraints) if _is_door(task, decomposition, horizon)]
    windows: dict[Formula, list[Any]] = {}
    for index in indices:
        task = constraints[index]
        windows.setdefault(task.predicate, []).append((task.guards, task.start, task.end))
    ranks: dict[frozenset[Any], int] = {}
    return {
        index: ranks.setdefault(frozenset(windows[constraints[index].predicate]), len(ranks))
        for index in indices
    }


def _is_door(task: Subtask, decomposition: Decomposition, horizon: int) -> bool:
    """Whether the way depends on when a constraint holds, or on whether it does.

    A constraint that covers most of the episode whatever the schedule is a fixed obstacle. One
    that belongs to a branch is closed where that branch is chosen.
    """
    if task.guards:
        return True
    lows = [v.low for v in decomposition.variables]
    highs = [v.high for v in decomposition.variables]
    return task.end.at(lows) - task.start.at(highs) < 0.6 * horizon


def _task_arrays(
    tasks: tuple[Subtask, ...], capacity: int, sizes: Sizes, table: PredicateTable
) -> TaskArrays:
    arrays = TaskArrays(
        mask=np.zeros(capacity, np.float32),
        predicate=np.zeros(capacity, np.int32),
        sign=np.ones(capacity, np.float32),
        start_weight=np.zeros((capacity, sizes.variables), np.float32),
        start_offset=np.zeros(capacity, np.float32),
        end_weight=np.zeros((capacity, sizes.variables), np.float32),
        end_offset=np.zeros(capacity, np.float32),
        guard=np.full((capacity, sizes.variables), -1, np.int32),
    )
    for i, task in enumerate(tasks):
        arrays.mask[i] = 1
        arrays.predicate[i], arrays.sign[i] = table.index(task.predicate)
        for variable in task.start.variables:
            arrays.start_weight[i, variable] += 1
        for variable in task.end.variables:
            arrays.end_weight[i, variable] += 1
        arrays.start_offset[i], arrays.end_offset[i] = task.start.offset, task.end.offset
        for variable, value in task.guards:
            arrays.guard[i, variable] = value
    return arrays


def _bars(
    subgoals: tuple[Subtask, ...],
    constraints: tuple[Subtask, ...],
    sizes: Sizes,
    table: PredicateTable,
) -> np.ndarray:
    """[G, C] 1 where a constraint leaves no position for a subgoal."""
    bars = np.zeros((sizes.subgoals, sizes.constraints), np.float32)
    for i, j in product(range(len(subgoals)), range(len(constraints))):
        bars[i, j] = table.exclude(subgoals[i].predicate, constraints[j].predicate)
    return bars


def _requirement_arrays(
    bounds: list[tuple[Requirement, int, int]], sizes: Sizes
) -> RequirementArrays:
    arrays = RequirementArrays(
        np.zeros((sizes.requirements, sizes.variables), np.float32),
        np.full(sizes.requirements, -NEVER, np.float32),
        np.full((sizes.requirements, sizes.variables), -1, np.int32),
    )
    for i, (requirement, sign, bound) in enumerate(bounds):
        for variable in requirement.total.variables:
            arrays.weight[i, variable] += sign
        for variable in requirement.since.variables:
            arrays.weight[i, variable] -= sign
        offset = requirement.total.offset - requirement.since.offset
        arrays.minimum[i] = sign * (bound - offset)
        for variable, value in requirement.guards:
            arrays.guard[i, variable] = value
    return arrays


def _bounds(decomposition: Decomposition) -> list[tuple[Requirement, int, int]]:
    """Requirements with the sign and the value of each of their bounds, below or above."""
    return [
        (requirement, sign, bound)
        for requirement in decomposition.requirements
        for sign, bound in ((1, requirement.minimum), (-1, requirement.maximum))
        if bound is not None
    ]
