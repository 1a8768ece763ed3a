"""What is selected - a region, the initial set, a part or a corner - and what is done with it."""

from dataclasses import replace

import numpy as np

from scenes import Region, unit_of
from studio.page.editing.corners import without_corner
from studio.page.editing.document import SHIFT, Document
from studio.page.editing.joining import part_met, with_part, without_part

INITIAL = ""
"""Selects the initial set; no region has this name."""


Ray = tuple[np.ndarray, np.ndarray]
"""Where it begins, and its direction [3]."""


class Selection:
    """Shared by all clients, like the document."""

    def __init__(self, document: Document) -> None:
        self.selection: str | None = None
        """A region's name, `INITIAL`, or None."""
        self.part: int | None = None
        """Index of the part of a union that is selected; None for the whole."""
        self.vertex: int | None = None
        """Index of the corner that is selected, of a polygon or prism."""
        self.joining = False
        """Whether the next region that is clicked becomes part of the selected one."""
        self._document = document

    @property
    def unit(self) -> float:
        """Length that is one unit in the arena [m]."""
        return unit_of(self._document.scene)

    @property
    def whole(self) -> Region | None:
        """The region or initial set that is selected, or that a part of is."""
        return self.at(self.selection, None)

    @property
    def selected(self) -> Region | None:
        """What is selected; a part has its region's name."""
        return self.at(self.selection, self.part)

    def at(self, target: str | None, part: int | None) -> Region | None:
        """The region of a name, or one of its parts; `INITIAL` is the initial set."""
        scene = self._document.scene
        if target == INITIAL:
            region = scene.initial
        else:
            region = next((each for each in scene.regions if each.name == target), None)
        if region is None or part is None or part >= len(region.parts):
            return region
        return region.parts[part]

    def select(self, target: str | None, part: int | None = None) -> None:
        """Select a region by name, the initial set, or nothing; of a union, perhaps a part."""
        self.selection, self.part, self.vertex, self.joining = target, part, None, False
        self.check_selection()

    def click(self, target: str, ray: Ray | None = None) -> None:
        """A region, or the initial set, was clicked: it is selected, or joined.

        A click on a union that is selected selects the part that its ray meets.
        """
        if target != self.selection:
            if self.joining and self.selection and target != INITIAL:
                self._document.join(self.selection, target)
                self.part = None
            else:
                self.select(target)
        elif ray is not None and self.whole is not None and self.whole.parts:
            self.select(target, part_met(self.whole, *ray))

    def check_selection(self) -> None:
        """Deselect what no longer exists."""
        region = self.whole
        if region is None:
            self.selection, self.joining = None, False
        if region is None or self.part is None or self.part >= len(region.parts):
            self.part = None
        shape = self.selected
        if shape is None or self.vertex is None or self.vertex >= len(shape.points):
            self.vertex = None

    def put(self, shape: Region, verb: str, gesture: str | None = None) -> None:
        """Give what is selected another shape, as a step that `verb` names."""
        self.put_at(self.selection, self.part, shape, verb, gesture)

    def put_at(  # noqa: PLR0913
        self,
        target: str | None,
        part: int | None,
        shape: Region,
        verb: str,
        gesture: str | None = None,
    ) -> None:
        """Give a region, or one of its parts, another shape; see `at` and `put`."""
        region = self.at(target, None)
        if target is None or region is None:
            return
        if part is not None and part < len(region.parts):
            shape = with_part(region, part, shape)
        self._document.put(target, shape, verb, gesture)

    def duplicate(self) -> None:
        """Copy the selected region or part; there is only one initial set."""
        union, part = self.whole, self.selected
        if self.part is not None and union is not None and part is not None:
            x, y, *rest = part.center
            shift = SHIFT * self.unit
            copy = part.at((x + shift, y - shift, *rest))
            grown = replace(union, parts=(*union.parts, copy), center=(), size=())
            self._document.put(self.selection or INITIAL, grown, "change")
            self.part = len(union.parts)
        elif self.selection:
            self.select(self._document.duplicate(self.selection))

    def delete(self) -> None:
        """Remove the corner, part or region that is selected; the initial set stays.

        Raises:
            UserError: a polygon would not be one without the corner.
        """
        shape, union = self.selected, self.whole
        if self.vertex is not None and shape is not None:
            self.put(without_corner(shape, self.vertex), "change")
            self.vertex = None
        elif self.part is not None and union is not None:
            smaller = without_part(union, self.part)
            self._document.put(self.selection or INITIAL, smaller, "change")
            self.part = None
        elif self.selection:
            self._document.delete(self.selection)
            self.select(None)

    def take_apart(self) -> None:
        """Make each part of the selected region a region of its own."""
        if self.selection:
            self._document.take_apart(self.selection)
            self.check_selection()

    def join(self) -> None:
        """Have the next clicks join regions to the selected one, or no longer."""
        self.joining = bool(self.selection) and not self.joining

    def make_initial(self) -> None:
        """Give the initial set the shape and position of what is selected, which stays."""
        region = self.selected
        if self.selection and region is not None:
            self._document.put(INITIAL, region, "change")
