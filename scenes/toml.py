"""TOML from people: what would take long is refused before it is parsed."""

import re
import tomllib
from typing import Any

from core.errors import UserError

LARGEST_FILE = 250_000
"""Bytes of a file; `tomllib` takes a second for a million of them."""

MOST_PARTS = 8
"""Parts of a dotted key; a project's have three."""

_TEXT = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"""|\Z)|'
    r"'''.*?(?:'''|\Z)|"
    r'"(?:\\.|[^"\\\n])*"?|'
    r"'[^'\n]*'?|#[^\n]*",
    re.DOTALL,
)
"""Strings and comments; one that is not closed ends with the line or the text, so that a scan
takes linear time."""

_BETWEEN = re.compile(r"[^,=\[\]{}\n]+")
"""A key, or a value that is no string."""


def read_toml(text: str) -> dict[str, Any]:
    """Parse TOML.

    Raises:
        UserError: not TOML, too large, or with a key of too many parts (the time that `tomllib`
            takes grows with the square of their number).
    """
    if len(text) > LARGEST_FILE:
        raise UserError(f"larger than {LARGEST_FILE:,} characters")
    plain = _TEXT.sub('""', text)
    parts = 1 + max((found[0].count(".") for found in _BETWEEN.finditer(plain)), default=0)
    if parts > MOST_PARTS:
        raise UserError(
            f"not valid here: a key of {parts:,} parts joined by dots; at most {MOST_PARTS} are "
            "read"
        )
    try:
        return tomllib.loads(text)
    except (ValueError, OverflowError, RecursionError) as error:  # also integers of many digits
        raise UserError(f"not valid TOML: {error}") from error
