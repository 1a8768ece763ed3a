"""State formulas in English: `in A and outside B`."""

from core.stl.printer import quote_name
from core.stl.syntax import And, Atom, Constant, Formula, Implies, Not, Or


def place(formula: Formula) -> str:
    """Where a state formula has the robot be; parts that join others stand in parentheses."""
    match formula:
        case Constant(value=value):
            return "anywhere" if value else "nowhere"
        case Atom():
            return f"{'in ' if formula.place else ''}{quote_name(formula.name)}"
        case Not(operand=Atom() as atom):
            return f"{'outside' if atom.place else 'not'} {quote_name(atom.name)}"
        case Not(operand=Not(operand=operand)):
            return place(operand)
        case Not(operand=Or(operands=operands)):
            return _listed(tuple(map(Not, operands)), "and")
        case Not(operand=operand):
            return f"not {_part(operand)}"
        case And(operands=(Implies(left=a, right=b), Implies(left=c, right=d))) if (a, b) == (d, c):
            return f"{_part(a)} exactly when {_part(b)}"
        case And(operands=(Or(operands=(a, b)), Not(operand=And(operands=both)))) if both == (a, b):
            return f"either {_part(a)} or {_part(b)} but not both"
        case And(operands=operands):
            return _listed(operands, "and")
        case Or(operands=operands):
            return _listed(operands, "or")
        case Implies(left=left, right=right):
            return f"{_part(right)} if {_part(left)}"
    raise TypeError(f"not a state formula: {formula!r}")


def _part(formula: Formula) -> str:
    match formula:
        case Constant() | Atom() | Not(operand=Atom()):
            return place(formula)
        case Not(operand=Not(operand=operand)):
            return _part(operand)
    return f"({place(formula)})"


def _listed(operands: tuple[Formula, ...], word: str) -> str:
    """`in A, in B and outside C`."""
    *first, last = map(_part, operands)
    return f"{', '.join(first)} {word} {last}"
