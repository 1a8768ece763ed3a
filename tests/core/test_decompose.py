"""The rules of decomposition one by one, on formulas small enough to decompose by hand."""

import pytest

from core.decompose import (
    TimeExpr,
    decompose,
    task_rows,
)
from core.stl import And, Atom, Span, parse, to_text


def domains(text: str, **options) -> list[tuple[str, int, int]]:
    return [(v.name, v.low, v.high) for v in decompose(parse(text), **options).variables]


def tasks(text: str, **options) -> list[tuple[str, ...]]:
    """Kind, predicate, start, end and, in branches, guards of every task."""
    plan = decompose(parse(text), **options)
    rows = task_rows(plan)
    return [
        (task.kind.value, *[cell for cell in row[1:] if cell])
        for task, row in zip(plan.tasks, rows, strict=True)
    ]


RULES = {
    "a state formula is one predicate": ("A & (B | !C)", [], [("reach", "A & (B | !C)", "0", "0")]),
    "state members of a conjunction are grouped where the first stands": (
        "F_[1:2](C) & (A & F_[0:3](D)) & !B",
        [("t1", 1, 2), ("t2", 0, 3)],
        [("reach", "C", "t1", "t1"), ("reach", "A & !B", "0", "0"), ("reach", "D", "t2", "t2")],
    ),
    "a temporal disjunction is a branch, its state members one alternative": (
        "A | F_[0:3](B) | C",
        [("b1", 0, 1), ("t1", 0, 3)],
        [("reach", "A | C", "0", "0", "b1 = 0"), ("reach", "B", "t1", "t1", "b1 = 1")],
    ),
    "branches nest": (
        "F_[0:2](A) | (F_[0:3](B) & (G_[0:1](C) | G_[2:3](A)))",
        [("b1", 0, 1), ("t1", 0, 2), ("t2", 0, 3), ("b2", 0, 1)],
        [
            ("reach", "A", "t1", "t1", "b1 = 0"),
            ("reach", "B", "t2", "t2", "b1 = 1"),
            ("stay", "C", "0", "1", "b1 = 1, b2 = 0"),
            ("stay", "A", "2", "3", "b1 = 1, b2 = 1"),
        ],
    ),
    "an implication is a disjunction": (
        "F_[0:2](A) -> F_[0:3](B)",
        [("b1", 0, 1), ("t1", 0, 3)],
        [("invariant", "!A", "0", "2", "b1 = 0"), ("reach", "B", "t1", "t1", "b1 = 1")],
    ),
    "nested F are one": (
        "F_[1:2](F_[3:5](A))",
        [("t1", 4, 7)],
        [("reach", "A", "t1", "t1")],
    ),
    "a variable of one value is a constant": (
        "F_[3:3](A) & G_[0:20](F_[1:1](B)) & (C)U_[2:2](D) & G_[0:9](F_[0:0](!A))",
        [],
        [
            ("stay", "A", "3", "3"),
            ("stay", "B", "1", "21"),
            ("stay", "C", "0", "2"),
            ("stay", "D", "2", "2"),
            ("invariant", "!A", "0", "9"),
        ],
    ),
    "a response is a visit, and no trigger where none is due": (
        "G_[2:28](A -> F_[0:10](B))",
        [("b1", 0, 1), ("t1", 2, 38)],
        [
            ("invariant", "!A", "2", "28", "b1 = 0"),
            ("reach", "B", "t1", "t1", "b1 = 1"),
            ("invariant", "!A", "2", "t1 - 11", "b1 = 1"),
            ("invariant", "!A", "t1 + 1", "28", "b1 = 1"),
        ],
    ),
    "a lockout is an episode, and no trigger before and after it": (
        "!F_[0:9](A & F_[1:4](B))",
        [("b1", 0, 1), ("t1", 0, 9), ("t2", 0, 9)],
        [
            ("invariant", "!A", "0", "9", "b1 = 0"),
            ("invariant", "!B", "t1 + 1", "t1 + t2 + 4", "b1 = 1"),
            ("invariant", "!A", "0", "t1 - 1", "b1 = 1"),
            ("invariant", "!A", "t1 + t2 + 1", "9", "b1 = 1"),
        ],
    ),
    "an until at every step is a chain of visits": (
        "G_[0:9]((!C)U_[0:4](B))",
        [("t1", 4, 4), ("t2", 5, 5)],
        [
            ("reach", "B", "t1", "t1"),
            ("reach", "B", "t1 + t2", "t1 + t2"),
            ("invariant", "!C", "0", "t1 + t2"),
        ],
    ),
    "an until that is due at some steps": (
        "G_[0:9](A -> (!C)U_[1:4](B))",
        [("b1", 0, 1), ("t1", 0, 9), ("t2", 1, 4)],
        [
            ("invariant", "!A", "0", "9", "b1 = 0"),
            ("reach", "B", "t1 + t2", "t1 + t2", "b1 = 1"),
            ("invariant", "!C", "t1", "t1 + t2", "b1 = 1"),
            ("invariant", "!A", "0", "t1 - 1", "b1 = 1"),
            ("invariant", "!A", "t1 + t2", "9", "b1 = 1"),
        ],
    ),
    "one of several places again and again": (
        "G_[0:20](F_[0:20](A) | F_[0:20](B))",
        [("t1", 20, 20)],
        [("reach", "A | B", "t1", "t1")],
    ),
    "F on the left of an until is a chain in a window of variable length": (
        "(F_[0:5](A))U_[0:9](B)",
        [("t1", 0, 9), ("t2", 0, 5), ("t3", 0, 6)],
        [
            ("reach", "B", "t1", "t1"),
            ("reach", "A", "t2", "t2"),
            ("reach", "A", "t2 + t3", "t2 + t3"),
        ],
    ),
    "a choice at each step of a short window is unrolled": (
        "G_[0:1](F_[0:5](A) | G_[0:5](B))",
        [("b1", 0, 1), ("t1", 0, 5), ("b2", 0, 1), ("t2", 0, 5)],
        [
            ("reach", "A", "t1", "t1", "b1 = 0"),
            ("stay", "B", "0", "5", "b1 = 1"),
            ("reach", "A", "t2 + 1", "t2 + 1", "b2 = 0"),
            ("stay", "B", "1", "6", "b2 = 1"),
        ],
    ),
    "nested G add up, and G of a conjunction distributes": (
        "F_[0:1](G_[1:2](G_[3:5](A & !B) & C))",
        [("t1", 0, 1)],
        [
            ("stay", "A", "t1 + 4", "t1 + 7"),
            ("invariant", "!B", "t1 + 4", "t1 + 7"),
            ("stay", "C", "t1 + 1", "t1 + 2"),
        ],
    ),
    "a disjunction of regions under G is one predicate": (
        "G_[0:3](A | B) & G_[0:3](A | !B)",
        [],
        [("stay", "A | B", "0", "3"), ("invariant", "A | !B", "0", "3")],
    ),
    "G over a single step is that step": (
        "G_[4:4](F_[0:2](A) | G_[0:1](B))",
        [("b1", 0, 1), ("t1", 0, 2)],
        [("reach", "A", "t1 + 4", "t1 + 4", "b1 = 0"), ("stay", "B", "4", "5", "b1 = 1")],
    ),
    "until": (
        "F_[1:2]((!D)U_[3:9](K))",
        [("t1", 1, 2), ("t2", 3, 9)],
        [("reach", "K", "t1 + t2", "t1 + t2"), ("invariant", "!D", "t1", "t1 + t2")],
    ),
    "until nests on the right, G stands on the left": (
        "(G_[1:2](A & !B))U_[0:3]((C)U_[2:4](D))",
        [("t1", 0, 3), ("t2", 2, 4)],
        [
            ("reach", "D", "t1 + t2", "t1 + t2"),
            ("stay", "C", "t1", "t1 + t2"),
            ("stay", "A", "1", "t1 + 2"),
            ("invariant", "!B", "1", "t1 + 2"),
        ],
    ),
    "a negated until is a branch": (
        "!((A)U_[1:3](B))",
        [("b1", 0, 1), ("t1", 0, 3)],
        [
            ("invariant", "!B", "1", "3", "b1 = 0"),
            ("reach", "!A", "t1", "t1", "b1 = 1"),
            ("invariant", "!B", "1", "t1 - 1", "b1 = 1"),
        ],
    ),
    "a negated until of a temporal right side has an alternative without window": (
        "!((A)U_[1:3](F_[0:1](B)))",
        [("b1", 0, 2), ("t1", 0, 1), ("t2", 2, 3)],
        [
            ("invariant", "!B", "1", "4", "b1 = 0"),
            ("reach", "!A", "t1", "t1", "b1 = 1"),
            ("reach", "!A", "t2", "t2", "b1 = 2"),
            ("invariant", "!B", "1", "t2", "b1 = 2"),
        ],
    ),
    "visits that must be as late as they can have no freedom": (
        "G_[0:20](F_[2:8](A))",
        [("t1", 8, 8), ("t2", 7, 7), ("t3", 7, 7)],
        [
            ("reach", "A", "t1", "t1"),
            ("reach", "A", "t1 + t2", "t1 + t2"),
            ("reach", "A", "t1 + t2 + t3", "t1 + t2 + t3"),
        ],
    ),
    "visits count from the start of the window": (
        "F_[0:3](G_[5:10](F_[0:4](A)))",
        [("t1", 0, 3), ("t2", 5, 9), ("t3", 1, 5)],
        [
            ("reach", "A", "t1 + t2", "t1 + t2"),
            ("reach", "A", "t1 + t2 + t3", "t1 + t2 + t3"),
        ],
    ),
    "what is visited may be temporal": (
        "G_[0:2](F_[0:1](A & F_[1:2](B)))",
        [("t1", 0, 1), ("t2", 1, 2), ("t3", 1, 2), ("t4", 1, 2)],
        [
            ("reach", "A", "t1", "t1"),
            ("reach", "B", "t1 + t2", "t1 + t2"),
            ("reach", "A", "t1 + t3", "t1 + t3"),
            ("reach", "B", "t1 + t3 + t4", "t1 + t3 + t4"),
        ],
    ),
    "constants leave no tasks": (
        "F_[0:3](A & true) & (true)U_[0:4](B) & (C)U_[2:4](true) & (false | G_[0:1](!D))",
        [("t1", 0, 3), ("t2", 0, 4)],
        [
            ("reach", "A", "t1", "t1"),
            ("reach", "B", "t2", "t2"),
            ("stay", "C", "0", "2"),
            ("invariant", "!D", "0", "1"),
        ],
    ),
    "what always holds needs nothing": ("G_[0:3](true) | F_[0:2](A)", [], []),
}


