"""Regions as tables of a scene file, and the spelling of TOML that this program writes."""

import json
import re
from typing import Any

import msgspec
import numpy as np

from core.documents import typed
from scenes.motion import Motion, along, through
from scenes.regions import FIELDS, KINDS, SHAPES, Region, SceneError

Position = tuple[float, ...]

IN_SPACE = {kind for kind, shape in SHAPES.items() if shape.dimension == 3} | {"prism"}
"""Kinds of regions of space."""


class _PartTable(msgspec.Struct, forbid_unknown_fields=True):
    """A region's table, or a part of a union's; what its values may be is `Region`'s to say."""

    kind: str
    center: list[float] = []
    size: list[float] = []
    angle: float = 0.0
    points: list[list[float]] = []
    z: list[float] = []


class _RegionTable(_PartTable, forbid_unknown_fields=True):
    """A table [regions.NAME] or [initial]."""

    parts: list[Any] = []
    """Tables of parts, read one by one."""
    color: str | None = None
    path: Any = None
    velocity: Any = None


def region_from(name: str, table: Any, field: str, kind: type[_PartTable] = _RegionTable) -> Region:
    """The region of a table at a place of a file.

    Args:
        name: of the region.
        table: as it was read.
        field: the place, for errors.
        kind: of table.

    Raises:
        UserError: with the place.
    """
    if not isinstance(table, dict):
        raise SceneError(f"{field}: must be a table with kind, center, size, ...")
    table = dict(table)
    motion, begins = _motion_of(table, field)
    read = typed(table, kind, f"{field}.")
    wanted = FIELDS.get(read.kind, ())
    for each in wanted:
        if each not in table and each != "angle":
            raise SceneError(f"{field}.{each}: this field is missing")
    given = {each: getattr(read, each) for each in kind.__struct_fields__[1:] if each in table}
    given.pop("velocity", given.pop("path", None))
    if "parts" in given:
        places = enumerate(given["parts"])
        given["parts"] = tuple(
            region_from(name, part, f"{field}.parts[{i}]", _PartTable) for i, part in places
        )
    for each in ("center", "size", "z"):
        if each in given and each not in wanted and read.kind in KINDS:
            raise SceneError(f"{field}.{each}: a {read.kind} is given by {', '.join(wanted)}")
    try:
        region = Region(name, read.kind, motion=motion, **given)
    except SceneError as error:
        raise SceneError(f"{field}.{error}") from error
    return region if begins is None else _beginning_at(region, begins, field, "center" in given)


def _motion_of(table: dict[str, Any], field: str) -> tuple[Motion | None, Position | None]:
    """How the region of a table moves, and where its path begins; fills in a missing centre."""
    path, velocity = table.get("path"), table.get("velocity")
    if path is None and velocity is None:
        return None, None
    if path is not None and velocity is not None:
        raise SceneError(f"{field}.velocity: a path is given too; only one of them may be")
    kind = table.get("kind")
    if kind == "point":
        raise SceneError(f"{field}.{'velocity' if path is None else 'path'}: a point cannot move")
    kinds = [kind]
    if kind == "union" and isinstance(table.get("parts"), list):
        kinds = [part.get("kind") for part in table["parts"] if isinstance(part, dict)]
    dimension = 3 if IN_SPACE.intersection(each for each in kinds if isinstance(each, str)) else 2
    try:
        if path is None:
            return along(velocity, dimension), None
        motion, begins = through(path, dimension)
    except SceneError as error:
        raise SceneError(f"{field}.{error}") from error
    if "center" in FIELDS.get(str(kind), ()):
        table.setdefault("center", list(begins))
    return motion, begins


def _beginning_at(region: Region, begins: Position, field: str, centred: bool) -> Region:
    """The region where its path begins; one that is given by a centre must be there already."""
    if centred and not np.allclose(region.center, begins, rtol=0, atol=1e-9):
        raise SceneError(
            f"{field}.path: begins at {list(begins)}, but center is {list(region.center)}; a path "
            "says where the centre is, so let them agree or leave center out"
        )
    return region if region.center == begins else region.at(begins)


def region_lines(region: Region) -> list[str]:
    """The lines of a region's table, without its header."""
    lines = [f"{field} = {value}" for field, value in _fields(region).items()]
    if region.motion is not None:
        lines.append(_motion_line(region))
    if region.color is not None:
        lines.append(f"color = {quoted(region.color)}")
    return lines


def _fields(region: Region) -> dict[str, str]:
    """What a region is given by, as TOML."""
    found = {"kind": quoted(region.kind)}
    for field in FIELDS[region.kind]:
        value = getattr(region, field)
        if field == "parts":
            found["parts"] = "[\n" + "".join(f"  {_inline(part)},\n" for part in value) + "]"
        elif field == "points":
            found["points"] = repr([list(point) for point in value])
        elif field == "angle":
            found |= {"angle": repr(value)} if value else {}
        else:
            found[field] = repr(list(value))
    return found


def _motion_line(region: Region) -> str:
    assert region.motion is not None
    if region.motion.velocity is not None:
        return f"velocity = {list(region.motion.velocity)}"
    return f"path = {[[step, *place] for step, place in region.motion.waypoints(region.center)]}"


def _inline(region: Region) -> str:
    values = ", ".join(f"{field} = {value}" for field, value in _fields(region).items())
    return f"{{ {values} }}"


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
