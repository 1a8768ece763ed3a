"""Runs: what is kept, what is refused, and that resuming changes nothing."""

import errno
import json
import math
import os
import re
import socket
import struct
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tensorboardX.proto.event_pb2 import Event  # pyright: ignore[reportAttributeAccessIssue]

from core.checkpoint import DivergedError, checkpoints, load_checkpoint
from core.errors import UserError
from core.methods.training import TrainingConfig, best_weights, fresh_state, train
from scenes import load_task
from studio.cli import main
from studio.runs import run as run_module
from studio.runs.bundle import load_bundle
from studio.runs.config import RunConfig, RunError, make_config, read_config
from studio.runs.run import Run, default_folder


@pytest.fixture(scope="session")
def config(small_algorithm):
    training = TrainingConfig(small_algorithm, seed=3, epochs=4, target=2.0, evaluate_every=2)
    return RunConfig(load_task("linear-08"), "studio", training)


@pytest.fixture(scope="session")
def history(config, linear_task):
    """The four epochs of an uninterrupted run."""
    return list(train(linear_task, config.training))


def same_bits(one, other) -> bool:
    """Whether two states agree in every bit, the time that they took apart."""
    pairs = zip(
        jax.tree.leaves(one._replace(seconds=0)),
        jax.tree.leaves(other._replace(seconds=0)),
        strict=True,
    )
    return all(_bytes(a) == _bytes(b) for a, b in pairs)


def _bytes(leaf) -> bytes:
    if jnp.issubdtype(jnp.asarray(leaf).dtype, jax.dtypes.prng_key):
        leaf = jax.random.key_data(leaf)
    return np.asarray(leaf).tobytes()


def lines(run: Run) -> list[dict]:
    text = (run.folder / "metrics.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


@pytest.mark.parametrize("interrupted_after", [1, 2, 3])
def test_resuming_gives_what_an_uninterrupted_run_gives(
    tmp_path, config, linear_task, history, interrupted_after
):
    with Run.create(tmp_path / "x", config, linear_task) as run:
        for progress in history[:interrupted_after]:
            run.record(progress)
        run.checkpoint()
    with (tmp_path / "x/metrics.jsonl").open("a") as file:  # what a kill may leave
        file.write('{"epoch": 4, "batch_success": 1.0}\n{"epo')
    with Run.resume(tmp_path / "x") as run:
        assert run.epochs == interrupted_after and run.notes == ()
        for progress in train(run.task, run.config.training, run.state):
            run.record(progress)
    assert run.state is not None and same_bits(run.state, history[-1].state)
    assert not same_bits(run.state, history[-2].state), "the comparison must see differences"
    assert [line["epoch"] for line in lines(run)] == [1, 2, 3, 4]
    assert [line["success_rate"] is None for line in lines(run)] == [True, False, True, False]


def test_a_finished_run_holds_everything(tmp_path, config, linear_task, history):
    with Run.create(tmp_path / "x", config, linear_task) as run:
        for progress in history:
            run.record(progress)
        summary = run.finish("epochs")
    names = {path.name for path in run.folder.iterdir()}
    assert names == {
        *("config.json", "metrics.jsonl", "summary.json", "lock"),
        *("tensorboard", "checkpoints", "bundle"),
    }
    assert (summary["task"], summary["method"], summary["seed"]) == ("linear-08", "tgpo-star", 3)
    assert summary["epochs"] == 4 and summary["env_steps"] == history[-1].env_steps
    kept = json.loads((run.folder / "summary.json").read_text())
    assert kept == {"format": 1, **summary, "stopped": "epochs"}
    policy = load_bundle(run.folder / "bundle")
    assert policy.success_rate == summary["success_rate"] and policy.epochs == 4
    assert policy.algorithm == config.training.algorithm and policy.scene == config.scene
    best = jax.tree.leaves(history[-1].state.best)
    assert all(map(np.array_equal, jax.tree.leaves(policy.weights), best))


def test_tensorboard_reads_the_curves(tmp_path, config, linear_task, history):
    with Run.create(tmp_path / "x", config, linear_task) as run:
        for progress in history:
            run.record(progress)
    (path,) = (run.folder / "tensorboard").iterdir()
    points = [(e.step, v.tag, v.simple_value) for e in events(path) for v in e.summary.value]
    evaluated = [(step, value) for step, tag, value in points if tag == "success/evaluation"]
    assert [step for step, _ in evaluated] == [2, 4]
    assert {tag for _, tag, _ in points} == {
        *("success/episodes", "success/evaluation", "robustness/evaluation"),
        *("reward/step", "time/train_seconds", "simulations/diverged"),
    }
    rewards = [value for _, tag, value in points if tag == "reward/step"]
    np.testing.assert_allclose(rewards, [p.batch_return for p in history], rtol=1e-6)


def events(path) -> list[Event]:
    """Events of a TensorBoard file: length, checksum, message, checksum."""
    data, found = path.read_bytes(), []
    while data:
        (size,) = struct.unpack("<Q", data[:8])
        found.append(Event.FromString(data[12 : 12 + size]))
        data = data[16 + size :]
    return found


def test_the_configuration_survives_the_file(tmp_path, config, linear_task):
    limited = replace(config, training=replace(config.training, time_limit=7.5))
    for name, written in (("a", config), ("b", limited)):
        Run.create(tmp_path / name, written, linear_task).close()
        assert read_config(tmp_path / name) == written


def test_a_folder_with_something_in_it_is_refused(tmp_path, config, linear_task):
    Run.create(tmp_path / "x", config, linear_task).close()
    with pytest.raises(RunError, match="exists and is not empty.*--resume"):
        Run.create(tmp_path / "x", config, linear_task)
    (tmp_path / "empty").mkdir()
    Run.create(tmp_path / "empty", config, linear_task).close()
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="cannot be made"):
        Run.create(tmp_path / "file", config, linear_task)


