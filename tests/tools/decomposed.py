"""Share of random temporal formulas that decompose, and that the arrays hold.

    python -m tests.tools.decomposed --count 2000 --seed 0

A formula of depth 3 has three operators nested in each other, at least one of them temporal.
"""

import argparse
import json
import random
from collections.abc import Iterator

from core.decompose import DecompositionError, decompose
from core.errors import UserError
from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    is_state_formula,
)
from core.task.grounding import ground

ATOMS = ("A", "B", "C")
LONGEST = 20
"""Bounds of intervals are at most this [steps]."""


def random_formulas(count: int, seed: int, depth: int = 3) -> Iterator[Formula]:
    """Temporal formulas; all operators are equally likely."""
    draw = random.Random(seed)
    while count:
        formula = _formula(draw, depth)
        if not is_state_formula(formula):
            count -= 1
            yield formula


def _formula(draw: random.Random, depth: int) -> Formula:
    if depth == 0:
        return Atom(draw.choice(ATOMS))

    def below() -> Formula:
        return _formula(draw, depth - 1 if draw.random() < 0.7 else 0)

    match draw.randrange(7):
        case 0:
            return Not(_formula(draw, depth - 1))
        case 1:
            return And((_formula(draw, depth - 1), below()))
        case 2:
            return Or((below(), _formula(draw, depth - 1)))
        case 3:
            return Implies(below(), _formula(draw, depth - 1))
        case 4:
            return Eventually(_interval(draw), _formula(draw, depth - 1))
        case 5:
            return Always(_interval(draw), _formula(draw, depth - 1))
    return Until(_interval(draw), below(), _formula(draw, depth - 1))


def _interval(draw: random.Random) -> Interval:
    first, last = draw.randint(0, LONGEST), draw.randint(0, LONGEST)
    return Interval(min(first, last), max(first, last))


def shares(count: int, seed: int) -> dict[str, float]:
    """Shares of random formulas that decompose, and that are grounded."""
    decomposed = grounded = 0
    for formula in random_formulas(count, seed):
        try:
            plan = decompose(formula)
        except DecompositionError:
            continue
        decomposed += 1
        try:
            ground(plan, ATOMS, 0)
        except UserError:
            continue
        grounded += 1
    return {"decomposed": decomposed / count, "grounded": grounded / count}


def main() -> None:
    """Print the shares as one JSON line."""
    parser = argparse.ArgumentParser(description="Share that decomposes.")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(json.dumps(shares(options.count, options.seed)))


if __name__ == "__main__":
    main()
