"""From a decomposition to padded arrays: the formula as data.

Every window bound is affine in the schedule t (the values of the time and branch variables):

    start_k(t) = <start_weight_k, t> + start_offset_k,     likewise end_k,

and task k counts only where t agrees with its guards. A task's predicate is an index into the
extended margin vector mu_ext = (mu of the atoms, mu of the compound predicates) and a sign: the
predicate holds where sign * mu_ext[index] >= 0. Compound predicates (state formulas that are no
literal) are kept in disjunctive normal form, max over clauses of min over signed atoms.

Dimensions: V variables, G subgoals, C constraints, A atoms, P compound predicates of at most
L x L literals, D dynamic constraints (doors) at most, hence 2^D combinations of closed doors.
"""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from core.decompose import Decomposition, Kind, Task
from core.errors import UserError
from core.stl import And, Atom, Constant, Formula, Not, Or, atom_names, to_text

MAX_VARIABLES = 8
MAX_SUBGOALS = 12
MAX_CONSTRAINTS = 24
MAX_ATOMS = 32
MAX_COMPOUNDS = 8
MAX_LITERALS = 4
MAX_DOORS = 3
COMBINATIONS = 2**MAX_DOORS
MAX_REQUIREMENTS = 4
NEVER = 1e6
"""Start of a window that never opens [steps]."""


class GroundingError(UserError):
    """A formula that is larger than the padded arrays."""


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
    """Padded requirements <weight, t> >= minimum on schedules (chains of visits)."""

    weight: np.ndarray  # [Q, V]
    minimum: np.ndarray  # [Q], -NEVER for padding
    guard: np.ndarray  # [Q, V]


class FormulaArrays(NamedTuple):
    """A grounded formula."""

    low: np.ndarray  # [V] smallest value of each variable
    high: np.ndarray  # [V] largest value
    variables: np.ndarray  # [] number of variables
    horizon: np.ndarray  # [] steps of an episode
    subgoals: TaskArrays  # K = G
    constraints: TaskArrays  # K = C
    requirements: RequirementArrays
    clause_atom: np.ndarray  # [P, L, L] atom index of each literal
    clause_sign: np.ndarray  # [P, L, L] its sign, 0 for padding
    door: np.ndarray  # [C] 2^i for the i-th door, 0 for the others


@dataclass(frozen=True)
class Grounding:
    """Arrays of a formula, with the tasks they stand for (unpadded, in array order)."""

    decomposition: Decomposition
    atoms: tuple[str, ...]
    steps: int
    arrays: FormulaArrays
    subgoals: tuple[Task, ...]
    constraints: tuple[Task, ...]
    doors: tuple[int, ...]

    def closed_sets(self) -> list[tuple[int, ...]]:
        """Constraints that act as obstacles, for each of the combinations of closed doors."""
        static = tuple(i for i in range(len(self.constraints)) if i not in self.doors)
        weights = self.arrays.door.astype(int)
        return [
            static + tuple(i for i in self.doors if weights[i] & combination)
            for combination in range(2 ** max(0, len({weights[i] for i in self.doors})))
        ]


def ground(decomposition: Decomposition, atoms: tuple[str, ...], horizon: int) -> Grounding:
    """Pad the tasks of a decomposition.

    Args:
        decomposition: tasks and variables of the formula.
        atoms: names in the order of the world's margin vector; must contain the formula's.
        horizon: the scene's horizon T; the episode lasts max(T, horizon of the formula).

    Raises:
        GroundingError: more variables, tasks or predicates than the arrays hold.
    """
    subgoals = tuple(t for t in decomposition.tasks if t.kind is not Kind.INVARIANT)
    constraints = tuple(t for t in decomposition.tasks if t.kind is Kind.INVARIANT)
    _check_sizes(decomposition, subgoals, constraints, atoms)
    steps = max(horizon, decomposition.horizon)
    table = _PredicateTable(atoms)
    goal_arrays = _task_arrays(subgoals, MAX_SUBGOALS, table)
    constraint_arrays = _task_arrays(constraints, MAX_CONSTRAINTS, table)
    clause_atom, clause_sign = table.clauses()
    doors = tuple(i for i, task in enumerate(constraints) if _is_door(task, decomposition, steps))
    door = np.zeros(MAX_CONSTRAINTS, np.float32)
    for rank, index in enumerate(doors):
        door[index] = 2 ** min(rank, MAX_DOORS - 1)
    low, high = np.zeros(MAX_VARIABLES, np.int32), np.zeros(MAX_VARIABLES, np.int32)
    for i, variable in enumerate(decomposition.variables):
        low[i], high[i] = variable.low, variable.high
    arrays = FormulaArrays(
        low,
        high,
        np.asarray(len(decomposition.variables), np.int32),
        np.asarray(steps, np.int32),
        goal_arrays,
        constraint_arrays,
        _requirement_arrays(decomposition),
        clause_atom,
        clause_sign,
        door,
    )
    return Grounding(decomposition, tuple(atoms), steps, arrays, subgoals, constraints, doors)


