"""Scenes whose formulas are stretched in time, as in the paper's sweep over horizons (Sec. 5.2)."""

from dataclasses import replace

from core.stl import (
    Always,
    Eventually,
    Formula,
    Interval,
    Until,
    children,
    to_text,
    with_children,
)
from scenes import Scene, scene_formula


def with_horizon(scene: Scene, horizon: int | None) -> Scene:
    """The scene with another horizon [steps], and all intervals of its formula stretched alike."""
    if horizon is None or horizon == scene.horizon:
        return scene
    formula = stretched(scene_formula(scene), horizon, scene.horizon)
    return replace(scene, horizon=horizon, formula=to_text(formula))


def stretched(formula: Formula, length: int, was: int) -> Formula:
    """The formula with every bound times length / was, rounded down."""
    parts = tuple(stretched(child, length, was) for child in children(formula))
    formula = with_children(formula, parts)
    if isinstance(formula, Eventually | Always | Until):
        first, last = formula.interval
        return replace(formula, interval=Interval(first * length // was, last * length // was))
    return formula
