"""Nudges: what is added to a controller's actions where its attempts nearly satisfy the formula.

Weights that never saw a scene may pass a gap a hand's breadth too far left with every schedule;
then other schedules help little, and other actions much. So smooth random numbers are added to
the actions of the most robust attempts, the controller goes on to react to where that leads it,
and what comes out more robust is varied in its turn: an evolution strategy around a closed loop.

A nudged plan is a trace like any other, but it belongs to one start: the controller alone does
not repeat it.

Dimensions: L steps, K attempts, m action.
"""

import numpy as np

PARENTS = 8
"""The most robust attempts, which are varied in turn."""

SCALE = 0.2
"""Standard deviation of a nudge of middle size; actions are in [-1, 1]."""

SIZES = (0.3, 1.0, 2.0)
"""Small, middle and large nudges, in units of `SCALE`; each attempt has one size, at random."""

PERSISTENCE = 0.8
"""Correlation of the nudges of two steps in a row."""


def drawn_nudges(random: np.random.Generator, steps: int, count: int, size: int) -> np.ndarray:
    """Smooth random numbers [L, K, m], a stationary autoregression of the first order."""
    fresh = random.normal(size=(steps, count, size))
    innovation = np.sqrt(1 - PERSISTENCE**2)
    for step in range(1, steps):
        fresh[step] = PERSISTENCE * fresh[step - 1] + innovation * fresh[step]
    sizes = SCALE * random.choice(SIZES, size=(count, 1))
    return (sizes * fresh).astype(np.float32)