def _check_sizes(decomposition, subgoals, constraints, atoms) -> None:
    found = {
        "time and branch variables": (len(decomposition.variables), MAX_VARIABLES),
        "subgoals": (len(subgoals), MAX_SUBGOALS),
        "invariant constraints": (len(constraints), MAX_CONSTRAINTS),
        "regions": (len(atoms), MAX_ATOMS),
        "requirements of G(F)": (len(decomposition.requirements), MAX_REQUIREMENTS),
    }
    for what, (given, allowed) in found.items():
        if given > allowed:
            raise GroundingError(
                f"the formula needs {given} {what}, at most {allowed} are supported; "
                "shorten the formula or split the mission"
            )
    unknown = set(atom_names(decomposition.formula)) - set(atoms)
    if unknown:
        raise GroundingError(
            f"unknown region {sorted(unknown)[0]!r} in the formula. Available: {sorted(atoms)}"
        )


def _is_door(task: Task, decomposition: Decomposition, steps: int) -> bool:
    """Whether a constraint opens or closes early enough for the way to depend on it.

    A constraint that covers most of the episode whatever the schedule is a fixed obstacle.
    """
    lows = [v.low for v in decomposition.variables]
    highs = [v.high for v in decomposition.variables]
    return task.end.at(lows) - task.start.at(highs) < 0.6 * steps


def _task_arrays(tasks: tuple[Task, ...], capacity: int, table: "_PredicateTable") -> TaskArrays:
    arrays = TaskArrays(
        mask=np.zeros(capacity, np.float32),
        predicate=np.zeros(capacity, np.int32),
        sign=np.ones(capacity, np.float32),
        start_weight=np.zeros((capacity, MAX_VARIABLES), np.float32),
        start_offset=np.zeros(capacity, np.float32),
        end_weight=np.zeros((capacity, MAX_VARIABLES), np.float32),
        end_offset=np.zeros(capacity, np.float32),
        guard=np.full((capacity, MAX_VARIABLES), -1, np.int32),
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


def _requirement_arrays(decomposition: Decomposition) -> RequirementArrays:
    arrays = RequirementArrays(
        np.zeros((MAX_REQUIREMENTS, MAX_VARIABLES), np.float32),
        np.full(MAX_REQUIREMENTS, -NEVER, np.float32),
        np.full((MAX_REQUIREMENTS, MAX_VARIABLES), -1, np.int32),
    )
    for i, requirement in enumerate(decomposition.requirements):
        for variable in requirement.total.variables:
            arrays.weight[i, variable] += 1
        arrays.minimum[i] = requirement.minimum - requirement.total.offset
        for variable, value in requirement.guards:
            arrays.guard[i, variable] = value
    return arrays


class _PredicateTable:
    """Hands out indices into mu_ext, adding a compound predicate when it meets a new one."""

    def __init__(self, atoms: tuple[str, ...]):
        self._atoms = {name: i for i, name in enumerate(atoms)}
        self._compounds: dict[Formula, list[list[tuple[int, int]]]] = {}

    def index(self, predicate: Formula) -> tuple[int, int]:
        match predicate:
            case Atom(name=name):
                return self._atoms[name], 1
            case Not(operand=Atom(name=name)):
                return self._atoms[name], -1
        if predicate not in self._compounds:
            self._compounds[predicate] = self._normal_form(predicate)
        if len(self._compounds) > MAX_COMPOUNDS:
            raise GroundingError(
                f"the formula has more than {MAX_COMPOUNDS} different state formulas that are "
                "neither a region nor a negated region"
            )
        return MAX_ATOMS + list(self._compounds).index(predicate), 1

    def _normal_form(self, predicate: Formula) -> list[list[tuple[int, int]]]:
        clauses = _disjunctive_normal_form(predicate)
        if len(clauses) > MAX_LITERALS or any(len(c) > MAX_LITERALS for c in clauses):
            raise GroundingError(
                f"the state formula {to_text(predicate)} needs more than {MAX_LITERALS} "
                f"alternatives of {MAX_LITERALS} regions each"
            )
        return [[(self._atoms[name], sign) for name, sign in clause] for clause in clauses]

    def clauses(self) -> tuple[np.ndarray, np.ndarray]:
        shape = (MAX_COMPOUNDS, MAX_LITERALS, MAX_LITERALS)
        atom, sign = np.zeros(shape, np.int32), np.zeros(shape, np.float32)
        for i, clauses in enumerate(self._compounds.values()):
            for j, clause in enumerate(clauses):
                for k, (index, polarity) in enumerate(clause):
                    atom[i, j, k], sign[i, j, k] = index, polarity
        return atom, sign


def _disjunctive_normal_form(formula: Formula) -> list[list[tuple[str, int]]]:
    """Clauses of (name, sign) of a state formula in negation normal form."""
    match formula:
        case Constant(value=value):
            raise GroundingError(
                f"the formula asks for {'true' if value else 'false'} as a task, which no robot "
                "can reach or leave; remove it"
            )
        case Atom(name=name):
            return [[(name, 1)]]
        case Not(operand=Atom(name=name)):
            return [[(name, -1)]]
        case Or(operands=operands):
            return [clause for o in operands for clause in _disjunctive_normal_form(o)]
        case And(operands=operands):
            parts = [_disjunctive_normal_form(o) for o in operands]
            return [list(dict.fromkeys(sum(choice, []))) for choice in product(*parts)]
    raise TypeError(f"not in negation normal form: {to_text(formula)}")