@pytest.mark.parametrize("rule", RULES)
def test_rules(rule: str):
    text, variables, expected = RULES[rule]
    assert domains(text) == variables
    assert tasks(text) == expected


def test_requirement_of_a_chain_of_visits():
    (requirement,) = decompose(parse("G_[0:9](F_[0:3](A))")).requirements
    assert requirement.total == TimeExpr(0, (0, 1, 2))
    assert (requirement.minimum, requirement.maximum) == (9, None)


def test_requirements_count_from_the_start_of_the_window_and_keep_their_guards():
    plan = decompose(parse("A & B | F_[0:3](G_[5:10](F_[0:4](A)))"))
    (requirement,) = plan.requirements
    assert [plan.variables[i].name for i in requirement.total.variables] == ["t2", "t3"]
    assert (requirement.minimum, requirement.guards) == (10, ((0, 1),))
    early = (1, 0, 5, 1)
    assert not plan.admissible(early)
    assert plan.admissible((0, *early[1:])), "the chain is not in the chosen branch"
    assert plan.admissible((1, 0, 5, 5))


def test_more_visits_free_the_schedule_but_never_leave_the_horizon():
    text = "G_[0:20](F_[2:8](A))"
    assert domains(text, visits_extra=1) == [("t1", 2, 8), *((f"t{i}", 0, 7) for i in (2, 3, 4))]
    plan = decompose(parse(text), visits_extra=1)
    (requirement,) = plan.requirements
    assert (requirement.minimum, requirement.maximum) == (22, 28)
    assert plan.horizon == 28
    assert not plan.admissible((8, 7, 7, 7))
    assert plan.admissible((8, 7, 7, 6))


