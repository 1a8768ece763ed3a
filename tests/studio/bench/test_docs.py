"""What docs/benchmarks.md says is in its summary, and nothing was changed by hand."""

import json
from pathlib import Path

import pytest

from studio.bench.report import page, write_report
from studio.bench.report.markdown import BEGIN, END, markdown
from studio.bench.store import Store
from tests.studio.bench.numbers import check_numbers

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def text():
    return (DOCS / "benchmarks.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def summary():
    return json.loads((DOCS / "benchmarks.json").read_text(encoding="utf-8"))


def test_every_number_is_in_the_summary(text, summary):
    assert check_numbers(text, summary) > 20


def test_it_is_what_the_summary_gives(text, summary):
    assert text.split(BEGIN, 1)[1].split(END, 1)[0].strip() == markdown(summary).strip()


def test_the_runs_beside_it_make_it_again(summary, tmp_path, monkeypatch):
    monkeypatch.setattr(page, "THEMES", ())  # no pictures
    store = Store(tmp_path)
    store.open()
    assert store.merge(DOCS / "benchmarks.parquet") >= summary["runs"]
    made = write_report(store).parent / "summary.json"
    assert markdown(json.loads(made.read_text(encoding="utf-8"))) == markdown(summary)
