"""A quick bound on the robustness of any trace, by interval arithmetic over the formula."""

from collections.abc import Mapping

from core.planning.outline import Facets, Sides
from core.planning.program import INFINITY, Program
from core.planning.reach import Boxes
from core.planning.values import Values
from core.stl import Atom, Formula, Not, atom_names


def ceiling(formula: Formula, boxes: Boxes, sides: Mapping[str, Sides]) -> float:
    """What the robustness of no trace exceeds whose positions lie in boxes [m].

    Args:
        formula: in negation normal form, without constants.
        boxes: that contain the position at every step.
        sides: what stands for the regions.
    """
    depths = {name: _depth(sides[name].wanted) for name in atom_names(formula)}

    def most(literal: Formula, step: int) -> float:
        low, high = boxes.low[step], boxes.high[step]
        match literal:
            case Atom(name):
                return min(depths[name], float(-sides[name].wanted.least(low, high).max()))
            case Not(operand=Atom(name)):
                return float(sides[name].avoided.most(low, high).max())
        raise TypeError(f"not a literal: {literal!r}")

    return Values(most).of(formula, 0)


def _depth(facets: Facets) -> float:
    """Largest distance to all facets that a position can have [m]."""
    program = Program()
    position = [program.column(-INFINITY, INFINITY) for _ in facets.normals[0]]
    depth = program.column(-INFINITY, INFINITY)
    for normal, offset in zip(*facets, strict=True):
        terms = dict(zip(position, normal.tolist(), strict=True)) | {depth: 1.0}
        program.row(terms, -INFINITY, offset)
    return program.maximise(depth, INFINITY).bound
