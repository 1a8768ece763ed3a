from core.decompose.model import (
    Decomposition,
    DecompositionError,
    Guards,
    Kind,
    Requirement,
    Task,
    TimeExpr,
    TreeNode,
    Variable,
)
from core.decompose.rules import decompose
from core.decompose.text import TaskRow, edge_text, task_name, task_rows, to_text
from core.decompose.visits import enough_visits, least_visits

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
