"""What an attack found, as a table."""

import sys
from collections.abc import Iterable, Mapping
from typing import NamedTuple

HANG = 2.0
"""Longest time in which a ping, a connection or a formula may go unanswered [s]."""


class Row(NamedTuple):
    """One kind of attempt."""

    part: str
    what: str
    tried: int
    refused: int
    failures: int
    """Exceptions that are not ours, hangs, and anything lost; 0 is wanted."""
    slowest_s: float
    growth_mb: float
    """Of the attacked process's memory, from before to after."""


def hangs(*waited: float) -> dict[str, int]:
    """Whether one of the answers took longer than `HANG`, for `failures`."""
    return {f"no answer within {HANG:g} s: {waited}": max(waited) > HANG}


def failures(part: str, what: str, wrong: Mapping[str, int]) -> int:
    """How much went wrong; each kind is said on stderr."""
    for kind, count in wrong.items():
        if count:
            print(f"{part}: {what}: {kind} ({count:d})", file=sys.stderr)
    return sum(wrong.values())


def table(rows: Iterable[Row]) -> str:
    """Columns of equal width, under their names."""
    lines = [Row._fields, *(tuple(map(_shown, row)) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def _shown(value: str | float) -> str:
    return f"{value:.2f}" if isinstance(value, float) else str(value)
