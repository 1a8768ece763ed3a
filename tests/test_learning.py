"""Learning on shipped tasks: success, determinism, and nothing compiled twice."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.candidates import choose_schedules
from core.evaluation import trace_robustness
from core.mdp.paper_mode import PaperMode
from core.methods.tgpo.algorithm import make_algorithm
from core.methods.training import TrainingConfig, final_evaluation, fresh_state, train
from core.rollout import roll_out, start_states
from core.stl import atom_names, parse, satisfied, to_text
from core.task.windows import RESERVE, tightest_leg, windows_of
from envs import ENVS, Linear, Unicycle
from scenes import load_task
from studio.runs.tasks import build_task

pytestmark = pytest.mark.optimised

SMALL = replace(
    make_algorithm("studio", "tgpo-star", Linear()),
    environments=32,
    hidden=(16, 16),
    passes=1,
    choice_candidates=16,
    elite_capacity=32,
)


@pytest.fixture(scope="module")
def solved():
    """Linear STL-08 trained by the default preset.

    Seeds 1007 to 1016 were all seen at 1.000 after 10 epochs, so 0.97 within 30 is generous.
    """
    task = build_task(load_task("linear-08"))
    config = TrainingConfig(make_algorithm("studio", "tgpo-star", Linear()), epochs=30)
    history = list(train(task, config))
    return task, config, history


def test_learns_a_nested_task(solved):
    """At least 0.97 on initial states that training never saw, and from about 0 before."""
    task, config, history = solved
    first = next(p.evaluation for p in history if p.evaluation)
    assert first.success_rate < 0.5
    final = final_evaluation(task, config, history[-1].state.best)
    assert final.success_rate >= 0.97
    assert final.robustness.shape == (512,)


def test_verdicts_are_those_of_the_formula_on_the_trace(solved):
    """The success rate is recomputed from the rollout's states by regions and formula alone."""
    task, config, history = solved
    controller = config.controller(history[-1].weights)
    states = start_states(task.problem, jax.random.key(5), count=512)
    schedules, _ = choose_schedules(task.problem, controller, jax.random.key(6), states)
    rollout = roll_out(task, controller, states, schedules)
    scene = load_task("linear-08")
    names = atom_names(parse(scene.formula))
    regions = {region.name: region for region in scene.regions}
    position = np.asarray(rollout.states)[: task.horizon + 1].astype(np.float64)
    margins = []
    for name in names:
        region = regions[name]
        offset = np.abs(position - region.center)
        if region.kind == "circle":
            margins.append(region.size[0] - np.linalg.norm(offset, axis=-1))
        else:
            excess = offset - region.size
            outside = np.linalg.norm(np.maximum(excess, 0), axis=-1)
            margins.append(-np.where(excess.max(-1) > 0, outside, excess.max(-1)))
    trace = np.moveaxis(np.stack(margins, -1), 0, 1)
    expected = satisfied(parse(scene.formula), trace, names)
    found = trace_robustness(task, np.asarray(rollout.margins)) >= 0
    assert (found == expected).mean() > 0.995  # float32 against float64 at the boundary
    assert found.mean() > 0.9


def test_a_trace_that_is_not_finite_has_failed(solved):
    task, _, _ = solved
    margins = np.zeros((task.padded_horizon + 1, 2, len(task.grounding.atoms)))
    margins[3, 1, 0] = np.nan
    assert trace_robustness(task, margins)[1] == -np.inf
    assert np.isfinite(trace_robustness(task, margins)[0])


def test_same_seed_same_weights_other_seed_others():
    task = build_task(load_task("linear-07"))

    def weights(seed):
        config = TrainingConfig(SMALL, seed=seed, epochs=2, evaluate_every=10)
        *_, last = train(task, config)
        return jax.tree.leaves(last.weights)

    first, again, other = weights(3), weights(3), weights(4)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not all(np.array_equal(a, b) for a, b in zip(first, other, strict=True))


@pytest.mark.parametrize("mode", ["studio", "paper"])
def test_nothing_compiles_for_another_formula_scene_or_seed(mode):
    compiled = []

    def listen(event: str, duration_secs: float, **_: str | int | float) -> None:
        del duration_secs
        if "backend_compile" in event:
            compiled.append(event)

    small = replace(SMALL, mode=make_algorithm(mode, "tgpo-star", Linear()).mode)
    config = TrainingConfig(small, epochs=2, evaluate_every=1)
    list(train(build_task(load_task("linear-02")), config))
    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        formula = "F_[3:50](C & F_[5:29](A)) & G_[0:100](!B5)"
        task = build_task(load_task("linear-02"), formula=formula)
        list(train(task, replace(config, seed=9)))
        list(train(build_task(load_task("linear-10")), config))
        assert compiled == []
        jax.jit(lambda x: x * 3.25 + 1)(jnp.ones(7))  # positive control: the listener hears
        assert compiled
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)


