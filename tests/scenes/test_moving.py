"""Regions that move: margins, ways, verdicts, and what is said before training."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.between import between, between_margins
from core.errors import UserError
from core.evaluation import verdicts
from core.stl import horizon
from core.task.later import later, past_margins
from core.task.problem import atom_margins, data_at, trace_margins
from core.task.sites import center_at, inside_at
from core.task.windows import leg_slack, windows_of
from scenes import Region, Scene, load_task, parse_scene
from scenes.distances import margin_of
from scenes.motion import Motion, along
from scenes.outlines import setting_of
from studio.gym.environment import StlEnv
from studio.runs.findings import findings_of
from studio.runs.layouts import held_out
from studio.runs.tasks import build_task
from tests.scenes.test_motion import VELOCITY

TRIANGLE = ((0.0, 0.0), (2.0, 0.0), (0.0, 1.0))
PATH = Motion((4, 14, 20), ((0.0, 0.0), (2.0, -1.0), (0.0, 2.0)))
START = Region("initial", "circle", (-3.0, 0.0), (0.2,))


def planar(*regions: Region, formula: str, **changes) -> Scene:
    changes = {"initial": START, "horizon": 20} | changes
    return replace(load_task("linear-01"), regions=regions, formula=formula, **changes)


@pytest.fixture(scope="module")
def case():
    """The shared case of a velocity."""
    return build_task(parse_scene(VELOCITY, "f"))


def random_traces(steps: int, count: int = 40) -> np.ndarray:
    """[L + 1, R, 2]."""
    return np.random.default_rng(1).uniform(-4, 4, (steps + 1, count, 2)).astype(np.float32)


def rectangle_margin(states: np.ndarray) -> np.ndarray:
    """Of the rectangle of half side 0.6 that begins at 0 and moves 0.1 m a step [L + 1, R]."""
    centers = np.stack([0.1 * np.arange(len(states)), np.zeros(len(states))], 1)
    excess = np.abs(states - centers[:, None]) - 0.6
    outside = np.linalg.norm(np.maximum(excess, 0.0), axis=-1)
    return -(outside + np.minimum(excess.max(-1), 0.0))


def test_margins_are_those_of_the_moved_rectangle(case):
    states = random_traces(32)
    margins = np.asarray(trace_margins(case.problem, jnp.asarray(states)))
    np.testing.assert_allclose(margins[..., 1], rectangle_margin(states), atol=2e-6)
    goal = 0.6 - np.linalg.norm(states - 2.0, axis=-1)
    np.testing.assert_allclose(margins[..., 0], goal, atol=2e-6)


def test_verdicts_are_the_brute_force_of_the_formula(case):
    states = random_traces(32, 3000)
    states[:, :, :] = np.cumsum(0.15 * states / 4, 0) - 3 * (np.arange(33) < 33)[:, None, None]
    states += np.linspace(0, 5, 33, dtype=np.float32)[:, None, None]
    margins = np.asarray(trace_margins(case.problem, jnp.asarray(states)))
    goal = (0.6 - np.linalg.norm(states[:31] - 2.0, axis=-1)).max(0)
    wanted = np.minimum(goal, (-rectangle_margin(states[:31])).min(0))
    found = verdicts(case, states, margins)
    np.testing.assert_allclose(found, wanted, atol=3e-6)
    assert 0.02 < (found >= 0).mean() < 0.98


def test_all_kinds_move_and_compound_predicates_with_them():
    box = Region("R", "rectangle", (0.3, 0.2), (0.5, 0.1), angle=30.0, motion=PATH)
    union = Region(
        "U",
        "union",
        parts=(
            Region("U", "circle", (1.0, 1.0), (0.4,)),
            Region("U", "polygon", points=TRIANGLE),
        ),
        motion=along([-0.1, 0.05], 2),
    )
    polygon = Region("P", "polygon", points=TRIANGLE, motion=PATH)
    standing = Region("S", "circle", (1.0, 0.0), (0.8,))
    regions = (box, union, polygon, standing)
    task = build_task(planar(*regions, formula="F_[0:20](R | (U & !S)) & G_[0:9](!P | S)"))
    states = random_traces(20)
    extended = jax.vmap(lambda row: past_margins(task.problem, row), 1, 1)(jnp.asarray(states))
    margins = np.asarray(extended)
    truth = np.stack(
        [
            [margin_of(region.displaced(step), states[step].astype(float)) for region in regions]
            for step in range(21)
        ]
    ).transpose(0, 2, 1)
    np.testing.assert_allclose(margins[..., :4], truth, atol=1e-5)
    r, u, p, s = np.moveaxis(truth, -1, 0)
    for compound in (np.maximum(r, np.minimum(u, -s)), np.maximum(-p, s)):
        gaps = np.abs(margins - compound[..., None]).max((0, 1))
        assert gaps.min() < 1e-5


def test_prisms_move_upwards_too():
    prism = Region(
        "P", "prism", points=TRIANGLE, z=(0.2, 1.0), motion=Motion((0, 10), ((0,) * 3, (1, 0, 2)))
    )
    ball = Region("B", "sphere", (0.0, 0.0, 1.0), (0.5,))
    scene = replace(
        load_task("quadrotor-01"),
        regions=(prism, ball),
        formula="F_[0:20](P) & F_[0:20](B)",
        horizon=20,
        initial=Region("initial", "sphere", (-1.0, 0.0, 1.0), (0.1,)),
    )
    task = build_task(scene)
    positions = np.random.default_rng(0).uniform(-2, 3, (50, 3)).astype(np.float32)
    states = np.asarray(jax.vmap(lambda p: task.robot.rest(jax.random.key(0), p))(positions))
    for step in (0, 5, 7.5, 10, 30):
        margins = jax.vmap(lambda state, step=step: atom_margins(task.problem, state, step)[0])
        truth = margin_of(prism.displaced(step), positions.astype(float))
        np.testing.assert_allclose(np.asarray(margins(jnp.asarray(states)))[:, 0], truth, atol=1e-5)


def test_margins_without_a_step_are_refused_where_regions_move(case):
    state = jnp.zeros(2)
    with pytest.raises(ValueError, match="regions move"):
        atom_margins(case.problem, state)
    with pytest.raises(ValueError, match="regions move"):
        case.problem.world.margins(case.problem.data, state)
    with pytest.raises(ValueError, match="regions move"):
        case.problem.world.field(case.problem.data, 0, state)


def test_nothing_is_added_to_problems_in_which_nothing_moves():
    problem = build_task(load_task("linear-01")).problem
    assert problem.sites is None and problem.data.paths is None and problem.data.step is None
    assert data_at(problem, None) is problem.data


@pytest.fixture(scope="module")
def chase():
    """A goal that moves, on this side of a wall that stands and beyond."""
    goal = Region("A", "circle", (-2.0, -3.0), (0.5,), motion=Motion((0, 20), ((0, 0), (4, 4))))
    wall = Region("W", "rectangle", (0.0, 2.0), (0.2, 2.0))
    return build_task(planar(goal, wall, formula="F_[0:20](A) & G_[0:20](!W)"))


@pytest.mark.parametrize("step", [0, 3, 10, 19, 32])
def test_the_way_to_a_moving_goal_is_that_to_where_it_is_then(chase, step):
    problem = chase.problem
    goal = Region("A", "circle", (-2.0, -3.0), (0.5,))
    share = min(step / 20, 1.0)
    standing = goal.at((-2 + 4 * share, -3 + 4 * share))
    wall = Region("W", "rectangle", (0.0, 2.0), (0.2, 2.0))
    still = build_task(planar(standing, wall, formula="F_[0:20](A) & G_[0:20](!W)")).problem
    positions = jnp.asarray(np.random.default_rng(2).uniform(-4, 4, (60, 2)), jnp.float32)
    there, first = data_at(problem, jnp.float32(step)), jnp.int32(0)
    found = jax.vmap(lambda p: problem.world.field(there, first, p)[0])(positions)
    wanted = jax.vmap(lambda p: still.world.field(still.data, first, p)[0])(positions)
    # within a cell of the grid, 0.25 m: the wall appears moved by half a cell at most
    np.testing.assert_allclose(found, wanted, atol=0.3)
    center = center_at(problem.sites, jnp.int32(0), jnp.float32(step))
    np.testing.assert_allclose(center, standing.center, atol=0.2)


def test_positions_in_a_moving_goal_lie_in_it_at_their_step(chase):
    problem = chase.problem
    for step in (0, 4, 7, 13, 20):
        at = jnp.float32(step)
        inside = [inside_at(problem.sites, jnp.int32(0), jnp.int32(i), at) for i in range(16)]
        margin = [float(atom_margins(problem, position, at)[0][0]) for position in inside]
        assert min(margin) >= -1e-5


def test_a_leg_is_as_long_as_the_way_to_where_the_goal_will_be(chase):
    def slack(time: int) -> float:
        schedule = np.zeros(chase.problem.formula.low.shape, np.int32)
        schedule[0] = time
        windows = windows_of(chase.problem, jnp.asarray(schedule))
        return float(leg_slack(chase.problem, windows, jnp.array([2.0, -1.0]), 1.0)[0][0])

    robot, start = chase.robot, np.array([2.0, -1.0])
    for time in (5, 10, 20):
        place = np.array([-2.0, -3.0]) + 4 * time / 20
        way = np.linalg.norm(place - start) - 0.4  # 0.1 m inside the goal
        expected = time - way / robot.speed - robot.lag
        if place[0] > 0:  # no wall between
            assert slack(time) == pytest.approx(expected, abs=1.0)
    assert slack(20) > slack(5) + 10


def test_what_is_left_of_a_problem_goes_on_where_regions_have_come(case):
    state, rest = jnp.array([0.5, 1.0]), later(case.problem, 12)
    for step in (0, 3, 9):
        here, there = atom_margins(rest, state, step), atom_margins(case.problem, state, 12 + step)
        np.testing.assert_allclose(here[0], there[0], atol=1e-6)


def jumping_wall(*, between_steps: bool = False) -> Scene:
    """A wall of 0.04 m that crosses the place of the robot within one step."""
    wall = Region(
        "W", "rectangle", (1.0, 0.0), (0.02, 1.0), motion=Motion((5, 6), ((0, 0), (-2, 0)))
    )
    goal = Region("A", "circle", (0.0, 0.0), (0.5,))
    formula = "F_[0:10](A) & G_[0:10](!W)"
    start = Region("initial", "circle", (0.0, 0.0), (0.1,))
    return planar(
        wall, goal, formula=formula, horizon=10, initial=start, between_steps=between_steps
    )


def test_a_wall_that_jumps_over_a_standing_robot_is_seen():
    task = build_task(jumping_wall())
    standing = np.zeros((17, 3, 2), np.float32)
    standing[:, 1, 1] = 1.5  # beside the wall's way
    standing[:, 2] = [0.3, 0.0]
    margins = np.asarray(trace_margins(task.problem, jnp.asarray(standing)))
    assert (verdicts(task, standing, margins)[[0, 2]] >= 0).all()
    traces = standing.swapaxes(0, 1)
    np.testing.assert_array_equal(between_margins(task, traces) >= 0, [False, True, False])
    found = between(task, traces[0])
    assert not found.holds and found.step == 5 and found.share == pytest.approx(0.5, abs=0.02)
    assert found.margin == pytest.approx(-0.02, abs=1e-4)
    assert between(task, traces[1]).holds


def test_a_robot_that_goes_along_with_a_wall_is_not_touched():
    wall = Region("W", "rectangle", (1.0, 0.0), (0.02, 1.0), motion=along([-0.5, 0.0], 2))
    task = build_task(planar(wall, formula="G_[0:6](!W)", horizon=6))
    steps = np.arange(17, dtype=np.float32)
    trace = np.stack([0.9 - 0.5 * steps, 0 * steps], 1)
    assert between_margins(task, trace[None])[0] == pytest.approx(0.08, abs=1e-4)


def test_where_the_scene_asks_for_it_the_jump_counts_in_the_verdict():
    standing = np.zeros((17, 1, 2), np.float32)
    for asked in (False, True):
        task = build_task(jumping_wall(between_steps=asked))
        margins = np.asarray(trace_margins(task.problem, jnp.asarray(standing)))
        assert (verdicts(task, standing, margins)[0] >= 0) != asked


def test_the_swept_margin_is_that_of_a_fine_brute_force():
    scene = planar(
        Region("O", "polygon", points=TRIANGLE, motion=PATH),
        Region("B", "circle", (0.0, -1.0), (0.3,), motion=along([0.3, 0.1], 2)),
        formula="G_[0:16](!O) & G_[0:16](!B)",
        horizon=16,
    )
    task, region, ball = build_task(scene), *scene.regions
    traces = np.cumsum(np.random.default_rng(3).uniform(-0.5, 0.5, (6, 17, 2)), 1)
    fine = np.linspace(0, 16, 16 * 400 + 1)
    for trace in traces.astype(np.float32):
        ways = np.stack([np.interp(fine, np.arange(17), axis) for axis in trace.T], 1)
        worst = np.inf
        for each in (region, ball):
            assert each.motion is not None
            offset = each.motion.offset(fine)  # a still region, seen from the moving one
            worst = min(worst, float(-margin_of(each, ways - offset).max()))
        found = between(task, trace).margin
        assert (found >= 0) == (worst >= 0)
        assert found == pytest.approx(worst, abs=0.02)


def test_no_proof_takes_a_moving_region_for_one_that_stands():
    blocked = Region("O", "rectangle", (-3.0, 0.0), (1.0, 1.0))  # around the start
    standing = planar(blocked, formula="G_[5:20](!O)")
    far = replace(blocked, motion=Motion((0, 5), ((0, 0), (8, 8))))
    assert not any(finding.proved for finding in findings_of(planar(far, formula="G_[5:20](!O)")))
    goal = Region("A", "circle", (4.0, 4.0), (0.3,))
    assert any(f.proved for f in findings_of(planar(goal, formula="F_[0:5](A)")))
    comes = replace(goal, motion=Motion((0, 5), ((0, 0), (-6, -4))))
    assert not any(f.proved for f in findings_of(planar(comes, formula="F_[0:5](A)")))
    assert standing.moving == frozenset()


def test_warnings_of_goals_that_leave_and_obstacles_that_jump():
    leaves = Region("A", "circle", (4.0, 0.0), (0.5,), motion=along([0.5, 0.0], 2))
    fast = Region("O", "circle", (0.0, 4.0), (0.5,), motion=along([0.0, -1.0], 2))
    scene = planar(leaves, fast, formula="F_[0:20](A) & G_[0:20](!O)")
    words = " ".join(finding.words for finding in findings_of(scene))
    assert "A has left the arena at step 4" in words
    assert "O is 1.00 m thick, but it moves up to 1.00 m a step" in words
    slow = replace(fast, motion=along([0.0, -0.1], 2))
    calm = planar(replace(leaves, motion=None), slow, formula=scene.formula)
    assert not findings_of(calm)
    asked = findings_of(replace(scene, between_steps=True))
    assert "thick" not in " ".join(finding.words for finding in asked)


def test_what_does_not_know_paths_refuses_them(case):
    scene = parse_scene(VELOCITY, "f")
    with pytest.raises(UserError, match="exact plans are for regions that stand, but O moves"):
        setting_of(scene)
    from core.methods import METHODS

    algorithm = METHODS["tgpo-star"].preset("studio", case.robot)
    with pytest.raises(UserError, match="drawn of regions that stand, but O moves"):
        next(held_out(scene, case, algorithm, 1))


def test_the_gymnasium_environment_shows_margins_at_their_time():
    scene = parse_scene(VELOCITY, "f")
    environment = StlEnv(scene=scene)
    environment.reset(options={"position": (0.0, 2.0)})
    still, observed = np.zeros(2, np.float32), []
    for _ in range(environment.task.horizon):
        seen, _, ended, _, info = environment.step(still)
        observed.append(seen[-1])
    trace = np.tile(np.array([0.0, 2.0]), (31, 1, 1))
    np.testing.assert_allclose(observed, rectangle_margin(trace)[1:, 0], atol=1e-5)
    assert ended and not info["satisfied"] and horizon(environment.task.formula) == 30
