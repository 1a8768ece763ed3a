"""A short form of `python -m tests.tools.attack`, on one page in a process of its own."""

import pytest

from tests.tools.attack import connections, headers, messages, page, table, uploads
from tests.tools.attack.serving import Served


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with Served(tmp_path_factory.mktemp("state"), "--task", "linear-08") as served:
        messages.judged_in(served.port)
        yield served


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """The long form measures times; here other tests may run beside it."""
    monkeypatch.setattr(table, "HANG", 20.0)


@pytest.mark.parametrize(("part", "count"), [(messages, 200), (connections, 330), (uploads, 100)])
def test_the_page_survives(served, part, count):
    rows = part.attack_page(served, count, 30)
    assert sum(row.failures for row in rows) == 0, table.table(rows)
    assert sum(row.tried for row in rows) > count / 2
    assert sum(row.refused for row in rows) > 0


def test_only_its_own_page_gets_an_answer(served):
    row = headers.attack_page(served, "no token", 100, 20, False)
    assert row.failures == 0
    assert row.refused == row.tried > 50


def test_a_killed_page_leaves_its_work():
    row = page.kills(1, 0.0)
    assert row.tried == 1
    assert row.failures == 0


def test_the_table_has_a_line_for_each_row():
    row = table.Row("messages", "bytes", 10, 9, 0, 0.25, 1.5)
    assert table.table([row]).splitlines() == [
        "part      what   tried  refused  failures  slowest_s  growth_mb",
        "messages  bytes  10     9        0         0.25       1.50",
    ]
    assert table.failures("messages", "bytes", {"tracebacks": 2, "hangs": False}) == 2
