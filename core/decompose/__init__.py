from core.decompose.advice import advice, strict_until
from core.decompose.model import (
    Decomposition,
    DecompositionError,
    Guards,
    Kind,
    Requirement,
    Subtask,
    TimeExpr,
    TreeNode,
    Variable,
)
from core.decompose.offer import stronger
from core.decompose.rules import decompose
from core.decompose.text import TaskRow, edge_text, left_out, task_name, task_rows, to_text
from core.decompose.visits import enough_visits, least_visits

__all__ = [
    "Decomposition",
    "DecompositionError",
    "Guards",
    "Kind",
    "Requirement",
    "Subtask",
    "TaskRow",
    "TimeExpr",
    "TreeNode",
    "Variable",
    "advice",
    "decompose",
    "edge_text",
    "enough_visits",
    "least_visits",
    "left_out",
    "strict_until",
    "stronger",
    "task_name",
    "task_rows",
    "to_text",
]
