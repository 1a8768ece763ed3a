"""Short formulas that stand for large structures."""

import random
from collections.abc import Iterator
from dataclasses import replace

from core.decompose import to_text
from scenes import load_task
from studio.runs.tasks import build_task, decompose_scene, ground_scene
from tests.tools.attack.table import Row
from tests.tools.trials import tried

LONGEST = 300
"""Characters of a formula."""

REFUSED_WITHIN = 0.1
"""Time for parsing, decomposing and grounding [s], on an idle core; three times that is a hang."""

_SCENE = load_task("linear-08")
_NAMES = ("A1", "A2", "A3", "B1", "B5", "!A1", "!B1")
_COMPILED = tuple(" & ".join(["G_[0:90](F_[0:60](A1))"] * n) for n in (1, 5, 9))
"""One repeated visit in each size of the arrays: programs are compiled once, for sizes."""

_BOUNDS = (0, 0, 1, 2, 10, 1000, 10**6)


def attack(count: int, seconds: float) -> list[Row]:
    """Grown families, random formulas, and those that pass made into tasks."""
    share = seconds / 3
    random_texts = list(random_formulas(min(count, 20_000)))
    for text in _COMPILED:
        _build(text)
    small = [text for text in grown() if len(text) <= LONGEST]
    return [
        tried("formulas", "grown", small, _ground, count=count, seconds=share, slowest_allowed=0.3),
        tried(
            "formulas",
            "random",
            random_texts,
            _ground,
            count=count,
            seconds=share,
            slowest_allowed=0.3,
        ),
        tried("formulas", "built", small + random_texts, _build, count=count, seconds=share),
    ]


def grown() -> Iterator[str]:
    """Families of formulas, by size."""
    for n in (2, 3, 5, 9, 12, 16, 19, 24, 30, 40, 60):
        yield f"F_[0:9]({'&'.join(['(A1|A2)'] * n)})"
        yield f"F_[0:9]({'&'.join(['(A1|A2|A3)'] * n)})"
        yield f"G_[0:9](!({'|'.join(['A1&A2'] * n)}))"
        yield f"F_[0:9]({'->'.join(['(A1&A2)'] * n)})"
        yield f"F_[0:9](!({'->'.join(['A1'] * n)}))"
        yield "&".join(["(F_[0:1](A1)|F_[0:1](A2))"] * n)
        yield "|".join(["F_[0:1](A1)"] * n)
        yield "&".join(["F_[0:1](A1)"] * n)
        yield "&".join(["G_[0:9](F_[0:1](A1))"] * n)
        yield f"{'!(' * n}A1 U_[0:9] A2{') U_[0:9] A1' * (n - 1)})"
        yield f"{'!(A1 U_[0:0] ' * n}A2{')' * n}"
        yield f"{'!(A1 U_[0:9] ' * n}A2{')' * n}"
        yield f"{'!(A1 U_[3:9] !' * n}(A2{')' * (n + 1)}"
        yield f"{'(A1 U_[0:9] ' * n}A2{')' * n}"
        yield f"{'F_[0:1000000](' * n}A1{')' * n}"
        yield f"{'G_[0:1000000](' * n}A1{')' * n}"
        yield f"{'G_[0:9](F_[0:1](' * n}A1{'))' * n}"
        yield f"{'G_[0:2](F_[0:0](' * n}A1{'))' * n}"
        yield f"{'G_[0:0](F_[0:1](A1 & ' * n}A1{'))' * n}"
        yield f"{'G_[0:3](F_[0:1](A2 & ' * n}A1{'))' * n}"
        yield f"{'(A1 -> ' * n}A1{')' * n}"
        yield f"{'(' * n}A1{' -> F_[0:1](A1))' * n}"
        yield f"{'!(' * n}A1{' & F_[0:1](A1))' * n}"
        yield f"G_[0:{10**n if n < 7 else 10**6}](F_[0:0](A1))"
        yield f"G_[0:1000000](F_[0:{n}](F_[0:1](A1) & F_[0:1](A2)))"
        yield f"{'F_[0:1]((A1|F_[0:1](A2))&' * n}A1{')' * n}"
        yield f"{'(F_[0:1](A1)|' * n}A1{')' * n}"
        yield f"{'(F_[0:1](A1)&(A1|' * n}A1{'))' * n}"
        yield f"G_[0:9]({'&'.join(['F_[0:1](A1)'] * n)})"
        yield f"F_[0:9]({'&'.join(['(A1->A2)'] * n)}) & G_[0:9]({'&'.join(['(A2->A1)'] * n)})"
        yield f"G_[0:1000000](A1 -> F_[0:{n}](A2))"
        yield f"{'G_[0:9](A1 -> F_[0:1](' * n}A2{'))' * n}"
        yield f"{'G_[0:9](F_[0:1](A1) | F_[0:2](' * n}A2{'))' * n}"
        yield f"{'G_[0:3](F_[0:1](A1) | F_[0:2](' * n}A2{'))' * n}"
        yield f"G_[0:9]({'|'.join(['(F_[0:1](A1)&F_[0:2](A2))'] * n)})"
        yield f"{'(' * n}A1{' U_[0:9] A2)' * n}"
        yield f"G_[0:9](!({'(' * n}A1{' U_[0:9] A2)' * n}))"
        yield f"G_[0:9](!({'&'.join(['(A1->F_[0:1](A2))'] * n)}))"
        yield "(" * n + "A1" + ")" * n
        yield "!" * n + "A1"


def random_formulas(count: int) -> Iterator[str]:
    """Formulas of random shape, biased towards wide and nested ones."""
    rng = random.Random(0)
    while count:
        text = _formula(rng, rng.randint(1, 12))
        if len(text) <= LONGEST:
            count -= 1
            yield text


def _formula(rng: random.Random, depth: int) -> str:
    if depth == 0 or rng.random() < 0.1:
        return rng.choice(_NAMES)
    match rng.randrange(9):
        case 0 | 1:
            return f"F_{_interval(rng)}({_formula(rng, depth - 1)})"
        case 2:
            return f"G_{_interval(rng)}({_formula(rng, depth - 1)})"
        case 3:
            inner = _formula(rng, depth - 1)
            return f"G_{_interval(rng)}(F_{_interval(rng)}({inner}))"
        case 4:
            left, right = _formula(rng, rng.randint(0, 1)), _formula(rng, depth - 1)
            return f"!(({left}) U_{_interval(rng)} ({right}))"
        case 5:
            left, right = _formula(rng, rng.randint(0, 1)), _formula(rng, depth - 1)
            return f"({left}) U_{_interval(rng)} ({right})"
        case 6:
            return f"({_formula(rng, depth - 1)}) -> ({_formula(rng, rng.randint(0, 1))})"
        case _:
            operator, part = rng.choice("&|"), _formula(rng, depth // 2)
            return operator.join([f"({part})"] * rng.randint(2, 12))


def _interval(rng: random.Random) -> str:
    low, high = sorted(rng.choices(_BOUNDS, k=2))
    return f"[{low}:{high}]"


def _ground(text: str) -> None:
    scene = replace(_SCENE, formula=text)
    to_text(decompose_scene(scene))
    ground_scene(scene)


def _build(text: str) -> None:
    build_task(replace(_SCENE, formula=text))