def test_requirements_of_a_window_of_variable_length():
    """Visits last until B, and not beyond what the formula looks at."""
    plan = decompose(parse("(F_[0:5](A))U_[0:9](B)"))
    (requirement,) = plan.requirements
    assert (requirement.total, requirement.since) == (TimeExpr(0, (1, 2)), TimeExpr(0, (0,)))
    assert (requirement.minimum, requirement.maximum) == (0, 5)
    assert plan.admissible((9, 5, 4)) and not plan.admissible((9, 4, 4))
    assert not plan.admissible((1, 5, 6))


def test_a_branch_for_a_whole_window_is_said_to_be_one_sided():
    assert decompose(parse("G_[0:30](F_[0:5](A) | G_[0:5](B))")).one_sided
    assert not decompose(parse("G_[0:3](F_[0:5](A) | G_[0:5](B))")).one_sided


def test_a_rising_edge_asks_for_an_answer():
    """The trigger is over at the next step: it may be followed by a rest, or by a visit."""
    plan = decompose(parse("G_[0:30](!A & F_[1:1](A) -> F_[0:9](B))"))
    assert plan.one_sided
    schedule = (2, 0, 0, 0, 20)
    active = [(to_text(t.predicate), start, end) for t, start, end in plan.active_tasks(schedule)]
    assert active == [("B", 20, 20), ("!A", 1, 11), ("!A", 22, 31)]


