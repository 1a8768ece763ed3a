"""Signal Temporal Logic: syntax, parser, printer, normal form and semantics."""

from core.stl.errors import FormulaError
from core.stl.normal_form import fold_constants, negation_normal_form
from core.stl.parser import MAX_DEPTH, MAX_LENGTH, parse
from core.stl.printer import quote_name, to_math, to_text
from core.stl.syntax import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Span,
    Until,
    atom_names,
    children,
    conjunction,
    disjunction,
    horizon,
    is_state_formula,
    walk,
)

__all__ = [
    "MAX_DEPTH",
    "MAX_LENGTH",
    "Always",
    "And",
    "Atom",
    "Constant",
    "Eventually",
    "Formula",
    "FormulaError",
    "Implies",
    "Interval",
    "Not",
    "Or",
    "Span",
    "Until",
    "atom_names",
    "children",
    "conjunction",
    "disjunction",
    "fold_constants",
    "horizon",
    "is_state_formula",
    "negation_normal_form",
    "parse",
    "quote_name",
    "to_math",
    "to_text",
    "walk",
]
