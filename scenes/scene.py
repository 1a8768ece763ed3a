"""Scenes: a robot, its named regions, a formula and the initial set, stored as TOML.

The same schema serves the shipped tasks (`scenes/<robot>/NN.toml`) and a user's project files
(`*.stl.toml`):

    format = 1
    name = "linear-08"            title = "..."       robot = "linear"
    horizon = 100  # steps        seed = 1007         formula = "F_[0:90](A1)"
    [initial]      kind, center, size                 # where episodes start
    [regions.A1]   kind, center, size, color?         # one table per region, in order
    [predicates]   slow = "v <= 1"                    # of the robot's state, if any

`variant = "..."` beside them asks for another reading of the robot, one of its `variants`;
`between_steps = true` for invariants that hold between the steps, too (`core.between`).
"""

import json
import os
import re
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec

from core.documents import typed
from core.errors import UserError, allowed
from envs import ENVS, Robot, make_robot
from scenes.predicates import Predicate, check_predicates
from scenes.regions import Region, SceneError
from scenes.toml import LARGEST_FILE, read_toml

FORMAT = 1
"""Version of the schema that this program reads and writes."""

DEMO = "-demo"
"""Suffix of a demo's name; the paper's tasks have numbers."""

LONGEST_FORMULA = 10_000  # characters, as in the parser
LARGEST_HORIZON = 10_000  # steps
LARGEST_SEED = 2**31 - 1


class _RegionTable(msgspec.Struct, forbid_unknown_fields=True):
    """A table [regions.NAME] or [initial]; what its values may be is `Region`'s to say."""

    kind: str
    center: list[float]
    size: list[float]
    color: str | None = None


