"""At which steps the places of a formula are worked out when regions move.

A distance field is right for one position of its goal. A goal that moves gets fields for some
steps, spread evenly over its way and the more the further it goes; at all other steps the field of
the nearest of them counts, moved by the way that the goal has gone since. So its own place is exact
at every step, and obstacles that stand appear moved by at most half a cell, or as far as
`MOST_ROWS` fields allow. Where several regions with different paths make up one goal, nothing is
moved, and every step gets a field as long as there are enough.

Obstacles that move are in no field: a way around where one is now may be free when the robot comes
there, and barred elsewhere. They are perceived as dangers, and verdicts have the last word.

Dimensions: T steps (padded), P places, N rows: places that were worked out, M combinations of
closed doors, G subgoals, d position.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.stl import Formula, atom_names
from scenes.motion import Motion
from scenes.predicates import without_state
from scenes.scene import Scene, robot_of

MOST_ROWS = 96
"""Fields of moving goals, all combinations of closed doors counted."""


@dataclass(frozen=True, eq=False)
class Snapshots:
    """The places of a formula, worked out at some steps.

    Attributes:
        places: index [N] of the place of each row; rows of a place follow each other.
        steps: at which it is worked out [N].
        row: the row [T + 1, P] that counts at each step.
        drift: how far each place has moved since [T + 1, P, d] [m].
        moves: whether a place moves [P].
    """

    places: np.ndarray
    steps: np.ndarray
    row: np.ndarray
    drift: np.ndarray
    moves: np.ndarray


def snapshots_of(
    scene: Scene, goals: Sequence[Formula], combinations: int, steps: int, spacing: float
) -> Snapshots:
    """When to work out the places of the goals of a scene whose regions move.

    Args:
        scene: its regions.
        goals: state formulas [P].
        combinations: M.
        steps: T.
        spacing: of the grid of the fields [m].
    """
    motions = [_motions_of(scene, goal) for goal in goals]
    share = max(1, MOST_ROWS // (combinations * max(1, sum(map(bool, motions)))))
    row = np.zeros((steps + 1, len(goals)), np.int32)
    drift = np.zeros((steps + 1, len(goals), scene.dimension), np.float32)
    places, taken = [], []
    for place, own in enumerate(motions):
        at = _spread(own, share, steps, spacing)
        nearest = np.abs(np.arange(steps + 1)[:, None] - at).argmin(1)
        row[:, place] = len(taken) + nearest
        if len(own) == 1 and own[0] is not None:
            offset = own[0].offset(np.arange(steps + 1))
            drift[:, place] = offset - own[0].offset(at)[nearest]
        places += [place] * len(at)
        taken += at.tolist()
    moves = np.array([bool(own) for own in motions], bool)
    return Snapshots(np.array(places), np.array(taken), row, drift, moves)


def _motions_of(scene: Scene, goal: Formula) -> list[Motion | None]:
    """The different motions of what a goal asks of the position, None for what stands.

    Nothing at all where nothing moves.
    """
    asked = without_state(goal, scene.predicates, robot_of(scene))
    motion = {region.name: region.motion for region in scene.regions}
    own = list(dict.fromkeys(motion.get(name) for name in atom_names(asked)))
    return own if any(own) else []


def _spread(motions: Sequence[Motion | None], most: int, steps: int, spacing: float) -> np.ndarray:
    """Steps at which a place that moves in some ways is worked out."""
    if not motions:
        return np.zeros(1, int)
    moving = [each.offset(np.arange(steps + 1)) for each in motions if each is not None]
    gone = np.max([np.linalg.norm(np.diff(each, axis=0), axis=1) for each in moving], axis=0)
    way = np.concatenate([[0.0], np.cumsum(gone)])
    wanted = int(np.ceil(way[-1] / spacing)) + 1 if len(motions) == 1 else steps + 1
    marks = np.linspace(0.0, way[-1], min(wanted, most, steps + 1))
    return np.unique(np.abs(way - marks[:, None]).argmin(1))
