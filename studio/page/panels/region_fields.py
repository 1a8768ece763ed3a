"""Exact values of the selected region: name, kind, center, size, colour."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import viser

from core.errors import UserError
from core.quoting import shown as shown_text
from scenes import Region
from scenes.regions import SHAPES, TURNED
from studio.page.editing.editor import INITIAL, TOOLS
from studio.page.session import Session
from studio.page.views.regions import region_look
from studio.page.views.roles import roles
from studio.page.views.solids import rgb

FINE = 0.05
"""Step of the fields' arrows, in robot lengths."""

DIGITS = 3
"""Decimal places of the fields: millimetres."""

LONGEST_PART = 30
"""Characters of a wrong corner that an error shows."""

PAUSE = 0.6
"""Pause in typing after which a name is applied and an undo step ends [s]."""

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
        self._color = gui.add_rgb("Colour", (0, 0, 0), visible=False)
        self._renaming: tuple[str, float] | None = None
        self._cornering: tuple[str, float] | None = None
        self._spell, self._touched = 0, 0.0
        for field in (*self._centers.values(), *self._sizes.values()):
            field.precision = DIGITS
        self._on_update(self._name, self._type_name)
        self._on_update(self._kind, self._reshape)
        self._on_update(self._color, self._recolor)
        self._on_update(self._angle, self._turn)
        self._on_update(self._corners, self._type_corners)
        for field in self._centers.values():
            self._on_update(field, self._move)
        for field in self._sizes.values():
            self._on_update(field, self._resize)

    def draw(self, session: Session) -> None:
        """Show the values of the selected region."""
        self._session = session
        if self._renaming is not None and time.monotonic() >= self._renaming[1]:
            (name, _), self._renaming = self._renaming, None
            session.post(partial(self._rename, name))
        if self._cornering is not None and time.monotonic() >= self._cornering[1]:
            (text, _), self._cornering = self._cornering, None
            session.post(partial(self._put_corners, text))
        region, selection = session.editor.selected, session.editor.selection
        fields = (
            *self._centers.values(), *self._sizes.values(), self._kind, self._angle, self._corners
        )  # fmt: skip
        shown = [] if region is None else self._show_shape(region)
        for field in fields:
            _set(field, "visible", field in shown)
        named = region is not None and selection != INITIAL
        _set(self._name, "visible", named)
        _set(self._color, "visible", named)
        if region is not None and named:
            if self._renaming is None:
                _set(self._name, "value", region.name)
            _set(self._color, "value", rgb(self._shown_color(region)))

    def _show_shape(self, region: Region) -> list[Any]:
        """Fill and return the fields that the region's shape needs."""
        fine = FINE * self._session.editor.unit
        center = self._centers[len(region.center)]
        _set(center, "step", fine)
        _set(center, "value", region.center)
        kinds = tuple(TOOLS[region.dimension][1:])
        _set(self._kind, "options", kinds if region.kind in kinds else (*kinds, region.kind))
        _set(self._kind, "value", region.kind)
        shown: list[Any] = [center, self._kind]
        if region.kind in SIZE_LABEL:
            size = self._sizes[len(region.size)]
            _set(size, "step", fine)
            _set(size, "value", region.size[0] if len(region.size) == 1 else region.size)
            _set(size, "label", SIZE_LABEL[region.kind])
            shown.append(size)
        if region.kind in TURNED:
            _set(self._angle, "value", region.angle)
            shown.append(self._angle)
        if region.points:
            if self._cornering is None:
                _set(self._corners, "value", corners_text(region.points))
            shown.append(self._corners)
        return shown

    def _shown_color(self, region: Region) -> str:
        scene = self._session.document.scene
        found = roles(scene.region_names, self._session.specification.decomposition)
        return region.color or region_look(region, found[region.name]).color

    def _on_update(self, field: Any, change: Callable[[Any], None]) -> None:
        @field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                self._session.post(partial(change, event.target.value))

    def _type_name(self, name: str) -> None:
        self._renaming = (name, time.monotonic() + PAUSE)

    def _rename(self, name: str) -> None:
        editor, document = self._session.editor, self._session.document
        name = name.strip()
        if editor.selection and name != editor.selection:
            document.rename(editor.selection, name)
            editor.selection = name

    def _reshape(self, kind: str) -> None:
        region = self._session.editor.selected
        if region is None or kind == region.kind or kind not in TOOLS[region.dimension][1:]:
            return
        shape = as_kind(region, kind, self._session.editor.unit / 2)
        self._session.document.put(self._session.editor.selection or "", shape, "change")

    def _turn(self, degrees: float) -> None:
        editor, region = self._session.editor, self._session.editor.selected
        if region is not None and region.kind in TURNED:
            turned = replace(region, angle=float(degrees))
            self._session.document.put(editor.selection or "", turned, "turn", self._gesture())

    def _type_corners(self, text: str) -> None:
        self._cornering = (text, time.monotonic() + PAUSE)

    def _put_corners(self, text: str) -> None:
        editor, region = self._session.editor, self._session.editor.selected
        if region is None or not region.points or text == corners_text(region.points):
            return
        shape = Region(region.name, region.kind, points=read_corners(text), z=region.z)
        self._session.document.put(editor.selection or "", shape, "change", self._gesture())

    def _recolor(self, value: tuple[int, int, int]) -> None:
        name, color = self._session.editor.selection, "#{:02x}{:02x}{:02x}".format(*value)
        if name:
            self._session.document.recolor(name, color, gesture=self._gesture())

    def _move(self, value: tuple[float, ...]) -> None:
        self._change(center=tuple(map(float, value)))

    def _resize(self, value: float | tuple[float, ...]) -> None:
        size = value if isinstance(value, tuple) else (value,)
        self._change(size=tuple(map(float, size)))

    def _gesture(self) -> str:
        """Changes in quick succession are one undo step."""
        now = time.monotonic()
        self._spell += now - self._touched > PAUSE
        self._touched = now
        return f"fields {self._spell}"

    def _change(
        self, center: tuple[float, ...] | None = None, size: tuple[float, ...] | None = None
    ) -> None:
        region, document = self._session.editor.selected, self._session.document
        if region is None:
            return
        if self._session.editor.selection == INITIAL:
            document.set_initial(center=center, size=size, gesture=self._gesture())
        elif center is not None:
            document.move(region.name, center, gesture=self._gesture())
        elif size is not None:
            document.resize(region.name, size, gesture=self._gesture())


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
        kind: one that can be drawn.
        half: size where the region has none [m].
    """
    size = region.size or (half,)
    if kind in SHAPES:
        return Region(region.name, kind, region.center, _size_for(kind, size))
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


def _set(field: Any, name: str, value: Any) -> None:
    """Send only what changes."""
    if getattr(field, name) != value:
        setattr(field, name, value)
