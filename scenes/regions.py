"""Named regions: the shapes that the atoms of a formula denote.

A region is a closed set of positions given by its kind, its center and its size, in metres:

=========  =  ==================================
kind       d  size
=========  =  ==================================
circle     2  (radius,)
rectangle  2  (half_x, half_y)
sphere     3  (radius,)
box        3  (half_x, half_y, half_z)
cylinder   3  (radius, half_height), axis along z
=========  =  ==================================
"""

import re
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

import numpy as np

from core.errors import UserError, allowed

Kind = Literal["circle", "rectangle", "sphere", "box", "cylinder"]

LARGEST_COORDINATE = 1e3
"""Largest magnitude of a coordinate and largest size in [m]; float32 stays exact to 0.1 mm."""

SMALLEST_SIZE = 1e-6
"""Smallest size in [m]; a smaller region vanishes in float32."""

LONGEST_NAME = 40
"""Largest number of characters of a region's name."""


class SceneError(UserError):
    """A scene, a region or a scene file that cannot be used."""


class Shape(NamedTuple):
    """What a kind of region needs: the dimension of its space and the names of its sizes."""

    dimension: int
    sizes: tuple[str, ...]


SHAPES = MappingProxyType(
    {
        "circle": Shape(2, ("radius",)),
        "rectangle": Shape(2, ("half_x", "half_y")),
        "sphere": Shape(3, ("radius",)),
        "box": Shape(3, ("half_x", "half_y", "half_z")),
        "cylinder": Shape(3, ("radius", "half_height")),
    }
)
assert set(SHAPES) == set(get_args(Kind))


@dataclass(frozen=True)
class Region:
    """A named closed region of the plane or of space.

    Attributes:
        name: The atom of the formulas that the region interprets.
        kind: One of `SHAPES`.
        center: [d] in [m].
        size: Half extents or radius in [m], all positive; see the module's table.
        color: `#rrggbb`, or None for the viewer's choice.
    """

    name: str
    kind: str
    center: tuple[float, ...]
    size: tuple[float, ...]
    color: str | None = None

    def __post_init__(self):
        check_name(self.name)
        if not isinstance(self.kind, str) or self.kind not in SHAPES:
            raise SceneError(f"kind: unknown {self.kind!r}. {allowed(self.kind, SHAPES)}")
        shape = SHAPES[self.kind]
        axes = ("x", "y", "z")[: shape.dimension]
        center = _numbers("center", self.center, axes, self.kind)
        size = _numbers("size", self.size, shape.sizes, self.kind)
        if min(size) <= 0:
            raise SceneError(f"size: {list(size)} must be positive [m]")
        if min(size) < SMALLEST_SIZE:
            raise SceneError(f"size: {list(size)} must be at least {SMALLEST_SIZE:g} m")
        object.__setattr__(self, "center", center)
        object.__setattr__(self, "size", size)
        if self.color is not None and not _is_color(self.color):
            raise SceneError(f"color: {self.color!r} is not of the form '#rrggbb'")

    @property
    def dimension(self) -> int:
        """Dimension d of the space: 2 or 3."""
        return SHAPES[self.kind].dimension

    @property
    def half_extents(self) -> np.ndarray:
        """Half sides [d] in [m] of the box around the region, which has its centre."""
        if self.kind == "cylinder":
            return np.array([self.size[0], self.size[0], self.size[1]])
        return np.resize(self.size, self.dimension)


def check_name(name: object) -> None:
    """Refuse names that a formula cannot quote: empty, long, padded, with quotes or controls."""
    if not isinstance(name, str) or not name:
        raise SceneError(f"name: {name!r} must be non-empty text")
    if len(name) > LONGEST_NAME:
        raise SceneError(f"name: {name[:LONGEST_NAME]!r}... is longer than {LONGEST_NAME}")
    if not name.isprintable() or name != name.strip() or re.search(r"[\"'`\\]", name):
        raise SceneError(
            f"name: {name!r} must be printable, without quotes, backslashes or spaces at the ends"
        )


def _is_color(color: object) -> bool:
    return isinstance(color, str) and re.fullmatch(r"#[0-9a-fA-F]{6}", color) is not None


def _numbers(field: str, values: object, names: tuple[str, ...], kind: str) -> tuple[float, ...]:
    """Check that there is one finite number per name and return them as floats."""
    expected = f"a {kind} needs ({', '.join(names)}) in [m]"
    if not isinstance(values, list | tuple):
        raise SceneError(f"{field}: {values!r} is not a list of numbers; {expected}")
    if len(values) != len(names):
        raise SceneError(f"{field}: {list(values)} has {len(values)} numbers; {expected}")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise SceneError(f"{field}: {value!r} is not a number; {expected}")
        if not abs(value) <= LARGEST_COORDINATE:  # NaN compares false
            given = repr(value) if isinstance(value, float) else "a number"
            raise SceneError(
                f"{field}: {given} must be finite and at most {LARGEST_COORDINATE:g} m"
            )
    return tuple(float(value) for value in values)
