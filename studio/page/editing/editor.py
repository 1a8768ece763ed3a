"""Editing the scene with the pointer: the selection, the active tool, and drags.

A drag is a sequence start, update, ..., end of points in space; it edits the document as it goes
(one undo step) and `cancel` reverts it. Runs on the page's loop, like the document.
"""

import math
from dataclasses import dataclass
from typing import Literal

from scenes import Region, workspace_of
from scenes.polygons import MOST_CORNERS
from studio.page.editing.corners import with_new_corner
from studio.page.editing.document import Document
from studio.page.editing.selection import Selection
from studio.page.editing.shapes import cornered, drawn, reshaped, snap
from studio.page.editing.turning import rotated, turn_between, turn_handle, turned

Phase = Literal["start", "update", "end"]
Action = Literal["move", "resize", "turn", "change"]
Point = tuple[float, ...]

SELECT = "select"
TOOLS = {
    2: (SELECT, "rectangle", "circle", "polygon"),
    3: (SELECT, "box", "sphere", "cylinder", "prism"),
}
"""By dimension: the tool to select and move, and the kinds that can be drawn."""

CLICKED = ("polygon", "prism")
"""Kinds that are drawn by clicks at their corners; the others by a drag."""

CLOSE = 0.2
"""Distance from the first corner at which a click closes a polygon, in units of the scene."""

STEP = 0.25
"""Step of the grid that drags snap to, in units of the scene."""


@dataclass(frozen=True)
class Grab:
    """A region, or a part of it, as it was when the pointer grabbed it."""

    target: str
    region: Region
    start: Point
    action: Action
    gesture: str
    part: int | None = None
    edge: int | None = None
    """On which a new corner is added."""


