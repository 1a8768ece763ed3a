"""Exact values of the selected region: name, kind, center, size, colour."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import viser

from core.errors import UserError
from core.quoting import shown as shown_text
from scenes import Region
from scenes.regions import SHAPES, TURNED
from studio.page.editing.corners import with_points
from studio.page.editing.editor import TOOLS, Editor
from studio.page.editing.selection import INITIAL
from studio.page.panels.fields import PAUSE, Typing, set_changed
from studio.page.session import Session
from studio.page.views.regions import region_look
from studio.page.views.roles import roles
from studio.page.views.solids import rgb

FINE = 0.05
"""Step of the fields' arrows, in robot lengths."""

DIGITS = 3
"""Decimal places of the fields: millimetres."""

ANGLE_DIGITS = 1
"""The same of the angle [degrees]."""

LONGEST_PART = 30
"""Characters of a wrong corner that an error shows."""

SIZE_LABEL = {
    "circle": "Radius",
    "sphere": "Radius",
    "rectangle": "Half size",
    "box": "Half size",
    "cylinder": "Radius, half h.",
    "polygon": "Half size",
    "prism": "Half size",
}
"""Of the kinds whose size can be typed."""


class Typed(NamedTuple):
    """A text, and what it was typed for; applied when typing pauses."""

    text: str
    editor: Editor
    selection: str | None
    part: int | None


class RegionFields:
    """Shown while something is selected. Invalid values are refused and the field is restored."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._name = gui.add_text("Name", "", visible=False)
        self._kind = gui.add_dropdown("Kind", list[str](["circle"]), visible=False)
        self._centers = {
            2: gui.add_vector2("Center", (0.0, 0.0), step=FINE, visible=False),
            3: gui.add_vector3("Center", (0.0, 0.0, 0.0), step=FINE, visible=False),
        }
        self._sizes = {
            1: gui.add_number("Radius", 1.0, min=0.001, step=FINE, visible=False),
            2: gui.add_vector2("Half size", (1.0, 1.0), step=FINE, visible=False),
            3: gui.add_vector3("Half size", (1.0, 1.0, 1.0), step=FINE, visible=False),
        }
        self._angle = gui.add_number("Angle (°)", 0.0, min=-360, max=360, step=5, visible=False)
        self._corners = gui.add_text("Corners", "", visible=False)
        self._levels = gui.add_vector2(
            "From, to height", (0.0, 1.0), step=FINE, visible=False, hint="Its two ends [m]"
        )
        self._color = gui.add_rgb("Colour", (0, 0, 0), visible=False)
        self._renaming, self._cornering = Typing[Typed](), Typing[Typed]()
        self._spell, self._touched = 0, 0.0
        for field in (*self._centers.values(), *self._sizes.values(), self._levels):
            field.precision = DIGITS
        self._angle.precision = ANGLE_DIGITS
        self._on_update(self._name, self._type_name)
        self._on_update(self._kind, self._reshape)
        self._on_update(self._color, self._recolor)
        self._on_update(self._angle, self._turn)
        self._on_update(self._corners, self._type_corners)
        self._on_update(self._levels, self._stand)
        for field in self._centers.values():
            self._on_update(field, self._move)
        for field in self._sizes.values():
            self._on_update(field, self._resize)

    def draw(self, session: Session) -> None:
        """Show the values of the selected region."""
        self._session = session
        if (typed := self._renaming.take()) is not None:
            session.post(partial(self._rename, typed))
        if (typed := self._cornering.take()) is not None:
            session.post(partial(self._put_corners, typed))
        region, selection = session.editor.selected, session.editor.selection
        fields = (
            *self._centers.values(), *self._sizes.values(),
            self._kind, self._angle, self._corners, self._levels,
        )  # fmt: skip
        shown = [] if region is None else self._show_shape(region)
        for field in fields:
            set_changed(field, visible=field in shown)
        named = region is not None and selection != INITIAL
        set_changed(self._name, visible=named)
        set_changed(self._color, visible=named)
        if region is not None and named:
            if not self._renaming.waits:
                set_changed(self._name, value=region.name)
            set_changed(self._color, value=rgb(self._shown_color(session.editor.whole or region)))

    def _show_shape(self, region: Region) -> list[Any]:
        """Fill and return the fields that the region's shape needs."""
        fine = FINE * self._session.editor.unit
        center = self._centers[len(region.center)]
        set_changed(center, step=fine)
        set_changed(center, value=region.center)
        kinds = self._kinds(region)
        set_changed(self._kind, options=kinds if region.kind in kinds else (*kinds, region.kind))
        set_changed(self._kind, value=region.kind)
        shown: list[Any] = [center, self._kind]
        if region.kind in SIZE_LABEL:
            size = self._sizes[len(region.size)]
            set_changed(size, step=fine)
            set_changed(size, value=region.size[0] if len(region.size) == 1 else region.size)
            set_changed(size, label=SIZE_LABEL[region.kind])
            shown.append(size)
        if region.kind in TURNED:
            set_changed(self._angle, value=region.angle)
            shown.append(self._angle)
        if region.points:
            if not self._cornering.waits:
                set_changed(self._corners, value=corners_text(region.points))
            shown.append(self._corners)
        if region.z:
            set_changed(self._levels, step=fine)
            set_changed(self._levels, value=region.z)
            shown.append(self._levels)
        return shown

    def _kinds(self, region: Region) -> tuple[str, ...]:
        """What the selected shape can be made; the initial set may be a point."""
        kinds = TOOLS[region.dimension][1:]
        return (*kinds, "point") if self._session.editor.selection == INITIAL else kinds

    def _shown_color(self, region: Region) -> str:
        scene = self._session.document.scene
        found = roles(scene.region_names, self._session.specification.decomposition)
        return region.color or region_look(region, found[region.name]).color

    def _on_update(self, field: Any, change: Callable[[Any], None]) -> None:
        @field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                self._session.post(partial(change, event.target.value))

    def _typed(self, text: str) -> Typed:
        editor = self._session.editor
        return Typed(text, editor, editor.selection, editor.part)

    def _type_name(self, name: str) -> None:
        self._renaming.put(self._typed(name))

    def _rename(self, typed: Typed) -> None:
        editor, name, old = self._session.editor, typed.text.strip(), typed.selection
        if typed.editor is editor and old and name != old:
            self._session.document.rename(old, name)
            if editor.selection == old:
                editor.select(name, editor.part)

    def _reshape(self, kind: str) -> None:
        region = self._session.editor.selected
        if region is None or kind == region.kind or kind not in self._kinds(region):
            return
        editor = self._session.editor
        editor.put(as_kind(region, kind, editor.unit / 2), "change")

    def _turn(self, degrees: float) -> None:
        region = self._session.editor.selected
        if region is not None and region.kind in TURNED:
            self._put(replace(region, angle=float(degrees)), "turn")

    def _stand(self, levels: tuple[float, ...]) -> None:
        region = self._session.editor.selected
        if region is not None and region.z:
            z = tuple(map(float, levels))
            self._put(replace(region, z=z, center=(), size=()), "change")

    def _type_corners(self, text: str) -> None:
        self._cornering.put(self._typed(text))

    def _put_corners(self, typed: Typed) -> None:
        editor, text, place = self._session.editor, typed.text, (typed.selection, typed.part)
        if typed.editor is not editor:
            return
        region = editor.at(*place)
        if region is not None and region.points and text != corners_text(region.points):
            shape = with_points(region, read_corners(text))
            editor.put_at(*place, shape, "change", self._gesture())

    def _recolor(self, value: tuple[int, int, int]) -> None:
        name, color = self._session.editor.selection, "#{:02x}{:02x}{:02x}".format(*value)
        if name:
            self._session.document.recolor(name, color, gesture=self._gesture())

    def _move(self, value: tuple[float, ...]) -> None:
        region = self._session.editor.selected
        if region is not None:
            self._put(region.at(tuple(map(float, value))), "move")

    def _resize(self, value: float | tuple[float, ...]) -> None:
        region = self._session.editor.selected
        if region is not None:
            size = value if isinstance(value, tuple) else (value,)
            self._put(region.sized(tuple(map(float, size))), "resize")

    def _put(self, shape: Region, verb: str) -> None:
        self._session.editor.put(shape, verb, self._gesture())

    def _gesture(self) -> str:
        """Changes in quick succession are one undo step."""
        now = time.monotonic()
        self._spell += now - self._touched > PAUSE
        self._touched = now
        return f"fields {self._spell}"