@pytest.mark.parametrize("method", ["tgpo", "tgpo-star"])
def test_paper_mode_runs(method):
    paper = make_algorithm("paper", method, Unicycle())
    assert paper.hidden == (512, 512, 512)
    assert paper.mode == PaperMode(violation=-3.5)
    small = replace(
        paper, environments=16, hidden=(16,), mcmc_steps=6, mcmc_warmup=2, choice_candidates=8
    )
    task = build_task(load_task("unicycle-08"))
    config = TrainingConfig(small, epochs=2, evaluate_every=1)
    *_, last = train(task, config)
    assert last.epoch == 2 and last.evaluation is not None
    elite = np.asarray(last.state.learner.elite.scores)
    assert (elite > -1e5).sum() == 32  # two epochs of 16 schedules, scored by the formula
    assert np.isfinite(jax.tree.leaves(last.weights)[0]).all()


def test_a_formula_without_time_variables_trains():
    task = build_task(load_task("linear-06"), formula="G_[0:100](!B5)")
    *_, last = train(task, TrainingConfig(SMALL, epochs=1, evaluate_every=1))
    assert last.evaluation is not None and last.evaluation.success_rate > 0.5


def test_a_branch_is_planned_without_the_other_branch_s_obstacles():
    """B5 is forbidden beside A1 alone: the way to A3 is as short as without it."""
    scene = load_task("linear-08")
    both = "(F_[0:60](A1) & G_[0:60](!B5)) | F_[0:60](A3)"
    alone = build_task(scene, formula="F_[0:60](A3)")
    task = build_task(scene, formula=both)
    variables = task.grounding.decomposition.variables
    (branch,) = (i for i, variable in enumerate(variables) if variable.kind == "branch")
    start = jnp.zeros(2)

    def needed(task, schedule):
        windows = windows_of(task.problem, jnp.asarray(schedule, jnp.int32))
        leg = tightest_leg(task.problem, windows, start, RESERVE)
        return to_text(task.grounding.subgoals[int(leg.target)].predicate), float(leg.needed)

    found = {}
    for choice in (0, 1):
        schedule = [v.low if i != branch else choice for i, v in enumerate(variables)]
        goal, steps = needed(task, schedule + [0] * (8 - len(schedule)))
        found[goal] = steps
    assert found["A3"] == pytest.approx(needed(alone, [0] * 8)[1])


def test_disjunction_and_recurrence_are_learnt():
    """From no success to most traces, whichever branch is taken."""
    formula = "(F_[0:60](A1) | F_[0:60](A2)) & G_[10:40](F_[0:40](A1)) & G_[0:100](!B5)"
    task = build_task(load_task("linear-07"), formula=formula)
    assert "branch" in [v.kind for v in task.grounding.decomposition.variables]
    algorithm = make_algorithm("studio", "tgpo-star", Linear())
    config = TrainingConfig(algorithm, epochs=20, target=0.9)
    untrained = final_evaluation(task, config, fresh_state(task, config).best)
    *_, last = train(task, config)
    final = final_evaluation(task, config, last.state.best)
    assert untrained.success_rate < 0.5
    assert final.success_rate > 0.8


def test_a_rollout_continues_past_a_violation(solved):
    """A trace is simulated to its end: what comes after a violation still counts."""
    task, config, history = solved
    controller = config.controller(history[-1].weights)
    states = jnp.asarray([[0.0, 0.0], [4.9, 4.9]], jnp.float32)
    hopeless = jnp.tile(jnp.asarray([0, 80, 20, 0, 0, 0, 0, 0], jnp.int32), (2, 1))  # A1 at once
    rollout = roll_out(task, controller, states, hopeless)
    assert (trace_robustness(task, np.asarray(rollout.margins)) < 0).all()
    positions = np.asarray(rollout.states)
    assert positions.shape == (task.padded_horizon + 1, 2, 2)
    moved = np.abs(np.diff(positions, axis=0)).sum(-1)
    assert np.isfinite(positions).all() and (moved[1 : task.horizon] > 0).any(0).all()
    assert moved[10:].max() > 1e-3  # long after the first step, which violated


@pytest.mark.parametrize("robot", ENVS)
def test_every_robot_learns(robot):
    """A few small epochs on its demo: what is earned per step rises well above the noise."""
    task = build_task(load_task(f"{robot}-demo"))
    algorithm = make_algorithm("studio", "tgpo-star", task.robot)
    small = replace(
        algorithm, environments=128, minibatches=4, model_epochs=10**6, evaluation_states=8
    )
    config = TrainingConfig(small, seed=3, epochs=12, target=2.0, evaluate_every=100)
    earned = [progress.batch_return for progress in train(task, config)]
    noise = np.std(earned[:3])
    assert np.mean(earned[-3:]) > np.mean(earned[:3]) + 2 * noise, earned
