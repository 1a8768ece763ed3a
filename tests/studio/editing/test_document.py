"""The edited document: edits, names in the formula, undo and redo, what becomes stale."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from core.errors import UserError
from core.grounding import MAX_ATOMS
from core.stl import Atom, atom_names, parse, quote_name, to_text, walk
from scenes import Region, Scene, format_scene, load_task, parse_scene
from studio.editing import shapes
from studio.editing.document import Document, EditError, free_name
from studio.editing.history import CAPACITY, History
from studio.editing.meaning import differences
from studio.editing.renaming import rename_in_formula
from tests.strategies import formulas

DT = 0.2


def scene() -> Scene:
    return Scene(
        name="draft",
        title="A draft",
        robot="linear",
        formula="F_[0:10](A1) &  G_[0:20]( !B )",
        horizon=20,
        seed=1,
        regions=(
            Region("A1", "circle", (1, 2), (0.5,)),
            Region("B", "rectangle", (0, 0), (1, 0.5), "#123456"),
            Region("C", "circle", (3, 3), (0.2,)),
        ),
        initial=Region("initial", "rectangle", (-3, -3), (0.5, 0.5)),
    )


@pytest.fixture
def document() -> Document:
    return Document(scene())


def test_new_regions_get_the_first_free_name(document):
    assert document.add("circle", (0, 0), (1,)) == "A2"
    assert document.add("rectangle", (0, 0), (1, 1), color="#ff0000") == "A3"
    document.delete("A2")
    assert document.add("circle", (0, 0), (1,)) == "A2"
    assert document.add("circle", (0, 0), (1,), prefix="B") == "B1"
    assert document.scene.region_names == ("A1", "B", "C", "A3", "A2", "B1")


def test_free_names_stay_within_the_longest():
    assert free_name("x" * 60, []) == "x" * 39 + "1"
    assert free_name("x" * 60, ["x" * 39 + str(n) for n in range(1, 10)]) == "x" * 38 + "10"


def test_edits_change_one_thing(document):
    document.move("C", (1.5, -1))
    document.resize("C", (0.7,))
    document.resize("B", (2, 1), center=(1, 1))
    document.recolor("C", "#00ff00")
    document.reshape("A1", "rectangle", (1, 2), (0.5, 0.6))
    document.set_initial(size=(0.1, 0.2))
    document.set_horizon(30)
    document.set_seed(7)
    document.set_title("Other")
    now = document.scene
    assert now.regions == (
        Region("A1", "rectangle", (1, 2), (0.5, 0.6)),
        Region("B", "rectangle", (1, 1), (2, 1), "#123456"),
        Region("C", "circle", (1.5, -1), (0.7,), "#00ff00"),
    )
    assert now.initial == Region("initial", "rectangle", (-3, -3), (0.1, 0.2))
    assert (now.horizon, now.seed, now.title, now.formula) == (30, 7, "Other", scene().formula)


def test_a_duplicate_lies_aside_under_its_own_name(document):
    assert document.duplicate("B") == "B1"
    assert document.duplicate("A1") == "A2"
    assert document.region("B1") == replace(document.region("B"), name="B1", center=(0.4, -0.4))
    assert document.region("A2").center == pytest.approx((1.4, 1.6))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda d: d.move("D", (0, 0)), "unknown 'D'. Allowed: "),
        (lambda d: d.move("C", (0, math.nan)), "center"),
        (lambda d: d.move("C", (0, 0, 0)), "3 numbers"),
        (lambda d: d.resize("C", (0,)), "positive"),
        (lambda d: d.recolor("C", "red"), "#rrggbb"),
        (lambda d: d.rename("C", "B"), "another region"),
        (lambda d: d.rename("C", "  "), "name"),
        (lambda d: d.add("cube", (0, 0), (1,)), "Allowed"),
        (lambda d: d.add("sphere", (0, 0, 0), (1,)), "dimension"),
        (lambda d: d.set_formula(" "), "formula"),
        (lambda d: d.set_horizon(0), "horizon"),
        (lambda d: d.set_seed(-1), "seed"),
        (lambda d: d.set_title(""), "title"),
        (lambda d: d.set_initial(size=(1, -1)), "positive"),
    ],
)
def test_bad_edits_are_refused_as_a_whole(document, edit, message):
    with pytest.raises(UserError, match=message):
        edit(document)
    assert document.scene == scene()
    assert document.undo_label is None


def test_no_more_regions_than_a_formula_can_name(document):
    while len(document.scene.regions) < MAX_ATOMS:
        document.add("circle", (0, 0), (1,))
    for edit in (lambda: document.add("circle", (0, 0), (1,)), lambda: document.duplicate("B")):
        with pytest.raises(EditError, match=f"at most {MAX_ATOMS} regions"):
            edit()


def test_rename_changes_the_formula_and_nothing_else_in_it(document):
    document.rename("A1", "the lobby")
    assert document.scene.formula == 'F_[0:10]("the lobby") &  G_[0:20]( !B )'
    assert document.scene.region_names == ("the lobby", "B", "C")
    document.rename("the lobby", "goal")
    assert document.scene.formula == "F_[0:10](goal) &  G_[0:20]( !B )"
    assert document.undo() == "rename the lobby to goal"
    assert document.undo() == "rename A1 to the lobby"
    assert document.scene == scene()


@pytest.mark.parametrize(
    ("text", "old", "new", "expected"),
    [
        ("F_[70:80](F) & G_[0:9](!F)", "F", "K", "F_[70:80](K) & G_[0:9](!K)"),
        ("F_[0:1](A) & A1 | AA", "A", "Z", "F_[0:1](Z) & A1 | AA"),
        ("F_[0:1](A)", "A", "F", "F_[0:1](F)"),
        ("F_[0:1](A)", "A", "and", 'F_[0:1]("and")'),
        ("not A", "A", "K", "not K"),
        ("A_1 & A_{1} & A1", "A1", "K", "K & K & K"),
        ("A_1U_[0:5]B", "A1", "goal", " goal U_[0:5]B"),
        ("'A'U_[0:5]\"A\"", "A", "x y", '"x y"U_[0:5]"x y"'),
        (r"\text{A} \land \neg A", "A", "K", r"K \land \neg K"),
        ("F_[0 s:0.4 s] A", "A", "K", "F_[0 s:0.4 s] K"),
        # The new name is what the formula already writes for another region.
        ("A_1 & C", "C", "A_1", 'A1 & "A_1"'),
        # Not formulas (yet): words and quotations.
        ("F_[0:1](A & ", "A", "K", "F_[0:1](K & "),
        ("F_[0:1](A & NEW)", "A", "K", "F_[0:1](K & NEW)"),
        ("F_[0:1](F & G_[2:1](A", "F", "K", "F_[0:1](K & G_[2:1](A"),
        ('A & "A" & "my A" & ', "A", "K L", '"K L" & "K L" & "my A" & '),
    ],
)
def test_renaming_in_text(text, old, new, expected):
    names = [name for name in ("A", "AA", "A1", "B", "C", "F") if name != new]
    assert rename_in_formula(text, old, new, names=names, dt=DT) == expected


@settings(max_examples=80, deadline=None)
@given(formulas(max_depth=3), st.sampled_from(["Z", "F", "U", "until", "x_1", "é", "1", "a b"]))
def test_renaming_renames_the_atoms_of_any_formula(formula, new):
    text = rename_in_formula(to_text(formula), "A", new, names=("A", "B", "C"), dt=None)
    found = parse(text, names=(new, "B", "C"))
    expected = [new if n == Atom("A") else getattr(n, "name", None) for n in walk(formula)]
    assert [getattr(node, "name", None) for node in walk(found)] == expected
    assert [type(node) for node in walk(found)] == [type(node) for node in walk(formula)]


def test_deleting_a_region_that_the_formula_names_is_undone_with_it(document):
    document.delete("A1")
    assert document.scene.formula == scene().formula
    with pytest.raises(UserError, match="unknown name 'A1'"):
        parse(document.scene.formula, dt=DT, names=document.scene.region_names)
    document.undo()
    assert document.scene == scene()


def test_a_drag_is_one_step(document):
    for x in range(5):
        document.move("C", (x, 0), gesture="7")
    document.move("B", (1, 0), gesture="7")
    document.move("C", (9, 9), gesture="8")
    assert [document.undo(), document.undo(), document.undo(), document.undo()] == [
        "move C",
        "move B",
        "move C",
        None,
    ]
    assert document.scene == scene()
    assert document.redo() == "move C"
    assert document.region("C").center == (4, 0)
    assert document.redo_label == "move B"


def test_a_drag_back_to_where_it_began_is_no_step(document):
    document.move("C", (5, 5), gesture="7")
    document.move("C", (3, 3), gesture="7")
    assert document.undo_label is None
    document.move("C", (4, 4), gesture="7")
    assert document.undo_label == "move C"


def test_undo_ends_a_gesture(document):
    document.move("C", (5, 5), gesture="7")
    document.undo()
    document.redo()
    document.move("C", (6, 6), gesture="7")
    document.undo()
    assert document.region("C").center == (5, 5)


def test_an_edit_without_effect_is_no_step(document):
    revision = document.revision
    document.move("C", (3.0, 3.0))
    document.rename("C", "C")
    assert (document.revision, document.undo_label) == (revision, None)


def test_an_edit_drops_what_was_undone(document):
    document.delete("C")
    document.undo()
    document.set_seed(5)
    assert document.redo() is None


def test_modified_compares_with_what_was_saved(document):
    assert not document.modified
    document.set_seed(5)
    assert document.modified
    document.mark_saved()
    assert not document.modified
    document.undo()
    assert document.modified


def test_edits_after_the_saved_scene_stay_unsaved(document):
    document.set_seed(5)
    written = document.scene
    document.set_seed(6)
    document.mark_saved(written)
    assert document.modified
    document.undo()
    assert not document.modified


def test_the_oldest_steps_are_forgotten():
    history = History(0)
    for number in range(1, CAPACITY + 11):
        history.record("count", number)
    while history.undo():
        pass
    assert history.present == 10


@pytest.mark.parametrize(
    ("edit", "stale"),
    [
        (lambda d: d.set_formula("F_[0:11](A1) & G_[0:20](!B)"), ("the formula",)),
        (lambda d: d.set_formula("F_[0:10](A1) & ("), ("the formula",)),
        (lambda d: d.delete("B"), ("the formula",)),
        (lambda d: d.move("A1", (0, 1)), ("region A1",)),
        (lambda d: d.resize("B", (1, 1)), ("region B",)),
        (lambda d: d.set_initial(center=(0, -1)), ("the initial set",)),
        (lambda d: d.set_horizon(21), ("the horizon",)),
        (lambda d: d.replace(replace(d.scene, robot="unicycle"), "robot"), ("the robot",)),
        (lambda d: d.set_horizon(5), ()),  # the formula looks 20 steps ahead anyway
        (lambda d: d.set_formula("◇[0,10]A1 and always[0,20] not B"), ()),
        (lambda d: d.set_formula("F_[0 s:2 s](A1) & G_[0:20](!B)"), ()),
        (lambda d: d.rename("A1", "B2"), ()),
        (lambda d: d.move("C", (0, 1)), ()),
        (lambda d: d.delete("C"), ()),
        (lambda d: d.add("circle", (0, 0), (1,)), ()),
        (lambda d: d.recolor("A1", "#ffffff"), ()),
        (lambda d: d.set_title("Other"), ()),
        (lambda d: d.set_seed(99), ()),
    ],
)
def test_what_makes_a_training_stale(document, edit, stale):
    edit(document)
    assert document.scene != scene()
    assert differences(scene(), document.scene) == stale
    assert document.matches(scene()) == (not stale)
    document.undo()
    assert document.matches(scene())


def test_regions_of_a_wrong_formula_count_as_used():
    wrong = replace(scene(), formula="F_[0:1](")
    document = Document(wrong)
    document.move("C", (0, 1))
    assert differences(wrong, document.scene) == ("region C",)
    document.delete("C")
    assert differences(wrong, document.scene) == ("the regions",)


def test_a_scene_without_regions_can_be_kept():
    empty = replace(scene(), regions=())
    assert parse_scene(format_scene(empty), "file") == empty


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


def test_snapping():
    assert shapes.snap((0.13, -0.37, 0.12), 0.25) == (0.25, -0.25, 0.0)
    assert shapes.snap((0.1 + 0.2,), 0.1) == (0.3,)
    assert shapes.snap((0.13, 1), 0) == (0.13, 1.0)


def test_drawing_by_a_drag():
    assert shapes.drawn("rectangle", (1, 1), (-1, 0)) == ((0, 0.5), (1, 0.5))
    assert shapes.drawn("circle", (1, 1), (1, 3)) == ((1, 1), (2,))
    assert shapes.drawn("sphere", (1, 1), (1, 3)) == ((1, 1, 2), (2,))
    assert shapes.drawn("box", (0, 0), (2, 2)) == ((1, 1, 0.5), (1, 1, 0.5))
    assert shapes.drawn("cylinder", (0, 0), (0, 2)) == ((0, 0, 0.5), (2, 0.5))
    assert shapes.drawn("rectangle", (0.1, 0), (0.9, 1.1), step=0.5) == ((0.5, 0.5), (0.5, 0.5))
    assert shapes.drawn("circle", (1, 1), (1.01, 1)) is None
    assert shapes.drawn("rectangle", (0, 0), (1, 0)) == ((0.5, 0), (0.5, shapes.SMALLEST))


KINDS = {"circle": 1, "rectangle": 2, "sphere": 1, "box": 3, "cylinder": 2}


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_a_dragged_handle_lands_where_the_pointer_is(data):
    kind = data.draw(st.sampled_from(sorted(KINDS)))
    dimension = 2 if kind in ("circle", "rectangle") else 3
    number = st.floats(-5, 5)
    center = data.draw(st.tuples(*[number] * dimension))
    size = data.draw(st.tuples(*[st.floats(0.1, 3)] * KINDS[kind]))
    region = Region("A", kind, center, size)
    points = shapes.handles(region)
    handle = data.draw(st.integers(0, len(points) - 1))
    same = shapes.resized(region, handle, points[handle])
    assert same.center == pytest.approx(center)
    assert same.size == pytest.approx(size)
    # Away from the centre by up to twice the size: the handle follows the pointer.
    scale = data.draw(st.floats(1.0, 2.0))
    target = tuple(c + scale * (p - c) for c, p in zip(center, points[handle], strict=True))
    new = shapes.resized(region, handle, target)
    moved = Region("A", kind, new.center, new.size)
    assert shapes.handles(moved)[handle] == pytest.approx(target, abs=1e-9)
    # Whatever the pointer does, the region stays one.
    wild = shapes.resized(region, handle, data.draw(st.tuples(*[number] * dimension)), step=0.25)
    assert Region("A", kind, wild.center, wild.size)


def test_corners_opposite_to_the_pointer_stay():
    region = Region("A", "rectangle", (0, 0), (1, 2))
    assert shapes.resized(region, 3, (3, 0)) == ((1, -1), (2, 1))
    assert shapes.resized(region, 0, (0.5, -4)) == ((0.75, -1), (0.25, 3))
    assert shapes.resized(region, 0, (9, -2)) == ((1 - shapes.SMALLEST, 0), (shapes.SMALLEST, 2))
    cylinder = Region("A", "cylinder", (0, 0, 1), (2, 1))
    assert shapes.resized(cylinder, 5, (7, 7, 4)) == ((0, 0, 2), (2, 2))
    assert shapes.resized(cylinder, 0, (0, 3, 9)) == ((0, 0, 1), (3, 1))


def test_every_shipped_scene_can_be_edited_and_renamed():
    document = Document(load_task("linear-08"))
    document.rename("A1", "first goal")
    now = document.scene
    assert quote_name("first goal") in now.formula
    assert document.matches(load_task("linear-08"))
    assert now.formula.count("\n") == load_task("linear-08").formula.count("\n")