def test_a_run_has_one_writer(tmp_path, config, linear_task, history, capsys):
    """The second is told who holds the run, and leaves every line as it is."""
    with Run.create(tmp_path / "x", config, linear_task) as run:
        run.record(history[0])
        run.checkpoint()
        run.record(history[1])
        holder = f"x: in use by process {os.getpid()} on {socket.gethostname()}"
        with pytest.raises(RunError, match=re.escape(holder)):
            Run.resume(tmp_path / "x")
        assert main(["--resume", str(tmp_path / "x")]) == 2
        assert holder in capsys.readouterr().err
        run.record(history[2])
        assert [line["epoch"] for line in lines(run)] == [1, 2, 3]
    with Run.resume(tmp_path / "x") as run:
        assert [line["epoch"] for line in lines(run)] == [1]


def test_a_run_that_was_killed_before_it_began_can_be_made_again(tmp_path, config, linear_task):
    (tmp_path / "x").mkdir()
    for name in ("lock", "lock.json", ".config.json.k1j2.tmp", ".lock.json.x.tmp"):
        (tmp_path / "x" / name).write_text("")
    Run.create(tmp_path / "x", config, linear_task).close()
    assert read_config(tmp_path / "x") == config
    assert not list((tmp_path / "x").glob(".*.tmp"))


def test_a_run_that_cannot_be_opened_is_not_held(tmp_path, config, linear_task):
    Run.create(tmp_path / "x", config, linear_task).close()
    (tmp_path / "x/checkpoints").mkdir()
    (tmp_path / "x/checkpoints/epoch-0000001.safetensors").write_bytes(b"")
    with pytest.raises(UserError, match="not a complete safetensors file"):
        Run.resume(tmp_path / "x")
    (tmp_path / "x/checkpoints/epoch-0000001.safetensors").unlink()
    Run.resume(tmp_path / "x").close()


def test_default_folders_never_meet(tmp_path, config):
    names = [default_folder(tmp_path, config).name for _ in range(3)]
    assert names == ["linear-08-tgpo-star-3", "linear-08-tgpo-star-3-2", "linear-08-tgpo-star-3-3"]
    odd = replace(config, scene=replace(config.scene, name="../ a/b*"))
    assert default_folder(tmp_path, odd).resolve() == tmp_path / "a-b-tgpo-star-3"