def corners_text(points: Sequence[tuple[float, float]]) -> str:
    """`0, 0; 1, 0; 1, 1`, in [m]."""
    return "; ".join(", ".join(f"{round(value, DIGITS):g}" for value in point) for point in points)


def read_corners(text: str) -> tuple[tuple[float, float], ...]:
    """The corners of a text like `corners_text`.

    Raises:
        UserError: not pairs of numbers.
    """
    points = []
    for part in text.strip().strip(";").split(";"):
        try:
            x, y = map(float, part.replace(",", " ").split())
        except ValueError:
            given = shown_text(repr(part.strip()), LONGEST_PART)
            raise UserError(
                f"corners: {given} must be two numbers, as in 0, 0; 1, 0; 1, 1"
            ) from None
        points.append((x, y))
    return tuple(points)


def as_kind(region: Region, kind: str, half: float) -> Region:
    """A region of another kind, as much like a region as possible.

    Args:
        region: of the same dimension.
        kind: one that can be drawn, or a point.
        half: size where the region has none [m].
    """
    size = region.size or (half,)
    if kind in SHAPES:
        return Region(region.name, kind, region.center, _size_for(kind, size))
    if kind == "point":
        return Region(region.name, kind, region.center)
    (x, y), (a, b) = region.center[:2], region.half_extents[:2].tolist()
    a, b = a or half, b or half
    points = ((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b))
    if kind == "polygon":
        return Region(region.name, kind, points=points)
    middle, tall = region.center[2], float(region.half_extents[2]) or half
    return Region(region.name, kind, points=points, z=(middle - tall, middle + tall))


def _size_for(kind: str, size: tuple[float, ...]) -> tuple[float, ...]:
    """The size for another kind of region, keeping as much as possible [m]."""
    count = len(SHAPES[kind].sizes)
    if count == 2 and SHAPES[kind].dimension == 3:
        return size[0], size[-1]
    return (*size, *[size[-1]] * count)[:count]
