"""Checkpoints: exact round trips, and nothing lost to a full disk, a kill or a bad file."""

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from safetensors.numpy import save_file

from core.checkpoint import (
    CheckpointError,
    DivergedError,
    checkpoints,
    load_checkpoint,
    load_tree,
    require_finite,
    save_checkpoint,
    save_tree,
)

ROOT = Path(__file__).parents[2]


class State(NamedTuple):
    weights: dict
    key: jax.Array
    epoch: jax.Array
    finished: jax.Array
    best: jax.Array
    empty: tuple = ()


def make_state(epoch: int = 3) -> State:
    weights = {"kernel": jnp.arange(6.0).reshape(2, 3) / 7, "none": jnp.zeros((0, 8), jnp.int32)}
    return State(
        weights,
        jax.random.fold_in(jax.random.key(5), epoch),
        jnp.int32(epoch),
        jnp.bool_(True),
        jnp.float32(-jnp.inf),
    )


def bits(tree) -> list[bytes]:
    """Every leaf's exact content."""
    leaves = jax.tree.leaves(tree)
    keys = [jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key) for leaf in leaves]
    plain = [jax.random.key_data(x) if key else x for x, key in zip(leaves, keys, strict=True)]
    return [np.asarray(leaf).tobytes() for leaf in plain]


@pytest.mark.parametrize("shapes_only", [False, True])
def test_round_trip_is_exact(tmp_path, shapes_only):
    state = make_state()
    like = jax.eval_shape(lambda: state) if shapes_only else make_state(9)
    save_tree(tmp_path / "a.safetensors", state, kind="checkpoint")
    loaded = load_tree(tmp_path / "a.safetensors", like, kind="checkpoint")
    assert jax.tree.structure(loaded) == jax.tree.structure(state)
    assert bits(loaded) == bits(state)
    for new, old in zip(jax.tree.leaves(loaded), jax.tree.leaves(state), strict=True):
        assert new.dtype == old.dtype and new.shape == old.shape
    assert jax.random.normal(loaded.key) == jax.random.normal(state.key)


def test_the_last_two_are_kept_and_the_newest_is_loaded(tmp_path):
    for epoch in (1, 2, 10):
        save_checkpoint(tmp_path, make_state(epoch), epoch)
    names = [path.name for path in checkpoints(tmp_path)]
    assert names == ["epoch-0000010.safetensors", "epoch-0000002.safetensors"]
    loaded = load_checkpoint(tmp_path, make_state())
    assert loaded is not None and int(loaded.tree.epoch) == 10 and loaded.skipped == ()


def test_no_checkpoint_yet(tmp_path):
    assert load_checkpoint(tmp_path / "nowhere", make_state()) is None


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_full_disk_loses_nothing(tmp_path, monkeypatch, call):
    save_checkpoint(tmp_path, make_state(1), 1)

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, call, full)
        with pytest.raises(CheckpointError, match="cannot be written: No space left on device"):
            save_checkpoint(tmp_path, make_state(2), 2)
    loaded = load_checkpoint(tmp_path, make_state())
    assert loaded is not None and int(loaded.tree.epoch) == 1
    assert [path.name for path in tmp_path.iterdir()] == [loaded.path.name], "a part was left"


KILLED = """
import os, pathlib, sys, time
from tests.core.test_checkpoint import make_state
from core.checkpoint import save_checkpoint
folder = pathlib.Path(sys.argv[1])
save_checkpoint(folder, make_state(1), 1)
def stuck(handle):  # the content is written, but the file is not yet in its place
    print("writing", flush=True)
    time.sleep(600)
os.fsync = stuck
save_checkpoint(folder, make_state(2), 2)
"""


