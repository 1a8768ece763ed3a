"""Exact plans against brute force over lattices of traces, and against known optima."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from core.planning.exact import TOLERANCE, Setting, plan_exactly
from core.planning.watch import Watch
from core.stl import horizon, parse, robustness
from scenes.outlines import margins_of, outline_of
from scenes.regions import Region
from tests.strategies import ATOMS, formulas

REGIONS = (
    Region("A", "rectangle", (1.0, 0.5), (0.5, 1.0)),
    Region("B", "rectangle", (-0.5, 1.0), (1.0, 0.5)),
    Region("C", "circle", (0.5, -1.0), (0.75,)),
)
BAR = Region("D", "rectangle", (0.5, 1.0), (1.5, 0.3), angle=25.0)
KITE = Region("E", "polygon", points=((0, 3), (-1, 0), (0, -0.5), (2, 0.5)))
STRIDE = 0.5
SECONDS = 20.0


def setting(start=(0.0, 0.0), regions=REGIONS) -> Setting:
    return Setting(
        np.array(start, float),
        np.full(2, STRIDE),
        lambda directions: {region.name: outline_of(region, directions) for region in regions},
        lambda positions: margins_of(regions, positions),
    )


def exact(formula, positions, regions=REGIONS):
    """Robustness by the evaluator of `core.stl`."""
    margins = np.stack(list(margins_of(regions, positions).values()), -1)
    return float(robustness(formula, margins, [region.name for region in regions]))


def lattice(steps: int) -> np.ndarray:
    """Margins [P, steps + 1, A] of all traces whose moves are full strides or none."""
    moves = np.array(list(product((-STRIDE, 0.0, STRIDE), repeat=2)))
    traces = np.zeros((1, 1, 2))
    for _ in range(steps):
        following = traces[:, None, -1] + moves
        grown = np.repeat(traces, len(moves), axis=0)
        traces = np.concatenate([grown, following.reshape(-1, 1, 2)], axis=1)
    flat = margins_of(REGIONS, traces.reshape(-1, 2))
    return np.stack(list(flat.values()), -1).reshape(*traces.shape[:2], -1)


LATTICE = lattice(4)


@settings(max_examples=150, deadline=None)
@given(formulas(3, max_bound=2, constants=False))
@example(parse("!A -> (!A)U_[0:0](G_[1:2](C))"))  # at rest, its trace is more robust
def test_no_trace_of_a_lattice_is_more_robust(formula):
    assume(horizon(formula) <= 4)
    best = float(np.max(robustness(formula, LATTICE, ATOMS)))
    found = plan_exactly(formula, setting(), seconds=SECONDS)
    if found.status == "infeasible":
        assert best < 0
        return
    if found.status == "unknown":  # what holds on a boundary at best may stay open
        assert best <= 1e-6 and found.bound <= TOLERANCE
        return
    assert found.positions is not None
    assert found.robustness == pytest.approx(exact(formula, found.positions), abs=1e-9)
    assert 0 <= found.robustness <= found.bound + 1e-6
    assert found.bound >= best - 1e-6
    if found.status == "optimal":
        assert found.robustness >= best - TOLERANCE
    moved = np.abs(np.diff(found.positions, axis=0))
    assert (moved <= STRIDE + 1e-6).all()
    assert found.positions[0] == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("text", "optimum"),
    [
        ("F_[0:9](A)", 0.5),  # the middle of the rectangle
        ("F_[2:2](A)", 0.5),  # two strides to the right are enough
        ("F_[1:1](A)", 0.0),  # one leads to its edge
        ("F_[0:9](A & C)", None),  # the rectangle meets the disc: something between
        ("G_[0:3](!A)", 0.5),  # as far as the start
        ("G_[3:3](!A)", 5**0.5),  # three strides to (-1.5, -1.5); the corner is at (0.5, -0.5)
        ("G_[3:3](!C)", 2.5 * 1.28062 - 0.75),  # to (-1.5, 1.5), from the centre at (0.5, -1)
        ("!((!C) U_[3:3] (A))", 5**0.5),
        ("!((!A) U_[2:2] (C))", 1.75),  # away from C, to (-1, 1)
        ("(!A) U_[0:9] (B)", 0.5),
    ],
)
def test_known_optima(text, optimum):
    found = plan_exactly(parse(text), setting(), seconds=SECONDS)
    assert found.status == "optimal"
    if optimum is not None:
        assert found.robustness == pytest.approx(optimum, abs=TOLERANCE)


@pytest.mark.parametrize(
    "text",
    [
        "G_[0:0](A)",  # the start is outside
        "G_[1:1](B) & G_[2:2](C)",  # there is no time
        "F_[0:9](B & C)",
        "G_[2:4](C) & F_[3:3](B)",
        "false",
    ],
)
def test_infeasible_is_proved(text):
    found = plan_exactly(parse(text), setting(), seconds=SECONDS)
    assert (found.status, found.positions, found.bound) == ("infeasible", None, -np.inf)


def test_what_holds_at_its_boundary_only_is_not_called_infeasible():
    found = plan_exactly(parse("G_[1:1](A)"), setting(), seconds=SECONDS)
    assert found.status != "infeasible"
    assert found.bound == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("gap", [0.002, 0.006])
def test_a_narrow_way_is_not_overlooked(gap):
    """Polygons around the discs close it, polygons in them open it too far."""
    discs = [Region(f"D{i}", "circle", (0.75, y), (1.0,)) for i, y in enumerate((-1.0, 1.0 + gap))]
    regions = (Region("A", "rectangle", (1.75, 0.0), (0.5, 0.5)), *discs)
    formula = parse("F_[0:5](A) & G_[0:5](!D0 & !D1)")
    found = plan_exactly(formula, setting((-0.75, gap / 2), regions), seconds=SECONDS)
    assert found.status == "optimal"
    assert 0 <= found.robustness <= found.bound + 1e-6


def test_a_limit_of_time_leaves_bounds():
    walls = [Region(f"W{i}", "circle", (i - 2.0, 1.0), (0.4,)) for i in range(5)]
    regions = (Region("A", "circle", (0.5, 2.5), (0.5,)), *walls)
    text = "F_[0:14](A) & G_[0:14](" + " & ".join(f"!{wall.name}" for wall in walls) + ")"
    found = plan_exactly(parse(text), setting(regions=regions), seconds=0.02)
    assert found.bound >= max(found.robustness, 0)
    more = plan_exactly(parse(text), setting(regions=regions), seconds=1.5)
    assert more.robustness >= found.robustness
    assert more.bound <= found.bound + 1e-6


def test_a_mirrored_scene_has_the_same_optimum():
    mirrored = tuple(replace(r, center=(-r.center[0], r.center[1])) for r in REGIONS)
    formula = parse("F_[0:6](C) & F_[3:8](B) & G_[0:8](!A)")
    one = plan_exactly(formula, setting(), seconds=SECONDS)
    other = plan_exactly(formula, setting(regions=mirrored), seconds=SECONDS)
    assert one.status == other.status
    assert one.bound == pytest.approx(other.bound, abs=TOLERANCE)


@settings(max_examples=100, deadline=None)
@given(
    st.sampled_from((*REGIONS, BAR, KITE)),
    st.sampled_from((8, 16, 64)),
    st.tuples(st.floats(-4, 4), st.floats(-4, 4)),
)
def test_outlines_enclose_the_distance(region, directions, position):
    outline = outline_of(region, directions)
    distance = -margins_of([region], np.array([position]))[region.name][0]
    lower, upper = (
        side.values(np.array(position)).max() for side in (outline.lower, outline.upper)
    )
    assert lower - 1e-9 <= distance <= upper + 1e-9
    nearest = np.linalg.norm(np.subtract(position, region.center))
    assert upper - lower <= 2 * (1 / np.cos(2 * np.pi / directions) - 1) * nearest + 1e-9 or (
        region.kind != "circle"
    )


def test_a_turned_wall_is_passed_by():
    """The goal is behind a bar; its bounding box would leave no way in time."""
    bar = Region("D", "rectangle", (1.5, 0.0), (1.5, 0.1), angle=45.0)
    goal = Region("A", "rectangle", (2.0, -0.5), (0.4, 0.4))
    formula = parse("F_[0:6](A) & G_[0:6](!D)")
    found = plan_exactly(formula, setting(start=(1.0, -1.0), regions=(bar, goal)), seconds=SECONDS)
    assert found.status == "optimal"
    assert found.positions is not None
    assert found.robustness == pytest.approx(exact(formula, found.positions, (bar, goal)))


def test_a_search_that_is_stopped_tells_what_it_has():
    formula, watch = parse("F_[0:6](A) & F_[0:9](C) & G_[0:9](!B)"), Watch()
    watch.stop.set()
    found = plan_exactly(formula, setting(), watch=watch)
    assert found.status in ("unknown", "feasible", "optimal")
    assert found.bound == watch.bound
    assert found.bound >= plan_exactly(formula, setting(), seconds=SECONDS).robustness


def test_the_robot_rests_once_nothing_depends_on_it():
    formula = parse("F_[0:4](A) & G_[0:40](!C)")
    found = plan_exactly(formula, setting(), seconds=SECONDS)
    assert found.status == "optimal" and found.positions is not None
    assert np.ptp(found.positions[5:], axis=0).max() == 0.0
    assert found.robustness == pytest.approx(exact(formula, found.positions))
