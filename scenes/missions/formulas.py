"""A random formula along a plan: its windows contain the plan's times.

What is written: reaches, chains F(A & F(B)), stays F(G A) and G A, stays in a zone while goals are
visited, patrols G F A, orders (!B) U A, doors (!D) U K, branches F A | F B and F (A | B), goals
that are closed until later, and G !O for what is to be avoided. In varied missions also responses
G(A -> F B) and lockouts G(A -> G !B), and more orders and closed
goals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from core.errors import UserError
from core.task.sizes import STANDARD
from scenes.missions.lifting import Regions
from scenes.missions.plans import Plan, Visit

CHAIN = 3
"""Longest chain of visits."""

REACTIONS = 0.25
"""Share of pairs of visits that are a response or a lockout, in varied missions."""

MOST_RESPONDED, MOST_LOCKED = 5, 4
"""Most visits of a mission with a response, with a lockout: each needs variables of its own."""


@dataclass
class _Writer:
    """Writes clauses; all windows are relative to the start of the plan."""

    random: np.random.Generator
    limit: int
    whole: int
    """Steps for which what is to be avoided is: walls that opened early would count as doors."""
    width: float
    """Steps by which windows exceed the plan's time on a side, at most."""
    others: list[str]
    doors: int
    varied: bool
    later: list[str] = field(default_factory=list)

    def chance(self, probability: float) -> bool:
        return bool(self.random.random() < probability)

    def before(self, time: float, least: int = 0) -> int:
        """A lower bound for a time of the plan."""
        return max(least, int(time - self.random.uniform(0.1, 1.0) * self.width))

    def after(self, time: float, most: int) -> int:
        """An upper bound for a time of the plan."""
        return min(most, int(np.ceil(time + self.random.uniform(0.15, 1.0) * self.width)))


def write_formula(
    random: np.random.Generator,
    regions: Regions,
    plan: Plan,
    together: int,
    shift: tuple[int, int] | None,
    *,
    varied: bool = False,
) -> str:
    """A formula that the plan's times satisfy.

    Args:
        random: draws the structure and the windows.
        regions: of the mission.
        plan: whose times are met; everything is decided by its limit.
        together: number of goals, the first ones, that lie in the zone; 0 if it is everything.
        shift: window of an F around everything, if there is to be one.
        varied: whether there may be responses and lockouts, and more goals that are closed.

    Raises:
        UserError: the plan visits no goal in the zone.
    """
    visits, limit = plan.visits, plan.limit
    width = 0.2 * limit * 2 ** float(random.uniform(-1.5, 1.5))
    others = [region.name for region in regions.others]
    doors = len(regions.doors)
    writer = _Writer(random, limit, plan.whole, width, others, doors, varied)
    locks = {key.name: door.name for key, door in zip(regions.keys, regions.doors, strict=False)}
    goals = [visit for visit in visits if visit.name not in locks]
    clauses = _visits(writer, goals)
    clauses += [_key(writer, visit, locks[visit.name]) for visit in visits if visit.name in locks]
    if regions.zone is not None:
        names = {goal.name for goal in regions.goals[:together]}
        inside = [visit for visit in goals if visit.name in names]
        if together and not inside:
            raise UserError("there is no time for a goal in the zone")
        clauses.append(_zone(writer, regions.zone.name, inside))
    clauses = [clauses[i] for i in random.permutation(len(clauses))]
    avoided = [region.name for region in (*regions.obstacles, *regions.walls)]
    if writer.others and writer.chance(0.5):
        avoided.append(writer.others.pop())
    clauses += _avoid(writer, avoided)
    formula = " & ".join(clauses)
    return formula if shift is None else f"F_[{shift[0]}:{shift[1]}]({formula})"


def _visits(writer: _Writer, visits: Sequence[Visit]) -> list[str]:
    """Clauses of all visits to goals, in chains of one to `CHAIN`."""
    clauses, first = [], 0
    names = [visit.name for visit in visits]
    twice = {name for name in names if names.count(name) > 1}
    if twice and writer.chance(0.5):
        for name in sorted(twice):
            clauses.append(_patrol(writer, [v for v in visits if v.name == name]))
        visits = [visit for visit in visits if visit.name not in twice]
    while first < len(visits):
        if writer.varied and (clause := _reaction(writer, visits, first)):
            clauses.append(clause)
            first += 2
            continue
        length = 1
        while length < min(CHAIN, len(visits) - first) and writer.chance(0.35):
            length += 1
        chain = visits[first : first + length]
        following = visits[first + length] if first + length < len(visits) else None
        if length > 1:
            clauses.append(_chain(writer, chain))
        else:
            clauses.append(_single(writer, chain[0], following))
        first += length
    return clauses


def _chain(writer: _Writer, visits: Sequence[Visit]) -> str:
    """F(A & F(B & ...)): each visit within a window after the one before."""
    text, windows, latest = "", [], 0
    for index, visit in enumerate(visits):
        gap = visit.when - (visits[index - 1].when if index else 0.0)
        after = visits[-1].when + visits[-1].stay - visit.when
        start = writer.before(gap, least=min(index, 1))
        end = writer.after(gap, int(writer.limit - after - latest))
        start = min(start, end - 1)
        latest += end
        windows.append((start, end))
    for visit, (start, end) in zip(reversed(visits), reversed(windows), strict=True):
        body = _held(visit)
        text = f"F_[{start}:{end}]({body} & {text})" if text else f"F_[{start}:{end}]({body})"
    return text


