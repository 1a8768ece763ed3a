"""What the parser reads: precedence, every spelling, names, bounds and spans."""

from pathlib import Path

import pytest

from core.stl import (
    MAX_DEPTH,
    MAX_LENGTH,
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    horizon,
    parse,
    to_text,
    walk,
)

A, B, C, D = (Atom(name) for name in "ABCD")
PAPER = dict(
    line.split(" ", 1)
    for line in Path(__file__).with_name("paper_formulas.txt").read_text("utf-8").splitlines()
)


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("A & B | C", Or((And((A, B)), C))),
        ("A | B & C", Or((A, And((B, C))))),
        ("A & B & C", And((A, B, C))),
        ("(A & B) & C", And((And((A, B)), C))),
        ("A | (B | C)", Or((A, Or((B, C))))),
        ("A -> B -> C", Implies(A, Implies(B, C))),
        ("(A -> B) -> C", Implies(Implies(A, B), C)),
        ("A | B -> C & D", Implies(Or((A, B)), And((C, D)))),
        ("!A & B", And((Not(A), B))),
        ("!!A", Not(Not(A))),
        ("!A U_[0:3] B", Until(Interval(0, 3), Not(A), B)),
        ("A U_[0:3] B & C", And((Until(Interval(0, 3), A, B), C))),
        ("F_[0:1] A & B", And((Eventually(Interval(0, 1), A), B))),
        ("F_[0:1] A U_[2:3] G_[4:5] B", None),
        ("(A U_[0:1] B) U_[2:3] C", Until(Interval(2, 3), Until(Interval(0, 1), A, B), C)),
        ("F_[1:2] G_[3:4] !A", Eventually(Interval(1, 2), Always(Interval(3, 4), Not(A)))),
        ("((((A))))", A),
        ("true & false", And((Constant(True), Constant(False)))),
    ],
)
def test_structure(text, formula):
    if formula is None:
        first, second = Eventually(Interval(0, 1), A), Always(Interval(4, 5), B)
        formula = Until(Interval(2, 3), first, second)
    assert parse(text) == formula


@pytest.mark.parametrize(
    ("canonical", "spellings"),
    [
        ("A & B", ["A && B", "A and B", "A AND B", r"A /\ B", r"A \land B", r"A \wedge B", "A∧B"]),
        ("A & B", ["A&B", "\tA\n&\r\nB ", "A\u00a0& B\u200b", r"A \& B", r"$A \, \land \; B$"]),
        ("A | B", ["A || B", "A or B", "A Or B", r"A \/ B", r"A \lor B", r"A \vee B", "A∨B"]),
        ("!A", ["~A", "not A", "NOT A", r"\neg A", r"\lnot A", "¬A", "! (A)", "not(A)"]),
        ("A -> B", ["A => B", r"A \to B", r"A \implies B", r"A \rightarrow B", r"A \Rightarrow B"]),
        ("A -> B", ["A → B", "A⇒B", "A ⟹ B", "A implies B"]),
        ("true", [r"\top", "⊤", "True", "TRUE", "(true)"]),
        ("false", [r"\bot", "⊥", "False", "FALSE"]),
        ("F_[0:5](A)", ["F[0:5]A", "F_[0,5](A)", "F [ 0 : 5 ] A", "F_{[0:5]}A", "F _ { [0,5] } A"]),
        ("F_[0:5](A)", ["◇[0,5] A", "◊_[0:5]A", r"\Diamond_{[0,5]} A", r"\lozenge_{[0,5]}(A)"]),
        ("F_[0:5](A)", ["eventually[0:5] A", "eventually_[0:5](A)", "Eventually_{[0,5]} A"]),
        ("F_[0:5](A)", [r"\mathbf{F}_{[0,5]} A", r"\left( F_{[0,5]} A \right)"]),
        (
            "G_[1:2](A)",
            ["G[1:2]A", "always_[1:2] A", "□[1,2]A", r"\Box_{[1,2]}A", r"\square_[1:2]A"],
        ),
        ("G_[1:2](A)", [r"\mathrm{G}_{[1,2]} A", r"$$ G_{[1:2]} \quad A $$"]),
        (
            "(A)U_[0:3](B)",
            ["A U_[0:3] B", "A U[0,3]B", "(A)U_{[0:3]}(B)", r"A \mathcal{U}_{[0,3]} B"],
        ),
        ("(A)U_[0:3](B)", ["A until_[0:3] B", "A until [0:3] B", "A UNTIL[0:3]B"]),
    ],
)
def test_every_spelling(canonical, spellings):
    for spelling in spellings:
        assert to_text(parse(spelling)) == canonical, spelling


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("F_[70:80](F)", "F_[70:80](F)"),
        ("G_[0:90](!G)", "G_[0:90](!G)"),
        ("F & G | U", "F & G | U"),
        ("U U_[0:5] U", "(U)U_[0:5](U)"),
        ("F [0:3] F [0:3] F", "F_[0:3](F_[0:3](F))"),
        ("H & GPU & Fast", "H & GPU & Fast"),
        ("notable & orchard & android & trueish", "notable & orchard & android & trueish"),
        ("eventually_here", "eventually_here"),
        ("s & ms & F_[0:1](s)", "s & ms & F_[0:1](s)"),
        ("A_1 & B_{12} & key_{left}", "A1 & B12 & key_left"),
        ("A_1U_{[0:5]}B_2", "(A1)U_[0:5](B2)"),
        ("room_1_2 & a1_b", "room_1_2 & a1_b"),
        ("Küche & φ1", "Küche & φ1"),
        ('"the lobby" & "A"', '"the lobby" & A'),
        ("'true' | 'F'", '"true" | F'),
        ('"A_1"', '"A_1"'),
        (r'"a \"b\" \\ c\nd"', r'"a \"b\" \\ c\nd"'),
        (r"\text{Reach A} & \mathrm{B}", '"Reach A" & B'),
    ],
)
def test_names(text, canonical):
    assert to_text(parse(text)) == canonical


