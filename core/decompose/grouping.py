"""Members of conjunctions and disjunctions as the rules count them."""

from core.stl import And, Formula, Or, Span, is_state_formula


def flat(formula: And | Or) -> list[Formula]:
    """Operands, those of nested nodes of the same type included."""
    operands: list[Formula] = []
    for operand in formula.operands:
        operands += flat(operand) if isinstance(operand, type(formula)) else [operand]
    return operands


def grouped(formula: And | Or) -> list[Formula]:
    """Operands, the state formulas among them joined where the first of them stands."""
    operands = flat(formula)
    states = [operand for operand in operands if is_state_formula(operand)]
    if len(states) < 2:
        return operands
    spans = [state.span for state in states if state.span]
    span = Span(min(s.start for s in spans), max(s.stop for s in spans)) if spans else None
    group = type(formula)(tuple(states), span=span)
    first = next(i for i, operand in enumerate(operands) if operand is states[0])
    rest = [operand for operand in operands if not is_state_formula(operand)]
    return [*rest[:first], group, *rest[first:]]
