"""The rules of decomposition one by one, on formulas small enough to decompose by hand."""

import pytest

from core.decompose import (
    DecompositionError,
    Kind,
    TimeExpr,
    decompose,
    edge_text,
    task_name,
    task_rows,
)
from core.decompose import to_text as plan_text
from core.errors import UserError
from core.stl import Always, And, Atom, Interval, Span, Until, parse, to_text


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


FIG_2 = "F_[5:10](mu1 & G_[2:4](mu2) & F_[1:3](mu3)) & G_[0:20](!mu0)"


def test_table_of_the_papers_figure():
    """Fig. 2 with a, b = 5, 10; a2, b2 = 2, 4; a3, b3 = 1, 3; c, d = 0, 20."""
    plan = decompose(parse(FIG_2))
    assert [(v.name, v.low, v.high) for v in plan.variables] == [("t1", 5, 10), ("t2", 1, 3)]
    assert task_rows(plan) == [
        ("Subgoal 1", "mu1", "t1", "t1", ""),
        ("Subgoal 2", "mu2", "t1 + 2", "t1 + 4", ""),
        ("Subgoal 3", "mu3", "t1 + t2", "t1 + t2", ""),
        ("Invariant", "!mu0", "0", "20", ""),
    ]
    assert [task.kind for task in plan.tasks] == [
        Kind.REACH,
        Kind.STAY,
        Kind.REACH,
        Kind.INVARIANT,
    ]
    assert plan.horizon == 20
    assert plan.requirements == ()


def test_tree_of_the_papers_figure():
    plan = decompose(parse(FIG_2))

    def outline(node):
        task = None if node.task is None else task_name(plan, node.task)
        below = [outline(child) for child in node.children]
        return (edge_text(node, plan.variables), node.label, task, below)

    assert outline(plan.tree) == (
        "",
        "Reach(phi, 0)",
        None,
        [
            (
                "t1 in [5, 10]",
                "Reach(phi0, t1)",
                None,
                [
                    ("", "Reach(mu1, t1)", "Subgoal 1", []),
                    ("", "Inv(mu2, [t1 + 2, t1 + 4])", "Subgoal 2", []),
                    ("t2 in [1, 3]", "Reach(mu3, t1 + t2)", "Subgoal 3", []),
                ],
            ),
            ("", "Inv(!mu0, [0, 20])", "Invariant", []),
        ],
    )
    assert [(name, to_text(formula)) for name, formula in plan.names] == [
        ("phi", FIG_2),
        ("phi0", "mu1 & G_[2:4](mu2) & F_[1:3](mu3)"),
    ]


def test_text_of_the_papers_figure():
    assert (
        plan_text(decompose(parse(FIG_2)))
        == """\
Reach(phi, 0)
├─ t1 in [5, 10]: Reach(phi0, t1)
│  ├─ Reach(mu1, t1)   <- Subgoal 1
│  ├─ Inv(mu2, [t1 + 2, t1 + 4])   <- Subgoal 2
│  └─ t2 in [1, 3]: Reach(mu3, t1 + t2)   <- Subgoal 3
└─ Inv(!mu0, [0, 20])   <- Invariant

phi = F_[5:10](mu1 & G_[2:4](mu2) & F_[1:3](mu3)) & G_[0:20](!mu0)
phi0 = mu1 & G_[2:4](mu2) & F_[1:3](mu3)

Task      | Predicate | Start   | End
----------+-----------+---------+--------
Subgoal 1 | mu1       | t1      | t1
Subgoal 2 | mu2       | t1 + 2  | t1 + 4
Subgoal 3 | mu3       | t1 + t2 | t1 + t2
Invariant | !mu0      | 0       | 20"""
    )


def test_text_shows_branches_and_requirements():
    text = plan_text(decompose(parse("G_[1:2](!A) | G_[0:9](F_[0:3](A))")))
    assert "\n├─ b1 = 0: Inv(!A, [1, 2])   <- Invariant\n" in text
    assert "b1 = 0: G_[1:2](!A)\nb1 = 1: G_[0:9](F_[0:3](A))\n" in text
    assert "\nrequired: 9 <= t1 + t2 + t3 when b1 = 1\n" in text
    assert "\nInvariant | !A        | 1            | 2            | b1 = 0\n" in text


