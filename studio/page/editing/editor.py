"""Editing the scene with the pointer: the selection, the active tool, and drags.

A drag is a sequence start, update, ..., end of points in space; it edits the document as it goes
(one undo step) and `cancel` reverts it. Runs on the page's loop, like the document.
"""

import math
from dataclasses import dataclass
from typing import Literal

from scenes import Region, unit_of, workspace_of
from scenes.polygons import MOST_CORNERS
from studio.page.editing.document import Document
from studio.page.editing.shapes import cornered, drawn, reshaped, snap

Phase = Literal["start", "update", "end"]
Action = Literal["move", "resize"]
Point = tuple[float, ...]

INITIAL = ""
"""Selects the initial set; no region has this name."""

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
    """A region as it was when the pointer grabbed it."""

    target: str
    region: Region
    start: Point
    action: Action
    gesture: str


class Editor:
    """Shared by all clients, like the document."""

    def __init__(self, document: Document) -> None:
        self.selection: str | None = None
        """A region's name, `INITIAL`, or None."""
        self.tool = SELECT
        self.preview: Region | None = None
        """The region being drawn."""
        self.corners: tuple[tuple[float, float], ...] = ()
        """Of the polygon being drawn."""
        self._document = document
        self._share = STEP
        self._grab: Grab | None = None
        self._drags = 0
        self._cancelled = False

    @property
    def unit(self) -> float:
        """Length that is one unit in the arena [m]."""
        return unit_of(self._document.scene)

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
    def selected(self) -> Region | None:
        """The region or initial set that is selected."""
        return None if self.selection is None else self._region(self.selection)

    def select(self, target: str | None) -> None:
        """Select a region by name, the initial set, or nothing."""
        self.selection = target
        self.check_selection()

    def check_selection(self) -> None:
        """Deselect a region that no longer exists."""
        names = (INITIAL, *self._document.scene.region_names)
        if self.selection not in names:
            self.selection = None

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
            self.selection = self._document.add_shape(cornered(kind, corners, self.unit))
            return
        start = (x - half, y - half) if kind in ("rectangle", "box") else (x, y)
        outline = drawn(kind, start, (x + half, y + half), unit=self.unit)
        assert outline is not None
        self.selection = self._document.add(kind, *outline)

    def duplicate(self) -> None:
        """Copy the selected region; there is only one initial set."""
        if self.selection:
            self.selection = self._document.duplicate(self.selection)

    def delete(self) -> None:
        """Remove the selected region; the initial set stays."""
        if self.selection:
            self._document.delete(self.selection)
            self.selection = None

    def make_initial(self) -> None:
        """Give the initial set the shape and position of the selected region, which stays."""
        region = self.selected
        if self.selection and region is not None:
            self._document.put(INITIAL, region, "change")

    def cancel(self) -> None:
        """Revert the current drag; without one, put the tool away, then deselect."""
        if self._grab is not None:
            self._put(self._grab, self._grab.region)
            self._grab, self._cancelled = None, True
        elif self.preview is not None:
            self.preview, self._cancelled = None, True
        elif self.corners:
            self.corners = self.corners[:-1]
        elif self.tool != SELECT:
            self.tool = SELECT
        else:
            self.selection = None

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
                self.selection = self._document.add(kind, *outline)
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
            self.selection = self._document.add_shape(region)
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
        self._put(grab, grab.region.at([s if abs(b) > 1e-9 else c for s, c, b in snapped]))

    def resize(self, handle: int, phase: Phase, point: Point) -> None:
        """Drag a handle of the selected region."""
        if self.selection is None:
            return
        grab = self._grabbed(self.selection, phase, point, "resize")
        if grab is not None:
            point = point[: grab.region.dimension]
            self._put(grab, reshaped(grab.region, handle, point, self.step, self.unit))

    def _grabbed(self, target: str, phase: Phase, start: Point, action: Action) -> Grab | None:
        """What the pointer holds; None for the rest of a cancelled drag."""
        if self._skip(phase):
            return None
        if phase == "start":
            self.select(target)
            if self.selected is not None:
                self._drags += 1
                self._grab = Grab(target, self.selected, start, action, f"drag {self._drags}")
        grab = self._grab
        if phase == "end":
            self._grab = None
        return grab

    def _skip(self, phase: Phase) -> bool:
        if phase == "start":
            self._cancelled = False
        return self._cancelled

    def _put(self, grab: Grab, region: Region) -> None:
        self._document.put(grab.target, region, grab.action, grab.gesture)

    def _region(self, target: str) -> Region | None:
        scene = self._document.scene
        if target == INITIAL:
            return scene.initial
        return next((region for region in scene.regions if region.name == target), None)
