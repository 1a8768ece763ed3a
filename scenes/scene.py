"""Scenes: a robot, its named regions, a formula and the initial set; read from and kept as TOML.

The same schema serves the shipped tasks (`scenes/<robot>/NN.toml`) and a user's project files
(`*.stl.toml`):

    format = 1
    name = "linear-08"            title = "..."       robot = "linear"
    horizon = 100  # steps        seed = 1007         formula = "F_[0:90](A1)"
    [initial]      kind, center, size                 # where episodes start
    [regions.A1]   kind, center, size, color?         # one table a region, in order

`variant = "..."` beside them asks for another reading of the robot, one of `VARIANTS`.
"""

import json
import os
import re
import tempfile
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from scenes.regions import Region, SceneError, allowed

FORMAT = 1
"""Version of the schema that this program reads and writes."""

WORKSPACE_DIMENSION = MappingProxyType(
    {"linear": 2, "unicycle": 2, "panda": 3, "quadrotor": 3, "ant": 2}
)
"""Dimension of the space in which each robot's regions live (a test holds it equal to `ENVS`)."""

VARIANTS = MappingProxyType({"panda": ("links",), "quadrotor": ("raw-motors",)})
"""Other readings of the robots (a test holds the names equal to those of `envs.VARIANTS`)."""

DEMO = "-demo"
"""Ends the name of a robot's demo, beside the numbers of the paper's tasks."""

LARGEST_FILE = 1_000_000  # bytes
LONGEST_FORMULA = 10_000  # characters, as in the parser
LARGEST_HORIZON = 10_000  # steps
LARGEST_SEED = 2**31 - 1

_SCENE_FIELDS = ("name", "title", "robot", "horizon", "seed", "formula", "initial", "regions")
_REGION_FIELDS = ("kind", "center", "size")


@dataclass(frozen=True)
class Scene:
    """One task: what the page edits and the trainer grounds.

    Attributes:
        name: Short name, such as `linear-08`.
        title: One line for a person.
        robot: One of `WORKSPACE_DIMENSION`.
        formula: Text of the formula over the regions' names; the parser judges it.
        horizon: Least length of an episode in steps.
        seed: Seed of the training.
        regions: In drawing order, names unique.
        initial: The set of initial positions (its name is not an atom).
        variant: One of the robot's `VARIANTS`, empty for the robot as it is.
    """

    name: str
    title: str
    robot: str
    formula: str
    horizon: int
    seed: int
    regions: tuple[Region, ...]
    initial: Region
    variant: str = ""

    def __post_init__(self):
        for field, longest in (("name", 80), ("title", 200), ("formula", LONGEST_FORMULA)):
            _check_text(field, getattr(self, field), longest)
        if not isinstance(self.robot, str) or self.robot not in WORKSPACE_DIMENSION:
            hint = allowed(self.robot, WORKSPACE_DIMENSION)
            raise SceneError(f"robot: unknown {self.robot!r}. {hint}")
        variants = VARIANTS.get(self.robot, ())
        if self.variant != "" and self.variant not in variants:
            known = allowed(self.variant, variants) if variants else "Allowed: none"
            raise SceneError(f"variant: unknown {self.variant!r} of {self.robot!r}. {known}")
        _check_integer("horizon", self.horizon, 1, LARGEST_HORIZON)
        _check_integer("seed", self.seed, 0, LARGEST_SEED)
        self._check_regions()

    def _check_regions(self) -> None:
        seen: set[str] = set()
        for region in self.regions:
            if region.name in seen:
                raise SceneError(f"regions.{region.name}: this name is given twice")
            seen.add(region.name)
        fields = {f"regions.{region.name}": region for region in self.regions}
        for field, region in ({"initial": self.initial} | fields).items():
            if region.dimension != self.dimension:
                raise SceneError(
                    f"{field}: a {region.kind} has dimension {region.dimension}, but the regions "
                    f"of the robot {self.robot!r} have dimension {self.dimension}"
                )

    @property
    def dimension(self) -> int:
        """Dimension d of the space of the regions."""
        return WORKSPACE_DIMENSION[self.robot]

    @property
    def region_names(self) -> tuple[str, ...]:
        """Names of the regions, in order: the atoms that the formula may use."""
        return tuple(region.name for region in self.regions)


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene file; every flaw is a SceneError that names the file and the field."""
    where = Path(path)
    try:
        if where.stat().st_size > LARGEST_FILE:
            raise SceneError(f"{where}: larger than {LARGEST_FILE:,} bytes")
        text = where.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise SceneError(f"{where}: cannot be read: {reason}") from error
    return parse_scene(text, str(where))


def save_scene(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write a scene file atomically: a reader sees the old file or the new one, never a part."""
    target = Path(path)
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(format_scene(scene))
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except OSError as error:
        if temporary is not None:
            with suppress(OSError):
                os.unlink(temporary)
        raise SceneError(f"{target}: cannot be written: {error.strerror}") from error


def task_names(robot: str | None = None) -> list[str]:
    """Names of the paper's tasks, such as `linear-08`, sorted; of one robot if given."""
    return [name for name in _shipped(robot) if not name.endswith(DEMO)]


