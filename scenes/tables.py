"""Regions as tables of a scene file, and the spelling of TOML that this program writes."""

import json
import re
from typing import Any

import msgspec

from core.documents import typed
from scenes.regions import Region, SceneError


class _RegionTable(msgspec.Struct, forbid_unknown_fields=True):
    """A table [regions.NAME] or [initial]; what its values may be is `Region`'s to say."""

    kind: str
    center: list[float]
    size: list[float]
    color: str | None = None


def region_from(name: str, table: Any, field: str) -> Region:
    """The region of a table at a place of a file.

    Raises:
        UserError: with the place.
    """
    if not isinstance(table, dict):
        raise SceneError(
            f"{field}: must be a table with {', '.join(_RegionTable.__struct_fields__)}"
        )
    read = typed(table, _RegionTable, f"{field}.")
    try:
        return Region(name, read.kind, tuple(read.center), tuple(read.size), read.color)
    except SceneError as error:
        raise SceneError(f"{field}.{error}") from error


def region_lines(region: Region) -> list[str]:
    """The lines of a region's table, without its header."""
    lines = [f"kind = {quoted(region.kind)}"]
    for field in ("center", "size"):
        values = ", ".join(repr(value) for value in getattr(region, field))
        lines.append(f"{field} = [{values}]")
    if region.color is not None:
        lines.append(f"color = {quoted(region.color)}")
    return lines


def quoted(text: str) -> str:
    """A TOML basic string; JSON's escapes are TOML's, but TOML also forbids a raw DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def quoted_lines(text: str) -> str:
    """A TOML string, multi-line if the text is."""
    if "\n" not in text:
        return quoted(text)
    return '"""\n' + "\n".join(quoted(line)[1:-1] for line in text.split("\n")) + '\n"""'


def key(name: str) -> str:
    """A key of a TOML table."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else quoted(name)
