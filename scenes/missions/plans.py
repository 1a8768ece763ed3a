"""A random plan: which stops a mission visits, when, and how long it stays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.errors import UserError
from core.task.windows import RESERVE
from scenes.missions.floor import Floor
from scenes.missions.lifting import Regions
from scenes.regions import Region

HASTY = 0.5
"""Share of missions that leave little more time than the plan needs."""

STAYS = (0.03, 0.05, 0.1)
"""Durations of stays over the plan's time."""


AGAIN = 0.25
"""Share of missions that visit a goal twice."""

ROUNDS = 0.1
"""Share of varied missions that go back and forth between two goals."""


@dataclass(frozen=True)
class Visit:
    """A stop of the plan.

    Attributes:
        name: Of the region.
        when: Step of the arrival.
        stay: Steps that the robot remains.
    """

    name: str
    when: float
    stay: int


@dataclass(frozen=True)
class Plan:
    """Visits in order, keys among them.

    Attributes:
        visits: In order of time.
        limit: Step by which all visits are over.
        whole: Step until which obstacles are avoided.
    """

    visits: tuple[Visit, ...]
    limit: int
    whole: int


def draw_plan(floor: Floor, regions: Regions, limit: int) -> Plan:
    """A plan that a planned way has time for, at most `limit` steps long.

    Goals for which no time is left are dropped. A hasty mission ends soon after the plan; in
    others the plan is stretched over the time that is left.

    Raises:
        UserError: there is not even time for the keys and one goal.
    """
    random = floor.random
    stops = _order(floor, regions)
    hasty = random.random() < HASTY
    at, time = np.array(regions.start.center), 0.0
    visits: list[Visit] = []
    for stop in stops:
        distance = floor.detour * float(np.linalg.norm(np.array(stop.center) - at))
        needed = RESERVE * distance / floor.measures.speed + floor.measures.lag
        arrival = time + needed * float(random.uniform(1.0, 1.1 if hasty else 1.4))
        stay = 0
        if stop not in regions.keys and random.random() < 0.4:
            stay = max(1, round(limit * float(random.choice(STAYS))))
        if arrival + stay > limit:
            break
        visits.append(Visit(stop.name, arrival, stay))
        at, time = np.array(stop.center), arrival + stay
    names = {visit.name for visit in visits}
    keys = {key.name for key in regions.keys}
    if not names >= keys or names == keys:
        raise UserError("there is no time for a goal")
    if hasty:
        soon = int(np.ceil(time * random.uniform(1.02, 1.3))) + 2
        return Plan(tuple(visits), min(limit, soon), limit)
    stretch = 1 + 0.8 * random.random() * (limit - time) / max(time, 1.0)
    stretched = [Visit(v.name, min(stretch * v.when, limit - v.stay), v.stay) for v in visits]
    return Plan(tuple(stretched), limit, limit)


def _order(floor: Floor, regions: Regions) -> list[Region]:
    """Keys and goals in the order of the plan; goals in a zone follow each other."""
    random = floor.random
    together = len(floor.goal_areas) if floor.zone is not None else 0
    first, rest = list(regions.goals[:together]), list(regions.goals[together:])
    rest = _shuffled(random, rest)
    place = int(random.integers(len(rest) + 1))
    goals = [*rest[:place], *first, *rest[place:]]
    if floor.varied and len(goals) > 1 and not together and random.random() < ROUNDS:
        goals = [*goals[:2], *goals[:2], *goals[2:]]
    elif len(goals) > 1 and not together and random.random() < AGAIN:
        again = int(random.integers(2, len(goals) + 1))
        goals.insert(again, goals[again - 2])
    before = []
    if regions.keys and random.random() < 0.5:
        before = [goal for goal in goals if _beside_the_start(floor, goal)][:1]
        goals = [goal for goal in goals if goal not in before]
    return [*before, *regions.keys, *goals]


def _beside_the_start(floor: Floor, goal: Region) -> bool:
    """Whether a goal lies where the start lies, before all doors."""
    if floor.start_area is None:
        return False
    low, high = floor.start_area
    center = np.array(goal.center[:2])
    return bool(((low <= center) & (center <= high)).all())


def _shuffled(random: np.random.Generator, regions: Sequence[Region]) -> list[Region]:
    return [regions[i] for i in random.permutation(len(regions))]