def avoid(stop: int, names: str) -> str:
    return " & ".join(f"G_[0:{stop}](!{name})" for name in names.split())


LINEAR = {
    "01": (f"F_[5:7](F_[50:85](A) & {avoid(90, 'B5 B1 B2 B3 B4')})", "5-7 50-85", 1, 5),
    "02": (
        f"F_[5:10](F_[0:50](A) & G_[60:80](C) & {avoid(90, 'B5 B1 B2 B3 B4')})",
        "5-10 0-50",
        2,
        5,
    ),
    "03": (
        f"F_[5:10](F_[0:50](A) & F_[40:60](C) & G_[70:80](D) & {avoid(90, 'B5 B0 B1 B2 B3 B4')})",
        "5-10 0-50 40-60",
        3,
        6,
    ),
    "04": (
        "F_[5:10](F_[0:50](A) & F_[40:50](C) & F_[70:80](F) & G_[50:60](D) & "
        f"{avoid(90, 'B E B1 B2 B3 B4')})",
        "5-10 0-50 40-50 70-80",
        4,
        6,
    ),
    "05": (
        "F_[5:10](F_[0:30](A) & F_[30:50](C) & F_[70:80](F) & F_[75:88](H) & G_[50:60](D) & "
        f"{avoid(90, 'B E G B1 B2 B3 B4')})",
        "5-10 0-30 30-50 70-80 75-88",
        5,
        7,
    ),
    "06": (f"F_[10:90](A) & {avoid(100, 'B1 B2 B3 B4 B5')}", "10-90", 1, 5),
    "07": (
        f"F_[0:90](A1) & F_[40:80](A2) & {avoid(100, 'B1 B2 B3 B4 B5')}",
        "0-90 40-80",
        2,
        5,
    ),
    "08": (
        f"F_[0:90](A1) & F_[40:80](A2 & F_[10:20](G_[0:10](A3))) & {avoid(100, 'B1 B2 B3 B4 B5')}",
        "0-90 40-80 10-20",
        3,
        5,
    ),
    "09": (
        "F_[5:20](A1 & F_[10:20](G_[0:5](A2) & F_[10:30](G_[0:5](A3)) & "
        f"F_[10:30](G_[0:10](A4)))) & {avoid(100, 'B1 B2 B3 B4 B5 B6 B7 B8 B9')}",
        "5-20 10-20 10-30 10-30",
        4,
        9,
    ),
    "10": (
        "(!D1)U_[0:100](K1) & (!D2)U_[0:100](K2) & (!D3)U_[0:100](K3) & "
        f"F_[80:90](G_[0:5](G)) & {avoid(100, 'B1 B2 B3 B4 B5')}",
        "0-100 0-100 0-100 80-90",
        4,
        8,
    ),
}