def test_visits_missing_is_met_by_as_many_extra_visits():
    formula = parse("G_[0:20](F_[2:8](A))")
    missing = decompose(formula).visits_missing
    assert missing > 0
    assert decompose(formula, visits_extra=missing).visits_missing == 0
    assert decompose(formula, visits_extra=missing - 1).visits_missing == 1
    assert decompose(parse("G_[0:4](A)")).visits_missing == 0


def test_variables_know_where_they_matter():
    plan = decompose(parse("F_[0:2](A) | (F_[0:3](B) & (G_[0:1](C) | F_[2:3](A)))"))
    assert [(v.name, v.kind, v.guards) for v in plan.variables] == [
        ("b1", "branch", ()),
        ("t1", "time", ((0, 0),)),
        ("t2", "time", ((0, 1),)),
        ("b2", "branch", ((0, 1),)),
        ("t3", "time", ((0, 1), (3, 1))),
    ]
    assert plan.variables[3].labels == ("G_[0:1](C)", "F_[2:3](A)")
    assert to_text(plan.variables[1].source) == "F_[0:2](A)"
    assert [v.high - v.low + 1 for v in plan.variables] == [2, 3, 4, 2, 2]


def test_active_tasks_are_those_of_the_chosen_branch():
    plan = decompose(parse("F_[0:2](A) | !((A)U_[1:3](B)) | G_[5:7](C)"))
    names = [variable.name for variable in plan.variables]
    assert names == ["b1", "t1", "b2", "t2"]

    def active(*schedule: int):
        return [(to_text(t.predicate), s, e) for t, s, e in plan.active_tasks(schedule)]

    assert active(0, 2, 0, 0) == [("A", 2, 2)]
    assert active(1, 2, 1, 0) == [("!A", 0, 0), ("!B", 1, -1)]
    assert active(2, 0, 0, 0) == [("C", 5, 7)]


def test_schedules_outside_the_domains_are_not_admissible():
    plan = decompose(parse("F_[2:4](A)"))
    assert list(plan.schedules()) == [(2,), (3,), (4,)]
    assert not plan.admissible((1,))
    assert not plan.admissible((5,))
    assert not plan.admissible((2, 2))


def test_times_read_like_sums():
    variables = decompose(parse("F_[0:1](A) & F_[0:1](B)")).variables
    assert TimeExpr(0).text(variables) == "0"
    assert TimeExpr(7).text(variables) == "7"
    assert TimeExpr(5, (0, 1)).text(variables) == "t1 + t2 + 5"
    assert TimeExpr(-1, (1,)).text(variables) == "t2 - 1"
    assert TimeExpr(5, (0, 1)).at((10, 200)) == 215


def test_columns_of_a_group_cover_its_members():
    text = "A & F_[0:1](C) & B"
    plan = decompose(parse(text))
    group = plan.tasks[0].predicate
    assert group == And((Atom("A"), Atom("B")))
    assert group.span == Span(0, len(text))
