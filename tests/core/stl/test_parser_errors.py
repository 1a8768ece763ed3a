"""Every bad input gives a FormulaError with its place, never another exception."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from core.errors import UserError
from core.stl import MAX_LENGTH, Formula, FormulaError, parse, to_text
from tests.strategies import formulas

DT = 0.1
OPERAND = "a name, true, false, '!', 'F_[a:b]', 'G_[a:b]' or '('"
OPERATOR = "an operator ('&', '|' or '->')"


def fail(text: str, **options) -> FormulaError:
    with pytest.raises(FormulaError) as caught:
        parse(text, **options)
    return caught.value


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        # nothing, or too little
        ("", 1, "the formula is empty; expected a formula like F_[0:10](A)"),
        ("  \n ", 1, "the formula is empty"),
        ("$$", 1, "the formula ends too early"),
        ("A &", 4, f"the formula ends too early; expected {OPERAND}"),
        ("F_[0:5]", 8, f"the formula ends too early; expected {OPERAND}"),
        ("!", 2, "the formula ends too early"),
        ("()", 2, f"unexpected ')'; expected {OPERAND}"),
        # operators and operands
        ("& A", 1, f"unexpected '&'; expected {OPERAND}"),
        ("A & & B", 5, f"unexpected '&'; expected {OPERAND}"),
        ("A and and B", 7, "unexpected 'and'"),
        ("A B", 3, f"unexpected 'B'; expected {OPERATOR} or 'U_[a:b]' or the end of the formula"),
        ("(A B)", 4, f"unexpected 'B'; expected {OPERATOR} or 'U_[a:b]' or ')'"),
        ("A ! B", 3, "unexpected '!'"),
        ("3", 1, "unexpected '3'"),
        ("A \\foo B", 3, "unexpected '\\foo'"),
        ("A ; import os", 5, "there is one formula only; join the parts with &"),
        ("F_[0:5](A) & B, C", 17, "there is one formula only"),
        ("A\x00", 2, "unexpected '\\x00'"),
        ("A " + "x" * 50, 3, "unexpected '" + "x" * 12 + " ... " + "x" * 12 + "'"),
        # parentheses
        ("(A", 3, "a parenthesis is never closed; expected"),
        ("A & (B | (C)", 13, "it was opened at line 1, column 5"),
        ("A)", 2, "this ')' has no matching '('"),
        ("(A & B)) | C", 8, "this ')' has no matching '('"),
        # intervals
        ("F_[0:](A)", 6, "unexpected ']'; expected a number of steps"),
        ("F_[:5](A)", 4, "unexpected ':'; expected a number of steps"),
        ("F_[](A)", 4, "unexpected ']'; expected a number of steps"),
        ("F_[5 A", 6, "unexpected 'A'; expected a unit (s or ms) or ':' or ',' or ']'"),
        ("F_[0:5 A", 8, "unexpected 'A'; expected a unit (s or ms) or ']'"),
        ("F_[0:5", 7, "the formula ends too early; expected a unit (s or ms) or ']'"),
        ("F_{[0:5] A", 10, "unexpected 'A'; expected '}'"),
        ("F_[0:5]} A", 8, "unexpected '}'"),
        (
            "F_[5:3](A)",
            2,
            "the interval [5:3] is empty ([a:b] needs 0 <= a <= b; did you mean [3:5]?)",
        ),
        ("F_[-1:3](A)", 4, "the bound -1 is negative"),
        ("F_[0:inf](A)", 1, "this F has no upper bound (without a scene every interval must be"),
        ("F_[0:\\infty](A)", 1, "this F has no upper bound"),
        ("F_[inf:5](A)", 4, "unexpected 'inf'; expected a number of steps"),
        ("F_{<0}(A)", 2, "no step is before step 0"),
        ("F_[0:2.5](A)", 6, "the nearest are 2 and 3"),
        ("F_[0:1e3](A)", 6, "`1e3` (columns 6-8) is part of a power of ten"),
        ("F_[0:9999999](A)", 6, "too large (at most 1000000 steps)"),
        ("F_[0:" + "9" * 5000 + "](A)", 6, "a number of 5000 characters is too long"),
        ("F_[0:0.35s](A)", 6, "the nearest are 0.3 s (3 steps) and 0.4 s (4 steps)"),
        ("F_[0:350 ms](A)", 6, "the nearest are 300 ms (3 steps) and 400 ms (4 steps)"),
        ("F_[0:0.05s](A)", 6, "the nearest are 0 s (0 steps) and 0.1 s (1 step)"),
        ("F_[2:0.3s](A)", 2, "one bound has a unit and the other has none"),
        ("F_[0:5sec](A)", 6, "`5sec` (columns 6-9) has the unit sec; the units are s and ms"),
        # operators without an upper bound, where no horizon is known
        ("F(A)", 1, "this F has no upper bound"),
        ("B & G A", 5, "this G has no upper bound"),
        ("A U B", 1, "this U has no upper bound"),
        ("A & ◇B", 5, "without a scene every interval must be bounded; write F_[0:10]"),
        ("until", 1, "unexpected 'until'"),
        ("AU_[0:5] B", 4, "an interval can only follow F, G or U"),
        ("F_[0:5] U_[0:3] A", 9, f"unexpected 'U'; expected {OPERAND}"),
        ("A U_[0:1] B U_[0:2] C", 13, "untils cannot be chained"),
        ("A U_[0:1] B until_[0:2] C", 13, "untils cannot be chained"),
        # quotes
        ('"lobby', 1, "the quoted name has no closing quote"),
        ("A & 'lobby\n'", 5, "the quoted name has no closing quote"),
        ('A & ""', 5, "the name is empty"),
        ("\\text{ }", 1, "the name is empty"),
        ("'a' 'b'", 5, "unexpected \"'b'\""),
        # limits
        ("A" * (MAX_LENGTH + 1), MAX_LENGTH + 1, "at most 10000 are allowed"),
        ("!" * 65 + "A", 65, "more than 64 operators are nested in each other"),
        ("!" * 9999 + "A", 65, "more than 64 operators are nested in each other"),
        ("(" * 4999 + "A" + ")" * 4999, 65, "more than 64 parentheses are nested"),
        ("(" * 9999, 10000, "the formula ends too early"),
        ("A->" * 3000 + "A", 193, "more than 64 operators are nested"),
        ("F_[0:1]" * 1000 + "A", 449, "more than 64 operators are nested"),
    ],
    ids=lambda value: ascii(value)[:30],
)
def test_bad_input(text, column, words):
    error = fail(text, dt=DT)
    assert words in str(error)
    assert (error.line, error.column) == (1, column)


def test_seconds_need_a_time_step():
    error = fail("F_[0:3s](A)")
    assert "the bound 3 s needs the robot's time step" in str(error)
    assert error.column == 6


def test_unknown_names_list_the_known_ones_closest_first():
    error = fail("F_[0:5](A1 & !Gaol)", names=["A1", "B", "Goal", "the lobby"])
    assert error.problem == "unknown name 'Gaol'"
    assert error.expected.startswith("one of Goal, ")
    assert '"the lobby"' in error.expected
    assert error.column == 15


def test_a_long_list_of_names_is_cut():
    error = fail("X", names=[f"A{index}" for index in range(40)])
    assert error.expected.endswith("and 28 more")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("A_5", "unknown name 'A_5'"),
        ("F_[0:3](A_{5})", "unknown name 'A_{5}'"),
        ("\\text{the bay}", "unknown name 'the bay'"),
        ('"A_5"', "unknown name 'A_5'"),
        ('"Bob\'s"', 'unknown name "Bob\'s"'),
        ("X" * 9000, "unknown name '" + "X" * 17 + " ... " + "X" * 17 + "'"),
        ('"a\x1b[31m\u202eb"', "unknown name 'a\\x1b[31m\\u202eb'"),
        ('"two\\nlines"', "unknown name 'two\\nlines'"),
    ],
)
def test_an_unknown_name_is_shown_as_typed_but_short_and_escaped(text, problem):
    assert fail(text, names=["A1"]).problem == problem


@settings(deadline=None, max_examples=200)
@given(
    st.text(max_size=200) | st.text(max_size=200).map(lambda name: f'"{name}"'),
    st.lists(st.text(min_size=1, max_size=200), max_size=20),
)
def test_every_message_is_short_and_printable(text, names):
    try:
        parse(text, names=names)
    except FormulaError as error:
        assert all(line.isprintable() for line in str(error).split("\n"))
        assert str(error).count("\n") == 2
        assert len(str(error)) <= 900


def test_no_names_at_all():
    assert "no names are defined yet" in str(fail("A", names=[]))


def test_line_column_and_caret():
    error = fail("F_[0:5](A) &\n  (B | ) & C")
    assert isinstance(error, UserError)
    assert (error.line, error.column, error.offset) == (2, 8, 20)
    assert error.expected == OPERAND
    assert error.caret == "  (B | ) & C\n       ^"
    assert str(error) == f"line 2, column 8: unexpected ')'; expected {OPERAND}\n{error.caret}"


@pytest.mark.parametrize("position", [10, 500, 995])
def test_the_caret_of_a_long_line_is_an_excerpt(position):
    text = "A" * position + "?" + "B" * (1000 - position)
    excerpt, caret = fail(text).caret.split("\n")
    assert len(excerpt) <= 90
    assert excerpt[caret.index("^")] == "?"


def test_control_characters_do_not_shift_the_caret():
    error = fail("A\t&\r\t?")
    assert error.caret == "A & " + " ?\n" + " " * 5 + "^"


@settings(deadline=None, max_examples=300)
@given(st.text(max_size=60) | st.text("FGU_[]{}():,0159.s m&|!~-><=AB\"'\\/$\n", max_size=60))
@example("F_[0:1]\\")
@example("\\mathbf{F}")
def test_any_text_parses_or_is_refused_with_a_place(text):
    try:
        formula = parse(text, dt=DT)
    except FormulaError as error:
        assert 1 <= error.line <= text.count("\n") + 1
        assert 0 <= error.offset <= len(text)
        excerpt, caret = error.caret.split("\n")
        assert caret.strip() == "^" and len(caret) <= len(excerpt) + 1
    else:
        assert isinstance(formula, Formula)
        assert parse(to_text(formula)) == formula


@settings(deadline=None, max_examples=200)
@given(formulas(max_depth=3), st.data())
def test_damaged_formulas_parse_or_are_refused(formula, data):
    text = to_text(formula)
    start = data.draw(st.integers(0, len(text)))
    stop = data.draw(st.integers(start, min(len(text), start + 3)))
    damaged = (
        text[:start] + data.draw(st.sampled_from(["", "(", ")", "[", "U", "&", "5"])) + text[stop:]
    )
    try:
        survivor = parse(damaged)
    except FormulaError as error:
        assert str(error).startswith(f"line {error.line}, column {error.column}: ")
    else:
        assert parse(to_text(survivor)) == survivor
