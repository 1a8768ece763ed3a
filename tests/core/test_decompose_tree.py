"""The tree of a decomposition, and how it reads as text."""

import pytest

from core.decompose import (
    decompose,
    edge_text,
)
from core.decompose import to_text as plan_text
from core.stl import parse
from tests.core.test_decompose import RULES


def test_text_shows_branches_and_requirements():
    text = plan_text(decompose(parse("G_[1:2](!A) | G_[0:9](F_[0:3](A))")))
    assert "\n├─ b1 = 0: Inv(!A, [1, 2])   <- Invariant\n" in text
    assert "b1 = 0: G_[1:2](!A)\nb1 = 1: G_[0:9](F_[0:3](A))\n" in text
    assert "\nrequired: 9 <= t1 + t2 + t3 when b1 = 1\n" in text
    assert "\nInvariant | !A        | 1            | 2            | b1 = 0\n" in text


def test_equal_subformulas_share_a_short_name_that_is_no_region():
    plan = decompose(parse("G_[0:2](F_[0:1](phi0 & F_[1:2](B)))"))
    labels = [node.label for node in plan.tree.walk() if node.task is None]
    assert labels == ["Reach(phi, 0)", "Reach(phi1, t1)", "Reach(phi1, t1 + t3)"]


def test_branches_in_the_tree():
    plan = decompose(parse("!((A)U_[1:3](B)) & G_[0:9](C)"))
    edges = [edge_text(node, plan.variables) for node in plan.tree.walk()]
    labels = [node.label for node in plan.tree.walk()]
    assert list(zip(edges, labels, strict=True)) == [
        ("", "Reach(phi, 0)"),
        ("", "Reach(phi0, 0)"),
        ("b1 = 0", "Inv(!B, [1, 3])"),
        ("b1 = 1", "Reach(phi0, 0)"),
        ("t1 in [0, 3]", "Reach(!A, t1)"),
        ("", "Inv(!B, [1, t1 - 1])"),
        ("", "Inv(C, [0, 9])"),
    ]


@pytest.mark.parametrize("text", [text for text, _, _ in RULES.values()])
def test_every_task_is_a_leaf_of_the_tree(text: str):
    plan = decompose(parse(text))
    leaves = [node for node in plan.tree.walk() if node.task is not None]
    assert [node.task for node in leaves] == list(range(len(plan.tasks)))
    assert all(not node.children for node in leaves)
    introduced = {node.variable for node in plan.tree.walk()} - {None}
    assert introduced == set(range(len(plan.variables)))
