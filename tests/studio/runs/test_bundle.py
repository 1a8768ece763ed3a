"""Policy bundles: the exported controller against our own rollout, and files that are refused."""

import json
import subprocess
import sys
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.checkpoint import DivergedError, save_tree
from core.controller import pad_schedule
from core.errors import UserError
from core.heatmap import score
from core.methods import METHODS
from core.methods.networks import Networks
from core.methods.tgpo.algorithm import make_algorithm
from core.rollout import roll_out
from scenes import load_task, robot_of
from studio.runs import bundle
from studio.runs.bundle import Policy, load_bundle, save_bundle
from studio.runs.controller import export_controller, functions_of
from studio.runs.readme import readme
from studio.runs.tasks import build_task
from tests.small import shrink

ROLLOUTS = 3


def fresh_weights(task, algorithm, seed: int = 0):
    """Random weights of both networks."""
    return METHODS["tgpo-star"].learner(task, algorithm).fresh(seed).parameters


def loud_weights(task, algorithm, seed: int = 0):
    """Random weights whose actions are of order one; fresh ones hardly act."""
    weights = fresh_weights(task, algorithm, seed)
    last = weights.actor["params"][f"Dense_{len(algorithm.hidden)}"]
    layers = weights.actor["params"] | {
        f"Dense_{len(algorithm.hidden)}": last | {"kernel": 100 * last["kernel"]}
    }
    return weights._replace(actor={"params": layers})


@pytest.mark.parametrize(("name", "mode"), [("unicycle-10", "studio"), ("linear-08", "paper")])
def test_the_controller_acts_as_the_rollout_does(name, mode, disk_cache):
    """unicycle-10 has doors (many distance fields); paper mode carries flags from step to step."""
    task = build_task(load_task(name))
    algorithm = shrink(make_algorithm(mode, "tgpo-star", task.robot))
    controller = METHODS["tgpo-star"].controller(algorithm, loud_weights(task, algorithm))

    random = np.random.default_rng(1)
    states = np.zeros((ROLLOUTS, task.robot.state_size), np.float32)
    states[:, :2] = random.uniform(-4, -2, (ROLLOUTS, 2))
    formula = task.problem.formula
    schedules = random.integers(formula.low, np.asarray(formula.high) + 1, (ROLLOUTS, 8), np.int32)

    rollout = roll_out(task, controller, jnp.asarray(states), jnp.asarray(schedules))
    scores = [
        score(task, controller, state, schedule[None]).values[0]
        for state, schedule in zip(jnp.asarray(states), schedules, strict=True)
    ]
    functions = functions_of(task, controller)
    used = schedules[:, : len(task.grounding.decomposition.variables)]

    @jax.jit
    @jax.vmap
    def theirs(visited, schedule):
        memory = functions.start(visited[0], schedule)
        _, taken = jax.lax.scan(functions.step, memory, visited[:-1])
        return taken, functions.score(visited[0], schedule)

    taken, values = theirs(jnp.swapaxes(rollout.states, 0, 1), used)
    np.testing.assert_allclose(jnp.swapaxes(taken, 0, 1), rollout.actions, atol=1e-5)
    np.testing.assert_allclose(values, scores, rtol=1e-5, atol=1e-5)
    assert float(taken.std()) > 0.1, "the policy must do something"


@pytest.fixture(scope="session")
def policy(small_algorithm, linear_task):
    weights = loud_weights(linear_task, small_algorithm, 5)
    scene = load_task("linear-08")
    return Policy(scene, "studio", "tgpo-star", 7, small_algorithm, weights, 0.5, -0.1, 12)


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
    assert replace(loaded, weights=policy.weights) == policy
    pairs = zip(jax.tree.leaves(loaded.weights), jax.tree.leaves(policy.weights), strict=True)
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
    algorithm = make_algorithm("studio", "tgpo-star", robot_of(scene))
    weights = fresh_weights(build_task(scene), algorithm)
    save_bundle(Policy(scene, "studio", "tgpo", 0, algorithm, weights, 0, 0, 1), tmp_path / "b")
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
    padded = pad_schedule(linear_task.problem, jnp.array(schedule))[None]
    rollout = roll_out(linear_task, policy.controller, jnp.array(states[:1]), padded)
    np.testing.assert_allclose(actions, rollout.actions[: len(actions), 0], atol=1e-5)
    np.testing.assert_allclose(states, rollout.states[: len(states), 0], atol=1e-5)
    assert np.std(actions) > 0.1, "the policy must do something"


def test_an_earlier_bundle_opens(copied):
    (copied / "rescore.stablehlo").unlink()
    path = copied / "metadata.json"
    values = json.loads(path.read_text())
    del values["sha256"]["rescore.stablehlo"]
    path.write_text(json.dumps(values))
    assert load_bundle(copied).seed == 7


def test_equal_weights_give_equal_programs(saved, policy, linear_task):
    """Exported again, from another place, after other programs were traced."""
    again = export_controller(linear_task, policy.controller)
    for name, program in again.items():
        assert program == (saved / f"{name}.stablehlo").read_bytes()
        assert b".py" not in program, "the files of this machine are nobody's business"
    louder = jax.tree.map(lambda leaf: 2 * leaf, policy.weights)
    assert export_controller(linear_task, replace(policy, weights=louder).controller) != again