class _SceneTable(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """A whole file; the bounds of its values are `Scene`'s to say."""

    format: int
    name: str
    title: str
    robot: str
    variant: str = ""
    between_steps: bool = False
    horizon: int
    seed: int
    formula: str
    initial: Any
    regions: dict[str, Any] = {}
    """A `_RegionTable` each, as `initial`; read one by one, so that errors can name them."""
    predicates: dict[str, Any] = {}


@dataclass(frozen=True)
class Scene:
    """One task: what the page edits and the trainer grounds.

    Attributes:
        name: Short name, such as `linear-08`.
        title: One descriptive line.
        robot: One of `envs.ENVS`.
        formula: Text of the formula over the regions' names; checked by the parser.
        horizon: T, the minimum length of an episode in steps.
        seed: Seed of the training.
        regions: In drawing order, names unique.
        initial: The set of initial positions (its name is not an atom).
        variant: One of the robot's `variants`, empty for the standard robot.
        between_steps: Whether invariants must hold between the steps, too.
        predicates: Of the robot's state; names unique, among the regions', too.
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
    between_steps: bool = False
    predicates: tuple[Predicate, ...] = ()

    def __post_init__(self):
        for field, longest in (("name", 80), ("title", 200), ("formula", LONGEST_FORMULA)):
            _check_text(field, getattr(self, field), longest)
        try:
            make_robot(self.robot, self.variant)
        except UserError as error:
            raise SceneError(str(error)) from error
        _check_integer("horizon", self.horizon, 1, LARGEST_HORIZON)
        _check_integer("seed", self.seed, 0, LARGEST_SEED)
        self._check_regions()
        check_predicates(self.predicates, robot_of(self))

    def _check_regions(self) -> None:
        seen: set[str] = set()
        for named in (*self.regions, *self.predicates):
            if named.name in seen:
                table = "regions" if isinstance(named, Region) else "predicates"
                raise SceneError(f"{table}.{named.name}: this name is given twice")
            seen.add(named.name)
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
        return ENVS[self.robot].position_size

    @property
    def region_names(self) -> tuple[str, ...]:
        """Names of the regions, in order."""
        return tuple(region.name for region in self.regions)

    @property
    def atom_names(self) -> tuple[str, ...]:
        """What the formula may speak of: the regions, then the predicates."""
        return (*self.region_names, *(predicate.name for predicate in self.predicates))


def robot_of(scene: Scene) -> Robot:
    """The robot of a scene, in its variant."""
    return make_robot(scene.robot, scene.variant)


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene file; every error is a SceneError that names the file and the field."""
    where = Path(path)
    try:
        with where.open(encoding="utf-8") as file:
            text = file.read(LARGEST_FILE + 1)  # a device has no size
        if len(text) > LARGEST_FILE:
            raise SceneError(f"{where}: larger than {LARGEST_FILE:,} characters")
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
        return _scene_from(read_toml(text))
    except UserError as error:
        raise SceneError(f"{where}: {error}") from error


def format_scene(scene: Scene) -> str:
    """TOML text of a scene; `parse_scene` returns the same scene.

    Not written by tomli-w: it breaks every array over several lines, so that a region would take
    ten lines instead of four, in files that people read and edit.
    """
    lines = [f"format = {FORMAT}"]
    for field in ("name", "title", "robot"):
        lines.append(f"{field} = {_quoted(getattr(scene, field))}")
    if scene.variant:
        lines.append(f"variant = {_quoted(scene.variant)}")
    if scene.between_steps:
        lines.append("between_steps = true")
    lines += [f"horizon = {scene.horizon}", f"seed = {scene.seed}"]
    lines += [f"formula = {_quoted_lines(scene.formula)}", "", "[initial]"]
    lines += _region_lines(scene.initial)
    for region in scene.regions:
        lines += ["", f"[regions.{_key(region.name)}]", *_region_lines(region)]
    if scene.predicates:
        lines += ["", "[predicates]"]
    lines += [f"{_key(each.name)} = {_quoted(each.text)}" for each in scene.predicates]
    return "\n".join(lines) + "\n"


def _shipped(robot: str | None = None) -> list[str]:
    if robot is not None and robot not in ENVS:
        raise SceneError(f"robot: unknown {robot!r}. {allowed(robot, ENVS)}")
    names = []
    for name in [robot] if robot else sorted(ENVS):
        folder = resources.files("scenes").joinpath(name)
        files = sorted(entry.name for entry in folder.iterdir()) if folder.is_dir() else []
        names += [f"{name}-{file[:-5]}" for file in files if file.endswith(".toml")]
    return names


def _scene_from(table: Mapping[str, Any]) -> Scene:
    version = table.get("format")
    if version != FORMAT or isinstance(version, bool):
        given = "is missing" if version is None else f"{version!r} is not known"
        raise SceneError(f"format: {given}; this program reads format = {FORMAT}")
    read = typed(table, _SceneTable)
    return Scene(
        name=read.name,
        title=read.title,
        robot=read.robot,
        formula=read.formula.strip("\r\n"),
        horizon=read.horizon,
        seed=read.seed,
        regions=tuple(
            _region_from(name, read.regions[name], f"regions.{name}") for name in read.regions
        ),
        initial=_region_from("initial", read.initial, "initial"),
        variant=read.variant,
        between_steps=read.between_steps,
        predicates=tuple(_predicate_from(name, text) for name, text in read.predicates.items()),
    )


def _predicate_from(name: str, text: str) -> Predicate:
    try:
        return Predicate(name, text)
    except SceneError as error:
        raise SceneError(f"predicates.{name}: {error}") from error


def _region_from(name: str, table: Any, field: str) -> Region:
    if not isinstance(table, dict):
        raise SceneError(
            f"{field}: must be a table with {', '.join(_RegionTable.__struct_fields__)}"
        )
    read = typed(table, _RegionTable, f"{field}.")
    try:
        return Region(name, read.kind, tuple(read.center), tuple(read.size), read.color)
    except SceneError as error:
        raise SceneError(f"{field}.{error}") from error


def _check_text(field: str, value: object, longest: int) -> None:
    if not isinstance(value, str) or not value.strip():
        raise SceneError(f"{field}: {value!r} must be non-empty text")
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
    """A TOML string, multi-line if the text is."""
    if "\n" not in text:
        return _quoted(text)
    return '"""\n' + "\n".join(_quoted(line)[1:-1] for line in text.split("\n")) + '\n"""'


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _quoted(name)
