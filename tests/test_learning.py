"""Learning on shipped tasks: success, determinism, and nothing compiled twice."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.algorithm import make_algorithm
from core.evaluation import trace_robustness
from core.programs import evaluation_programs, use_disk_cache
from core.rollout import roll_out
from core.stl import atom_names, parse, satisfied
from core.training import TrainingConfig, final_evaluation, train
from scenes import load_task
from studio.tasks import build_task

SMALL = replace(
    make_algorithm("studio", "tgpo-star", "linear"),
    environments=32,
    hidden=(16, 16),
    passes=1,
    choice_candidates=16,
    elite_capacity=32,
)


@pytest.fixture(scope="module", autouse=True)
def _disk_cache():
    use_disk_cache()


@pytest.fixture(scope="module")
def solved():
    """Linear STL-08 trained by the default preset.

    Seeds 1007 to 1016 were all seen at 1.000 after 10 epochs, so 0.97 within 30 is generous.
    """
    task = build_task(load_task("linear-08"))
    config = TrainingConfig(make_algorithm("studio", "tgpo-star", "linear"), epochs=30)
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
    programs = evaluation_programs(task, config.algorithm)
    states = programs.initial(task.problem, jax.random.key(5))
    parameters = history[-1].parameters
    schedules, _ = programs.choose(task.problem, parameters, jax.random.key(6), states)
    rollout = programs.roll_out(task.problem, parameters, states, schedules)
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
    margins = np.zeros((task.steps + 1, 2, len(task.grounding.atoms)))
    margins[3, 1, 0] = np.nan
    assert trace_robustness(task, margins)[1] == -np.inf
    assert np.isfinite(trace_robustness(task, margins)[0])


def test_same_seed_same_weights_other_seed_others():
    task = build_task(load_task("linear-07"))

    def weights(seed):
        config = TrainingConfig(SMALL, seed=seed, epochs=2, evaluate_every=10)
        *_, last = train(task, config)
        return jax.tree.leaves(last.parameters)

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

    small = replace(SMALL, mode=make_algorithm(mode, "tgpo-star", "linear").mode)
    config = TrainingConfig(small, epochs=2, evaluate_every=1)
    list(train(build_task(load_task("linear-02")), config))
    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        formula = "F_[3:50](C & F_[5:9](A)) & G_[0:100](!B5)"
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
    paper = make_algorithm("paper", method, "unicycle")
    assert paper.hidden == (512, 512, 512) and paper.mode.violation == -3.5
    small = replace(
        paper, environments=16, hidden=(16,), mcmc_steps=6, mcmc_warmup=2, choice_candidates=8
    )
    task = build_task(load_task("unicycle-08"))
    config = TrainingConfig(small, epochs=2, evaluate_every=1)
    *_, last = train(task, config)
    assert last.epoch == 2 and last.evaluation is not None
    elite = np.asarray(last.state.learner.elite.scores)
    assert (elite > -1e5).sum() == 32  # two epochs of 16 schedules, scored by the formula
    assert np.isfinite(jax.tree.leaves(last.parameters)[0]).all()


def test_a_formula_without_time_variables_trains():
    task = build_task(load_task("linear-06"), formula="G_[0:100](!B5)")
    *_, last = train(task, TrainingConfig(SMALL, epochs=1, evaluate_every=1))
    assert last.evaluation is not None and last.evaluation.success_rate > 0.5


def test_disjunction_and_recurrence_train():
    formula = "(F_[0:60](A1) | F_[0:60](A2)) & G_[10:40](F_[0:40](A1)) & G_[0:100](!B5)"
    task = build_task(load_task("linear-07"), formula=formula)
    kinds = [v.kind for v in task.grounding.decomposition.variables]
    assert "branch" in kinds
    *_, last = train(task, TrainingConfig(SMALL, epochs=1, evaluate_every=1))
    assert last.evaluation is not None


def test_rollout_continues_past_a_violation(solved):
    """A trace is simulated to its end, so that the verdict is exact whatever went wrong."""
    task, config, history = solved
    from core.programs import setting_of

    states = jnp.asarray([[0.0, 0.0], [4.9, 4.9]], jnp.float32)
    schedules = jnp.zeros((2, 8), jnp.int32)
    rollout = roll_out(
        setting_of(task, config.algorithm), task.problem, history[-1].parameters, states, schedules
    )
    assert rollout.states.shape == (task.steps + 1, 2, 2)
    assert np.isfinite(rollout.states).all()
