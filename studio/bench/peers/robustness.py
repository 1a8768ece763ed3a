"""How long robustness takes: 512 traces of 101 samples, by other libraries and by `core.stl`.

Each case is evaluated a few times in turns, and the least time counts, which other programs on the
machine disturb least. Evaluations under JAX are compiled; the compilation is timed apart.

Dimensions: R traces, T samples, A atoms.
"""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.stl import Formula, parse, robustness
from studio.bench.peers.libraries import library
from studio.bench.peers.translation import rtamt_text, sentil_text, stljax_formula

NAMES = ("A", "B", "C")
TRACES, SAMPLES = 512, 101
REPEATS = 5

CASES = {
    "F and G": "F_[0:40](A) & G_[20:60](!B) & F_[10:50](G_[0:10](C))",
    "until": "(A)U_[0:100](B)",
}

Evaluate = Callable[[np.ndarray], np.ndarray]
"""Robustness [R] of traces [R, T, A]."""


class Timed(NamedTuple):
    """How long an evaluation takes [s]."""

    first: float  # compilation, or what else is done once, included
    least: float
    values: np.ndarray  # [R]


def timed(evaluate: Evaluate, traces: np.ndarray) -> Timed:
    """The first evaluation of traces [R, T, A], and the fastest of some more."""
    seconds = []
    values = np.empty(0)
    for _ in range(1 + REPEATS):
        began = time.perf_counter()
        values = np.asarray(evaluate(traces))
        seconds.append(time.perf_counter() - began)
    return Timed(seconds[0], min(seconds[1:]), values)


def compare(name: str) -> list[dict[str, Any]]:
    """Each case by a library (`rtamt`, `stljax` or `sentil`) and by ours."""
    traces = np.random.default_rng(1007).normal(size=(TRACES, SAMPLES, len(NAMES)))
    traces = traces.astype(np.float32)
    rows = []
    for case, text in CASES.items():
        formula = parse(text, names=NAMES)
        theirs = timed(RIVALS[name](formula), traces)
        own = timed(_compiled(formula) if name == "stljax" else _plain(formula), traces)
        rows.append(
            {
                "case": case,
                "formula": text,
                "first_seconds": theirs.first,
                "seconds": theirs.least,
                "own_first_seconds": own.first,
                "own_seconds": own.least,
                "difference": float(np.abs(theirs.values - own.values).max()),
            }
        )
    return rows


def _plain(formula: Formula) -> Evaluate:
    return lambda traces: np.asarray(robustness(formula, traces, NAMES))


def _compiled(formula: Formula) -> Evaluate:
    run = jax.jit(lambda traces: robustness(formula, traces, NAMES))
    return lambda traces: np.asarray(run(jnp.asarray(traces)))


def _stljax(formula: Formula) -> Evaluate:
    rule = stljax_formula(library("stljax.formula"), formula, NAMES)
    run = jax.jit(jax.vmap(rule.robustness))

    def evaluate(traces: np.ndarray) -> np.ndarray:
        with jax.numpy_rank_promotion("allow"):
            return np.asarray(run(jnp.asarray(traces)))

    return evaluate


def _rtamt(formula: Formula) -> Evaluate:
    rtamt = library("rtamt")
    specification = rtamt.StlDiscreteTimeOfflineSpecification()
    for name in NAMES:
        specification.declare_var(f"margin_{name}", "float")
    specification.spec = rtamt_text(formula)
    specification.parse()
    steps = list(range(SAMPLES))

    def evaluate(traces: np.ndarray) -> np.ndarray:
        found = []
        for trace in traces:
            columns = {f"margin_{n}": trace[:, i].tolist() for i, n in enumerate(NAMES)}
            found.append(specification.evaluate({"time": steps, **columns})[0][1])
        return np.array(found)

    return evaluate


def _sentil(formula: Formula) -> Evaluate:
    sentil = library("sentil")
    rule = sentil.Formula.parse(sentil_text(formula))
    steps = np.arange(SAMPLES, dtype=float)

    def evaluate(traces: np.ndarray) -> np.ndarray:
        found = []
        for trace in traces.astype(float):
            columns = {f"margin_{n}": trace[:, i] for i, n in enumerate(NAMES)}
            found.append(rule.robustness(sentil.Trace(steps, columns)))
        return np.array(found)

    return evaluate


RIVALS: dict[str, Callable[[Formula], Evaluate]] = {
    "rtamt": _rtamt,
    "stljax": _stljax,
    "sentil": _sentil,
}
"""By name; each translates a formula, so that only evaluation is timed."""
