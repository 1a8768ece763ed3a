"""Numbers of a generated document, looked up in the summary that it was made of."""

import re
from collections.abc import Iterator
from typing import Any

from studio.bench.report.markdown import BEGIN, END

NUMBER = r"(?<![\w.-])-?\d+(?:\.\d+)?(?![\w.])"


def check_numbers(text: str, summary: Any) -> int:
    """Assert that every number between the marks is in a summary; returns how many there are."""
    part = text.split(BEGIN, 1)[1].split(END, 1)[0]
    known = set(_known(summary))
    found = re.findall(NUMBER, part)
    missing = [number for number in found if number not in known]
    assert not missing, missing
    return len(found)


def _known(value: Any) -> Iterator[str]:
    """All numbers of a summary, as texts: as they are, with three decimals, and those in texts."""
    match value:
        case dict():
            for one in value.values():
                yield from _known(one)
        case list():
            for one in value:
                yield from _known(one)
        case bool() | None:
            pass
        case int() | float():
            yield str(value)
            yield f"{value:.3f}"
        case str():
            yield from re.findall(NUMBER, value)
