from dataclasses import replace

import numpy as np
import pytest

from core.decompose import Kind
from scenes import load_task
from studio.runs.recording import record
from studio.runs.tasks import build_task

SCHEDULE = (20, 50, 15)
"""t1, t2, t3 of linear-08: A1 at 20, A2 at 50, A3 from 65 to 75."""


def margins_of(task, visits, crash=None):
    """Margins [L + 1, A]: -1 but for visits {name: (first, last step)}, obstacles 2 m away."""
    names = task.grounding.atoms
    margins = np.full((task.padded_horizon + 1, 32), -1.0)
    for name, (first, last) in visits.items():
        margins[first : last + 1, names.index(name)] = 0.25
    margins[:, [i for i, name in enumerate(names) if name.startswith("B")]] = -2.0
    if crash is not None:
        margins[crash, names.index("B5")] = 0.5
    return margins


GOOD = {"A1": (18, 22), "A2": (50, 50), "A3": (65, 75)}


def recorded(task, visits, schedule=SCHEDULE, crash=None, nudged=False):
    states = np.linspace(0, 1, task.padded_horizon + 1)[:, None] * np.ones(2)
    actions = np.zeros((task.padded_horizon, 2))
    margins = margins_of(task, visits, crash)
    return record(task, schedule, states, actions, margins, nudged=nudged)


def test_a_trace_that_keeps_to_the_schedule_is_satisfied(linear_task):
    recording = recorded(linear_task, GOOD)
    assert recording.satisfied
    assert recording.robustness == pytest.approx(0.25)
    assert all(outcome.worst >= 0 for outcome in recording.outcomes)
    assert recording.steps == linear_task.horizon
    assert recording.positions.shape == (linear_task.horizon + 1, 3)


def test_windows_follow_the_schedule(linear_task):
    outcomes = {o.predicate: o for o in recorded(linear_task, GOOD).outcomes}
    assert (outcomes["A3"].kind, outcomes["A3"].start, outcomes["A3"].end) == (Kind.STAY, 65, 75)
    assert (outcomes["¬B5"].start, outcomes["¬B5"].end) == (0, 100)
    assert outcomes["¬B5"].worst == pytest.approx(2.0)


def test_what_fails_first_is_found(linear_task):
    recording = recorded(linear_task, GOOD | {"A3": (65, 70)}, crash=30)
    assert not recording.satisfied
    first = {o.predicate: o.first_failure for o in recording.outcomes}
    assert (first["A1"], first["A3"], first["¬B5"]) == (None, 71, 30)


def test_the_verdict_is_the_formulas_not_the_schedules(linear_task):
    """A1 is visited at another time than planned: the formula holds, the task does not."""
    recording = recorded(linear_task, GOOD, schedule=(40, 50, 15))
    assert recording.satisfied
    assert [o.predicate for o in recording.outcomes if o.worst < 0] == ["A1"]


def test_a_nudged_trace_is_told_with_the_times_that_it_met(linear_task):
    recording = recorded(linear_task, GOOD, schedule=(40, 50, 15), nudged=True)
    assert recording.satisfied and 18 <= recording.schedule[0] <= 22
    assert recording.schedule[1:] == (50, 15)
    assert all(outcome.worst >= 0 for outcome in recording.outcomes)
    kept = recorded(linear_task, GOOD, schedule=(22, 50, 15), nudged=True)
    assert kept.schedule == (22, 50, 15)
    violated = recorded(linear_task, GOOD, schedule=(40, 50, 15), crash=30, nudged=True)
    assert violated.schedule == (40, 50, 15)


def test_padding_of_a_schedule_is_dropped(linear_task):
    assert recorded(linear_task, GOOD, schedule=(20, 50, 15, 0, 0, 0, 0, 0)).schedule == SCHEDULE


def test_a_schedule_is_one_of_the_formula_not_of_the_layout(linear_task):
    recording, scene = recorded(linear_task, GOOD), load_task("linear-08")
    moved = replace(scene.regions[0], center=(scene.regions[0].center[0] + 0.05, 0.0))
    same = build_task(replace(scene, regions=(moved, *scene.regions[1:])))
    fewer = build_task(scene, "F_[0:90](A1)")
    later = build_task(scene, scene.formula.replace("0:90", "0:80"))
    assert recording.schedule_for(linear_task) == SCHEDULE
    assert recording.schedule_for(same) == SCHEDULE
    assert recording.schedule_for(fewer) is recording.schedule_for(later) is None
    assert recording.schedule_for(None) is None


def test_a_broken_simulation_is_a_violation(linear_task):
    states = np.zeros((linear_task.padded_horizon + 1, 2))
    margins = margins_of(linear_task, GOOD)
    margins[3, 0] = np.nan
    recording = record(
        linear_task, SCHEDULE, states, np.zeros((linear_task.padded_horizon, 2)), margins
    )
    assert recording.robustness == -np.inf
    assert not recording.satisfied
