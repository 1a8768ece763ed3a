"""Policy bundles: the exported controller against our own rollout, and files that are refused."""

import json
import subprocess
import sys
from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.algorithm import make_algorithm
from core.checkpoint import DivergedError, save_tree
from core.errors import UserError
from core.programs import fresh_learner, setting_of
from core.rollout import roll_out, score_schedules
from scenes import load_task
from studio.files import bundle
from studio.files.bundle import Policy, load_bundle, save_bundle
from studio.files.controller import make_controller
from studio.tasks import build_task
from tests.small import shrink

ROLLOUTS = 3


def loud_parameters(task, algorithm, seed: int = 0):
    """Random weights whose actions are of order one; fresh ones hardly act."""
    parameters = fresh_learner(task, algorithm, seed).parameters
    last = parameters.actor["params"][f"Dense_{len(algorithm.hidden)}"]
    layers = parameters.actor["params"] | {
        f"Dense_{len(algorithm.hidden)}": last | {"kernel": 100 * last["kernel"]}
    }
    return parameters._replace(actor={"params": layers})


@pytest.mark.parametrize(("name", "mode"), [("unicycle-10", "studio"), ("linear-08", "paper")])
def test_the_controller_acts_as_the_rollout_does(name, mode, disk_cache):
    """unicycle-10 has doors (many distance fields); paper mode carries flags from step to step."""
    task = build_task(load_task(name))
    algorithm = shrink(make_algorithm(mode, "tgpo-star", task.robot.name))
    setting, parameters = setting_of(task, algorithm), loud_parameters(task, algorithm)

    random = np.random.default_rng(1)
    states = np.zeros((ROLLOUTS, task.robot.state_size), np.float32)
    states[:, :2] = random.uniform(-4, -2, (ROLLOUTS, 2))
    formula = task.problem.formula
    schedules = random.integers(formula.low, np.asarray(formula.high) + 1, (ROLLOUTS, 8), np.int32)

    @jax.jit
    def ours(problem, states, schedules):
        rollout = roll_out(setting, problem, parameters, states, schedules)
        value, short = score_schedules(setting, problem, parameters, states, schedules)
        return rollout.states, rollout.actions, value - 10 * algorithm.prune * short

    visited, actions, scores = ours(task.problem, states, schedules)
    controller = make_controller(task, algorithm, parameters)
    used = schedules[:, : len(task.grounding.decomposition.variables)]

    @jax.jit
    @jax.vmap
    def theirs(visited, schedule):
        memory = controller.start(visited[0], schedule)
        _, taken = jax.lax.scan(controller.step, memory, visited[:-1])
        return taken, controller.score(visited[0], schedule)

    taken, values = theirs(jnp.swapaxes(visited, 0, 1), used)
    np.testing.assert_allclose(jnp.swapaxes(taken, 0, 1), jnp.clip(actions, -1, 1), atol=1e-5)
    np.testing.assert_allclose(values, scores, rtol=1e-5, atol=1e-5)
    assert float(taken.std()) > 0.1, "the policy must do something"


@pytest.fixture(scope="session")
def policy(small_algorithm, linear_task):
    parameters = loud_parameters(linear_task, small_algorithm, 5)
    scene = load_task("linear-08")
    return Policy(scene, "studio", "tgpo-star", 7, small_algorithm, parameters, 0.5, -0.1, 12)


@pytest.fixture(scope="session")
def saved(policy, tmp_path_factory):
    folder = tmp_path_factory.mktemp("policies") / "bundle"
    save_bundle(policy, folder)
    return folder


@pytest.fixture
def copied(saved, tmp_path):
    for path in saved.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def test_round_trip(saved, policy):
    loaded = load_bundle(saved)
    assert replace(loaded, parameters=policy.parameters) == policy
    pairs = zip(jax.tree.leaves(loaded.parameters), jax.tree.leaves(policy.parameters), strict=True)
    assert all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in pairs)


def test_what_a_bundle_says(saved, linear_task):
    values = json.loads((saved / "metadata.json").read_text())
    assert values["format"] == 1 and values["jax"] == jax.__version__ and values["tgpo_studio"]
    assert (values["robot"], values["mode"], values["seed"]) == ("linear", "studio", 7)
    variables = linear_task.grounding.decomposition.variables
    shown = [(v["name"], v["low"], v["high"]) for v in values["controller"]["variables"]]
    assert shown == [(v.name, v.low, v.high) for v in variables]
    assert values["controller"]["robot_constants"]["max_velocity"] == 2.0


@pytest.mark.parametrize("name", ["linear-08", "unicycle-05"])
def test_a_bundle_is_small(tmp_path, name, disk_cache):
    """Full size networks; each different distance field is kept once (78 kB)."""
    scene = load_task(name)
    algorithm = make_algorithm("studio", "tgpo-star", scene.robot)
    parameters = fresh_learner(build_task(scene), algorithm, 0).parameters
    save_bundle(Policy(scene, "studio", "tgpo", 0, algorithm, parameters, 0, 0, 1), tmp_path / "b")
    assert sum(path.stat().st_size for path in (tmp_path / "b").iterdir()) < 2_000_000