def test_a_formula_without_time_variables(tmp_path, small_algorithm):
    scene = replace(load_task("linear-01"), formula="G_[0:50](!B1)")
    task = build_task(scene)
    weights = fresh_weights(task, small_algorithm)
    made = Policy(scene, "studio", "tgpo", 0, small_algorithm, weights, 1, 0, 1)
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
    with pytest.raises(UserError, match="contains something other than a policy bundle"):
        save_bundle(policy, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_weights_that_are_not_finite_are_not_written(tmp_path, policy):
    bad = policy.weights._replace(log_std=jnp.array([jnp.nan, 0.0]))
    with pytest.raises(DivergedError, match="'log_std'"):
        save_bundle(replace(policy, weights=bad), tmp_path / "b")
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
        ({"epochs": -1}, "metadata.json: epochs: -1 must be an integer from 0"),
        ({"success_rate": 1.5}, "metadata.json: success_rate: 1.5 must be a number from 0 to 1"),
        ({"sucess_rate": 1}, "metadata.json: sucess_rate: unknown. Allowed: success_rate"),
        ({"seed": None}, "metadata.json: seed: None must be an integer"),
        ({"algorithm": {"mode": {}, "hidden": [17]}}, "it does not fit this task"),
        ({"algorithm": {"mode": {}, "hidden": [1024] * 8}}, "it does not fit this task"),
        ({"algorithm": {"mode": {}, "hidden": [5000]}}, "must be an integer from 1 to 1024"),
        ({"algorithm": {"mode": {}, "hidden": [0]}}, "must be an integer from 1 to 1024"),
        ({"algorithm": {"mode": {}, "hidden": [8] * 9}}, "a list of at most 8, each entry"),
        (
            {"algorithm": {"mode": {}, "elite_capacity": 10**7}},
            "10000000 must be an integer from 1",
        ),
        ({"algorithm": {"mode": {}, "layouts": 0}}, "layouts: 0 must be an integer from 1"),
        ({"algorithm": {"mode": {}, "layouts": 64, "environments": 8}}, "layouts: 64 must be at"),
        ({"algorithm": {"mode": {}, "passes": -1}}, "passes: -1 must be an integer from 1"),
        ({"algorithm": {"mode": {}, "share_mcmc": 0.95}}, r"share_elite: 1\.05 must be at most 1"),
        ({"algorithm": {"mode": {}, "log_std": 10**400}}, "a number too large to use"),
        ({"algorithm": {"mode": {}, "learning_rate": 0}}, "must be a number above 0 and at most"),
        (
            {"algorithm": {"mode": {}, "prune_candidates": 4096, "choice_candidates": 4096}},
            r"prune_candidates \* environments: 2097152 must be at most 1048576",
        ),
        ({"algorithm": {"mode": {"scale": 0}}}, "algorithm.mode.scale: 0 must be a number above 0"),
        ({"sha256": {"step.stablehlo": "0"}}, "task.stl.toml is not the file that was saved"),
    ],
)
def test_metadata_that_was_tampered_with_is_refused(copied, changed, message):
    path = copied / "metadata.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))
    with pytest.raises(UserError, match=message):
        load_bundle(copied)


@pytest.mark.parametrize(
    "name", ["score.stablehlo", "start.stablehlo", "step.stablehlo", "rescore.stablehlo"]
)
def test_altered_programs_are_told(copied, name):
    path = copied / name
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(UserError, match=f"{name} is not the file that was saved"):
        load_bundle(copied)


def test_a_bundle_without_checksums_opens(copied):
    path = copied / "metadata.json"
    values = json.loads(path.read_text())
    assert set(values.pop("sha256")) == {path.name for path in copied.iterdir()} - {
        "metadata.json",
        "README.txt",
    }
    path.write_text(json.dumps(values))
    assert load_bundle(copied).seed == 7


def test_no_weights_are_made_to_look_at_a_file(copied, monkeypatch):
    def refuse(*_):
        raise AssertionError("weights were made")

    monkeypatch.setattr(Networks, "initial", refuse)
    assert load_bundle(copied).seed == 7


def test_weights_of_another_shape_are_refused(copied, policy):
    wrong = policy.weights._replace(log_std=jnp.zeros(3))
    save_tree(copied / "weights.safetensors", wrong, kind="weights")
    with pytest.raises(UserError, match=r"'log_std' is float32\[3\], expected float32\[2\]"):
        load_bundle(copied)


def test_weights_that_are_not_finite_are_refused(copied, policy):
    wrong = policy.weights._replace(log_std=jnp.full(2, jnp.nan))
    save_tree(copied / "weights.safetensors", wrong, kind="weights")
    with pytest.raises(DivergedError, match="'log_std' contain numbers that are not"):
        load_bundle(copied)


def test_truncated_weights_are_refused(copied):
    path = copied / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(UserError, match="not a complete safetensors file"):
        load_bundle(copied)


@pytest.mark.parametrize(
    ("rate", "sentence"),
    [
        (0.984, "It satisfied the formula from 98.4 % of random initial states."),
        (float("nan"), "Its success rate has not been measured."),
    ],
)
def test_the_readme_tells_what_was_measured(linear_task, rate, sentence):
    assert sentence in readme(load_task("linear-08"), linear_task, rate).splitlines()
