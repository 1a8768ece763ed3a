"""How deep and how large a formula may be, known from lark's tree before it is built.

`<->` and `xor` write both sides twice; chains of them would grow exponentially.
"""

from lark import Tree

MAX_DEPTH = 64
"""Operators nested in one another, and parentheses nested in one another."""

MAX_SIZE = 10_000
"""Names and operators; only `<->` and `xor` can exceed it."""

_NO_OPERATOR = {
    "parentheses",
    "name",
    "quoted",
    "latex_text",
    "true",
    "false",
    "interval",
    "bound",
    "open",
}


def too_large(root: Tree) -> tuple[str, Tree] | None:
    """What is too much and where, or None; without recursion.

    Args:
        root: of a formula.
    """
    pending, order = [(root, 0, 0)], []
    while pending:
        node, operators, parentheses = pending.pop()
        order.append(node)
        operators += _levels(node)
        parentheses += node.data == "parentheses"
        if max(operators, parentheses) > MAX_DEPTH:
            what = "operators" if operators > MAX_DEPTH else "parentheses"
            return f"more than {MAX_DEPTH} {what} are nested in each other", node
        pending += [(child, operators, parentheses) for child in subtrees(node)]
    sizes: dict[int, int] = {}
    for node in reversed(order):
        size = sizes[id(node)] = _size(node, [sizes[id(child)] for child in subtrees(node)])
        if size > MAX_SIZE:
            return f"written without <-> and xor it has more than {MAX_SIZE:,} operators", node
    return None


def subtrees(node: Tree) -> list[Tree]:
    """Children but for the tokens."""
    return [child for child in node.children if isinstance(child, Tree)]


def _levels(node: Tree) -> int:
    """Operators that a node nests its operands in, at most."""
    match node.data:
        case "equivalence":
            return 2
        case "exclusive":
            return 3 * (len(subtrees(node)) - 1)
    return int(node.data not in _NO_OPERATOR)


def _size(node: Tree, parts: list[int]) -> int:
    """Nodes of the formula that is built from a node."""
    match node.data:
        case "equivalence":
            return 2 * sum(parts) + 3
        case "exclusive":
            total = parts[0]
            for part in parts[1:]:
                total = 2 * (total + part) + 4
            return total
        case "interval" | "bound" | "open":
            return 0
    return sum(parts) + (node.data != "parentheses")
