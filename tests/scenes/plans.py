"""One good order of visits for each of the ten formulas, written down by hand.

The formulas of the planar robots are the same; those of the robots in space have other windows
in tasks 8 and 9, and walls of their own names. A plan gives, for the latest choice of the outer
variable (t1 = 7 or 10 in STL-01..05), when each visit may begin and how long it must last.
"""

from dataclasses import dataclass, field

import numpy as np

from scenes import Scene
from scenes.scene import DEMO
from tests.scenes.geometry import at, distance_from

WALLS = {2: {"B1", "B2", "B3", "B4"}, 3: {"W1", "W2", "W3", "W4", "W5", "W6"}}
"""Walls around the workspace, by dimension."""


@dataclass(frozen=True)
class Visit:
    """Enter `region` in base + [low, high] and stay; `doors` are closed on the way to it."""

    region: str
    low: int
    high: int
    stay: int = 0
    base: int | None = None  # index of the visit from whose entry the window counts
    doors: frozenset[str] = field(default=frozenset())


def _keys() -> list[Visit]:
    return [
        Visit("K1", 0, 100, doors=frozenset({"D1", "D2", "D3"})),
        Visit("K2", 0, 100, doors=frozenset({"D2", "D3"})),
        Visit("K3", 0, 100, doors=frozenset({"D3"})),
        Visit("G", 80, 90, stay=5),
    ]


PLANS: dict[int, list[Visit]] = {
    1: [Visit("A", 57, 92)],
    2: [Visit("A", 10, 60), Visit("C", 70, 70, stay=20)],
    3: [Visit("A", 10, 60), Visit("C", 50, 70), Visit("D", 80, 80, stay=10)],
    4: [
        Visit("A", 10, 60),
        Visit("C", 50, 60),
        Visit("D", 60, 60, stay=10),
        Visit("F", 80, 90),
    ],
    5: [
        Visit("A", 10, 40),
        Visit("C", 40, 60),
        Visit("D", 60, 60, stay=10),
        Visit("F", 80, 90),
        Visit("H", 85, 98),
    ],
    6: [Visit("A", 10, 90)],
    7: [Visit("A1", 0, 90), Visit("A2", 40, 80)],
    8: [Visit("A1", 0, 90), Visit("A2", 40, 80), Visit("A3", 10, 20, stay=10, base=1)],
    9: [
        Visit("A1", 5, 20),
        Visit("A2", 10, 20, stay=5, base=0),
        Visit("A3", 10, 30, stay=5, base=1),
        Visit("A4", 10, 30, stay=10, base=1),
    ],
    10: _keys(),
}
SPATIAL_PLANS = PLANS | {
    8: [Visit("A1", 0, 90), Visit("A2", 40, 60), Visit("A3", 15, 30, stay=5, base=1)],
    9: [
        Visit("A1", 25, 30),
        Visit("A2", 20, 28, stay=5, base=0),
        Visit("A3", 10, 30, stay=5, base=1),
        Visit("A4", 10, 30, stay=10, base=1),
    ],
}

ANT_PLANS = {
    1: [Visit("A", 114, 184)],
    2: [Visit("A", 20, 120), Visit("C", 140, 140, stay=40)],
    3: [Visit("A", 20, 120), Visit("C", 100, 140), Visit("D", 160, 160, stay=20)],
    4: [
        Visit("A", 20, 120),
        Visit("C", 100, 120),
        Visit("D", 120, 120, stay=20),
        Visit("F", 160, 180),
    ],
    5: [
        Visit("A", 20, 80),
        Visit("C", 80, 120),
        Visit("D", 120, 120, stay=20),
        Visit("F", 160, 180),
        Visit("H", 170, 196),
    ],
    6: [Visit("A", 20, 180)],
    7: [Visit("A1", 0, 180), Visit("A2", 80, 160)],
    8: [Visit("A1", 0, 180), Visit("A2", 80, 160), Visit("A3", 20, 40, stay=20, base=1)],
    9: [
        Visit("A1", 10, 40),
        Visit("A2", 20, 40, stay=10, base=0),
        Visit("A3", 20, 60, stay=10, base=1),
        Visit("A4", 20, 60, stay=20, base=1),
    ],
    10: [
        Visit("K1", 0, 200, doors=frozenset({"D1", "D2", "D3"})),
        Visit("K2", 0, 200, doors=frozenset({"D2", "D3"})),
        Visit("K3", 0, 200, doors=frozenset({"D3"})),
        Visit("G", 160, 180, stay=10),
    ],
}


def plan_of(scene: Scene) -> list[Visit]:
    """The plan of a shipped task or demo."""
    if scene.name.endswith(DEMO):
        last = 160 if scene.robot == "ant" else 80
        return [Visit("A1", 0, last), Visit("A2", 0, last)]
    number = int(scene.name.rsplit("-", 1)[1])
    if scene.robot == "ant":
        return ANT_PLANS[number]
    return (PLANS if scene.dimension == 2 else SPATIAL_PLANS)[number]


def obstacles(scene: Scene) -> set[str]:
    """Regions that the formula forbids throughout: those that no plan visits or opens."""
    plan = plan_of(scene)
    visited = {visit.region for visit in plan}.union(*(visit.doors for visit in plan))
    return set(scene.region_names) - visited


def leg_lengths(scene: Scene, starts, clearance: float, free: bool = False) -> np.ndarray:
    """Lengths [S, legs] in [m] of the shortest ways start -> first center -> second and so on.

    Args:
        scene: a shipped task.
        starts: points [S, d].
        clearance: distance from obstacles in [m].
        free: whether the obstacles are taken away.
    """
    lengths, places = [], list(starts)
    for visit in plan_of(scene):
        blocked = set() if free else obstacles(scene) | visit.doors
        field = distance_from(scene, visit.region, blocked, clearance)
        lengths.append([at(scene, field, place) for place in places])
        center = scene.regions[scene.region_names.index(visit.region)].center
        places = [center] * len(places)
    return np.transpose(lengths)


def needed_speed(scene: Scene, lengths) -> float:
    """Least constant speed in [m/step] at which the plan keeps all its deadlines."""
    low, high = 0.0, 20.0
    for _ in range(30):
        middle = (low + high) / 2
        if _feasible(plan_of(scene), lengths, middle):
            high = middle
        else:
            low = middle
    return high


def _feasible(plan: list[Visit], lengths, speed: float) -> bool:
    entries: list[float] = []
    free = 0.0
    for visit, length in zip(plan, lengths, strict=True):
        base = 0.0 if visit.base is None else entries[visit.base]
        entry = max(base + visit.low, free + length / speed)
        if entry > base + visit.high:
            return False
        entries.append(entry)
        free = entry + visit.stay
    return True
