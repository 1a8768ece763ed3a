"""Signal Temporal Logic: syntax, parser, printer, normal form and semantics."""

from core.stl.english import sentences
from core.stl.errors import FormulaError
from core.stl.normal_form import fold_constants, negation_normal_form
from core.stl.parser import MAX_DEPTH, MAX_LENGTH, Reading, parse, read
from core.stl.plain import one_line
from core.stl.printer import quote_name, to_math, to_text
from core.stl.reading import samples_read
from core.stl.semantics import (
    TraceError,
    check_columns,
    check_trace,
    robustness,
    robustness_signal,
    satisfied,
    smooth_robustness,
)
from core.stl.simplify import simplify
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
    operand_windows,
    walk,
    with_children,
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
    "Reading",
    "Span",
    "TraceError",
    "Until",
    "atom_names",
    "check_columns",
    "check_trace",
    "children",
    "conjunction",
    "disjunction",
    "fold_constants",
    "horizon",
    "is_state_formula",
    "negation_normal_form",
    "one_line",
    "operand_windows",
    "parse",
    "quote_name",
    "read",
    "robustness",
    "robustness_signal",
    "samples_read",
    "satisfied",
    "sentences",
    "simplify",
    "smooth_robustness",
    "to_math",
    "to_text",
    "walk",
    "with_children",
]
