"""Nudges: what is added to a controller's actions where its attempts nearly satisfy the formula.

Weights that never saw a scene may pass a gap a hand's breadth too far left with every schedule;
then other schedules help little, and other actions much. So smooth random numbers are added to
the actions of the most robust attempts, all along or around the step that decided the robustness;
the controller goes on to react to where that leads it, and what comes out more robust is varied in
its turn: an evolution strategy around a closed loop.

A nudged plan is a trace like any other, but it belongs to one start: the controller alone does
not repeat it.

Dimensions: L steps, K attempts, m action, A atoms.
"""

from collections.abc import Sequence

import numpy as np

PARENTS = 8
"""The most robust attempts, which are varied in turn."""

SCALE = 0.15
"""Standard deviation of a nudge of middle size; actions are in [-1, 1]."""

SIZES = (0.3, 1.0, 2.0)
"""Small, middle and large nudges, in units of `SCALE`; each attempt has one size, at random."""

PERSISTENCE = 0.8
"""Correlation of the nudges of two steps in a row."""

BEFORE, AFTER = 30, 8
"""Most steps of a focused nudge before and after the step that decided the robustness."""

FOCUSED = 3.0
"""How much larger focused nudges are."""


def drawn_nudges(
    random: np.random.Generator, steps: int, size: int, focus: Sequence[int | None]
) -> np.ndarray:
    """Smooth random numbers [L, K, m], a stationary autoregression of the first order.

    Args:
        random: where they come from.
        steps: L.
        size: m.
        focus: the step around which each attempt is nudged; None: all along [K].
    """
    count = len(focus)
    nudges = random.normal(size=(steps, count, size))
    innovation = np.sqrt(1 - PERSISTENCE**2)
    for step in range(1, steps):
        nudges[step] = PERSISTENCE * nudges[step - 1] + innovation * nudges[step]
    nudges *= SCALE * random.choice(SIZES, size=(count, 1))
    before, after = (random.integers(1, most, size=count) for most in (BEFORE, AFTER))
    for index, middle in enumerate(focus):
        if middle is not None:
            nudges[:, index] *= FOCUSED
            nudges[: max(0, middle - before[index]), index] = 0
            nudges[middle + after[index] :, index] = 0
    return nudges.astype(np.float32)