def with_weights(progress, value: float):
    """The progress with all biases of the actor replaced."""
    learner = progress.state.learner
    actor = jax.tree.map(lambda leaf: jnp.full_like(leaf, value), learner.parameters.actor)
    weights = learner.parameters._replace(actor=actor)
    learner = learner._replace(parameters=weights)
    return replace(progress, weights=weights, state=progress.state._replace(learner=learner))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_weights_that_are_not_finite_are_never_kept(tmp_path, config, linear_task, history, value):
    with Run.create(tmp_path / "x", config, linear_task) as run:
        run.record(history[0])
        with pytest.raises(DivergedError, match="diverged in epoch 2 .* not finite"):
            run.record(with_weights(history[1], value))
        run.finish("diverged")
    found = load_checkpoint(run.folder / "checkpoints", history[0].state)
    assert found is not None and same_bits(found.tree, history[0].state)
    assert [line["epoch"] for line in lines(run)] == [1]
    load_bundle(run.folder / "bundle")


def test_a_full_disk_keeps_the_last_checkpoint(tmp_path, config, linear_task, history, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(run_module, "CHECKPOINT_SECONDS", 0.0)
    with Run.create(tmp_path / "x", config, linear_task) as run:
        run.record(history[0])
        with monkeypatch.context() as patch:
            patch.setattr(os, "replace", full)
            with pytest.raises(UserError, match="No space left on device"):
                run.record(history[1])
    with Run.resume(run.folder) as again:
        assert again.state is not None and same_bits(again.state, history[0].state)


def test_checkpoints_are_due_by_the_clock(tmp_path, config, linear_task, history, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(run_module.time, "monotonic", lambda: now[0])
    kept = []
    with Run.create(tmp_path / "x", config, linear_task) as run:
        for progress, now[0] in zip(history, (0.0, 4.9, 5.0, 9.9), strict=True):
            run.record(progress)
            kept.append([path.stem[-1] for path in checkpoints(run.folder / "checkpoints")])
    assert kept == [["1"], ["1"], ["3", "1"], ["3", "1"]]


def test_a_run_without_a_checkpoint_starts_again(tmp_path, config, linear_task):
    Run.create(tmp_path / "x", config, linear_task).close()
    with Run.resume(tmp_path / "x") as run:
        assert run.epochs == 0 and "from the beginning" in run.notes[0]
        with pytest.raises(RunError, match="no epoch was finished"):
            run.finish("interrupted")


def test_a_damaged_checkpoint_is_passed_over_with_a_note(tmp_path, config, linear_task, history):
    with Run.create(tmp_path / "x", config, linear_task) as run:
        for progress in history[:2]:
            run.record(progress)
            run.checkpoint()
    newest = checkpoints(run.folder / "checkpoints")[0]
    newest.write_bytes(newest.read_bytes()[:-1])
    with Run.resume(run.folder) as again:
        assert again.epochs == 1 and newest.name in again.notes[0]


def test_a_new_budget_can_be_given(tmp_path, config, linear_task, history):
    with Run.create(tmp_path / "x", config, linear_task) as run:
        run.record(history[1])
    achieved = float(history[1].state.best_success)
    for target, finished in ((achieved + 0.1, False), (max(achieved, 1e-9), achieved > 0)):
        with Run.resume(run.folder, epochs=9, target=target) as again:
            assert again.config.training.epochs == 9 and again.state is not None
            assert bool(again.state.finished) == finished
    assert read_config(run.folder).training.epochs == 9


def test_the_best_policy_is_the_latest_before_an_evaluation(config, linear_task, history):
    asked = (linear_task, config.training)
    assert best_weights(*asked, history[0].state) is history[0].weights
    assert best_weights(*asked, history[1].state) is history[1].state.best
    fresh = fresh_state(*asked)
    assert best_weights(*asked, fresh) is fresh.learner.parameters


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"format": 2}, "format: 2 is not known; this program reads format 1"),
        ({"format": None}, "format: None is not known"),
        ({"seed": "x"}, "config.json: seed: 'x' must be an integer from 0"),
        ({"seed": -1}, "seed: -1 must be an integer from 0"),
        ({"epochs": True}, "epochs: True must be an integer from 1"),
        ({"epochs": 0}, "epochs: 0 must be an integer from 1"),
        ({"mode": "fast"}, "mode: unknown 'fast'"),
        ({"formula": "F_[0:1](A1)"}, "formula: differs"),
        ({"scene": "robot ="}, "scene: not valid TOML"),
        ({"algorithm": {}}, "algorithm.mode: this table is missing"),
        (
            {"algorithm": {"mode": {}, "hiden": [3]}},
            "algorithm.hiden: unknown. Allowed: hidden, env",
        ),
        (
            {"algorithm": {"mode": {}, "hidden": 3}},
            "algorithm.hidden: 3 must be a list of at most 8, each entry an int",
        ),
        ({"algorithm": {"mode": 3}}, "config.json: algorithm.mode: 3 must be a table"),
        ({"algorithm": {"mode": {}, "hidden": [3, "x"]}}, r"algorithm.hidden\[1\]: 'x' must be"),
        ({"algorithm": {"mode": {}, "clip": 0}}, "algorithm.clip: 0 must be a number above 0"),
        (
            {"algorithm": {"mode": {}, "environments": -5}},
            "environments: -5 must be an integer from 1",
        ),
        ({"algorithm": []}, r"algorithm: \[\] must be a table"),
        ({"time_limit": 0}, "time_limit: 0 must be a number above 0 or null"),
        ({"sede": 3}, "config.json: sede: unknown. Allowed: seed, "),
        ({"format": True}, "format: True is not known"),
        ({"target": math.nan}, "not valid JSON: invalid character in line"),
        ({"algorithm": {"mode": {"scale": "x"}}}, "algorithm.mode.scale: 'x' must be a number"),
    ],
)
def test_a_configuration_that_was_tampered_with_is_refused(
    tmp_path, config, linear_task, changed, message
):
    Run.create(tmp_path / "x", config, linear_task).close()
    path = tmp_path / "x/config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changed, indent=1))
    with pytest.raises(UserError, match=message):
        Run.resume(tmp_path / "x")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "not valid JSON: "),
        ("{", "not valid JSON: "),
        ('{\n"format": 1,\n?}', "not valid JSON: .* in line 3"),
        ('{"format": 1e999}', "not valid JSON: .*out of range"),
        ("[]", "must be a table"),
        ("\xff", "not valid JSON: "),
        ("[" * 100_000, "nested too deeply"),
        (" " * 4_000_001, "larger than 4,000,000 bytes"),
    ],
)
def test_a_configuration_that_is_no_object_is_refused(tmp_path, text, reason):
    (tmp_path / "config.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(UserError, match=f"config.json: {reason}"):
        read_config(tmp_path)


def test_a_missing_field_is_named(tmp_path, config, linear_task):
    Run.create(tmp_path / "x", config, linear_task).close()
    path = tmp_path / "x/config.json"
    values = json.loads(path.read_text())
    del values["method"]
    path.write_text(json.dumps(values))
    with pytest.raises(UserError, match="method: this field is missing"):
        read_config(tmp_path / "x")


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(RunError, match="not a run"):
        Run.resume(tmp_path)


@pytest.mark.parametrize(
    "budget",
    [
        *({"epochs": 0}, {"epochs": 10**7}, {"time_limit": 0.0}, {"time_limit": math.nan}),
        *({"target": 0.0}, {"target": math.nan}, {"target": math.inf}, {"seed": -1}),
    ],
)
def test_bad_budgets_are_refused(budget):
    (name,) = budget
    with pytest.raises(RunError, match=f"{name}: .* must be "):
        make_config(load_task("linear-01"), **budget)
