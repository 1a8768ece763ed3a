"""The positions of a trace as columns of a program: one a step, or one every few steps.

A robot that moves by bounded strides, p' = p + u with |u_i| <= stride_i, is at
p_k + (j / h) (p_{k+h} - p_k) after j of the h steps between two knots if it keeps its velocity.
"""

import numpy as np

from core.planning.program import Program
from core.planning.reach import Boxes


class Trace:
    """Columns of positions, with what keeps them in reach of one another."""

    def __init__(
        self, program: Program, boxes: Boxes, start: np.ndarray, stride: np.ndarray, hold: int
    ):
        """Add columns and rows to a program.

        Args:
            program: to which they are added.
            boxes: that contain the positions; the number of their steps is a multiple of `hold`.
            start: position [d] at step 0 [m].
            stride: most that a coordinate changes in a step [d] [m].
            hold: steps for which a velocity is kept.
        """
        self.hold, self.boxes = hold, boxes
        low, high = boxes.low[::hold].copy(), boxes.high[::hold].copy()
        low[0] = high[0] = start
        self.knots = [
            [program.column(*bounds) for bounds in zip(*ends, strict=True)]
            for ends in zip(low.tolist(), high.tolist(), strict=True)
        ]
        for before, after in zip(self.knots, self.knots[1:], strict=False):
            for one, other, most in zip(before, after, (hold * stride).tolist(), strict=True):
                program.row({other: 1.0, one: -1.0}, -most, most)

    def along(self, normal: np.ndarray, step: int) -> dict[int, float]:
        """Terms of n . p at a step."""
        knot, part = divmod(step, self.hold)
        share = part / self.hold
        terms = dict(zip(self.knots[knot], ((1 - share) * normal).tolist(), strict=True))
        if part:
            terms |= zip(self.knots[knot + 1], (share * normal).tolist(), strict=True)
        return terms

    def span(self, step: int) -> tuple[int, ...]:
        """Steps at which a facet is kept so that it is kept at a step, the same for a segment."""
        if self.hold == 1:
            return (step,)
        knot = min(step // self.hold, len(self.knots) - 2) * self.hold
        return (knot, knot + self.hold)

    def positions(self, values: np.ndarray) -> np.ndarray:
        """Positions [T + 1, d] of a solution [m]."""
        knots = values[np.array(self.knots)]
        steps = np.arange(self.hold * (len(knots) - 1) + 1)
        axes = [np.interp(steps, steps[:: self.hold], axis) for axis in knots.T]
        return np.stack(axes, axis=-1)
