"""The report of a store: every number on the page is in its summary."""

import json
import math
import re
from typing import Any

import pytest

from core.errors import UserError
from studio.bench.cli import main
from studio.bench.report import write_docs, write_report
from studio.bench.report.markdown import BEGIN, END
from studio.bench.store import Store
from tests.studio.bench.numbers import check_numbers
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
        store.add(row(0.2, seed=seed, variant="no-fields", changes={"mode": {"fields": False}}))
    store.add(row(0.95, weights="shipped"))
    store.add(row(0.97, task="linear-08", method="cem"))
    exact = {"robustness_mean": 0.6, "middle_robustness": 0.6, "bound": 0.6, "stopped": "optimal"}
    store.add(row(1.0, method="exact", seconds=7.0) | exact)
    values = [index / 10 - 2 for index in range(40)]
    critic: dict[str, Any] = {"critic_scores": values, "critic_robustness": values}
    critic["critic_map"] = {"first": [0, 5], "second": [1, 2, 3], "scores": [1.0] * 5 + [math.nan]}
    store.add(row(0.92, seed=4, critic_samples=40) | critic | {"middle_robustness": 0.3})
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


def table(page, key):
    """Rows of a table in the summary, by their first cell."""
    parts = json.loads((page.parent / "summary.json").read_text())["parts"]
    (found,) = [part for part in parts if part["kind"] == "table" and part["key"] == key]
    return {row[0]: row[1:] for row in found["rows"]}


ROBOT = "linear-2-epochs--ends-early-at-the-default-target"


def test_figures_and_tables(page):
    html = page.read_text()
    parts = json.loads((page.parent / "summary.json").read_text())["parts"]
    figures = {part["key"] for part in parts if part["kind"] == "figure"}
    assert figures >= {
        *(f"success-{ROBOT}-{group}" for group in ("all", "two-layer", "multi-layer")),
        *(f"curves-{ROBOT}", f"seconds-{ROBOT}"),
        *(f"variants-linear-tgpo-star-studio-{part}" for part in ("sources", "pieces")),
        *(f"horizon-linear-tgpo-star-{what}" for what in ("success", "seconds")),
        *("critic-linear-tgpo-star", "critic-linear-tgpo-star-maps"),
    }
    for key in figures:
        for name in (f"{key}.png", f"{key}-dark.png"):
            assert (page.parent / name).read_bytes().startswith(b"\x89PNG")
            assert f'"{name}"' in html
    best, published, two, multi = table(page, f"success-{ROBOT}")["tgpo-star"]
    assert (two["runs"], multi["runs"]) == (4, 3)
    assert published == 0.8753
    assert best["mean"] == pytest.approx(0.92) and (best["seeds"], best["runs"]) == (4, 7)
    assert best["half_width"] == pytest.approx(3.18245 * 0.0081650 / 4**0.5, rel=1e-4)
    shipped = table(page, f"success-{ROBOT}")["tgpo-star, shipped weights"][0]
    assert (shipped["runs"], shipped["half_width"]) == (1, None)
    assert set(table(page, "horizon-linear-tgpo-star")) == {50, 200}
    sources = table(page, "variants-linear-tgpo-star-studio-sources")
    assert set(sources) == {"default", "random"}
    assert sources["random"][2:4] == [pytest.approx(0.3)] * 2, "each task, beside the published"
    assert sources["random"][4]["runs"] == 6, "robustness"
    pieces = table(page, "variants-linear-tgpo-star-studio-pieces")
    assert set(pieces) == {"default", "default, shipped weights", "no-fields"}
    assert pieces["no-fields"][2] is None, "it had no run on the second task"


def test_it_says_first_where_a_baseline_is_better(page):
    headings = re.findall(r"<h2[^>]*>([^<]*)", page.read_text())
    assert headings[0] == "Where a baseline is better than TGPO*"
    lost = table(page, "beaten")
    assert list(lost) == ["linear-08"]
    assert lost["linear-08"][1] == "cem" and lost["linear-08"][2]["mean"] == pytest.approx(0.97)


def test_optimality_is_a_share_of_the_exact_planners(page):
    assert table(page, "optimality-exact")["linear-01"][:3] == [0.6, "optimal", 0.6]
    parts = json.loads((page.parent / "summary.json").read_text())["parts"]
    (found,) = [part for part in parts if part.get("key") == "optimality"]
    shares = {row[1]: row[3] for row in found["rows"] if row[0].startswith("tgpo-star (")}
    assert shares == {"linear-01": pytest.approx(0.5)}
    (name,) = [name for name in table(page, "optimality-means") if name.startswith("tgpo-star (")]
    assert table(page, "optimality-means")[name] == [1, pytest.approx(0.5)]


def test_the_critic_is_held_against_robustness(page):
    (seed, samples, rank, success, best) = table(page, "critic-linear-tgpo-star")["linear-01"]
    assert (seed, samples, rank) == (4, 40, pytest.approx(1.0))
    assert (success, best) == (0.5, 1.0)


def test_the_docs_hold_the_numbers_of_the_summary_and_keep_what_is_written_by_hand(
    store, page, tmp_path
):
    summary = page.parent / "summary.json"
    written = write_docs(summary, tmp_path, store.rows())
    text = written.read_text()
    assert check_numbers(text, json.loads((tmp_path / "benchmarks.json").read_text())) > 50
    written.write_text(text.replace(END, f"{END}\n\n## By hand\n\nKept 17.25."))
    again = write_docs(summary, tmp_path, store.rows()).read_text()
    assert "Kept 17.25." in again and again.count(BEGIN) == 1
    written.write_text("no marks")
    with pytest.raises(UserError, match="must stand in it"):
        write_docs(summary, tmp_path, store.rows())


def test_a_number_that_is_not_in_the_summary_is_found(page, tmp_path):
    text = write_docs(page.parent / "summary.json", tmp_path, []).read_text()
    wrong = text.replace("0.920", "0.921")
    assert wrong != text
    with pytest.raises(AssertionError, match="0.921"):
        check_numbers(wrong, json.loads((tmp_path / "benchmarks.json").read_text()))


def test_the_runs_beside_the_docs_make_the_same_report_again(store, page, tmp_path, capsys):
    write_docs(page.parent / "summary.json", tmp_path, store.rows())
    again = tmp_path / "again"
    table = str(tmp_path / "benchmarks.parquet")
    assert main(["merge", table, str(store.folder), "--out", str(again)]) == 0
    assert json.loads(capsys.readouterr().out)["added"] == len(store.rows())
    summary = write_report(Store(again)).parent / "summary.json"
    assert summary.read_bytes() == (page.parent / "summary.json").read_bytes()
    assert main(["merge", table, "--out", str(again)]) == 0
    assert json.loads(capsys.readouterr().out)["added"] == 0
    assert main(["merge", str(tmp_path / "none"), "--out", str(again)]) == 2
    assert "none: cannot be read" in capsys.readouterr().err


def test_the_paper_stands_beside_with_its_citation(page):
    html = page.read_text()
    assert "arXiv 2510.00225" in html and "<td>0.875</td>" in html


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