def test_a_killed_writer_loses_nothing(tmp_path):
    command = [sys.executable, "-c", KILLED, str(tmp_path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None and writer.stdout.readline() == "writing\n"
        writer.kill()
        assert writer.wait() == -signal.SIGKILL
    leftovers = list(tmp_path.glob(".*.tmp"))
    assert leftovers, "the writer was to be killed in the middle"
    loaded = load_checkpoint(tmp_path, make_state())
    assert loaded is not None and int(loaded.tree.epoch) == 1
    save_checkpoint(tmp_path, make_state(2), 2)
    assert not list(tmp_path.glob(".*.tmp"))
    loaded = load_checkpoint(tmp_path, make_state())
    assert loaded is not None and bits(loaded.tree) == bits(make_state(2))


@pytest.mark.parametrize("length", [0, 5, 200, -1])
def test_a_truncated_file_is_refused_and_the_previous_one_used(tmp_path, length):
    save_checkpoint(tmp_path, make_state(1), 1)
    newest = save_checkpoint(tmp_path, make_state(2), 2)
    newest.write_bytes(newest.read_bytes()[:length])
    with pytest.raises(CheckpointError, match="not a complete safetensors file"):
        load_tree(newest, make_state(), kind="checkpoint")
    loaded = load_checkpoint(tmp_path, make_state())
    assert loaded is not None and int(loaded.tree.epoch) == 1
    assert newest.name in loaded.skipped[0]


def test_only_unreadable_checkpoints_are_an_error(tmp_path):
    save_checkpoint(tmp_path, make_state(1), 1).write_bytes(b"nonsense")
    with pytest.raises(CheckpointError, match="epoch-0000001"):
        load_checkpoint(tmp_path, make_state())


def foreign_header(path: Path, header) -> None:
    metadata = None if header is None else {"tgpo-studio": json.dumps(header)}
    save_file({"x": np.zeros(3, np.float32)}, path, metadata)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (None, "not written by this program"),
        ({"version": 1, "kind": "checkpoint"}, "not written by this program"),
        ({"version": 2, "kind": "checkpoint", "keys": {}}, "version 2 is not known"),
        ({"version": 1, "kind": "weights", "keys": {}}, "is a 'weights' file"),
        ({"version": 1, "kind": "checkpoint", "keys": {}}, "'weights/kernel' is missing"),
    ],
)
def test_foreign_files_are_refused(tmp_path, header, message):
    foreign_header(tmp_path / "x.safetensors", header)
    like = {"weights": {"kernel": jnp.zeros(3)}}
    with pytest.raises(CheckpointError, match=message):
        load_tree(tmp_path / "x.safetensors", like, kind="checkpoint")


def test_a_header_that_is_no_json_is_refused(tmp_path):
    save_file({"x": np.zeros(3)}, tmp_path / "x.safetensors", {"tgpo-studio": "{"})
    with pytest.raises(CheckpointError, match="not valid JSON"):
        load_tree(tmp_path / "x.safetensors", {}, kind="checkpoint")


@pytest.mark.parametrize(
    ("like", "message"),
    [
        ({"x": jnp.zeros(4)}, r"'x' is float32\[3\], expected float32\[4\]"),
        ({"x": jnp.zeros(3, jnp.int32)}, r"'x' is float32\[3\], expected int32\[3\]"),
        ({}, "unexpected array 'x'"),
        ({"x": jnp.zeros(3), "y": jnp.zeros(())}, "'y' is missing"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(tmp_path, like, message):
    save_tree(tmp_path / "x.safetensors", {"x": jnp.zeros(3)}, kind="weights")
    with pytest.raises(CheckpointError, match=message):
        load_tree(tmp_path / "x.safetensors", like, kind="weights")


def test_a_key_of_another_type_is_refused(tmp_path):
    path = tmp_path / "x.safetensors"
    save_tree(path, {"k": jax.random.key(0, impl="rbg")}, kind="checkpoint")
    with pytest.raises(CheckpointError, match="'k' is a key"):
        load_tree(path, {"k": jax.random.key(0, impl="unsafe_rbg")}, kind="checkpoint")


@pytest.mark.parametrize("start", ['{"keys": ', '{"other": ', ""])
def test_a_deeply_nested_header_is_refused(tmp_path, start):
    path = tmp_path / "x.safetensors"
    save_file({"x": np.zeros(3)}, path, {"tgpo-studio": start + "[" * 200_000})
    with pytest.raises(CheckpointError, match=r"x\.safetensors: (not written|its header)"):
        load_tree(path, {"x": jnp.zeros(3)}, kind="weights")


def test_a_huge_header_is_refused_unread(tmp_path):
    path = tmp_path / "x.safetensors"
    path.write_bytes((50_000_000).to_bytes(8, "little") + b"{" + b" " * 1000)
    with pytest.raises(CheckpointError, match="a header of 50,000,000 bytes"):
        load_tree(path, {"x": jnp.zeros(3)}, kind="weights")


@pytest.mark.parametrize("path", ["missing.safetensors", "."])
def test_what_cannot_be_opened_is_refused(tmp_path, path):
    with pytest.raises(CheckpointError, match="cannot be read: "):
        load_tree(tmp_path / path, {}, kind="checkpoint")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(CheckpointError, match="cannot be written: "):
        save_checkpoint(tmp_path / "file" / "checkpoints", make_state(), 1)


@pytest.mark.parametrize("bad", [jnp.nan, jnp.inf])
def test_weights_that_are_not_finite_are_named(bad):
    require_finite({"a": jnp.ones(3)}, "epoch 7")
    with pytest.raises(DivergedError, match="epoch 7: the weights 'actor/b' contain numbers"):
        require_finite({"a": jnp.ones(3), "actor": {"b": jnp.array([0.0, bad])}}, "epoch 7")