def test_escapes_in_quoted_names():
    assert parse(r'"a \"b\" \\ c\nd"') == Atom('a "b" \\ c\nd')


def test_a_known_spelling_wins_over_the_subscript_rule():
    assert parse("A_1", names=["A1"]) == Atom("A1")
    assert parse("A_1", names=["A_1"]) == parse("A_1", names=["A1", "A_1"]) == Atom("A_1")


@pytest.mark.parametrize(
    ("interval", "dt", "expected"),
    [
        ("[0.3s:0.7s]", 0.1, (3, 7)),
        ("[0:1.5 s]", 0.5, (0, 3)),
        ("[200ms:1s]", 0.05, (4, 20)),
        ("[ .5 s , 2. s ]", 0.25, (2, 8)),
        ("[0s:0]", 0.1, (0, 0)),
        ("[3:7]", 0.1, (3, 7)),
        ("[2.0:+3]", None, (2, 3)),
        ("[0:1s]", 1 / 3, None),
        ("[7:7]", None, (7, 7)),
    ],
)
def test_bounds(interval, dt, expected):
    if expected is None:
        with pytest.raises(ValueError, match="not a multiple"):
            parse(f"F_{interval}(A)", dt=dt)
    else:
        assert parse(f"F_{interval}(A)", dt=dt) == Eventually(Interval(*expected), A)


@pytest.mark.parametrize("dt", [0.0, -0.1, float("nan"), float("inf")])
def test_a_time_step_is_positive(dt):
    with pytest.raises(ValueError, match="dt must be positive"):
        parse("A", dt=dt)


def test_spans_point_into_the_source():
    text = " F_[0:5] (A & !B) -> (C)U_[1:2]('x y') "
    spans = {to_text(node): text[slice(*node.span)] for node in walk(parse(text)) if node.span}
    assert spans == {
        'F_[0:5](A & !B) -> (C)U_[1:2]("x y")': text.strip(),
        "F_[0:5](A & !B)": "F_[0:5] (A & !B)",
        "A & !B": "A & !B",
        "A": "A",
        "!B": "!B",
        "B": "B",
        '(C)U_[1:2]("x y")': "(C)U_[1:2]('x y')",
        "C": "C",
        '"x y"': "'x y'",
    }


def test_limits_are_inclusive():
    deepest = "!" * MAX_DEPTH + "A"
    assert to_text(parse(deepest)) == deepest
    assert parse("(" * MAX_DEPTH + "A" + ")" * MAX_DEPTH) == A
    operators = "F_[0:1]" * MAX_DEPTH + "A"
    assert parse(to_text(parse(operators))) == parse(operators)
    assert parse("A" * MAX_LENGTH) == Atom("A" * MAX_LENGTH)
    wide = parse(" & ".join(["A"] * 2000))
    assert isinstance(wide, And) and len(wide.operands) == 2000


@pytest.mark.parametrize("task", PAPER)
def test_the_formulas_of_the_paper(task):
    formula = parse(PAPER[task])
    assert parse(to_text(formula)) == formula
    assert "_" not in "".join(node.name for node in walk(formula) if isinstance(node, Atom))


def test_two_formulas_of_the_paper_in_full():
    assert len(PAPER) == 50
    assert to_text(parse(PAPER["linear-08"])) == (
        "F_[0:90](A1) & F_[40:80](A2 & F_[10:20](G_[0:10](A3))) & G_[0:100](!B1) & G_[0:100](!B2)"
        " & G_[0:100](!B3) & G_[0:100](!B4) & G_[0:100](!B5)"
    )
    assert to_text(parse(PAPER["unicycle-10"])) == (
        "(!D1)U_[0:100](K1) & (!D2)U_[0:100](K2) & (!D3)U_[0:100](K3) & F_[80:90](G_[0:5](G))"
        " & G_[0:100](!B1) & G_[0:100](!B2) & G_[0:100](!B3) & G_[0:100](!B4) & G_[0:100](!B5)"
    )


def test_thirteen_formulas_look_past_the_episode_of_the_paper():
    steps = {task: 200 if task.startswith("ant") else 100 for task in PAPER}
    assert sum(horizon(parse(PAPER[task])) > steps[task] for task in PAPER) == 13
