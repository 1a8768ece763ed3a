"""Scenes: a robot, its named regions, a formula and the initial set, stored as TOML.

The same schema serves the shipped tasks (`scenes/<robot>/NN.toml`) and a user's project files
(`*.stl.toml`):

    format = 1
    name = "linear-08"            title = "..."       robot = "linear"
    horizon = 100  # steps        seed = 1007         formula = "F_[0:90](A1)"
    [initial]      kind, center, size                 # where episodes start
    [regions.A1]   kind, center, size, color?, path?  # one table per region, in order
    [predicates]   slow = "v <= 1"                    # of the robot's state, if any

`variant = "..."` beside them asks for another reading of the robot, one of its `variants`;
`arena = [[low, high], ...]` for another arena than the robot's, and `between_steps = true` for
invariants that hold between the steps, too (`core.between`). docs/scene-files.md has it all.
"""

import os
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
from envs import ENVS, Robot, Workspace, make_robot
from scenes.arena import Arena, checked, fitted, round_scale, scale_of
from scenes.predicates import Predicate, check_predicates
from scenes.regions import Region, SceneError
from scenes.tables import key, quoted, quoted_lines, region_from, region_lines
from scenes.toml import LARGEST_FILE, read_toml

FORMAT = 1
"""Version of the schema that this program reads and writes."""

DEMO = "-demo"
"""Suffix of a demo's name; the paper's tasks have numbers."""

LONGEST_FORMULA = 10_000  # characters, as in the parser
LARGEST_HORIZON = 10_000  # steps
LARGEST_SEED = 2**31 - 1


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
    """A table each, as `initial`; read one by one, so that errors can name them."""
    predicates: dict[str, Any] = {}
    arena: Any = None
    workspace: Any = None
    """What people also call it; only one of the two may be given."""


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
        arena: (low, high) of each axis in [m]; None for the robot's own.
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
    arena: Arena | None = None
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
        if self.arena is not None:
            object.__setattr__(self, "arena", checked(self.arena, robot_of(self)))
        self._check_regions()
        check_predicates(self.predicates, robot_of(self))

    def _check_regions(self) -> None:
        seen: set[str] = set()
        for named in (*self.regions, *self.predicates):
            table = "regions" if isinstance(named, Region) else "predicates"
            if named.name in seen:
                raise SceneError(f"{table}.{named.name}: this name is given twice")
            seen.add(named.name)
            if isinstance(named, Region) and named.kind == "point":
                raise SceneError(
                    f"regions.{named.name}: a point can only be the initial set; a region needs "
                    "an inside, such as that of a small circle or sphere"
                )
        if self.initial.motion is not None:
            raise SceneError("initial.path: the initial set cannot move: episodes begin at step 0")
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
    def moving(self) -> frozenset[str]:
        """Names of the regions that move."""
        return frozenset(region.name for region in self.regions if region.motion is not None)

    @property
    def atom_names(self) -> tuple[str, ...]:
        """What the formula may speak of: the regions, then the predicates."""
        return (*self.region_names, *(predicate.name for predicate in self.predicates))


def robot_of(scene: Scene) -> Robot:
    """The robot of a scene, in its variant."""
    return make_robot(scene.robot, scene.variant)


def workspace_of(scene: Scene) -> Workspace:
    """The robot's workspace, in the scene's arena."""
    workspace = robot_of(scene).workspace
    return workspace if scene.arena is None else fitted(workspace, scene.arena)


def unit_of(scene: Scene) -> float:
    """The length [m] that counts as one where a scene is drawn: the robot's, in its arena.

    In another arena it is multiplied by 1, 2 or 5 times a power of ten, so that a grid of it is
    one of round numbers.
    """
    robot = robot_of(scene)
    return robot.length * round_scale(scale_of(robot.workspace, workspace_of(scene).arena))


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
        lines.append(f"{field} = {quoted(getattr(scene, field))}")
    if scene.variant:
        lines.append(f"variant = {quoted(scene.variant)}")
    if scene.between_steps:
        lines.append("between_steps = true")
    lines += [f"horizon = {scene.horizon}", f"seed = {scene.seed}"]
    if scene.arena is not None:
        lines.append(f"arena = {[list(pair) for pair in scene.arena]}")
    lines += [f"formula = {quoted_lines(scene.formula)}", "", "[initial]"]
    lines += region_lines(scene.initial)
    for region in scene.regions:
        lines += ["", f"[regions.{key(region.name)}]", *region_lines(region)]
    if scene.predicates:
        lines += ["", "[predicates]"]
    lines += [f"{key(each.name)} = {quoted(each.text)}" for each in scene.predicates]
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
            region_from(name, read.regions[name], f"regions.{name}") for name in read.regions
        ),
        initial=region_from("initial", read.initial, "initial"),
        variant=read.variant,
        arena=_arena_from(read),
        between_steps=read.between_steps,
        predicates=tuple(_predicate_from(name, text) for name, text in read.predicates.items()),
    )


def _arena_from(read: _SceneTable) -> Any:
    """Pairs (low, high), also from a flat list of them; `Scene` says what they may be."""
    if read.arena is not None and read.workspace is not None:
        raise SceneError("workspace: another word for arena, which is given too")
    given = read.workspace if read.arena is None else read.arena
    if isinstance(given, list) and given and not any(isinstance(each, list) for each in given):
        return [given[i : i + 2] for i in range(0, len(given), 2)]
    return given


def _predicate_from(name: str, text: str) -> Predicate:
    try:
        return Predicate(name, text)
    except SceneError as error:
        raise SceneError(f"predicates.{name}: {error}") from error


def _check_text(field: str, value: object, longest: int) -> None:
    if not isinstance(value, str) or not value.strip():
        raise SceneError(f"{field}: {value!r} must be non-empty text")
    if len(value) > longest:
        raise SceneError(f"{field}: {len(value):,} characters are too many: at most {longest:,}")


def _check_integer(field: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SceneError(f"{field}: {value!r} must be an integer from {low} to {high}")
