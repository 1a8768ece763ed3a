"""Cores that are dealt to runs, and processes that keep to them."""

import json
import os
import subprocess
import sys

import pytest

from studio.bench import cores, runner
from studio.bench.cores import bounded, dealt, own_cores
from studio.bench.runner import Outcome
from studio.bench.store import Store
from tests.studio.bench.tiny import job

PINS = hasattr(os, "sched_setaffinity")


@pytest.mark.skipif(not PINS, reason="this system lets no process choose its cores")
@pytest.mark.parametrize(
    ("given", "processes", "expected"),
    [
        ((0, 1), 1, [()]),
        ((0, 1), 2, [(0,), (1,)]),
        ((4, 5, 6, 7, 8), 2, [(4, 6, 8), (5, 7)]),
        ((2, 3), 3, [(2,), (3,), (2,)]),
    ],
)
def test_every_run_has_a_share(given, processes, expected):
    assert dealt(given, processes) == expected


def test_where_no_process_can_choose_none_is_dealt(monkeypatch):
    monkeypatch.delattr(os, "sched_setaffinity", raising=False)
    assert dealt((0, 1), 2) == [(), ()]


@pytest.mark.skipif(not PINS, reason="this system lets no process choose its cores")
@pytest.mark.parametrize("processes", [1, 2])
def test_a_budget_of_the_processor_is_spent_on_one_core(monkeypatch, tmp_path, processes):
    kept = {}

    def run(_store, order, _alive):
        kept[order.job.cpu_seconds] = order.cores
        return Outcome(order.job, "")

    monkeypatch.setattr(runner, "_run", run)
    monkeypatch.setattr(runner, "own_cores", lambda: (0, 1, 2, 3))
    jobs = [job(seconds=9.0), job(cpu_seconds=9.0)]
    runner.run_jobs(Store(tmp_path), jobs, processes=processes, told=lambda _: None)
    assert len(kept[None]) != 1
    assert len(kept[9.0]) == 1


def test_pools_are_as_large_as_the_share():
    assert bounded(()) == {}
    assert set(bounded((3, 5)).values()) == {"2"}


@pytest.mark.skipif(not PINS, reason="this system lets no process choose its cores")
def test_a_process_keeps_to_its_cores():
    script = """
import json, sys
from studio.bench.cores import keep_to, own_cores
keep_to(json.loads(sys.argv[1]))
print(json.dumps([own_cores()]))
"""
    first = own_cores()[:1]
    command = [sys.executable, "-c", script, json.dumps(first)]
    root = os.path.dirname(os.path.dirname(os.path.dirname(cores.__file__)))
    found = subprocess.run(
        command, capture_output=True, text=True, check=True, env=os.environ | {"PYTHONPATH": root}
    )
    assert json.loads(found.stdout) == [list(first)]