def _single(writer: _Writer, visit: Visit, following: Visit | None) -> str:
    """A reach or a stay of its own, in one of many ways."""
    most = writer.limit - visit.stay
    start = writer.before(visit.when)
    end = max(start + 2, writer.after(visit.when, most))
    window = f"[{start}:{end}]"
    if visit.stay and writer.chance(0.35):
        return f"G_[{int(visit.when)}:{int(visit.when) + visit.stay}]({visit.name})"
    if writer.others and writer.chance(0.5):
        return _branch(writer, visit, window)
    order, closed_share, early = (0.3, 0.45, 0.12) if writer.varied else (0.15, 0.2, 0.3)
    if following is not None and writer.doors < STANDARD.doors and writer.chance(order):
        writer.doors += 1
        return f"(!{following.name}) U_[0:{end}] ({_held(visit)})"
    may_close = writer.doors < STANDARD.doors and start > early * writer.limit
    if may_close and writer.chance(closed_share):
        writer.doors += 1
        closed = int(start * writer.random.uniform(0.4, 0.9))
        return f"G_[0:{closed}](!{visit.name}) & F_{window}({_held(visit)})"
    if writer.chance(0.3):
        return f"F_[0:{most}]({_held(visit)})"
    return f"F_{window}({_held(visit)})"


def _reaction(writer: _Writer, visits: Sequence[Visit], first: int) -> str:
    """A response or a lockout of two visits in a row; empty where there is none."""
    pair = visits[first : first + 2]
    names = [visit.name for visit in visits]
    once = all(names.count(visit.name) == 1 for visit in pair)
    if len(pair) < 2 or not once or writer.doors > 0 or not writer.chance(REACTIONS):
        return ""
    before, after = pair
    left, gap = int(before.when) + before.stay + 1, after.when - before.when
    low, high = writer.before(before.when), writer.after(before.when, writer.limit - before.stay)
    trigger = f"F_[{low}:{max(low + 2, high)}]({_held(before)})"
    if len(visits) <= MOST_RESPONDED and writer.chance(0.6):
        within = writer.after(gap, int(writer.limit - left - after.stay))
        latest = writer.limit - within - after.stay
        if within <= gap or latest <= left:
            return ""
        until = int(writer.random.integers(left, latest + 1))
        answer = f"{before.name} -> F_[0:{within}]({_held(after)})"
    elif len(visits) <= MOST_LOCKED:
        within = int(writer.random.uniform(0.3, 0.8) * (gap - before.stay))
        latest = writer.limit - within
        if within < 1 or latest <= left:
            return ""
        until = int(writer.random.integers(left, latest + 1))
        answer = f"{before.name} -> G_[0:{within}](!{after.name})"
        low, high = writer.before(after.when), writer.after(after.when, writer.limit - after.stay)
        trigger += f" & F_[{low}:{max(low + 2, high)}]({_held(after)})"
    else:
        return ""
    writer.doors = STANDARD.doors
    return f"{trigger} & G_[0:{until}]({answer})"


def _patrol(writer: _Writer, visits: Sequence[Visit]) -> str:
    """G F: the region again and again, as often as the plan visits it."""
    times = [0.0, *(visit.when for visit in visits)]
    longest = max(later - earlier for earlier, later in zip(times, times[1:], strict=False))
    within = writer.after(longest, writer.limit - 1)
    until = min(int(times[-1]), writer.limit - within)
    return f"G_[0:{until}](F_[0:{within}]({visits[0].name}))"


def _branch(writer: _Writer, visit: Visit, window: str) -> str:
    """The visit, or one to another region instead."""
    other = writer.others.pop()
    if writer.chance(0.5):
        return f"F_{window}({visit.name} | {other})"
    start, end = sorted(int(writer.random.uniform(0, writer.limit)) for _ in range(2))
    least = int(0.1 * writer.limit)
    end = min(writer.limit, max(end, start + least))
    return f"(F_{window}({_held(visit)}) | F_[{min(start, end - 1)}:{end}]({other}))"


def _key(writer: _Writer, visit: Visit, door: str) -> str:
    """A door that is closed until its key is reached."""
    end = writer.limit
    if writer.chance(0.4):
        end = max(int(visit.when) + 2, writer.after(visit.when, writer.limit))
    return f"(!{door}) U_[0:{end}] {visit.name}"


def _zone(writer: _Writer, zone: str, inside: Sequence[Visit]) -> str:
    """Remain in a zone: always, or while the goals in it are visited."""
    if not inside:
        return f"G_[0:{writer.whole}]({zone})"
    start, end = int(inside[0].when), int(np.ceil(inside[-1].when + inside[-1].stay))
    if writer.chance(0.5):
        return f"G_[{start}:{end}]({zone})"
    low, high = writer.before(start), writer.after(start, writer.limit - (end - start))
    return f"F_[{low}:{max(low + 1, high)}](G_[0:{end - start}]({zone}))"


def _avoid(writer: _Writer, names: Sequence[str]) -> list[str]:
    """What is never to be entered: one clause each, or one for all."""
    if names and writer.chance(0.3):
        return [f"G_[0:{writer.whole}](" + " & ".join(f"!{name}" for name in names) + ")"]
    return [f"G_[0:{writer.whole}](!{name})" for name in names]


def _held(visit: Visit) -> str:
    """The region, or a stay in it."""
    return f"G_[0:{visit.stay}]({visit.name})" if visit.stay else visit.name
