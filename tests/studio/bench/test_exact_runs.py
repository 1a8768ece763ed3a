"""The exact planner as a run of a benchmark, and what is asked of weights beyond success."""

import json

import numpy as np
import pytest

from studio.bench.matrix import parse_matrix
from studio.bench.store import Store
from studio.bench.worker import measure
from tests.studio.bench.tiny import TINY, job


def test_the_exact_planner_is_a_run(disk_cache):
    row = measure(job(task="linear-01", method="exact", seconds=60.0, epochs=None))
    assert row["status"] == "finished" and row["stopped"] in ("optimal", "feasible")
    assert 0 <= row["middle_robustness"] <= row["bound"] + 1e-6
    refused = measure(job(task="unicycle-01", method="exact", seconds=5.0, epochs=None))
    assert refused["status"] == "refused" and "exact plans are for robots" in refused["message"]


def test_what_the_critic_is_worth_is_kept(tmp_path, disk_cache):
    text = TINY.replace("linear-demo", "linear-01").replace(
        "epochs = 2", "epochs = 2\ncritic_samples = 600"
    )
    row = measure(parse_matrix(text, "t").jobs[0])
    store = Store(tmp_path)
    store.open()
    store.add(row)
    (kept,) = store.rows()
    assert len(kept["critic_scores"]) == len(kept["critic_robustness"]) == 600
    assert np.isfinite(kept["critic_scores"]).all() and kept["middle_robustness"] is not None
    found = kept["critic_map"]
    assert len(found["scores"]) == len(found["first"]) * len(found["second"]) > 1
    assert json.loads(kept["job"])["critic_samples"] == 600
    assert kept["critic_robustness"][0] == pytest.approx(row["critic_robustness"][0])
