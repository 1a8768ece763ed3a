"""The decomposition for reading: the tree and the table of tasks, as in the paper's Fig. 2."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from core.decompose.model import Decomposition, Guards, Kind, TimeExpr, TreeNode, Variable
from core.stl import to_text as formula_text


class TaskRow(NamedTuple):
    """A row of the table; `when` names the branches in which the task counts."""

    task: str
    predicate: str
    start: str
    end: str
    when: str


def task_name(decomposition: Decomposition, index: int) -> str:
    """`Subgoal 2`, `Invariant 1`; an invariant without siblings has no number."""
    invariant = [task.kind is Kind.INVARIANT for task in decomposition.tasks]
    number = sum(kind == invariant[index] for kind in invariant[: index + 1])
    if not invariant[index]:
        return f"Subgoal {number}"
    return f"Invariant {number}" if sum(invariant) > 1 else "Invariant"


def task_rows(decomposition: Decomposition) -> list[TaskRow]:
    """Return the table of tasks, in the order of the formula."""
    variables = decomposition.variables
    return [
        TaskRow(
            task_name(decomposition, index),
            formula_text(task.predicate),
            task.start.text(variables),
            task.end.text(variables),
            _guards_text(task.guards, variables),
        )
        for index, task in enumerate(decomposition.tasks)
    ]


def edge_text(node: TreeNode, variables: Sequence[Variable]) -> str:
    """Write what the edge to a node carries: `t1 in [5, 10]`, `b1 = 0`, or nothing."""
    if node.variable is None:
        return ""
    variable = variables[node.variable]
    if node.choice is not None:
        return f"{variable.name} = {node.choice}"
    return f"{variable.name} in [{variable.low}, {variable.high}]"


def left_out(decomposition: Decomposition) -> str:
    """Say which satisfying traces fit no schedule; empty if each fits one."""
    missing = decomposition.visits_missing
    reasons = []
    if missing:
        more = "one visit" if missing == 1 else f"up to {missing} visits"
        reasons.append(f"repeated visits are planned without {more} that irregular traces need")
    if decomposition.one_sided:
        reasons.append("a choice for each step is planned as one for the whole window")
    text = "; ".join(reasons)
    return text[:1].upper() + text[1:]


def to_text(decomposition: Decomposition) -> str:
    """Tree, short names, branches, requirements, tasks and what is left out, as plain text."""
    blocks = [
        list(_tree_lines(decomposition, decomposition.tree)),
        [f"{name} = {formula_text(formula)}" for name, formula in decomposition.names],
        _branch_lines(decomposition),
        _requirement_lines(decomposition),
        _table_lines(decomposition),
        [left_out(decomposition)] if left_out(decomposition) else [],
    ]
    return "\n\n".join("\n".join(block) for block in blocks if block)


def _tree_lines(
    decomposition: Decomposition, node: TreeNode, first: str = "", rest: str = ""
) -> Iterator[str]:
    edge = edge_text(node, decomposition.variables)
    task = "" if node.task is None else f"   <- {task_name(decomposition, node.task)}"
    yield f"{first}{edge + ': ' if edge else ''}{node.label}{task}"
    for child in node.children:
        corner, line = ("└─ ", "   ") if child is node.children[-1] else ("├─ ", "│  ")
        yield from _tree_lines(decomposition, child, rest + corner, rest + line)


def _branch_lines(decomposition: Decomposition) -> list[str]:
    return [
        f"{variable.name} = {value}: {label}"
        for variable in decomposition.variables
        for value, label in enumerate(variable.labels)
    ]


def _requirement_lines(decomposition: Decomposition) -> list[str]:
    lines = []
    for requirement in decomposition.requirements:
        total = requirement.total.text(decomposition.variables)
        if requirement.since != TimeExpr():
            total += f" - ({requirement.since.text(decomposition.variables)})"
        lower = "" if requirement.minimum is None else f"{requirement.minimum} <= "
        upper = "" if requirement.maximum is None else f" <= {requirement.maximum}"
        when = _guards_text(requirement.guards, decomposition.variables)
        lines.append(f"required: {lower}{total}{upper}{' when ' + when if when else ''}")
    return lines


def _table_lines(decomposition: Decomposition) -> list[str]:
    header = TaskRow("Task", "Predicate", "Start", "End", "When")
    rows = [header, *task_rows(decomposition)]
    columns = 5 if any(row.when for row in rows[1:]) else 4
    widths = [max(len(row[i]) for row in rows) for i in range(columns)]
    lines = [
        " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)).rstrip()
        for row in rows
    ]
    return [lines[0], "-+-".join("-" * width for width in widths), *lines[1:]]


def _guards_text(guards: Guards, variables: Sequence[Variable]) -> str:
    return ", ".join(f"{variables[index].name} = {value}" for index, value in guards)
