"""What holds between the steps of a trace."""

from core.between.strict import Asked, Strict, strict_formula
from core.between.sweep import SUBSTEPS, Sweep, swept
from core.between.verdict import (
    Between,
    between,
    between_margins,
    between_sentence,
    breach_text,
    strict_robustness,
)

__all__ = [
    "SUBSTEPS",
    "Asked",
    "Between",
    "Strict",
    "Sweep",
    "between",
    "between_margins",
    "between_sentence",
    "breach_text",
    "strict_formula",
    "strict_robustness",
    "swept",
]
