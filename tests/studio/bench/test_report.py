"""The report of a store: every number on the page is in its summary."""

import json
import re

import pytest

from core.errors import UserError
from studio.bench.cli import main
from studio.bench.report import write_report
from studio.bench.store import Store
from tests.studio.bench.tiny import row


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("store"))
    store.open()
    for seed in (1, 2, 3):
        for task in ("linear-01", "linear-08"):
            store.add(row(0.9 + seed / 100, task=task, seed=seed))
            store.add(row(0.5, task=task, seed=seed, method="tgpo"))
            store.add(row(0.3, task=task, seed=seed, variant="random", changes={"share_mcmc": 0.0}))
        for horizon in (50, 200):
            store.add(row(0.8, seconds=horizon / 10, seed=seed, horizon=horizon))
    store.add(row(0.95, weights="shipped"))
    refused = row(0.0, task="linear-02", method="tgpo", seed=9)
    store.add(refused | {"status": "refused", "message": "not <here>", "success_rate": None})
    return store


@pytest.fixture(scope="module")
def page(store):
    return write_report(store)


def test_rows_come_back_as_they_were(store):
    rows = {one["key"]: one for one in store.rows()}
    given = row(0.91, task="linear-01", seed=1)
    assert rows[given["key"]] == given | {"message": None}


def test_figures_and_tables(page):
    summary = json.loads((page.parent / "summary.json").read_text())
    html = page.read_text()
    for key in (
        *("success-linear-all", "success-linear-two-layer", "success-linear-multi-layer"),
        *("seconds-linear", "variants-linear-tgpo-star-studio"),
        *("horizon-linear-tgpo-star-studio-success_rate",),
    ):
        assert (page.parent / f"{key}.png").read_bytes().startswith(b"\x89PNG")
        assert f'src="{key}.png"' in html and summary[key]
    assert (page.parent / "curves-linear.png").exists()
    best = summary["success-linear-all"]["tgpo-star"]
    assert best["mean"] == pytest.approx(0.92) and (best["seeds"], best["runs"]) == (3, 6)
    assert best["half_width"] == pytest.approx(4.30265 * 0.01 / 3**0.5, rel=1e-4)
    shipped = summary["success-linear-all"]["tgpo-star, shipped weights"]
    assert (shipped["runs"], shipped["half_width"]) == (1, None)
    assert set(summary["horizon-linear-tgpo-star-studio-train_seconds"]) == {"50", "200"}
    assert set(summary["variants-linear-tgpo-star-studio"]) == {"default", "random"}


def test_every_number_of_a_table_is_in_the_summary(page):
    summary = json.loads((page.parent / "summary.json").read_text())
    means = {
        f"{entry['mean']:.3f}"
        for table in summary.values()
        if isinstance(table, dict)
        for entry in table.values()
        if isinstance(entry, dict)
    }
    shown = re.findall(r"<td>(\d+\.\d{3})(?: ±| \()", page.read_text())
    assert len(shown) > 10 and set(shown) <= means


def test_the_paper_stands_beside_with_its_citation(page):
    html = page.read_text()
    assert "arXiv 2510.00225" in html and "<td>0.8753" in html


def test_what_was_refused_is_listed_and_escaped(page):
    assert "tgpo: linear-02: not &lt;here&gt;" in page.read_text()


def test_no_store_no_report(tmp_path, capsys):
    with pytest.raises(UserError, match="not a benchmark's folder"):
        write_report(Store(tmp_path))
    Store(tmp_path).open()
    with pytest.raises(UserError, match="no run is finished"):
        write_report(Store(tmp_path))
    (tmp_path / "runs" / "x.parquet").write_bytes(b"PAR1")
    assert main(["report", str(tmp_path)]) == 2
    assert "x.parquet: cannot be read" in capsys.readouterr().err