# Runs the README's own example; all that it adds is the robot, x' = x + 0.4 u.
ELSEWHERE = """
import json, pathlib, sys
text = pathlib.Path("README.txt").read_text(encoding="utf-8")
code = "\\n".join(line[4:] for line in text.splitlines() if line.startswith("    "))
code = code[code.index("import jax"):]
states, actions = [], []
def your_robot(x, action):
    states.append(x.tolist())
    actions.append(np.asarray(action).tolist())
    return (x + np.float32(0.4) * np.asarray(action)).astype(np.float32)
exec(code)
ours = {"core", "envs", "scenes", "studio", "flax", "optax", "safetensors"} & set(sys.modules)
print(json.dumps([states, actions, t.tolist(), float(score(x, t)), sorted(ours)]))
"""


def test_the_exported_controller_needs_nothing_but_jax(saved, policy, linear_task):
    command = [sys.executable, "-I", "-c", ELSEWHERE]
    done = subprocess.run(command, cwd=saved, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    states, actions, schedule, _, ours = json.loads(done.stdout)
    assert ours == []
    assert len(actions) == linear_task.horizon
    padded = jnp.zeros((1, 8), jnp.int32).at[0, : len(schedule)].set(jnp.array(schedule))
    setting = setting_of(linear_task, policy.algorithm)
    rollout = jax.jit(partial(roll_out, setting))(
        linear_task.problem, policy.parameters, jnp.array(states[:1]), padded
    )
    expected = np.clip(rollout.actions[: len(actions), 0], -1, 1)
    np.testing.assert_allclose(actions, expected, atol=1e-5)
    np.testing.assert_allclose(states, rollout.states[: len(states), 0], atol=1e-5)
    assert np.std(actions) > 0.1, "the policy must do something"


def test_a_formula_without_time_variables(tmp_path, small_algorithm):
    scene = replace(load_task("linear-01"), formula="G_[0:50](!B1)")
    task = build_task(scene)
    parameters = fresh_learner(task, small_algorithm, 0).parameters
    made = Policy(scene, "studio", "tgpo", 0, small_algorithm, parameters, 1, 0, 1)
    save_bundle(made, tmp_path / "b")
    program = jax.export.deserialize(bytearray((tmp_path / "b/score.stablehlo").read_bytes()))
    assert np.isfinite(program.call(np.zeros(2, np.float32), np.zeros(0, np.int32)))


def test_a_bundle_is_replaced_as_a_whole(copied, policy):
    (copied / "stray.txt").write_text("")
    save_bundle(replace(policy, seed=8), copied)
    assert load_bundle(copied).seed == 8 and not (copied / "stray.txt").exists()
    assert not list(copied.parent.glob(f".{copied.name}.*"))


def test_a_writer_that_fails_leaves_the_old_bundle(copied, policy, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(bundle, "write_document", full)
    with pytest.raises(UserError, match="cannot be written: No space left on device"):
        save_bundle(replace(policy, seed=8), copied)
    assert load_bundle(copied).seed == 7
    assert not list(copied.parent.glob(f".{copied.name}.*"))


def test_foreign_folders_are_left_alone(tmp_path, policy):
    (tmp_path / "thesis.tex").write_text("")
    with pytest.raises(UserError, match="holds something else"):
        save_bundle(policy, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_weights_that_are_not_finite_are_not_written(tmp_path, policy):
    bad = policy.parameters._replace(log_std=jnp.array([jnp.nan, 0.0]))
    with pytest.raises(DivergedError, match="'log_std'"):
        save_bundle(replace(policy, parameters=bad), tmp_path / "b")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "name", ["metadata.json", "task.stl.toml", "weights.safetensors", "step.stablehlo"]
)
def test_a_missing_file_is_named(copied, name):
    (copied / name).unlink()
    with pytest.raises(UserError, match=f"{name} is missing"):
        load_bundle(copied)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"format": 2}, "format: 2 is not known; this program reads format 1"),
        ({"robot": "unicycle"}, "robot: 'unicycle', but task.stl.toml is for 'linear'"),
        ({"mode": "x"}, "mode: unknown 'x'"),
        ({"seed": None}, "seed: None must be of type int"),
        ({"algorithm": {"mode": {}, "hidden": [17]}}, "it does not fit this task"),
    ],
)
def test_metadata_that_was_tampered_with_is_refused(copied, changed, message):
    path = copied / "metadata.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))
    with pytest.raises(UserError, match=message):
        load_bundle(copied)


def test_weights_of_another_shape_are_refused(copied, policy):
    wrong = policy.parameters._replace(log_std=jnp.zeros(3))
    save_tree(copied / "weights.safetensors", wrong, kind="weights")
    with pytest.raises(UserError, match=r"'log_std' is float32\[3\], expected float32\[2\]"):
        load_bundle(copied)


def test_weights_that_are_not_finite_are_refused(copied, policy):
    wrong = policy.parameters._replace(log_std=jnp.full(2, jnp.nan))
    save_tree(copied / "weights.safetensors", wrong, kind="weights")
    with pytest.raises(DivergedError, match="'log_std' hold numbers that are not"):
        load_bundle(copied)


def test_truncated_weights_are_refused(copied):
    path = copied / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(UserError, match="not a complete safetensors file"):
        load_bundle(copied)
