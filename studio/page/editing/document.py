"""The scene being edited, with one undo and redo stack shared by all clients.

Every edit leads from one valid `Scene` to another or is refused as a whole. Not thread-safe: one
thread edits, others read `scene`, which is replaced and never mutated.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from core.errors import UserError, allowed
from core.task.grounding import MAX_ATOMS
from envs import ENVS
from scenes import Predicate, Region, Scene, unit_of
from scenes.arena import Arena
from scenes.checks import LONGEST_NAME
from scenes.motion import Motion
from studio.page.editing.history import History
from studio.page.editing.joining import apart, joined
from studio.page.editing.meaning import differences
from studio.page.editing.renaming import rename_in_formula, spread_in_formula

SHIFT = 0.4
"""Offset of a duplicate from its original along x and y, in units of the scene."""


class EditError(UserError):
    """An edit that is refused; the document is unchanged."""


class Document:
    """A scene and its history.

    Edits take an optional `gesture`: consecutive edits with the same one are one undo step.
    """

    def __init__(self, scene: Scene, *, saved: bool = True) -> None:
        self._history = History(scene)
        self._saved = scene if saved else None

    @property
    def scene(self) -> Scene:
        """The current scene."""
        return self._history.present

    @property
    def revision(self) -> int:
        """Counts the changes of the scene."""
        return self._history.revision

    @property
    def modified(self) -> bool:
        """Whether the scene differs from what was last opened or saved."""
        return self.scene != self._saved

    @property
    def undo_label(self) -> str | None:
        """What `undo` would undo; None if nothing."""
        return self._history.undo_label

    @property
    def redo_label(self) -> str | None:
        """What `redo` would redo; None if nothing."""
        return self._history.redo_label

    def undo(self) -> str | None:
        """Undo the last step; returns its label, None if there is none."""
        return self._history.undo()

    def redo(self) -> str | None:
        """Redo the step that was last undone; returns its label, None if there is none."""
        return self._history.redo()

    def mark_saved(self, scene: Scene | None = None) -> None:
        """Remember that a scene was saved, by default the current one."""
        self._saved = self.scene if scene is None else scene

    def matches(self, trained: Scene) -> bool:
        """Whether what is learnt on a scene applies to this one; see `meaning`."""
        return not differences(trained, self.scene)

    def region(self, name: str) -> Region:
        """The region with a name.

        Raises:
            EditError: there is none.
        """
        for region in self.scene.regions:
            if region.name == name:
                return region
        raise EditError(f"region: unknown {name!r}. {allowed(name, self.scene.region_names)}")

    def replace(self, scene: Scene, label: str) -> None:
        """Replace this scene by another, as a step that can be undone."""
        self._record(label, scene)

    def add(
        self,
        kind: str,
        center: Sequence[float],
        size: Sequence[float],
        *,
        prefix: str = "A",
        color: str | None = None,
    ) -> str:
        """Add a region under the first free name, A1, A2, ...; returns the name."""
        region = Region("new", kind, tuple(center), tuple(size), color)
        return self.add_shape(region, prefix)

    def add_shape(self, shape: Region, prefix: str = "A") -> str:
        """Add a region of a shape under the first free name; returns the name."""
        name = free_name(prefix, self.scene.atom_names)
        return self._add(f"add {name}", replace(shape, name=name))

    def duplicate(self, name: str) -> str:
        """Add a copy of a region, slightly offset; returns its name."""
        region, shift = self.region(name), SHIFT * unit_of(self.scene)
        copy = free_name(_stem(name), self.scene.atom_names)
        x, y, *rest = region.center
        moved = replace(region, name=copy).at((x + shift, y - shift, *rest))
        return self._add(f"duplicate {name}", moved)

    def move(self, name: str, center: Sequence[float], gesture: str | None = None) -> None:
        """Move a region's center [m]."""
        self.put(name, self.region(name).at(center), "move", gesture)

    def resize(
        self,
        name: str,
        size: Sequence[float],
        center: Sequence[float] | None = None,
        gesture: str | None = None,
    ) -> None:
        """Change a region's size [m], and its center if a corner stays fixed."""
        region = self.region(name)
        center = region.center if center is None else tuple(center)
        self.put(name, region.sized(size).at(center), "resize", gesture)

    def reshape(self, name: str, kind: str, center: Sequence[float], size: Sequence[float]) -> None:
        """Change the kind of a region to one that has a center and a size."""
        region = Region(name, kind, tuple(center), tuple(size))
        self.put(name, region, "change")

    def put(self, name: str, shape: Region, verb: str, gesture: str | None = None) -> None:
        """Give a region another shape; name, colour and path stay.

        Args:
            name: of the region; the empty one for the initial set.
            shape: that it takes.
            verb: what the step is called.
            gesture: that the step is part of.
        """
        if name == "":
            old = self.scene.initial
            initial = replace(shape, name=old.name, color=old.color, motion=None)
            scene = replace(self.scene, initial=initial)
            self._record("change the initial set", scene, gesture)
            return
        old = self.region(name)
        region = replace(shape, name=name, color=old.color, motion=old.motion)
        self._change(f"{verb} {name}", name, region, gesture)

    def set_motion(self, name: str, motion: Motion | None, begins: Sequence[float]) -> None:
        """Have a region move, from a position of its centre on [m], or stand there."""
        region = self.region(name).at(begins)
        self._change(f"change the path of {name}", name, replace(region, motion=motion))

    def recolor(self, name: str, color: str | None, gesture: str | None = None) -> None:
        """Change a region's colour, `#rrggbb`; None for the viewer's choice."""
        region = replace(self.region(name), color=color)
        self._change(f"recolour {name}", name, region, gesture)

    def rename(self, name: str, new: str) -> None:
        """Rename a region, in the formula too."""
        region = self.region(name)
        names = self.scene.atom_names
        if new != name and new in names:
            other = "another region" if new in self.scene.region_names else "a predicate"
            raise EditError(f"name: {new!r} is already the name of {other}")
        renamed = replace(region, name=new)
        formula = rename_in_formula(self.scene.formula, name, new, **self._reading)
        regions = tuple(renamed if each is region else each for each in self.scene.regions)
        scene = replace(self.scene, formula=formula, regions=regions)
        self._record(f"rename {name} to {new}", scene)

    def join(self, name: str, other: str) -> None:
        """Make another region part of a region; the formula names the one instead of the other."""
        union = joined(self.region(name), self.region(other))
        formula = rename_in_formula(self.scene.formula, other, name, **self._reading)
        regions = tuple(
            union if each.name == name else each
            for each in self.scene.regions
            if each.name != other
        )
        scene = replace(self.scene, formula=formula, regions=regions)
        self._record(f"join {name} with {other}", scene)

    def take_apart(self, name: str) -> None:
        """Make every part a region; the formula names any of them where it named the whole."""
        union, taken = self.region(name), list(self.scene.atom_names)
        if not union.parts:
            raise EditError(f"{name} has no parts to take it apart into")
        if len(taken) + len(union.parts) - 1 > MAX_ATOMS:
            raise EditError(f"a scene has at most {MAX_ATOMS} regions; delete one first")
        names = [name]
        for _ in union.parts[1:]:
            names.append(free_name(_stem(name), taken))
            taken.append(names[-1])
        pieces = apart(union, tuple(names))
        formula = spread_in_formula(self.scene.formula, name, names, **self._reading)
        at = self.scene.regions.index(union)
        regions = (*self.scene.regions[:at], *pieces, *self.scene.regions[at + 1 :])
        self._record(f"take {name} apart", replace(self.scene, formula=formula, regions=regions))

    def delete(self, name: str) -> None:
        """Remove a region; a formula that names it stays and becomes invalid."""
        region = self.region(name)
        regions = tuple(each for each in self.scene.regions if each is not region)
        self._record(f"delete {name}", replace(self.scene, regions=regions))

    def set_initial(
        self,
        *,
        kind: str | None = None,
        center: Sequence[float] | None = None,
        size: Sequence[float] | None = None,
        gesture: str | None = None,
    ) -> None:
        """Change the initial set; values that are not given stay."""
        old = self.scene.initial
        center = old.center if center is None else tuple(center)
        if kind is not None and kind != old.kind:
            size = old.size if size is None else tuple(size)
            initial = Region(old.name, kind, center, size)
        else:
            initial = (old if size is None else old.sized(size)).at(center)
        self.put("", initial, "change", gesture)

    def set_formula(self, text: str, gesture: str | None = None) -> None:
        """Change the text of the formula, valid or not."""
        self._record("edit the formula", replace(self.scene, formula=text), gesture)

    def set_predicates(self, predicates: Sequence[Predicate]) -> None:
        """Change the predicates of the robot's state; a formula that names them stays."""
        scene = replace(self.scene, predicates=tuple(predicates))
        self._record("change the predicates", scene)

    def set_between_steps(self, asked: bool) -> None:
        """Change whether invariants must hold between the steps, too."""
        scene = replace(self.scene, between_steps=asked)
        self._record("change what counts between the steps", scene)

    def set_horizon(self, steps: int, gesture: str | None = None) -> None:
        """Change the scene's horizon, the minimum length of an episode."""
        self._record("change the horizon", replace(self.scene, horizon=steps), gesture)

    def set_seed(self, seed: int, gesture: str | None = None) -> None:
        """Change the seed of the training."""
        self._record("change the seed", replace(self.scene, seed=seed), gesture)

    def set_arena(self, arena: Arena | None, gesture: str | None = None) -> None:
        """Change the arena, (low, high) of each axis [m]; None for the robot's own."""
        self._record("change the arena", replace(self.scene, arena=arena), gesture)

    def set_name(self, name: str, gesture: str | None = None) -> None:
        """Change the scene's name, under which it is saved."""
        self._record("rename the mission", replace(self.scene, name=name), gesture)

    def set_title(self, title: str, gesture: str | None = None) -> None:
        """Change the line that describes the scene."""
        self._record("change the title", replace(self.scene, title=title), gesture)

    @property
    def _reading(self) -> dict[str, Any]:
        """How the scene's formula is read."""
        scene = self.scene
        names, dt = scene.atom_names, ENVS[scene.robot].dt
        return {"names": names, "dt": dt, "horizon": scene.horizon}

    def _add(self, label: str, region: Region) -> str:
        if len(self.scene.regions) >= MAX_ATOMS:
            raise EditError(f"a scene has at most {MAX_ATOMS} regions; delete one first")
        regions = (*self.scene.regions, region)
        self._record(label, replace(self.scene, regions=regions))
        return region.name

    def _change(self, label: str, name: str, region: Region, gesture: str | None = None) -> None:
        regions = tuple(region if each.name == name else each for each in self.scene.regions)
        self._record(label, replace(self.scene, regions=regions), gesture)

    def _record(self, label: str, scene: Scene, gesture: str | None = None) -> None:
        # The label separates two regions that are dragged in what the client calls one gesture.
        self._history.record(label, scene, gesture and f"{label} {gesture}")


def _stem(name: str) -> str:
    """A name without the number at its end."""
    return re.sub(r"[0-9]+\Z", "", name) or name


def free_name(prefix: str, taken: Sequence[str]) -> str:
    """The first of A1, A2, ... that is not taken."""
    number = 1
    while (name := f"{prefix[: LONGEST_NAME - len(str(number))]}{number}") in taken:
        number += 1
    return name
