"""Decomposition of a formula into reach and invariance tasks with time variables.

The rules stand in `core.decomposition.rules`, the data in `core.decomposition.model`.
"""

from core.decomposition import (
    Decomposition,
    DecompositionError,
    Guards,
    Kind,
    Requirement,
    Task,
    TaskRow,
    TimeExpr,
    TreeNode,
    Variable,
    decompose,
    edge_text,
    enough_visits,
    least_visits,
    task_name,
    task_rows,
    to_text,
)

__all__ = [
    "Decomposition",
    "DecompositionError",
    "Guards",
    "Kind",
    "Requirement",
    "Task",
    "TaskRow",
    "TimeExpr",
    "TreeNode",
    "Variable",
    "decompose",
    "edge_text",
    "enough_visits",
    "least_visits",
    "task_name",
    "task_rows",
    "to_text",
]
