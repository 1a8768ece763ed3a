"""The figure and the linear tasks of the paper, decomposed."""

import pytest

from core.decompose import (
    Kind,
    decompose,
    edge_text,
    task_name,
    task_rows,
)
from core.decompose import to_text as plan_text
from core.stl import parse, to_text

FIG_2 = "F_[5:10](mu1 & G_[2:4](mu2) & F_[1:3](mu3)) & G_[0:20](!mu0)"


def test_table_of_the_papers_figure():
    """Fig. 2 with a, b = 5, 10; a2, b2 = 2, 4; a3, b3 = 1, 3; c, d = 0, 20."""
    plan = decompose(parse(FIG_2))
    assert [(v.name, v.low, v.high) for v in plan.variables] == [("t1", 5, 10), ("t2", 1, 3)]
    assert task_rows(plan) == [
        ("Subgoal 1", "mu1", "t1", "t1", ""),
        ("Subgoal 2", "mu2", "t1 + 2", "t1 + 4", ""),
        ("Subgoal 3", "mu3", "t1 + t2", "t1 + t2", ""),
        ("Invariant", "!mu0", "0", "20", ""),
    ]
    assert [task.kind for task in plan.tasks] == [
        Kind.REACH,
        Kind.STAY,
        Kind.REACH,
        Kind.INVARIANT,
    ]
    assert plan.horizon == 20
    assert plan.requirements == ()


def test_tree_of_the_papers_figure():
    plan = decompose(parse(FIG_2))

    def outline(node):
        task = None if node.task is None else task_name(plan, node.task)
        below = [outline(child) for child in node.children]
        return (edge_text(node, plan.variables), node.label, task, below)

    assert outline(plan.tree) == (
        "",
        "Reach(phi, 0)",
        None,
        [
            (
                "t1 in [5, 10]",
                "Reach(phi0, t1)",
                None,
                [
                    ("", "Reach(mu1, t1)", "Subgoal 1", []),
                    ("", "Inv(mu2, [t1 + 2, t1 + 4])", "Subgoal 2", []),
                    ("t2 in [1, 3]", "Reach(mu3, t1 + t2)", "Subgoal 3", []),
                ],
            ),
            ("", "Inv(!mu0, [0, 20])", "Invariant", []),
        ],
    )
    assert [(name, to_text(formula)) for name, formula in plan.names] == [
        ("phi", FIG_2),
        ("phi0", "mu1 & G_[2:4](mu2) & F_[1:3](mu3)"),
    ]


def test_text_of_the_papers_figure():
    assert (
        plan_text(decompose(parse(FIG_2)))
        == """\
Reach(phi, 0)
├─ t1 in [5, 10]: Reach(phi0, t1)
│  ├─ Reach(mu1, t1)   <- Subgoal 1
│  ├─ Inv(mu2, [t1 + 2, t1 + 4])   <- Subgoal 2
│  └─ t2 in [1, 3]: Reach(mu3, t1 + t2)   <- Subgoal 3
└─ Inv(!mu0, [0, 20])   <- Invariant

phi = F_[5:10](mu1 & G_[2:4](mu2) & F_[1:3](mu3)) & G_[0:20](!mu0)
phi0 = mu1 & G_[2:4](mu2) & F_[1:3](mu3)

Task      | Predicate | Start   | End
----------+-----------+---------+--------
Subgoal 1 | mu1       | t1      | t1
Subgoal 2 | mu2       | t1 + 2  | t1 + 4
Subgoal 3 | mu3       | t1 + t2 | t1 + t2
Invariant | !mu0      | 0       | 20"""
    )


def avoid(stop: int, names: str) -> str:
    return " & ".join(f"G_[0:{stop}](!{name})" for name in names.split())


LINEAR = {
    "01": (f"F_[5:7](F_[50:85](A) & {avoid(90, 'B5 B1 B2 B3 B4')})", "5-7 50-85", 1, 5),
    "02": (
        f"F_[5:10](F_[0:50](A) & G_[60:80](C) & {avoid(90, 'B5 B1 B2 B3 B4')})",
        "5-10 0-50",
        2,
        5,
    ),
    "03": (
        f"F_[5:10](F_[0:50](A) & F_[40:60](C) & G_[70:80](D) & {avoid(90, 'B5 B0 B1 B2 B3 B4')})",
        "5-10 0-50 40-60",
        3,
        6,
    ),
    "04": (
        "F_[5:10](F_[0:50](A) & F_[40:50](C) & F_[70:80](F) & G_[50:60](D) & "
        f"{avoid(90, 'B E B1 B2 B3 B4')})",
        "5-10 0-50 40-50 70-80",
        4,
        6,
    ),
    "05": (
        "F_[5:10](F_[0:30](A) & F_[30:50](C) & F_[70:80](F) & F_[75:88](H) & G_[50:60](D) & "
        f"{avoid(90, 'B E G B1 B2 B3 B4')})",
        "5-10 0-30 30-50 70-80 75-88",
        5,
        7,
    ),
    "06": (f"F_[10:90](A) & {avoid(100, 'B1 B2 B3 B4 B5')}", "10-90", 1, 5),
    "07": (
        f"F_[0:90](A1) & F_[40:80](A2) & {avoid(100, 'B1 B2 B3 B4 B5')}",
        "0-90 40-80",
        2,
        5,
    ),
    "08": (
        f"F_[0:90](A1) & F_[40:80](A2 & F_[10:20](G_[0:10](A3))) & {avoid(100, 'B1 B2 B3 B4 B5')}",
        "0-90 40-80 10-20",
        3,
        5,
    ),
    "09": (
        "F_[5:20](A1 & F_[10:20](G_[0:5](A2) & F_[10:30](G_[0:5](A3)) & "
        f"F_[10:30](G_[0:10](A4)))) & {avoid(100, 'B1 B2 B3 B4 B5 B6 B7 B8 B9')}",
        "5-20 10-20 10-30 10-30",
        4,
        9,
    ),
    "10": (
        "(!D1)U_[0:100](K1) & (!D2)U_[0:100](K2) & (!D3)U_[0:100](K3) & "
        f"F_[80:90](G_[0:5](G)) & {avoid(100, 'B1 B2 B3 B4 B5')}",
        "0-100 0-100 0-100 80-90",
        4,
        8,
    ),
}


@pytest.mark.parametrize("number", LINEAR)
def test_linear_tasks_of_the_paper(number: str):
    text, expected, subgoals, constraints = LINEAR[number]
    plan = decompose(parse(text))
    assert " ".join(f"{v.low}-{v.high}" for v in plan.variables) == expected
    kinds = [task.kind for task in plan.tasks]
    assert len(kinds) - kinds.count(Kind.INVARIANT) == subgoals
    assert kinds.count(Kind.INVARIANT) == constraints