class Editor(Selection):
    """The selection with tools and drags."""

    def __init__(self, document: Document) -> None:
        super().__init__(document)
        self.tool = SELECT
        self.preview: Region | None = None
        """The region being drawn."""
        self.corners: tuple[tuple[float, float], ...] = ()
        """Of the polygon being drawn."""
        self._share = STEP
        self._grab: Grab | None = None
        self._drags = 0
        self._turned = 0.0
        """By how much the grabbed region is turned so far [degrees]."""
        self._cancelled = False

    @property
    def step(self) -> float:
        """Step of the grid that drags snap to [m]."""
        return self._share * self.unit

    @step.setter
    def step(self, metres: float) -> None:
        self._share = metres / self.unit

    @property
    def dragging(self) -> bool:
        """Whether a region follows the pointer."""
        return self._grab is not None

    @property
    def adding(self) -> int | None:
        """Edge of the grabbed polygon on which a new corner follows the pointer."""
        return None if self._grab is None else self._grab.edge

    @property
    def grabbed(self) -> Region | None:
        """What follows the pointer, as it was before."""
        return None if self._grab is None else self._grab.region

    @property
    def turn_handle(self) -> Point | None:
        """Where the selected shape is taken to turn it; it follows the pointer round."""
        grab, region = self._grab, self.selected
        if region is None:
            return None
        if grab is None or grab.action != "turn":
            return turn_handle(region, self.unit)
        handle = turn_handle(grab.region, self.unit)
        return None if handle is None else rotated(handle, self._turned, grab.region.center)

    def take(self, tool: str) -> None:
        """Switch to another tool."""
        if tool in TOOLS[self._document.scene.dimension]:
            self.tool, self.preview, self.corners = tool, None, ()

    def take_tool(self, index: int) -> None:
        """Switch to the tool at an index of `TOOLS`."""
        self.take(TOOLS[self._document.scene.dimension][index])

    def add(self, kind: str) -> None:
        """Add a region in the middle of the floor."""
        x, y = workspace_of(self._document.scene).middle[:2]
        half = self.unit / 2
        if kind in CLICKED:
            corners = ((x - half, y - half), (x + half, y - half), (x, y + half))
            self.select(self._document.add_shape(cornered(kind, corners, self.unit)))
            return
        start = (x - half, y - half) if kind in ("rectangle", "box") else (x, y)
        outline = drawn(kind, start, (x + half, y + half), unit=self.unit)
        assert outline is not None
        self.select(self._document.add(kind, *outline))

    def cancel(self) -> None:
        """Revert the current drag; without one, put the tool away, then deselect."""
        if self._grab is not None:
            self._change(self._grab, self._grab.region)
            self._grab, self._cancelled = None, True
        elif self.preview is not None:
            self.preview, self._cancelled = None, True
        elif self.corners:
            self.corners = self.corners[:-1]
        elif self.tool != SELECT:
            self.tool = SELECT
        elif self.joining or self.vertex is not None:
            self.joining, self.vertex = False, None
        else:
            self.select(self.selection if self.part is not None else None)

    def draw(self, phase: Phase, start: Point, end: Point) -> None:
        """Draw a region of the tool's kind on the floor; a rectangle or box without a tool."""
        if self._skip(phase):
            return
        kind = self.tool
        if kind in CLICKED:
            if phase == "end":
                self.corner(end)
            return
        if kind == SELECT:
            kind = TOOLS[self._document.scene.dimension][1]
        outline = drawn(kind, start, end, self.step, self.unit)
        self.preview = None if outline is None else Region("new", kind, *outline)
        if phase == "end":
            self.preview = None
            if outline is not None:
                self.select(self._document.add(kind, *outline))
                self.tool = SELECT

    def corner(self, point: Point) -> None:
        """Add a corner to the polygon being drawn; one at the first closes it.

        Raises:
            UserError: the polygon that it closes crosses itself.
        """
        x, y = snap(point[:2], self.step)
        if self.tool not in CLICKED or (x, y) in self.corners[-1:]:
            return
        if len(self.corners) > 2 and math.dist((x, y), self.corners[0]) <= CLOSE * self.unit:
            self.close()
            return
        self.corners = (*self.corners, (x, y))
        if len(self.corners) == MOST_CORNERS:
            self.close()

    def close(self) -> None:
        """Complete the polygon being drawn; its corners stay if they make none.

        Raises:
            UserError: too few corners, or the polygon crosses itself.
        """
        if self.tool in CLICKED:
            region = cornered(self.tool, self.corners, self.unit)
            self.select(self._document.add_shape(region))
            self.take(SELECT)

    def move(self, target: str, phase: Phase, start: Point, end: Point) -> None:
        """Drag a region; its center snaps to the grid."""
        grab = self._grabbed(target, phase, start, "move")
        if grab is None:
            return
        center = grab.region.center
        by = [b - a for a, b in zip(grab.start, end, strict=True)]
        goal = tuple(c + b for c, b in zip(center, by, strict=False))
        # An axis along which the pointer stayed keeps its value, on the grid or not.
        snapped = zip(snap(goal, self.step), center, by, strict=False)
        self._change(grab, grab.region.at([s if abs(b) > 1e-9 else c for s, c, b in snapped]))

    def resize(self, handle: int, phase: Phase, point: Point) -> None:
        """Drag a handle of what is selected."""
        grab = self._taken(phase, point, "resize")
        if grab is not None:
            point = point[: grab.region.dimension]
            self._change(grab, reshaped(grab.region, handle, point, self.step, self.unit))

    def add_corner(self, edge: int, phase: Phase, point: Point) -> None:
        """Drag a new corner out of the middle of an edge of the selected polygon or prism."""
        grab = self._taken(phase, point, "change", edge)
        if grab is not None:
            x, y = snap(point[:2], self.step)
            self._change(grab, with_new_corner(grab.region, edge, (x, y)))

    def turn(self, phase: Phase, point: Point, *, fine: bool = False) -> None:
        """Drag what is selected round its centre, in steps of five degrees unless `fine`."""
        grab = self._taken(phase, point, "turn")
        if grab is not None:
            self._turned = turn_between(grab.region, grab.start, point, fine=fine)
            self._change(grab, turned(grab.region, self._turned, grab.region.center))

    def _taken(
        self, phase: Phase, point: Point, action: Action, edge: int | None = None
    ) -> Grab | None:
        """What is selected, held by one of its handles."""
        if self.selection is None:
            return None
        return self._grabbed(self.selection, phase, point, action, edge)

    def _grabbed(  # noqa: PLR0913
        self, target: str, phase: Phase, start: Point, action: Action, edge: int | None = None
    ) -> Grab | None:
        """What the pointer holds; None for the rest of a cancelled drag."""
        if self._skip(phase):
            return None
        if phase == "start":
            if target != self.selection:
                self.select(target)
            self.joining, self.vertex = False, None
            if self.selected is not None:
                self._drags, self._turned = self._drags + 1, 0.0
                gesture = f"drag {self._drags}"
                self._grab = Grab(target, self.selected, start, action, gesture, self.part, edge)
        grab = self._grab
        if phase == "end":
            self._grab = None
        return grab

    def _skip(self, phase: Phase) -> bool:
        if phase == "start":
            self._cancelled = False
        return self._cancelled

    def _change(self, grab: Grab, region: Region) -> None:
        self.put_at(grab.target, grab.part, region, grab.action, grab.gesture)
