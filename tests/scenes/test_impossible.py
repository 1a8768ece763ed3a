"""Missions that are said to be impossible, or hard, before training: cases by hand, and z3's."""

from dataclasses import replace

import pytest

from scenes import Region, Scene, demo_names, load_task, task_names
from studio.runs.findings import findings_of
from tests.tools.impossible import cases

REGIONS = (
    Region("A", "rectangle", (-3.5, 3.0), (0.4, 0.4)),
    Region("B", "rectangle", (3.2, 3.4), (0.4, 0.4)),
    Region("C", "rectangle", (3.0, -3.4), (0.4, 0.4)),
    Region("D", "circle", (-3.0, -3.0), (0.4,)),
    Region("O", "rectangle", (0.0, 0.0), (1.2, 0.6)),
    Region("I", "circle", (0.5, 0.0), (0.3,)),
    Region("Far", "rectangle", (7.0, 0.0), (0.5, 0.5)),
)
"""Of `linear` in an arena of 10 x 10 m; I lies in O, Far outside the arena."""

INITIAL = Region("initial", "rectangle", (0.0, -2.0), (0.3, 0.3))


def scene(formula: str, initial: Region = INITIAL) -> Scene:
    return replace(
        load_task("linear-01"), formula=formula, regions=REGIONS, initial=initial, horizon=100
    )


def told(formula: str, initial: Region = INITIAL) -> list[str]:
    """Findings as lines."""
    return [str(finding) for finding in findings_of(scene(formula, initial))]


def test_a_deadline_that_is_too_tight():
    """From y <= -1.7 to y >= 2.6 in steps of 0.4 m: 11; from x <= -3.1 to x >= 2.6: 15."""
    assert told("F_[0:5](A) & F_[0:5](C)") == [
        "impossible: the start to A is at least 11 steps, 5 are left",
        "impossible: A then C is at least 15 steps, 5 are left",
        "impossible: the start to C is at least 6 steps, 5 are left; "
        "F_[0:29](A) and F_[0:8](C) would do",
    ]


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("F_[3:3](A)", "the start to A is at least 11 steps, 3 are left; F_[3:14](A) would do"),
        ("F_[0:60](A & F_[0:9](C))", "A then C is at least 15 steps, 9 are left"),
        ("F_[20:25](A) & F_[26:30](C)", "A then C is at least 15 steps, 10 are left"),
        ("(!B) U_[0:10] A", "the start to A is at least 11 steps, 10 are left"),
        ("G_[0:20](F_[0:9](A))", "the start to A is at least 11 steps, 9 are left"),
        ("G_[20:40](F_[0:12](A)) & G_[20:40](F_[0:12](C))", "A then C is at least 15 steps"),
        ("F_[0:30](G_[0:60](A)) & F_[0:40](C)", ""),
        ("F_[0:8](A) & F_[0:90](C) | F_[0:9](B)", "with "),
        ("F_[0:30](A & B)", "no position satisfies A & B"),
        ("F_[0:30](A) & G_[20:40](D) & G_[30:50](B)", "wanted from step 30 to 40, but do not meet"),
        ("F_[0:50](I) & G_[0:50](!O)", "I lies inside O, which is forbidden meanwhile"),
        ("(!O) U_[0:50] I", "I lies inside O"),
        ("G_[0:30](A)", "the start contradicts the formula: A must hold from step 0"),
        ("A U_[0:20] B", "the start contradicts the formula: A must hold from step 0"),
        ("F_[0:40](A) & F_[0:40](B) & F_[0:40](C) & F_[0:40](D)", "is at least 41 steps"),
    ],
)
def test_what_is_proved(formula, words):
    lines = told(formula)
    if not words:  # C first, then the stay
        assert not any(line.startswith("impossible") for line in lines)
    else:
        assert lines and all(line.startswith("impossible: ") for line in lines)
        assert any(words in line for line in lines), lines


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("(!A) U_[0:30] A", "A and !A are wanted at once, which only a boundary allows"),
        ("(!A & !B) U_[0:30] (A & F_[1:8]((!A) U_[0:30] B))", "phi1 must still hold at the step"),
        ("F_[0:12](A)", "the start to A is about 14 steps at planning speed, 12 are left"),
        ("F_[0:14](A)", "of the initial set, the start to A is about"),
        ("F_[0:50](Far & !O)", "Far & !O lies outside the arena"),
        ("F_[0:50](Far)", "Far lies outside the arena, which extends from [-5.0, -5.0] to [5.0"),
    ],
)
def test_what_is_warned_of(formula, words):
    (line,) = told(formula)
    assert line.startswith("warning: ") and words in line


