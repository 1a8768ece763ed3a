"""Other ways of writing the same, and what is answered to what the language has not."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import (
    FormulaError,
    atom_names,
    horizon,
    one_line,
    parse,
    read,
    robustness,
    to_text,
)
from tests.strategies import formulas, traces

NAMES = list("ABCDEFGO")
DT, T = 0.2, 100

READ = {
    # operators without an upper bound
    "F A & F B": "F_[0:100](A) & F_[0:100](B)",
    "G(!O) & F(A)": "G_[0:100](!O) & F_[0:100](A)",
    "[]<>(A) & []<>(B)": "G_[0:50](F_[0:50](A)) & G_[0:50](F_[0:50](B))",
    "GF(A)": "G_[0:50](F_[0:50](A))",
    "F(A & F(B)) & G(!O)": "F_[0:50](A & F_[0:50](B)) & G_[0:100](!O)",
    "F(A & F(B & F(C)))": "F_[0:33](A & F_[0:33](B & F_[0:33](C)))",
    "G(F_[0:20](A))": "G_[0:80](F_[0:20](A))",
    "F_[10:20](G A)": "F_[10:20](G_[0:80](A))",
    "F(A) & F(G_[0:10](B & F(C)))": "F_[0:100](A) & F_[0:45](G_[0:10](B & F_[0:45](C)))",
    "(!A) U B": "(!A)U_[0:100](B)",
    "A until B": "(A)U_[0:100](B)",
    "always !O and eventually A": "G_[0:100](!O) & F_[0:100](A)",
    "F_[0:inf](A)": "F_[0:100](A)",
    "F_[10,∞)(A)": "F_[10:100](A)",
    r"\mathbf{F}_{[0,\infty)} A": "F_[0:100](A)",
    "F_[20:T](A)": "F_[20:100](A)",
    "F_{>=20} A": "F_[20:100](A)",
    "F F": "F_[0:100](F)",
    "F (F)": "F_[0:100](F)",
    "F & G": "F & G",
    "F U G": "(F)U_[0:100](G)",
    "!F | G": "!F | G",
    # one bound
    "F_5 (A)": "F_[5:5](A)",
    "F_5 & A": None,
    "F_[20](A)": "F_[20:20](A)",
    "G_{5} A": "G_[5:5](A)",
    "F_{<=5} A": "F_[0:5](A)",
    "F_{<5} A": "F_[0:4](A)",
    r"F_{\leq 1s} A": "F_[0:5](A)",
    "◇_{≤5} A": "F_[0:5](A)",
    "F_{=5} A": "F_[5:5](A)",
    "A U_{<=5} B": "(A)U_[0:5](B)",
    "A U_5 B": "(A)U_[5:5](B)",
    # intervals
    r"F_{\left[0,5\right]} A": "F_[0:5](A)",
    "F_{0,5} A": "F_[0:5](A)",
    "F^{[0,5]} A": "F_[0:5](A)",
    "F_[0;30](A)": "F_[0:30](A)",
    "F[0..5] A": "F_[0:5](A)",
    r"F_{[0\,\mathrm{s}, 5\,\mathrm{s}]} A": "F_[0:25](A)",
    "F{[0:5]} A": "F_[0:5](A)",
    # words and signs
    "ev_[0, 50] (A) and alw_[0, 50] (not O)": "F_[0:50](A) & G_[0:50](!O)",
    "alw_[0,50] (A => ev_[0,20] B)": "G_[0:50](A -> F_[0:20](B))",
    "globally[0,5] !O & Finally [0:9] A": "G_[0:5](!O) & F_[0:9](A)",
    "◊[0,5] A & ⋄[0,5] A & ♢[0,5]A & <>[0,5] A": " & ".join(["F_[0:5](A)"] * 4),
    "□[0,5]A & ◻[0,5] A & ▢[0,5] A & [][0,5] A": " & ".join(["G_[0:5](A)"] * 4),
    r"\Box_{[0,5]} A \wedge \square_{[0,5]} A": "G_[0:5](A) & G_[0:5](A)",
    "A --> B": "A -> B",
    "A ==> B": "A -> B",
    r"A \Longrightarrow B": "A -> B",
    "A <-> B": "(A -> B) & (B -> A)",
    "A iff B": "(A -> B) & (B -> A)",
    "A ⇔ B": "(A -> B) & (B -> A)",
    r"A \iff B": "(A -> B) & (B -> A)",
    "A <=> B -> C": "(A -> B -> C) & ((B -> C) -> A)",
    "A xor B": "(A | B) & !(A & B)",
    "A ⊕ B | C": "(A | (B | C)) & !(A & (B | C))",
    "A & (B xor C) -> D": "A & ((B | C) & !(B & C)) -> D",
    # LaTeX
    r"$\Diamond_{[0,30]} A$": "F_[0:30](A)",
    r"\text{F}_{[0,30]} A": "F_[0:30](A)",
    r"\operatorname{F}_{[0,30]} \text{A}": "F_[0:30](A)",
    r"\mathbf F_{[0,5]} A \text{ and } \mathrm{B}": "F_[0:5](A) & B",
    r"\mathbf{G}\mathbf{F} A": "G_[0:50](F_[0:50](A))",
    r"\neg A \,\mathcal{U}_{[0,30]}\, B": "(!A)U_[0:30](B)",
    r"\left( A \lor B \right) \land \lnot{O}": "(A | B) & !O",
    r"\[ F_{[0,5]} A \]": "F_[0:5](A)",
    "A \\\\ \\land B": "A & B",
    r"\begin{equation} F_{[0,5]} A \end{equation}": "F_[0:5](A)",
    # full width
    "Ｆ［０：５］（Ａ）＆！Ｂ": "F_[0:5](A) & !B",
    "Ｇ＿［１，２］（¬Ａ）": "G_[1:2](!A)",
    "𝐅[0,5] A ∧ 𝖦[0,5] ¬O": "F_[0:5](A) & G_[0:5](!O)",
    "F[0，5]（“A”）": "F_[0:5](A)",
    # around the formula
    "F_[0:50](A) // go to A": "F_[0:50](A)",
    "F_[0:50](A) # don't & can't": "F_[0:50](A)",
    "F_[0:50](A) /* go\nto */ & B": "F_[0:50](A) & B",
    "# first\nA\n// then\n& B": "A & B",
    "F_[0:50](A);": "F_[0:50](A)",
    "F_[0:50](A).": "F_[0:50](A)",
    "out = always[0,5](A)": "G_[0:5](A)",
    r"\varphi_1 := F_{[0,5]} A": "F_[0:5](A)",
    "phi: A -> B": "A -> B",
}


@pytest.mark.parametrize("text", READ)
def test_dialects(text):
    if READ[text] is None:
        with pytest.raises(FormulaError, match="unknown name 'F_5'"):
            parse(text, dt=DT, names=NAMES, horizon=T)
        return
    formula = parse(text, dt=DT, names=NAMES, horizon=T)
    assert to_text(formula) == READ[text]
    assert parse(READ[text], names=NAMES) == formula


@pytest.mark.parametrize(
    ("text", "names", "name"),
    [
        (r"\text{A}_1", None, "A1"),
        (r"\mathrm{A}_{1}", ["A1"], "A1"),
        (r"\mathrm{A_1}", ["A1"], "A1"),
        (r"\mathrm{A_1}", ["A_1", "A1"], "A_1"),
        (r"\text{room}_{left}", None, "room_left"),
        (r"A_{\text{goal}}", None, "A_goal"),
        (r"\textit{the lobby}", None, "the lobby"),
        ("Ａ１", None, "Ａ１"),
        ("Ａ１", ["A1"], "A1"),
        ("Ａ_1", ["A1"], "A1"),
        ("“Ａ１”", ["Ａ１"], "Ａ１"),
        ('"a // b # c"', None, "a // b # c"),
        (r"\text{a // b}", None, "a // b"),
        ("ev & alw & iff & xor & X & once & since", None, "ev"),
        ("F_5", None, "F5"),
        ("GF", None, "GF"),
    ],
)
def test_names_in_dialects(text, names, name):
    assert atom_names(parse(text, names=names))[0] == name


@pytest.mark.parametrize("name", ["ev", "alw", "finally", "globally", "iff", "xor", "GF", "inf"])
def test_words_of_dialects_remain_names(name):
    text = f"F_[0:5]({name}) & ({name})U_[0:3](!{name}) | {name}"
    assert to_text(parse(text)) == text
    operators = f"{name}_[0:5]({name}) & {name} ({name})"
    if name in {"ev", "finally"}:
        assert to_text(parse(operators, horizon=9)) == f"F_[0:5]({name}) & F_[0:9]({name})"


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("F A", "reach to the scene's horizon, 100 steps: F_[0:100]."),
        ("G F A", "100 steps, which nested operators share: G_[0:50], F_[0:50]."),
        ("A U B", "U_[0:100]"),
        ("F_[7](A)", "_[7] is the one step [7:7]; for any step up to it write [0:7]."),
        ("out = A", "'out =' names the formula and is left out."),
    ],
)
def test_what_the_text_left_open_is_said(text, note):
    (said,) = read(text, dt=DT, names=NAMES, horizon=T).notes
    assert note in said


@pytest.mark.parametrize("text", ["F_[0:5](A)", "A <-> B", "F_[0:50](A) // here", "F_{<=5} A"])
def test_nothing_is_said_where_nothing_was_left_open(text):
    assert read(text, dt=DT, names=NAMES, horizon=T).notes == ()


@pytest.mark.parametrize("text", ["F_[0:100](F A)", "G_[50:120](A U B)", "F_[100:inf](A)"])
def test_an_open_operator_needs_a_step(text):
    with pytest.raises(FormulaError, match="no step left for it: .* the scene's horizon is 100"):
        parse(text, horizon=T)


@settings(deadline=None, max_examples=200)
@given(formulas(max_depth=4, constants=False), st.integers(1, 60))
def test_open_operators_end_with_the_horizon(formula, steps):
    text = to_text(formula)
    try:
        closed = parse(text.replace("_[0:1]", " "), horizon=steps)
    except FormulaError as error:
        assert "no step left" in str(error)
    else:
        assert horizon(closed) <= max(steps, horizon(formula))


@settings(deadline=None, max_examples=100)
@given(formulas(max_depth=2), formulas(max_depth=2), st.data())
def test_equivalence_and_exclusive_or(left, right, data):
    signs = {"iff": -1, "xor": 1}
    trace = data.draw(traces(max(horizon(left), horizon(right)) + 1, ties=False))
    a, b = (robustness(side, trace, "ABC") for side in (left, right))
    for word, sign in signs.items():
        both = parse(f"({to_text(left)}) {word} ({to_text(right)})")
        margin = sign * -np.sign(a) * np.sign(b) * min(abs(a), abs(b))
        assert robustness(both, trace, "ABC") == pytest.approx(margin)


@pytest.mark.parametrize(
    "text", ["A # first\n& B", '"a # b" // x\n& B /* and\nno more */ | C', "A\n\n  & B", "A # B"]
)
def test_a_formula_on_one_line_is_the_same(text):
    line = one_line(text)
    assert "\n" not in line and parse(line) == parse(text)


@pytest.mark.parametrize("word", ["<->", " xor "])
def test_chains_that_would_grow_exponentially_are_refused_at_once(word):
    began = time.process_time()
    with pytest.raises(FormulaError, match="more than"):
        parse(word.join(["A"] * 1000))
    with pytest.raises(FormulaError, match="more than 10,000 operators"):
        parse(word.join(["(A & B & C & D & E & F & G & H & I)"] * 11))
    assert time.process_time() - began < 5


ANSWERED = {
    "F_[0:50](x > 3)": ("`x > 3` (columns 10-14) compares numbers", "draw a region where x > 3"),
    "G_[0:50](x >= -5 & x <= 5)": ("`x >= -5` (columns 10-16)", "draw a region"),
    "G_[0:50](sqrt(x^2+y^2) < 4)": ("`sqrt(x^2+y^2) < 4` (columns 10-26)", "draw a region"),
    "G_[0:50](dist(A, B) >= 1.5)": ("compares numbers", "draw a region"),
    "x = 3": ("`x = 3` (columns 1-5)", "draw a region"),
    "F_[0:5](A == B)": ("compares", "write A <-> B"),
    "X A": ("`X A` (columns 1-3) is the operator next", "write F_[1:1](A)"),
    "G_[0:5](A -> X (B & C))": ("`X (B & C)` (columns 14-22)", "write F_[1:1](B & C)"),
    "next A": ("next", "write F_[1:1](A)"),
    "○ A": ("next", "write F_[1:1](A)"),
    r"\mathbf{X} A": ("next", "write F_[1:1](A)"),
    "X[3] A": ("next", "write F_[3:3](A)"),
    "G_[0:50](A -> once[0:10](B))": ("`once[0:10](B)` (columns 15-27) looks back", "forward"),
    "historically[0:10](A)": ("looks back", "begin with what comes first"),
    "A since[0:10] B": ("`A since[0:10] B`", "F_[0:50](B & G_[0:10](A))"),
    "A S_[0:10] B": ("looks back", "G_[0:10](A)"),
    "A R_[0:20] B": ("release", "write (B U_[0:20] A) | G_[0:20](B)"),
    "A release B": ("release", "(B U_[0:50] A)"),
    "(!A) W_[0:20] B": ("weak until", "write ((!A) U_[0:20] B) | G_[0:20](!A)"),
    "A M_[0:5] B": ("strong release", "write B U_[0:5] A"),
    "always[0:50](rise(A) -> eventually[0:20](B))": ("`rise(A)`", "!A & F_[1:1](A)"),
    "G_[0:5](fall(A))": ("`fall(A)`", "A & F_[1:1](!A)"),
    "F_[0,5)(A)": ("`[0,5)` (columns 3-7) is an interval without", "write [0:4]"),
    "F_(0,5](A)": ("`(0,5]`", "write [1:5]"),
    "F_(0,5)(A)": ("`(0,5)`", "write [1:4], or [0:5] with both ends"),
    "F_]0,5](A)": ("`]0,5]`", "write [1:5]"),
    "F_[0s,5s)(A)": ("`[0s,5s)`", "write [0s:5s], with both ends"),
    "F_[20:10](A)": ("the interval [20:10] is empty", "did you mean [10:20]?"),
    "always[0:1.5](!O)": ("1.5 is not a whole number of steps", "write 1.5 s"),
    "F_[0:5 min](A)": ("has the unit min", "write 300 s"),
    "F_[0:5sec](A)": ("has the unit sec", "write 5 s"),
    "F_[0:20 steps](A)": ("has the unit steps", "write 20"),
    "F[0, 50]^w1 (A) &&^w2 G[0,50] (!O)": ("`^w1` (columns 9-11) is a weight", "leave out ^w1"),
    "F_[0:30](in A)": ("`in A` (columns 10-13)", "write A"),
    "F_[0:30](reach(A))": ("`reach(A)`", "write A"),
    "G_[0:30](avoid O)": ("`avoid O`", "write !O"),
    "eventually between 0 and 30 A": ("`between 0 and 30`", "F_[0:30](A)"),
    "reach A within 30 steps": ("", "write A"),
    "Eventually(A, [0,30])": ("is a call of a function", "write F_[0:30](A)"),
    "Until(A, B, [0,30])": ("is a call", "write A U_[0:30] B"),
    "And(A, B)": ("is a call", "write A & B"),
    "A ~> F_[0:5](B)": ("`A ~> F_` (columns 1-7) is the operator leads to", "G_[0:50](A -> F_"),
    "A leadsto B": ("leads to", "write G_[0:50](A -> F_[0:50](B))"),
    "if A then F_[0:5](B)": ("`if A then` (columns 1-9)", "write A -> ..."),
    "A = B": ("'A =' stands before a formula, but 'A' is an atom", "write A <-> ..."),
    "A ^ B": ("`^`", "write xor or &"),
    "A * B": ("`*`", "write & for and"),
    "A + B": ("`+`", "write | for or"),
    "AG (A)": ("`AG (` (columns 1-4) has a quantifier", "leave out A and E"),
    "A /* here": ("`/*` (columns 3-4) is a comment without an end", "close it with */"),
    "A -- here": ("`--`", "a comment begins with # or //"),
    "the robot must visit A": ("`robot`", "a formula looks like"),
    "F_[0:5](A); G_[0:5](B)": ("unexpected 'G'", "there is one formula only"),
    "F_[0:5](A)\nG_[0:5](B)": ("unexpected 'G'", "join the lines with &"),
    "F_[0:30](a)": ("unknown name 'a'", "did you mean A? Capitals count"),
    "F_[0:30](A & F_[0:10](B)": ("a parenthesis is never closed", "line 1, column 9"),
}


@pytest.mark.parametrize("text", ANSWERED)
def test_what_is_not_of_the_language_is_answered_with_what_to_write(text):
    problem, answer = ANSWERED[text]
    with pytest.raises(FormulaError) as caught:
        parse(text, dt=DT, names=NAMES, horizon=T)
    assert problem in caught.value.problem
    assert answer in str(caught.value)


@pytest.mark.parametrize(
    ("release", "written"),
    [
        ("A R_[0:4] B", "(B U_[0:4] A) | G_[0:4](B)"),
        ("A R_[2:4] B", "F_[0:1](A) | F_[2:2](B U_[0:2] A) | G_[2:4](B)"),
    ],
)
def test_what_is_offered_for_release_is_release(release, written):
    with pytest.raises(FormulaError) as caught:
        parse(release)
    assert written in caught.value.hint
    formula, (a, b) = parse(written), map(int, release[5:8].split(":"))
    for trace in np.random.default_rng(4).choice([-1.0, 1.0], (200, 8, 2)):
        A, B = (trace >= 0).T
        holds = all(B[t] or A[:t].any() for t in range(a, b + 1))
        assert (robustness(formula, trace, "AB") >= 0) == holds


UNITS = [
    "F",
    "F_",
    "F_{0,",
    "GF",
    "[",
    "[ ",
    "<",
    "A<->",
    "A xor ",
    "9",
    "1.",
    "x+",
    "((x)",
    "\\text",
]
UNITS += [
    '"',
    "\\",
    "'",
    "/*",
    "//",
    "#",
    "A R ",
    "X ",
    "once ",
    "(",
    "{",
    "“",
    "Ｆ",
    "alw_",
    "^",
    " ",
]


@pytest.mark.parametrize("unit", UNITS)
def test_the_longest_texts_are_answered_soon(unit):
    began = time.process_time()
    for tail in ("", "A", ")", " @"):
        try:
            parse((unit * 10_000)[: 10_000 - len(tail)] + tail, dt=DT, names=NAMES, horizon=T)
        except FormulaError as error:
            assert len(str(error)) < 1000
    assert time.process_time() - began < 4
