"""Whatever is edited, the scene stays valid and can be retraced."""

import math

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from core.errors import UserError
from core.stl import atom_names, parse
from scenes import format_scene, parse_scene
from studio.page.editing.document import Document
from tests.studio.page.editing.draft import DT, scene

NAMES = st.sampled_from(["A1", "A2", "B", "C", "goal", "F", "x y", "A_1"])
NUMBERS = st.sampled_from([-2.0, 0.0, 0.5, 3.0, 1e9, math.nan])
PAIRS = st.tuples(NUMBERS, NUMBERS)
TEXTS = st.sampled_from(["F_[0:5](A1)", "G_[0:9](!B) & F_[0:2](C)", "(A1", "", "'x y'U_[0:3]F"])


class Editing(RuleBasedStateMachine):
    """Random edits: every scene is valid, undo and redo retrace them."""

    def __init__(self):
        super().__init__()
        self.document = Document(scene())
        self.past, self.future = [], []

    def edit(self, change) -> None:
        before = self.document.scene
        try:
            change(self.document)
        except UserError:
            assert self.document.scene is before
            return
        if self.document.scene != before:
            self.past.append(before)
            self.future = []

    @rule(center=PAIRS, radius=NUMBERS)
    def add(self, center, radius):
        self.edit(lambda d: d.add("circle", center, (radius,)))

    @rule(name=NAMES, center=PAIRS)
    def move(self, name, center):
        self.edit(lambda d: d.move(name, center))

    @rule(name=NAMES, size=PAIRS | st.tuples(NUMBERS))
    def resize(self, name, size):
        self.edit(lambda d: d.resize(name, size))

    @rule(name=NAMES, new=NAMES)
    def rename(self, name, new):
        used = self.atoms()
        exists = name in self.document.scene.region_names
        self.edit(lambda d: d.rename(name, new))
        renamed = self.document.scene.region_names
        if used is not None and exists and new in renamed and name != new and name not in renamed:
            assert self.atoms() == tuple(new if each == name else each for each in used)

    @rule(name=NAMES)
    def delete(self, name):
        self.edit(lambda d: d.delete(name))

    @rule(name=NAMES)
    def duplicate(self, name):
        self.edit(lambda d: d.duplicate(name))

    @rule(text=TEXTS)
    def set_formula(self, text):
        self.edit(lambda d: d.set_formula(text))

    @rule(center=PAIRS)
    def set_initial(self, center):
        self.edit(lambda d: d.set_initial(center=center))

    @rule(steps=st.integers(-1, 30))
    def set_horizon(self, steps):
        self.edit(lambda d: d.set_horizon(steps))

    @rule()
    def undo(self):
        if self.document.undo() is None:
            assert not self.past
        else:
            self.future.append(self.redone)
            assert self.document.scene == self.past.pop()

    @rule()
    def redo(self):
        if self.document.redo() is None:
            assert not self.future
        else:
            self.past.append(self.redone)
            assert self.document.scene == self.future.pop()

    @invariant()
    def is_valid(self):
        now = self.document.scene
        assert parse_scene(format_scene(now), "file") == now
        assert self.document.matches(now)
        self.redone = now

    def atoms(self):
        now = self.document.scene
        try:
            return atom_names(parse(now.formula, dt=DT, names=now.region_names))
        except UserError:
            return None


TestEditing = Editing.TestCase
TestEditing.settings = settings(max_examples=60, stateful_step_count=25, deadline=None)