@pytest.mark.parametrize("number", LINEAR)
def test_linear_tasks_of_the_paper(number: str):
    text, expected, subgoals, constraints = LINEAR[number]
    plan = decompose(parse(text))
    assert " ".join(f"{v.low}-{v.high}" for v in plan.variables) == expected
    kinds = [task.kind for task in plan.tasks]
    assert len(kinds) - kinds.count(Kind.INVARIANT) == subgoals
    assert kinds.count(Kind.INVARIANT) == constraints


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
    "nested F add their variables": (
        "F_[1:2](F_[3:5](A))",
        [("t1", 1, 2), ("t2", 3, 5)],
        [("reach", "A", "t1 + t2", "t1 + t2")],
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
    assert plan.domain_sizes == (2, 3, 4, 2, 2)


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


def test_equal_subformulas_share_a_short_name_that_is_no_region():
    plan = decompose(parse("G_[0:2](F_[0:1](phi0 & F_[1:2](B)))"))
    labels = [node.label for node in plan.tree.walk() if node.task is None]
    assert labels == ["Reach(phi, 0)", "Reach(phi1, t1)", "Reach(phi1, t1 + t3)"]


def test_branches_in_the_tree():
    plan = decompose(parse("!((A)U_[1:3](B)) & G_[0:9](C)"))
    edges = [edge_text(node, plan.variables) for node in plan.tree.walk()]
    labels = [node.label for node in plan.tree.walk()]
    assert list(zip(edges, labels, strict=True)) == [
        ("", "Reach(phi, 0)"),
        ("", "Reach(phi0, 0)"),
        ("b1 = 0", "Inv(!B, [1, 3])"),
        ("b1 = 1", "Reach(phi0, 0)"),
        ("t1 in [0, 3]", "Reach(!A, t1)"),
        ("", "Inv(!B, [1, t1 - 1])"),
        ("", "Inv(C, [0, 9])"),
    ]


@pytest.mark.parametrize("text", [text for text, _, _ in RULES.values()])
def test_every_task_is_a_leaf_of_the_tree(text: str):
    plan = decompose(parse(text))
    leaves = [node for node in plan.tree.walk() if node.task is not None]
    assert [node.task for node in leaves] == list(range(len(plan.tasks)))
    assert all(not node.children for node in leaves)
    introduced = {node.variable for node in plan.tree.walk()} - {None}
    assert introduced == set(range(len(plan.variables)))


REFUSED = {
    "G_[0:3](A | F_[0:1](B))": ("A | F_[0:1](B)", "choice"),
    "G_[0:3](A -> G_[0:1](B))": ("!A | G_[0:1](B)", "choice"),
    "F_[0:2](C) & G_[0:3]((A)U_[0:2](B))": ("(A)U_[0:2](B)", "until"),
    "G_[0:3](!((A)U_[0:2](B)))": ("!((A)U_[0:2](B))", "until"),
    "((A)U_[0:2](B))U_[0:3](C)": ("(A)U_[0:2](B)", "until"),
    "(F_[0:2](A))U_[0:3](B)": ("F_[0:2](A)", "length depends"),
    "(G_[0:1](F_[0:2](A)))U_[0:3](B)": ("F_[0:2](A)", "length depends"),
    "!((A)U_[0:3](G_[0:1](B)))": ("F_[0:1](!B)", "length depends"),
    "F_[0:3](A & false)": ("F_[0:3](A & false)", "never hold"),
    "!((true)U_[0:3](true))": ("!((true)U_[0:3](true))", "never hold"),
    "G_[0:5000](F_[0:3](A))": ("G_[0:5000](F_[0:3](A))", "variables"),
}


@pytest.mark.parametrize("text", REFUSED)
def test_refusals_name_the_subformula(text: str):
    subformula, reason = REFUSED[text]
    with pytest.raises(DecompositionError) as caught:
        decompose(parse(text))
    assert f"`{to_text(parse(subformula))}`" in str(caught.value)
    assert reason in str(caught.value)


@pytest.mark.parametrize("text", ["C & G_[0:3](A U_[0:2] B)", "C & (A U_[0:2] B) U_[0:3] D"])
def test_refusals_give_the_columns_of_the_subformula(text: str):
    with pytest.raises(DecompositionError) as caught:
        decompose(parse(text))
    span = caught.value.span
    assert span is not None
    assert text[span.start : span.stop].strip("()") == "A U_[0:2] B"
    assert f"(columns {span.start + 1}-{span.stop})" in str(caught.value)


def test_refusals_of_formulas_without_a_source_text_give_no_columns():
    until = Until(Interval(0, 2), Atom("A"), Atom("B"))
    with pytest.raises(DecompositionError) as caught:
        decompose(Always(Interval(0, 3), until))
    assert "columns" not in str(caught.value)
    assert f"`{to_text(until)}`" in str(caught.value)


def test_columns_of_a_group_cover_its_members():
    text = "A & F_[0:1](C) & B"
    plan = decompose(parse(text))
    group = plan.tasks[0].predicate
    assert group == And((Atom("A"), Atom("B")))
    assert group.span == Span(0, len(text))


def test_fewer_visits_than_the_least_are_refused():
    with pytest.raises(UserError, match="visits_extra must be 0 or more, given -1"):
        decompose(parse("A"), visits_extra=-1)
