from core.decomposition.model import (
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
from core.decomposition.rules import decompose
from core.decomposition.text import TaskRow, edge_text, task_name, task_rows, to_text
from core.decomposition.visits import enough_visits, least_visits

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
