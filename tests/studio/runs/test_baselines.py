"""The baselines' files, and what they refuse: checkpoints, configurations, bundles, options."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.checkpoint import load_tree, save_tree
from core.errors import UserError
from core.methods import METHODS
from core.methods.training import TrainingConfig, fresh_state, state_from_weights
from core.rollout import roll_out
from scenes import load_task, robot_of
from studio.cli import main
from studio.runs.bundle import Policy, load_bundle, save_bundle
from studio.runs.config import RunConfig, make_config, read_config
from studio.runs.controller import functions_of
from studio.runs.json_documents import DocumentError, algorithm_document, write_document
from studio.runs.pretrained import FORMAT, Card, load_weights
from studio.runs.tasks import build_task, initial_state

BASELINES = [name for name, method in METHODS.items() if not method.chooses_times]
SCENE = load_task("linear-01")
"""Of two layers, so that every baseline knows it."""


@pytest.fixture(scope="module")
def task(disk_cache):
    return build_task(SCENE)


def small(name: str):
    return replace(METHODS[name].preset("studio", robot_of(SCENE)), hidden=(16,))


def same(one, other) -> bool:
    """Whether two pytrees agree in structure, types and every number."""

    def plain(leaf):
        typed = jnp.issubdtype(jnp.asarray(leaf).dtype, jax.dtypes.prng_key)
        return np.asarray(jax.random.key_data(leaf) if typed else leaf)

    leaves, others = jax.tree.leaves(one), jax.tree.leaves(other)
    assert jax.tree.structure(one) == jax.tree.structure(other)
    pairs = [(plain(a), plain(b)) for a, b in zip(leaves, others, strict=True)]
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize("name", BASELINES)
def test_what_is_kept_is_read_again(task, tmp_path, name):
    training = TrainingConfig(small(name), name, seed=4)
    state = fresh_state(task, training)
    save_tree(tmp_path / "state", state, kind="checkpoint")
    like = fresh_state(task, replace(training, seed=5))
    assert same(load_tree(tmp_path / "state", like, kind="checkpoint"), state)
    assert not same(like, state)
    assert same(state_from_weights(task, training, state.best).best, state.best)

    config = RunConfig(SCENE, "studio", training)
    write_document(tmp_path / "config.json", config.document())
    assert read_config(tmp_path) == config

    policy = Policy(SCENE, "studio", name, 4, training.algorithm, state.best, 0.5, -0.1, 1)
    save_bundle(policy, tmp_path / "bundle")
    loaded = load_bundle(tmp_path / "bundle")
    assert replace(loaded, weights=policy.weights) == policy
    assert same(loaded.weights, policy.weights)
    assert "This policy chooses no times" in (tmp_path / "bundle/README.txt").read_text()


@pytest.mark.parametrize("name", BASELINES)
def test_the_exported_functions_act_as_the_rollout_does(task, name):
    learner = METHODS[name].learner(task, small(name))
    weights = jax.tree.map_with_path(_louder, learner.weights(learner.fresh(1)))
    controller = learner.controller(weights)
    states, schedules = initial_state(task)[None], jnp.zeros((1, 8), jnp.int32)
    rollout = roll_out(task, controller, states, schedules)
    functions = functions_of(task, controller)
    times = jnp.zeros(len(task.grounding.decomposition.variables), jnp.int32)

    @jax.jit
    def theirs(visited):
        return jax.lax.scan(functions.step, functions.start(visited[0], times), visited[:-1])[1]

    taken = theirs(rollout.states[:, 0])
    np.testing.assert_allclose(taken, rollout.actions[:, 0], atol=1e-5)
    assert float(jnp.abs(taken).max()) > 0.05, "the policy must do something"
    assert float(functions.score(states[0], times)) == 0


def _louder(path, leaf):
    """Perceptrons' kernels are larger: fresh weights hardly act."""
    return 10 * leaf if "Dense" in jax.tree_util.keystr(path) and leaf.ndim > 1 else leaf


@pytest.mark.parametrize("name", BASELINES)
def test_a_damaged_configuration_is_refused(task, tmp_path, name):
    config = RunConfig(SCENE, "studio", TrainingConfig(small(name), name)).document()
    for change, message in (
        ({"hidden": [0]}, r"algorithm\.hidden\[0\]: 0 must be an integer from 1"),
        ({"mode": "paper"}, "algorithm.mode: 'paper' must be 'studio'"),
        ({"prune": True}, "prune: unknown"),
    ):
        wrong = replace_field(config, change)
        write_document(tmp_path / "config.json", wrong)
        with pytest.raises(DocumentError, match=message):
            read_config(tmp_path)


def replace_field(config, change):
    values = {name: getattr(config, name) for name in config.__struct_fields__}
    return {**values, "algorithm": {**config.algorithm, **change}}


@pytest.mark.parametrize("name", BASELINES)
def test_modes_are_two_sizes_of_one_method(name):
    studio, paper = (METHODS[name].preset(mode, robot_of(SCENE)) for mode in ("studio", "paper"))
    assert (studio.mode_name, paper.mode_name) == ("studio", "paper")
    assert studio.hidden == (64, 64) and paper.hidden == (512, 512, 512)
    studio.check()
    paper.check()
    with pytest.raises(UserError, match="unknown mode 'fast'. Available: .*paper"):
        METHODS[name].preset("fast", robot_of(SCENE))


@pytest.mark.parametrize("name", BASELINES)
def test_weights_and_many_layouts_are_refused(name):
    with pytest.raises(UserError, match=f"--weights: {name} begins from scratch.*Allowed: none"):
        make_config(SCENE, method=name, weights="shipped")
    with pytest.raises(UserError, match=f"--randomize: {name} learns a single layout only"):
        make_config(SCENE, method=name, randomize=True)
    config = make_config(SCENE, method=name, weights="none")
    assert config.weights == "none" and not config.training.warm


def test_no_plan_without_training(capsys):
    assert main(["--plan", "--task", "linear-01", "--method", "cem", "--no-cache"]) == 2
    assert "--method cannot be used with --plan: it answers by tgpo" in capsys.readouterr().err


def test_weights_for_plans_are_those_of_methods_that_choose_times(task, tmp_path):
    card = Card(
        format=FORMAT,
        robot="linear",
        mode="studio",
        method="cem",
        seed=0,
        epochs=1,
        env_steps=1,
        train_seconds=1.0,
        families=(),
        held_out=(),
        algorithm=algorithm_document(small("cem")),
    )
    write_document(tmp_path / "w.json", card)
    with pytest.raises(
        DocumentError, match="weights of cem do not serve every task.*Allowed: tgpo"
    ):
        load_weights(tmp_path / "w.safetensors", task)


def test_a_formula_outside_of_the_fragment_leaves_no_folder(tmp_path, capsys, disk_cache):
    out = tmp_path / "x"
    asked = ["--train-only", "--task", "linear-08", "--method", "f-mdp", "--out", str(out)]
    assert main(asked) == 2
    assert "`F_[10:20](G_[0:10](A3))` holds a third layer" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("name", BASELINES)
def test_shapes_of_weights_are_those_of_fresh_ones(task, name):
    learner = METHODS[name].learner(task, small(name))
    weights, shapes = learner.weights(learner.fresh(0)), learner.weight_shapes()
    assert jax.tree.structure(weights) == jax.tree.structure(shapes)
    pairs = zip(jax.tree.leaves(weights), jax.tree.leaves(shapes), strict=True)
    assert all((one.shape, one.dtype) == (other.shape, other.dtype) for one, other in pairs)
