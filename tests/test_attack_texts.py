"""A short form of the attack on texts and files; `python -m tests.tools.attack` is the long one."""

import pytest

from core.errors import UserError
from tests.tools.attack.__main__ import parts
from tests.tools.attack.table import Row, table
from tests.tools.trials import tried

SHORT = {"files": (400, 4.0), "bundles": (20, 8.0), "formulas": (200, 5.0), "kills": (1, 60.0)}
"""Inputs and seconds of each part."""


@pytest.mark.parametrize("part", SHORT)
def test_nothing_breaks(part, disk_cache):
    rows = parts()[part].attack(*SHORT[part])
    assert rows and all(row.tried > 0 for row in rows)
    assert not any(row.failures for row in rows), table(rows)


def test_what_an_attack_counts(capsys):
    def answer(number: int) -> None:
        if number == 1:
            raise UserError("no")
        if number == 2:
            raise ZeroDivisionError
        if number == 3:
            sum(range(3_000_000))

    row = tried("part", "what", range(9), answer, count=5, seconds=60, slowest_allowed=0.01)
    assert row[:5] == ("part", "what", 5, 1, 2)
    assert "ZeroDivisionError" in capsys.readouterr().err
    assert table([row]).splitlines()[1].startswith("part  what  5      1        2")
    assert Row._fields[0] == "part"