def demo_names(robot: str | None = None) -> list[str]:
    """Names of the demos, such as `linear-demo`; of one robot if given."""
    return [name for name in _shipped(robot) if name.endswith(DEMO)]


def load_task(name: str) -> Scene:
    """Read a shipped task or demo by its name."""
    names = _shipped()
    if name not in names:
        raise SceneError(f"task: unknown {name!r}. {allowed(name, names)}")
    robot, number = name.rsplit("-", 1)
    file = resources.files("scenes").joinpath(robot, f"{number}.toml")
    return parse_scene(file.read_text(encoding="utf-8"), f"scenes/{robot}/{number}.toml")


def parse_scene(text: str, where: str) -> Scene:
    """Build a scene from TOML text; `where` names the source in errors."""
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also integers of thousands of digits
        raise SceneError(f"{where}: not valid TOML: {error}") from error
    try:
        return _scene_from(table)
    except SceneError as error:
        raise SceneError(f"{where}: {error}") from error


def format_scene(scene: Scene) -> str:
    """TOML text of a scene; `parse_scene` gives the same scene back."""
    lines = [f"format = {FORMAT}"]
    for field in ("name", "title", "robot"):
        lines.append(f"{field} = {_quoted(getattr(scene, field))}")
    if scene.variant:
        lines.append(f"variant = {_quoted(scene.variant)}")
    lines += [f"horizon = {scene.horizon}", f"seed = {scene.seed}"]
    lines += [f"formula = {_quoted_lines(scene.formula)}", "", "[initial]"]
    lines += _region_lines(scene.initial)
    for region in scene.regions:
        lines += ["", f"[regions.{_key(region.name)}]", *_region_lines(region)]
    return "\n".join(lines) + "\n"


def _shipped(robot: str | None = None) -> list[str]:
    if robot is not None and robot not in WORKSPACE_DIMENSION:
        raise SceneError(f"robot: unknown {robot!r}. {allowed(robot, WORKSPACE_DIMENSION)}")
    names = []
    for folder in [robot] if robot else sorted(WORKSPACE_DIMENSION):
        files = sorted(entry.name for entry in resources.files("scenes").joinpath(folder).iterdir())
        names += [f"{folder}-{file[:-5]}" for file in files if file.endswith(".toml")]
    return names


def _scene_from(table: Mapping[str, Any]) -> Scene:
    version = table.get("format")
    if version != FORMAT or isinstance(version, bool):
        given = "is missing" if version is None else f"{version!r} is not known"
        raise SceneError(f"format: {given}; this program reads format = {FORMAT}")
    required = tuple(field for field in _SCENE_FIELDS if field != "regions")
    _check_fields(table, required, ("format", "regions", "variant"), "")
    rows = table.get("regions", {})
    if not isinstance(rows, dict):
        raise SceneError("regions: must be tables [regions.NAME]")
    regions = tuple(_region_from(name, row, f"regions.{name}") for name, row in rows.items())
    values = {field: table[field] for field in _SCENE_FIELDS[:6]}
    if isinstance(values["formula"], str):
        values["formula"] = values["formula"].strip("\r\n")
    initial = _region_from("initial", table["initial"], "initial")
    variant = table.get("variant", "")
    return Scene(**values, regions=regions, initial=initial, variant=variant)


def _region_from(name: str, table: Any, field: str) -> Region:
    if not isinstance(table, dict):
        raise SceneError(f"{field}: must be a table with {', '.join(_REGION_FIELDS)}")
    _check_fields(table, _REGION_FIELDS, ("color",), f"{field}.")
    try:
        return Region(name=name, **table)
    except SceneError as error:
        raise SceneError(f"{field}.{error}") from error


def _check_fields(
    table: Mapping[str, Any], required: tuple[str, ...], optional: tuple[str, ...], prefix: str
) -> None:
    for field in required:
        if field not in table:
            raise SceneError(f"{prefix}{field}: this field is missing")
    for field in table:
        if field not in required + optional:
            raise SceneError(f"{prefix}{field}: unknown. {allowed(field, required + optional)}")


def _check_text(field: str, value: object, longest: int) -> None:
    if not isinstance(value, str) or not value.strip():
        raise SceneError(f"{field}: {value!r} must be text of at least one character")
    if len(value) > longest:
        raise SceneError(f"{field}: {len(value):,} characters are too many: at most {longest:,}")


def _check_integer(field: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SceneError(f"{field}: {value!r} must be an integer from {low} to {high}")


def _region_lines(region: Region) -> list[str]:
    lines = [f"kind = {_quoted(region.kind)}"]
    for field in ("center", "size"):
        values = ", ".join(repr(value) for value in getattr(region, field))
        lines.append(f"{field} = [{values}]")
    if region.color is not None:
        lines.append(f"color = {_quoted(region.color)}")
    return lines


def _quoted(text: str) -> str:
    """A TOML basic string; JSON's escapes are TOML's, but TOML also forbids a raw DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _quoted_lines(text: str) -> str:
    """A TOML string, spread over lines where the text is."""
    if "\n" not in text:
        return _quoted(text)
    return '"""\n' + "\n".join(_quoted(line)[1:-1] for line in text.split("\n")) + '\n"""'


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _quoted(name)