@pytest.mark.parametrize(
    "formula",
    [
        "F_[0:17](A)",
        "F_[0:40](A) & F_[0:40](C)",
        "F_[0:5](A) | F_[0:40](C)",
        "(!O) U_[0:40] A & F_[0:90](I)",
        "(!B) U_[0:30] (A & F_[1:8](!A & ((!A) U_[0:30] B)))",
        "G_[0:50](F_[0:50](A)) & G_[0:50](F_[0:50](B)) & G_[0:50](F_[0:50](C))",
        "G_[0:60](A -> F_[0:5](B)) & F_[0:40](C)",
        "G_[10:50](A | !A) & F_[0:40](C)",
        "!(A U_[0:9] B)",
    ],
)
def test_nothing_is_said_of_what_is_possible(formula):
    assert told(formula) == []


def test_operators_without_a_bound_reach_to_the_horizon():
    """As they do for the task itself: 100 steps."""
    assert told("F A & F C & G !O") == told("F_[0:100](A) & F_[0:100](C) & G_[0:100](!O)") == []
    assert told("G A & F C") == told("G_[0:100](A) & F_[0:100](C)") != []


def test_a_start_in_an_obstacle():
    """Each inner point of O is 0.3 m or more from its boundary for this initial set."""
    inside = replace(INITIAL, center=(0.0, 0.0))
    (line,) = told("F_[0:30](A) & G_[0:30](!O)", inside)
    assert line == (
        "impossible: the start contradicts the formula: !O must hold from step 0, but all of the "
        "initial set is 0.3 m or more away from that"
    )


@pytest.mark.parametrize("task", task_names() + demo_names())
def test_nothing_is_said_of_shipped_tasks(task):
    assert findings_of(load_task(task)) == ()


@pytest.mark.parametrize(
    ("robot", "steps", "proved"),
    [("unicycle", 6, True), ("quadrotor", 6, True), ("panda", 6, False), ("ant", 6, False)],
)
def test_other_robots(robot, steps, proved):
    """The arm's bound is loose and its start not exact; how fast an ant can be is not known."""
    demo = load_task(f"{robot}-demo")
    (finding,) = findings_of(replace(demo, formula=f"F_[0:{steps}]({demo.regions[0].name})"))
    assert finding.proved == proved
    assert finding.words.startswith("the start to")


def test_the_ant_cannot_begin_elsewhere():
    demo = load_task("ant-demo")
    (finding,) = findings_of(replace(demo, formula=f"G_[0:9]({demo.regions[0].name})"))
    assert finding.proved


def test_z3_agrees():
    """`python -m tests.tools.impossible` tries more; of 1,500 impossible ones 99 % are proved."""
    found = list(cases(range(40)))
    impossible = [case for case in found if not case.possible]
    assert [case.scene.name for case in found if case.possible and case.proved] == []
    assert 10 <= len(impossible) <= 30
    assert sum(case.proved for case in impossible) >= 0.9 * len(impossible)


POINT = Region("initial", "point", (0.0, -2.0))


def test_a_point_start_is_judged_like_a_small_set():
    assert told("F_[0:50](A) & G_[0:50](!O)", POINT) == []
    assert told("F_[0:5](A)", POINT) == [
        "impossible: the start to A is at least 12 steps, 5 are left; F_[0:15](A) would do"
    ]
    (inside,) = told("G_[0:5](!O)", Region("initial", "point", (0.0, 0.0)))
    assert inside.startswith("impossible: ") and "!O" in inside


CORNERS = ((-1.2, -0.6), (1.2, -0.6), (1.2, 0.6), (-1.2, 0.6))


@pytest.mark.parametrize("formula", ["F_[0:5](A)", "F_[0:50](O & A)", "G_[0:9](O)", "F_[0:50](I)"])
def test_a_rectangle_is_judged_alike_as_a_polygon_and_turned(formula):
    polygon = Region("O", "polygon", points=CORNERS)
    turned = Region("O", "rectangle", (0.0, 0.0), (0.6, 1.2), angle=90.0)
    union = Region("O", "union", parts=(polygon,))
    for other in (polygon, turned, union):
        regions = tuple(other if region.name == "O" else region for region in REGIONS)
        found = findings_of(replace(scene(formula), regions=regions))
        assert [str(finding) for finding in found] == told(formula)
