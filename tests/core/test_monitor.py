"""Signals of subformulas, the verdict in words, and where tasks stand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.decompose import Kind, decompose
from core.errors import UserError
from core.monitor import (
    FailureSignals,
    LeafStatus,
    Signals,
    diagnose,
    leaf_status,
    monitor_rows,
)
from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    TraceError,
    Until,
    horizon,
    parse,
    robustness,
    walk,
)
from tests.core.stl.reference import reference_robustness
from tests.strategies import ATOMS, formulas, nested_formulas, traces

FORMULAS = formulas(max_depth=3) | nested_formulas(max_depth=4, max_bound=3)
DT = 0.2


def table(**signals) -> tuple[np.ndarray, list[str]]:
    return np.stack([np.asarray(s, float) for s in signals.values()], axis=1), list(signals)


def near(step: int, steps: int, best: float = -0.31) -> np.ndarray:
    """Outside everywhere, nearest at one step."""
    return best - 0.1 * np.abs(np.arange(steps) - step)


def visit(first: int, last: int, steps: int, depth: float = 0.1) -> np.ndarray:
    signal = np.full(steps, -1.0)
    signal[first : last + 1] = depth
    return signal


def says(formula: str, margins, names) -> str:
    return diagnose(parse(formula, names=names), margins, names, DT).sentence


def test_rows_are_in_tree_order_with_text_depth_and_windows():
    margins, names = table(A=visit(3, 5, 40), B=visit(8, 20, 40))
    formula = parse("F_[0:10](A & F_[2:4](B)) & G_[0:20](!A) & (!A)U_[3:5](B)", names=names)
    rows = monitor_rows(formula, margins, names)
    assert [(row.text, row.depth, row.windows) for row in rows] == [
        ("F_[0:10](A & F_[2:4](B)) & G_[0:20](!A) & (!A)U_[3:5](B)", 0, ((0, 0),)),
        ("F_[0:10](A & F_[2:4](B))", 1, ((0, 0),)),
        ("A & F_[2:4](B)", 2, ((0, 10),)),
        ("A", 3, ((0, 10),)),
        ("F_[2:4](B)", 3, ((0, 10),)),
        ("B", 4, ((2, 14),)),
        ("G_[0:20](!A)", 1, ((0, 0),)),
        ("!A", 2, ((0, 20),)),
        ("(!A)U_[3:5](B)", 1, ((0, 0),)),
    ]
    assert rows[1].interval == Interval(0, 10)
    assert rows[3].interval is None
    assert rows[5].signal.tolist() == margins[:, 1].tolist()


def test_windows_of_a_repeated_subformula_stay_apart_where_they_are():
    margins, names = table(A=np.ones(30))
    rows = monitor_rows(
        parse("F_[0:2](A) & G_[10:12](A) & F_[3:4](A)", names=names), margins, names
    )
    assert [row.windows for row in rows if row.text == "A"] == [((0, 4), (10, 12))]


def test_signals_end_where_the_trace_no_longer_decides():
    margins, names = table(A=np.arange(5.0))
    rows = monitor_rows(parse("F_[0:9](G_[0:2](A))", names=names), margins, names)
    assert [row.signal.tolist() for row in rows] == [[], [0, 1, 2], [0, 1, 2, 3, 4]]


@settings(max_examples=60, deadline=None)
@given(FORMULAS, st.data())
def test_signals_are_the_semantics_of_every_subformula(formula: Formula, data):
    margins = data.draw(traces(horizon(formula) + 2))
    signals = Signals(margins, ATOMS)
    for node in walk(formula):
        length = len(margins) - horizon(node)
        expected = [reference_robustness(node, margins, ATOMS, t) for t in range(length)]
        assert signals[node].tolist() == expected


def hopeful(formula: Formula, positive: bool = True) -> Formula:
    """Atoms renamed by the sign of their place, so that each can be given its best future."""

    def same(operand: Formula) -> Formula:
        return hopeful(operand, positive)

    match formula:
        case Atom(name=name):
            return Atom(("p" if positive else "n") + name)
        case Not(operand=operand):
            return Not(hopeful(operand, not positive))
        case And(operands=operands):
            return And(tuple(map(same, operands)))
        case Or(operands=operands):
            return Or(tuple(map(same, operands)))
        case Implies(left=left, right=right):
            return Implies(hopeful(left, not positive), same(right))
        case Eventually(interval=interval, operand=operand):
            return Eventually(interval, same(operand))
        case Always(interval=interval, operand=operand):
            return Always(interval, same(operand))
        case Until(interval=interval, left=left, right=right):
            return Until(interval, same(left), same(right))
    return formula


@settings(max_examples=60, deadline=None)
@given(FORMULAS, st.data())
def test_the_failure_step_is_the_first_that_no_future_mends(formula: Formula, data):
    margins = data.draw(traces(horizon(formula) + 1))
    names = ["p" + name for name in ATOMS] + ["n" + name for name in ATOMS]

    def mendable(step: int) -> bool:
        """Whether the best future after a step satisfies the formula."""
        past = np.arange(len(margins))[:, None] <= step
        futures = [np.where(past, margins, best) for best in (9.0, -9.0)]
        return bool(robustness(hopeful(formula), np.concatenate(futures, axis=1), names) >= 0)

    failed = FailureSignals(margins, ATOMS)[formula][0]
    first = next((t for t in range(-1, len(margins)) if not mendable(t)), np.inf)
    assert failed == (first if first >= 0 else -np.inf)


@settings(max_examples=150, deadline=None)
@given(FORMULAS, st.data())
def test_the_sentence_agrees_with_the_verdict(formula: Formula, data):
    margins = data.draw(traces(horizon(formula) + 1, ties=data.draw(st.booleans())))
    found = diagnose(formula, margins, ATOMS, DT)
    value = robustness(formula, margins, ATOMS)
    assert found.robustness == value
    assert found.satisfied == (value >= 0)
    assert found.sentence.startswith("Satisfied" if value >= 0 else "Violated: ")
    if found.step is not None:
        assert 0 <= found.step < len(margins)
    if found.satisfied and found.atom is not None:
        assert abs(margins[found.step, ATOMS.index(found.atom)]) == value


def test_an_obstacle_that_was_hit():
    depth = np.full(101, -0.5)
    depth[37:42] = [0.02, 0.12, 0.1, 0.05, 0.01]
    margins, names = table(B5=depth, A=np.ones(101))
    assert says("F_[0:9](A) & G_[0:100](!B5)", margins, names) == (
        "Violated: the robot was in B5 during steps 37-41 (7.4-8.2 s), up to 0.12 m deep, "
        "but G_[0:100](!B5) forbids it."
    )
    depth[38:42] = -0.5
    margins, names = table(B5=depth)
    found = diagnose(parse("!F_[0:100](B5)", names=names), margins, names, DT)
    assert found.sentence == (
        "Violated: the robot was in B5 at step 37 (7.4 s), 0.02 m deep, "
        "but !F_[0:100](B5) forbids it."
    )
    assert (found.step, found.atom) == (37, "B5")


def test_a_goal_that_was_missed():
    margins, names = table(A2=near(62, 101))
    assert says("F_[40:80](A2)", margins, names) == (
        "Violated: A2 was never reached between steps 40 and 80 (8-16 s); "
        "the robot came closest at step 62 (12.4 s), 0.31 m away."
    )
    assert "A2 was never left between steps 1 and 3" in says("F_[1:3](!A2)", -margins, names)
    assert says("F_[62:62](A2)", margins, names) == (
        "Violated: the robot was outside A2 at step 62 (12.4 s), 0.31 m away, "
        "but F_[62:62](A2) requires it to be inside."
    )


def test_what_failed_first_comes_first():
    # The goal's window closes at step 20, after B at 15 and before C at 30.
    margins, names = table(A=near(5, 50), B=visit(15, 15, 50), C=visit(30, 30, 50, 3.0))
    assert "in B at step 15" in says("F_[0:20](A) & G_[0:40](!B) & G_[0:40](!C)", margins, names)
    assert "A was never reached" in says("G_[0:40](!C) & F_[0:20](A)", margins, names)
    assert "in C at step 30" in says("F_[0:35](A) & G_[0:40](!C)", margins, names)


def test_a_stay_that_was_left_too_early():
    margins, names = table(A2=visit(44, 46, 120), A3=visit(56, 62, 120))
    formula = "F_[40:80](A2 & F_[10:20](G_[0:10](A3)))"
    assert says(formula, margins, names) == (
        "Violated: in the closest attempt (step 56), the robot was outside A3 during steps 63-66 "
        "(12.6-13.2 s), up to 1.00 m away, but G_[0:10](A3) requires it to be inside."
    )


def test_attempts_name_the_start_of_each():
    signal = visit(44, 46, 120)
    margins, names = table(A2=signal, A3=visit(50, 80, 120), A4=visit(52, 60, 120))
    found = says("F_[40:70](A2 & G_[10:12](A3) & F_[20:22](A4))", margins, names)
    assert found.startswith("Violated: in the closest attempt (step 44), A4 was never reached")


def test_until_fails_early_or_never_arrives():
    margins, names = table(D=visit(20, 21, 60), K=visit(30, 40, 60))
    assert says("(!D)U_[0:50](K)", margins, names) == (
        "Violated: the robot was in D during steps 20-21 (4-4.2 s), up to 0.10 m deep, before K "
        "was reached, but (!D)U_[0:50](K) forbids it."
    )
    assert "K was never reached between steps 0 and 15" in says("(!D)U_[0:15](K)", margins, names)
    assert says("!(K U_[0:50](D)) & !((!D)U_[5:9](!K))", margins, names) == (
        "Violated: !D held until !K held at step 5 (1 s), but !((!D)U_[5:9](!K)) forbids it."
    )
    assert "F_[0:3](K) failed before D was reached: K was never reached" in says(
        "(F_[0:3](K))U_[0:30](D)", margins, names
    )


def test_disjunctions_and_implications():
    margins, names = table(A=near(9, 60), B=visit(20, 20, 60), C=visit(5, 6, 60))
    assert says("F_[0:30](A) | G_[0:20](!C)", margins, names) == (
        "Violated: every alternative of F_[0:30](A) | G_[0:20](!C) failed; in the closest, the "
        "robot was in C during steps 5-6 (1-1.2 s), up to 0.10 m deep, but G_[0:20](!C) forbids it."
    )
    assert says("G_[0:40](B -> F_[0:5](C))", margins, names) == (
        "Violated: when the robot was in B at step 20 (4 s), C was never reached between steps 20 "
        "and 25 (4-5 s); the robot came closest at step 20 (4 s), 1.00 m away."
    )


def test_state_formulas():
    margins, names = table(A=[-0.2, 1], B=[-0.1, -0.1])
    assert says("A | B", margins, names) == (
        "Violated: A | B did not hold at step 0 (0 s), missing by 0.10 m."
    )
    assert "outside A at step 0" in says("A & B", margins, names)
    assert says("F_[0:1](!A | B)", np.array([[0.2, -0.1], [1.0, -0.1]]), names) == (
        "Violated: !A | B never held between steps 0 and 1 (0-0.2 s); "
        "it came closest at step 0 (0 s), missing by 0.10 m."
    )


def test_satisfied_names_the_closest_call():
    margins, names = table(A=visit(50, 70, 101, 0.3), B=near(37, 101, -0.08))
    found = diagnose(parse("F_[40:80](A) & !F_[0:100](B)", names=names), margins, names, DT)
    assert found.sentence == (
        "Satisfied; the tightest margin is 0.08 m from B at step 37 (7.4 s), for !F_[0:100](B)."
    )
    assert (found.step, found.atom) == (37, "B")
    assert says("F_[40:80](A)", margins, names) == (
        "Satisfied; the tightest margin is 0.30 m inside A at step 50 (10 s)."
    )
    assert says("F_[40:80](A)", 0 * margins, names).startswith(
        "Satisfied; the tightest margin is 0 m inside A"
    )
    assert says("(!B)U_[0:60](A)", margins, names).startswith(
        "Satisfied; the tightest margin is 0.08 m from B"
    )
    assert says("!((!A)U_[0:49](B))", margins, names) == (
        "Satisfied; the tightest margin is 0.08 m from B at step 37 (7.4 s)."
    )


def test_constants():
    margins, names = table(A=[1.0, 1.0])
    assert says("true", margins, names) == "Satisfied: the formula holds whatever the robot does."
    for text in ("false", "F_[0:1](false)", "A & G_[0:1](false)"):
        assert says(text, margins, names) == "Violated: the formula fails whatever the robot does."


def test_a_broken_simulation_is_no_success():
    margins, names = table(A=[1.0, np.nan, 1.0])
    found = diagnose(parse("F_[0:2](A)", names=names), margins, names, DT)
    assert not found.satisfied
    assert "broke down" in found.sentence
    assert found.step == 1


def diagnosed(formula: Formula, margins: np.ndarray, names: list[str]):
    return diagnose(formula, margins, names, DT)


def test_long_names_and_control_marks_are_kept_out_of_sentences():
    for name in ("L" * 9000, "a\x1b[31mb\n" * 10):
        formula, margins = (
            Always(Interval(0, 1), And((Atom(name), Not(Atom("B"))))),
            np.zeros((2, 2)),
        )
        margins[:, 0] = -1.0
        sentence = diagnose(formula, margins, [name, "B"], DT).sentence
        assert sentence.isprintable() and len(sentence) < 300
        with pytest.raises(TraceError) as refused:
            diagnose(formula, margins[:, :1], ["B"], DT)
        assert str(refused.value).isprintable() and len(str(refused.value)) < 200


@pytest.mark.parametrize("call", [diagnosed, monitor_rows])
def test_unknown_atoms_and_wrong_shapes_are_refused(call):
    with pytest.raises(TraceError, match="no margins for B; it has A"):
        call(parse("F_[0:1](B)"), np.zeros((5, 1)), ["A"])
    with pytest.raises(TraceError, match="shape"):
        call(parse("F_[0:1](A)"), np.zeros((5, 2, 1)), ["A"])


def test_a_short_trace_has_no_verdict():
    with pytest.raises(
        UserError, match="has 5 steps; the formula looks 5 steps ahead and needs at least 6"
    ):
        diagnose(parse("F_[0:5](A)"), np.zeros((5, 1)), ["A"], DT)


def test_leaves_go_from_pending_to_met_or_violated():
    margins, names = table(A=visit(3, 5, 12), B=visit(6, 6, 12), C=visit(8, 12, 12))
    found = decompose(parse("F_[0:5](A) & G_[2:8](!B) & F_[0:9](G_[0:2](C))", names=names))
    assert [task.kind for task in found.tasks] == [Kind.REACH, Kind.INVARIANT, Kind.STAY]
    status = leaf_status(found, (4, 8), margins, names)
    letters = ["".join("-PHMV"[value] for value in row) for row in status]
    assert letters == ["PPPPMMMMMMMM", "PPHHHHVVVVVV", "PPPPPPPPHHMM"]
    assert leaf_status(found, (2, 0, 0, 0), margins, names)[0].tolist() == [1, 1] + [4] * 10


def test_leaves_of_other_branches_are_inactive_and_empty_windows_met():
    margins, names = table(A=np.ones(8), B=-np.ones(8))
    found = decompose(parse("F_[0:3](A) | G_[0:3](B)", names=names))
    branch = next(i for i, v in enumerate(found.variables) if v.kind == "branch")
    taken = [0] * len(found.variables)
    status = leaf_status(found, taken, margins, names)
    assert set(status[1].tolist()) == {LeafStatus.INACTIVE}
    taken[branch] = 1
    status = leaf_status(found, taken, margins, names)
    assert set(status[0].tolist()) == {LeafStatus.INACTIVE}
    assert set(status[1].tolist()) == {LeafStatus.VIOLATED}
    negated = decompose(parse("!(A U_[0:3](B))", names=names))
    schedule = [1, 0]
    windows = [(start, end) for _, start, end in negated.active_tasks(schedule)]
    empty = next(i for i, (start, end) in enumerate(windows) if start > end)
    index = negated.tasks.index(negated.active_tasks(schedule)[empty][0])
    assert set(leaf_status(negated, schedule, margins, names)[index].tolist()) == {LeafStatus.MET}


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_all_leaves_are_met_exactly_when_the_schedule_is_carried_out(data):
    texts = ["F_[0:3](A & F_[1:2](B)) & G_[0:4](!C)", "(!C)U_[0:3](A) | F_[2:4](G_[0:1](B))"]
    found = decompose(parse(data.draw(st.sampled_from(texts)), names=ATOMS))
    schedule = data.draw(st.sampled_from(list(found.schedules())))
    margins = data.draw(traces(found.horizon + 1)) + 1
    status = leaf_status(found, schedule, margins, ATOMS)
    carried_out = all(
        reference_robustness(task.predicate, margins, ATOMS, t) >= 0
        for task, start, end in found.active_tasks(schedule)
        for t in range(start, end + 1)
    )
    final = {value for value in status[:, -1].tolist() if value != LeafStatus.INACTIVE}
    assert (final <= {LeafStatus.MET}) == carried_out
    assert (np.diff(status, axis=1) >= 0).all()
    if carried_out:
        assert robustness(found.formula, margins, ATOMS) >= 0
