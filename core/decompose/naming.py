"""Short names for the subformulas in the tree: phi for the whole, phi0, phi1, ... inside."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import count

from core.decompose.model import TreeNode, Variable
from core.stl import Formula, atom_names

Names = tuple[tuple[str, Formula], ...]


def name_nodes(tree: TreeNode, variables: Sequence[Variable]) -> tuple[TreeNode, Names]:
    """Label the nodes that are not tasks `Reach(phi0, t1)` or `Inv(phi0, [0, t1])`.

    Equal subformulas share a name.
    """
    fresh = _fresh_names(set(atom_names(tree.formula)))
    names: dict[Formula, str] = {}

    def named(node: TreeNode) -> TreeNode:
        if node.task is not None:
            return node
        if node.formula not in names:
            names[node.formula] = next(fresh)
        name, start = names[node.formula], node.time.text(variables)
        label = f"Reach({name}, {start})"
        if node.end is not None:
            label = f"Inv({name}, [{start}, {node.end.text(variables)}])"
        return replace(node, label=label, children=tuple(named(c) for c in node.children))

    labelled = named(tree)
    return labelled, tuple((name, formula) for formula, name in names.items())


def _fresh_names(taken: set[str]) -> Iterator[str]:
    candidates = ("phi" if i < 0 else f"phi{i}" for i in count(-1))
    return (name for name in candidates if name not in taken)
