"""Shells of Franka's arm, modelled on its proportions: a hull per link, dark rings between.

Each link's pieces are in the frame that its joint turns, Craig's modified Denavit-Hartenberg
frame as in `envs.panda`; `base` is in the robot's, `hand` in that of the seventh joint.
"""

from functools import cache

import numpy as np

from studio.page.views.bodies.pieces import Piece, block, drum, hull

SHELL, RING, METAL = (236, 239, 243), (58, 63, 70), (206, 211, 217)

ELBOW = 0.0825
"""Offset of the elbow in [m]."""

WRIST = 0.088
"""Offset of the seventh axis from the sixth in [m]."""

FLANGE = 0.107
"""Height of the flange over the seventh joint's origin in [m]."""


@cache
def arm_pieces() -> dict[str, tuple[Piece, ...]]:
    """Pieces of `base`, `link1` to `link7` and `hand`."""
    return {
        "base": (
            hull(
                SHELL,
                drum(0.09, (0, 0, 0), (0, 0, 0.05)),
                drum(0.06, (-0.1, 0, 0), (-0.1, 0, 0.06)),
            ),
            hull(
                SHELL,
                drum(0.088, (0, 0, 0.02), (0, 0, 0.06)),
                drum(0.06, (0, 0, 0.09), (0, 0, 0.137)),
            ),
            hull(RING, drum(0.0605, (0, 0, 0.136), (0, 0, 0.145), 0.002)),
        ),
        "link1": (
            hull(
                SHELL,
                drum(0.06, (0, 0, -0.19), (0, 0, -0.1)),
                drum(0.06, (0, -0.06, 0), (0, 0.06, 0), 0.02),
            ),
        ),
        "link2": (
            *_caps(0.066),
            hull(
                SHELL,
                drum(0.0585, (0, -0.19, 0), (0, -0.1, 0)),
                drum(0.0585, (0, 0, -0.058), (0, 0, 0.058), 0.02),
            ),
            hull(RING, drum(0.0595, (0, -0.197, 0), (0, -0.187, 0), 0.002)),
        ),
        "link3": (
            hull(
                SHELL,
                drum(0.059, (0, 0, -0.118), (0, 0, -0.05)),
                drum(0.056, (ELBOW, -0.058, 0), (ELBOW, 0.058, 0), 0.02),
            ),
        ),
        "link4": (
            *_caps(0.064, 0.04),
            hull(
                SHELL,
                drum(0.055, (0, 0, -0.057), (0, 0, 0.057), 0.02),
                drum(0.057, (-ELBOW, 0.05, 0), (-ELBOW, 0.12, 0)),
            ),
            hull(RING, drum(0.058, (-ELBOW, 0.117, 0), (-ELBOW, 0.127, 0), 0.002)),
        ),
        "link5": (
            hull(
                SHELL,
                drum(0.057, (0, 0, -0.257), (0, 0, -0.17)),
                drum(0.046, (0, 0.02, -0.1), (0, 0.02, -0.05)),
                drum(0.046, (0, -0.05, 0), (0, 0.05, 0), 0.018),
            ),
        ),
        "link6": (
            *_caps(0.058, 0.034),
            hull(
                SHELL,
                drum(0.045, (0, 0, -0.051), (0, 0, 0.051), 0.018),
                drum(0.045, (WRIST, 0.05, 0), (WRIST, -0.04, 0), 0.018),
            ),
            hull(RING, drum(0.046, (WRIST, -0.038, 0), (WRIST, -0.046, 0), 0.002)),
        ),
        "link7": (
            hull(SHELL, drum(0.044, (0, 0, 0.046), (0, 0, 0.09), 0.015)),
            hull(RING, drum(0.036, (0, 0, 0.085), (0, 0, FLANGE), 0.003)),
        ),
        "hand": _turned(
            hull(
                SHELL,
                block((0.031, 0.1, 0.02), (0, 0, FLANGE + 0.025), 0.014),
                block((0.026, 0.075, 0.01), (0, 0, FLANGE + 0.056), 0.01),
            ),
            *(
                hull(
                    RING,
                    block((0.011, 0.009, 0.012), (0, side * 0.034, FLANGE + 0.075), 0.004),
                    block((0.009, 0.006, 0.012), (0, side * 0.024, FLANGE + 0.1), 0.004),
                )
                for side in (-1, 1)
            ),
        ),
    }


def _caps(reach: float, radius: float = 0.042) -> tuple[Piece, ...]:
    """Dark discs at the ends of a joint's drum along z."""
    return tuple(
        hull(RING, drum(radius, (0, 0, side * (reach - 0.02)), (0, 0, side * reach), 0.004))
        for side in (-1, 1)
    )


def _turned(*pieces: Piece) -> tuple[Piece, ...]:
    """The hand is mounted an eighth of a turn back about the flange's axis."""
    c = np.sqrt(0.5)
    turn = np.eye(4)
    turn[:2, :2] = [[c, c], [-c, c]]
    return tuple(Piece(mesh.copy().apply_transform(turn), color) for mesh, color in pieces)
