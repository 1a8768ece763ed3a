"""A rollout as a table, in memory: CSV for spreadsheets, npz for NumPy.

Rows are the steps 0 ... T. The action of a step leads to the next one, so the last row has none;
the robustness of a subformula exists only where the rollout is long enough to decide it. Missing
numbers are empty cells in CSV and NaN in npz.
"""

import csv
import io
from dataclasses import dataclass
from typing import cast

import numpy as np

from core.between import Between, between
from core.monitor import monitor_rows
from core.stl import to_text
from core.task.task import Task
from envs import Robot

FORMAT = 1
"""Version of the npz files."""


@dataclass(frozen=True, eq=False)
class RolloutTable:
    """One rollout with the names of its columns; T steps, S subformulas.

    Attributes:
        task: name of the task.
        formula: its text.
        time: [T + 1] in [s].
        state: [T + 1, n], units in the names.
        action: [T, m], normalised, in [-1, 1] as the robot executed it.
        margins: [T + 1, A] of the regions [m], >= 0 inside, then of the predicates of the state.
        robustness: [T + 1, S] of the subformulas, the formula first [m]; NaN where undecided.
        schedule: [V] values of the variables [steps].
        between: what the rollout does between its steps.
        satisfied: the verdict, between the steps, too, where the task asks for it.
        moves: steps at which somebody has put the robot somewhere else.
    """

    task: str
    formula: str
    time: np.ndarray
    state: np.ndarray
    action: np.ndarray
    margins: np.ndarray
    robustness: np.ndarray
    schedule: np.ndarray
    state_names: tuple[str, ...]
    action_names: tuple[str, ...]
    region_names: tuple[str, ...]
    predicate_names: tuple[str, ...]
    subformulas: tuple[str, ...]
    variable_names: tuple[str, ...]
    between: Between
    satisfied: bool
    moves: tuple[int, ...] = ()


def rollout_table(  # noqa: PLR0913
    task: Task,
    schedule: np.ndarray,
    states: np.ndarray,
    actions: np.ndarray,
    margins: np.ndarray,
    *,
    moves: tuple[int, ...] = (),
) -> RolloutTable:
    """Collect one rollout of a task.

    Args:
        task: the grounded task.
        schedule: values of the variables, padding included or not.
        states: [L + 1, n], L at least the task's horizon.
        actions: [L, m] as the policy gave them.
        margins: [L + 1, A] of the atoms, padding included or not [m].
        moves: steps at which somebody has put the robot somewhere else.
    """
    robot, names = cast(Robot, task.robot), task.grounding.atoms
    variables = task.grounding.decomposition.variables
    length = task.horizon + 1
    margins = np.asarray(margins, float)[:length, : len(names)]
    rows = monitor_rows(task.formula, margins, names)
    robustness = np.full((length, len(rows)), np.nan)
    found = between(task, np.asarray(states)[:length])
    for column, row in enumerate(rows):
        robustness[: len(row.signal), column] = row.signal
    return RolloutTable(
        task=task.name,
        formula=to_text(task.formula),
        time=np.round(np.arange(length) * robot.dt, 9),
        state=np.asarray(states, float)[:length],
        action=np.clip(np.asarray(actions, float)[: task.horizon], -1, 1),
        margins=margins,
        robustness=robustness,
        schedule=np.asarray(schedule, np.int64)[: len(variables)],
        state_names=robot.state_names,
        action_names=robot.action_names,
        region_names=tuple(name for name in names if name not in task.predicate_names),
        predicate_names=tuple(name for name in names if name in task.predicate_names),
        subformulas=tuple(row.text for row in rows),
        variable_names=tuple(variable.name for variable in variables),
        between=found,
        satisfied=bool(robustness[0, 0] >= 0) and (found.holds or not task.between_steps),
        moves=moves,
    )


def rollout_csv(table: RolloutTable) -> bytes:
    """Write UTF-8 CSV with one header line; numbers to 9 significant digits."""
    # Every header begins with our own word, so a region `=1+1` is not a spreadsheet formula.
    header = [
        "time [s]",
        *(f"state {name}" for name in table.state_names),
        *(f"action {name}" for name in table.action_names),
        *(f"margin {name} [m]" for name in table.region_names),
        *(f"margin {name}" for name in table.predicate_names),
        *(f"robustness {text} [m]" for text in table.subformulas),
    ]
    action = np.full((len(table.time), table.action.shape[1]), np.nan)
    action[: len(table.action)] = table.action
    columns = (table.time[:, None], table.state, action, table.margins, table.robustness)
    file = io.StringIO(newline="")
    writer = csv.writer(file)
    writer.writerow(header)
    for row in np.concatenate(columns, axis=1):
        writer.writerow(["" if np.isnan(value) else f"{value:.9g}" for value in row])
    return file.getvalue().encode()


def rollout_npz(table: RolloutTable) -> bytes:
    """Write a compressed npz of numbers and text; `numpy.load` needs no pickle."""
    file, found = io.BytesIO(), table.between
    np.savez_compressed(
        file,
        format=np.int64(FORMAT),
        task=np.str_(table.task),
        formula=np.str_(table.formula),
        satisfied=np.bool_(table.satisfied),
        time=table.time,
        state=table.state,
        action=table.action,
        margins=table.margins,
        robustness=table.robustness,
        schedule=table.schedule,
        state_names=np.array(table.state_names, np.str_),
        action_names=np.array(table.action_names, np.str_),
        region_names=np.array(table.region_names, np.str_),
        predicate_names=np.array(table.predicate_names, np.str_),
        subformulas=np.array(table.subformulas, np.str_),
        variable_names=np.array(table.variable_names, np.str_),
        between_margin=np.float64(found.margin),
        between_invariant=np.str_("" if found.invariant is None else to_text(found.invariant)),
        between_step=np.int64(found.step),
        between_position=np.array(found.position, float),
        moves=np.array(table.moves, np.int64),
    )
    return file.getvalue()
