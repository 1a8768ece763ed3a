"""A real Ray cluster of this machine carries out a matrix."""

import json
import subprocess
import sys

import pytest

from studio.bench.cli import main
from studio.bench.matrix import parse_matrix
from studio.bench.store import Store
from tests.studio.bench.test_resuming import ENVIRONMENT

REFUSED = """
format = 1
title = "refused: nothing is compiled, and the rows are there all the same"

[[runs]]
tasks = ["linear-05"]
horizons = [10]
seeds = [1, 2]
"""


def arguments(folder):
    (folder / "refused.toml").write_text(REFUSED)
    return ["run", str(folder / "refused.toml"), "--out", str(folder / "store"), "--ray", "local"]


def test_every_run_is_kept_and_none_is_repeated(tmp_path):
    pytest.importorskip("ray", reason="needs the extra `cluster`")
    command = [sys.executable, "-m", "studio.bench.cli", *arguments(tmp_path)]
    jobs, store = parse_matrix(REFUSED, "refused").jobs, Store(tmp_path / "store")
    store.open()
    store.add({"key": jobs[0].key, "status": "finished"})
    found = subprocess.run(
        command, env=ENVIRONMENT, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr
    lines = [json.loads(line) for line in found.stdout.splitlines() if line.startswith("{")]
    assert [line["run"] for line in lines[:-1]] == [jobs[1].key]
    assert (lines[-1]["already_finished"], lines[-1]["failed"]) == (1, 0)
    (row,) = [row for row in store.rows() if row["key"] == jobs[1].key]
    assert row["status"] == "refused" and row["message"] and row["concurrent"] is None
    assert row["seed"] == 2 and row["wall_seconds"] > 0


def test_a_cluster_that_is_not_there_is_said(tmp_path, capsys):
    pytest.importorskip("ray", reason="needs the extra `cluster`")
    wrong = [*arguments(tmp_path)[:-1], "ray:/nowhere"]
    assert main(wrong) == 2
    assert "--ray: no cluster at 'ray:/nowhere'" in capsys.readouterr().err
    assert not (tmp_path / "store").exists()


def test_without_ray_it_says_what_to_install(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    assert main(arguments(tmp_path)) == 2
    assert "pip install 'tgpo-studio[cluster]'" in capsys.readouterr().err
