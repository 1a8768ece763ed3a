"""Named regions: the shapes that the atoms of a formula denote.

A region is a closed set of positions, in metres:

=========  =  =================================================================
kind       d  what it is given by
=========  =  =================================================================
circle     2  center, size (radius,)
rectangle  2  center, size (half_x, half_y), angle
sphere     3  center, size (radius,)
box        3  center, size (half_x, half_y, half_z), angle
cylinder   3  center, size (radius, half_height), axis along z
polygon    2  points: 3 to 16 corners, convex or not
prism      3  points: the polygon of its base; z: from where to where it stands
union      -  parts: regions of other kinds
point      -  center; an initial set only
=========  =  =================================================================

An angle turns a rectangle or a box about the vertical axis through its centre, counter-clockwise,
in degrees. Polygons, prisms and unions have the centre and the half sides of the box around them
as their `center` and `size`. A region may move (`scenes.motion`); it is where it begins then.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from core.errors import allowed
from scenes import polygons
from scenes.checks import SMALLEST_SIZE, SceneError, check_name, is_color, numbers
from scenes.motion import Motion

Kind = Literal["circle", "rectangle", "sphere", "box", "cylinder"]

LARGEST_ANGLE = 360.0

MOST_PARTS = 16
"""Parts of a union."""


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
"""Kinds given by a center and a size."""
assert set(SHAPES) == set(get_args(Kind))

TURNED = ("rectangle", "box")
"""Kinds that may have an angle."""

KINDS = (*SHAPES, "polygon", "prism", "union", "point")

FIELDS = MappingProxyType(
    {kind: ("center", "size") for kind in SHAPES}
    | {kind: ("center", "size", "angle") for kind in TURNED}
    | {"polygon": ("points",), "prism": ("points", "z")}
    | {"union": ("parts",), "point": ("center",)}
)
"""What each kind is given by."""


@dataclass(frozen=True)
class Region:
    """A named closed region of the plane or of space; see the module's table.

    Attributes:
        name: The atom of the formulas that the region interprets.
        kind: One of `KINDS`.
        center: [d] in [m].
        size: Half extents or radius in [m], all positive.
        color: `#rrggbb`, or None for the viewer's choice.
        angle: Of a rectangle or box, in degrees.
        points: (x, y) of a polygon's or prism's corners in [m].
        z: Low and high end of a prism in [m].
        parts: Of a union.
        motion: How it moves; None if it stands.
    """

    name: str
    kind: str
    center: tuple[float, ...] = ()
    size: tuple[float, ...] = ()
    color: str | None = None
    angle: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    z: tuple[float, ...] = ()
    parts: "tuple[Region, ...]" = ()
    motion: Motion | None = None

    def __post_init__(self):
        check_name(self.name)
        if not isinstance(self.kind, str) or self.kind not in KINDS:
            raise SceneError(f"kind: unknown {self.kind!r}. {allowed(self.kind, KINDS)}")
        self._check_fields()
        match self.kind:
            case "polygon" | "prism":
                self._check_points()
            case "union":
                self._check_parts()
            case "point":
                self._set(center=_point(self.center))
            case _:
                self._check_shape()
        if self.color is not None and not is_color(self.color):
            raise SceneError(f"color: {self.color!r} is not of the form '#rrggbb'")
        if self.motion is not None and self.motion.dimension != self.dimension:
            raise SceneError(
                f"path: it leads through {self.motion.dimension} dimensions, but a {self.kind} "
                f"lies in {self.dimension}"
            )

    @property
    def dimension(self) -> int:
        """Dimension d of the space: 2 or 3."""
        return len(self.center)

    @property
    def half_extents(self) -> np.ndarray:
        """Half sides [d] in [m] of the box around the region, which has its centre."""
        match self.kind:
            case "cylinder":
                return np.array([self.size[0], self.size[0], self.size[1]])
            case "rectangle" | "box" if self.angle:
                cosine, sine = np.abs(self.turn)
                x, y, *rest = self.size
                return np.array([cosine * x + sine * y, sine * x + cosine * y, *rest])
            case "point":
                return np.zeros(self.dimension)
        return np.resize(self.size, self.dimension)

    @property
    def turn(self) -> tuple[float, float]:
        """Cosine and sine of the angle; exact for quarter turns."""
        quarters, rest = divmod(self.angle, 90.0)
        if rest == 0:
            return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
        angle = np.deg2rad(self.angle)
        return float(np.cos(angle)), float(np.sin(angle))

    @property
    def pieces(self) -> "tuple[Region, ...]":
        """The parts of a union; of all others, the region itself."""
        return self.parts or (self,)

    def displaced(self, step: float) -> "Region":
        """The region as it is at a step, standing there."""
        if self.motion is None:
            return self
        offset = self.motion.offset(step)
        return replace(self, motion=None).at((self.center + offset).tolist())

    def at(self, center: Sequence[float]) -> "Region":
        """The region with its centre moved to a position [d] in [m], and its path with it."""
        if self.kind in SHAPES or self.kind == "point":
            return replace(self, center=tuple(center))
        return self._mapped(np.ones(self.dimension), np.subtract(center, self.center))

    def mirrored(self, sign: np.ndarray) -> "Region":
        """The region with its coordinates multiplied by 1 or -1 [d]."""
        motion = self.motion and self.motion.mirrored(sign)
        if self.kind not in SHAPES and self.kind != "point":
            return replace(self._mapped(sign, np.zeros(self.dimension)), motion=motion)
        angle = -self.angle if self.angle and sign[0] * sign[1] < 0 else self.angle
        center = tuple((sign * self.center).tolist())
        return replace(self, center=center, angle=angle, motion=motion)

    def sized(self, size: Sequence[float]) -> "Region":
        """The region with other sizes [m]; polygons and prisms are stretched.

        Raises:
            SceneError: a union or a point, which have no sizes of their own.
        """
        if self.kind in SHAPES:
            return replace(self, size=tuple(size))
        if self.kind not in ("polygon", "prism"):
            raise SceneError(f"size: a {self.kind} has none of its own")
        factor = np.divide(size, self.size)
        return self._mapped(factor, (1 - factor) * self.center)

    def _mapped(self, scale: np.ndarray, shift: np.ndarray) -> "Region":
        """With scale * p + shift for every position p [d] of a polygon, a prism or a union.

        A union's parts are mirrored, but not stretched.
        """

        def mapped(position: Sequence[float], axes: slice) -> tuple[float, ...]:
            values = scale[axes] * np.array(position) + shift[axes]
            return tuple(np.round(values, 9).tolist())

        return replace(
            self,
            center=(),
            size=(),
            points=tuple(mapped(point, slice(2)) for point in self.points),
            z=tuple(sorted(mapped(self.z, slice(2, None)))) if self.z else (),
            parts=tuple(
                part.mirrored(scale).at(mapped(part.center, slice(None))) for part in self.parts
            ),
        )

    def _check_fields(self) -> None:
        """Refuse what the kind does not have."""
        given = {"angle": self.angle, "points": self.points, "z": self.z, "parts": self.parts}
        for field, value in given.items():
            if field not in FIELDS[self.kind] and value not in ((), 0.0):
                wanted = ", ".join(FIELDS[self.kind])
                raise SceneError(f"{field}: a {self.kind} has none; it is given by {wanted}")

    def _check_shape(self) -> None:
        shape = SHAPES[self.kind]
        axes = ("x", "y", "z")[: shape.dimension]
        center = numbers("center", self.center, axes, self.kind)
        size = numbers("size", self.size, shape.sizes, self.kind)
        if min(size) <= 0:
            raise SceneError(f"size: {list(size)} must be positive [m]")
        if min(size) < SMALLEST_SIZE:
            raise SceneError(f"size: {list(size)} must be at least {SMALLEST_SIZE:g} m")
        angle = self.angle
        if type(angle) not in (int, float) or not abs(angle) <= LARGEST_ANGLE:
            raise SceneError(f"angle: {angle!r} must be degrees, at most {LARGEST_ANGLE:g}")
        self._set(center=center, size=size, angle=float(angle))

    def _check_points(self) -> None:
        if not isinstance(self.points, list | tuple):
            raise SceneError(f"points: {self.points!r} is not a list of corners (x, y)")
        given = self.points[: polygons.MOST_CORNERS + 2]
        points = [numbers("points", point, ("x", "y"), "corner") for point in given]
        if len(points) > 3 and points[0] == points[-1]:  # closed, as maps have it
            points = points[:-1]
        if flaw := polygons.flaw(points):  # pyright: ignore[reportArgumentType]
            raise SceneError(f"points: {flaw}")
        ends = np.array([np.min(points, axis=0), np.max(points, axis=0)])
        z: tuple[float, ...] = ()
        if self.kind == "prism":
            z = numbers("z", self.z, ("low", "high"), self.kind)
            if not z[1] - z[0] >= 2 * SMALLEST_SIZE:
                raise SceneError(f"z: {list(z)}: low must be below high")
            ends = np.column_stack([ends, z])
        self._set(points=tuple(points), z=z)
        self._derive(*ends)

    def _check_parts(self) -> None:
        parts = self.parts
        if not isinstance(parts, list | tuple) or not 1 <= len(parts) <= MOST_PARTS:
            raise SceneError(f"parts: a union has from 1 to {MOST_PARTS}")
        for number, part in enumerate(parts):
            if part.motion is not None:
                raise SceneError(f"parts[{number}]: a part cannot move; the whole union can")
            if part.kind in ("union", "point") or part.dimension != parts[0].dimension:
                raise SceneError(
                    f"parts[{number}]: a {part.kind} of dimension {part.dimension} cannot be part "
                    f"of a union with a {parts[0].kind}"
                )
        low = np.min([part.center - part.half_extents for part in parts], axis=0)
        high = np.max([part.center + part.half_extents for part in parts], axis=0)
        self._set(parts=tuple(replace(part, name=self.name, color=None) for part in parts))
        self._derive(low, high)

    def _derive(self, low: np.ndarray, high: np.ndarray) -> None:
        """Set centre and size to those of the box from low to high [d]."""
        found = {"center": (low + high) / 2, "size": (high - low) / 2}
        for field, values in found.items():
            derived = tuple(values.tolist())
            if getattr(self, field) not in ((), derived):
                raise SceneError(f"{field}: that of a {self.kind} follows from its {self._given}")
            self._set(**{field: derived})

    @property
    def _given(self) -> str:
        return FIELDS[self.kind][0]

    def _set(self, **fields: Any) -> None:
        for field, value in fields.items():
            object.__setattr__(self, field, value)


def _point(center: object) -> tuple[float, ...]:
    """The coordinates of a point of the plane or of space."""
    axes = ("x", "y", "z")[: 3 if isinstance(center, list | tuple) and len(center) == 3 else 2]
    return numbers("center", center, axes, "point")
