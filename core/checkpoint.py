"""Checkpoints: a pytree of arrays in one safetensors file, written atomically.

safetensors rather than orbax: a checkpoint here is a few hundred kilobytes of arrays on one
machine, so one small file that appears by a rename needs no background machinery, no folder
protocol and no further dependency, and the same format holds the weights of policy bundles.

A file is written beside its destination, flushed to disk and renamed over it: a writer that is
killed, or meets a full disk, leaves the previous file and at most a temporary one, which the next
save removes. A JSON header names the kind of the file, its version and the type of each random
key (typed keys are kept as their key data); names, shapes and types of all arrays are checked
against the pytree that the reader expects.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import msgspec
import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from core.errors import UserError
from core.quoting import quoted

VERSION = 1
"""Version of the files that this program reads and writes."""

LARGEST_HEADER = 4_000_000
"""Bytes of a safetensors header: names, types and shapes of the arrays."""

_HEADER = "tgpo-studio"
_TYPES = {"BOOL": "bool"} | {
    f"{name[0].upper()}{bits}": f"{name}{bits}"
    for name in ("float", "int", "uint")
    for bits in (8, 16, 32, 64)
}
"""NumPy's names of safetensors' types."""
_TEMPORARY = ".tmp"
_CHECKPOINT = "epoch-*.safetensors"

Tree = TypeVar("Tree")


class CheckpointError(UserError):
    """A checkpoint that cannot be written, read or used."""


class DivergedError(UserError):
    """Weights that are not finite."""


class _Header(msgspec.Struct):
    """What this program writes about a file into its safetensors header."""

    kind: str
    version: int
    keys: dict[str, str]
    """Type of each random key."""


class Loaded(NamedTuple):
    """A restored pytree, its file, and why newer files were skipped."""

    tree: Any
    path: Path
    skipped: tuple[str, ...]


def save_checkpoint(folder: Path, tree: Any, epoch: int, *, keep: int = 2) -> Path:
    """Write the checkpoint of an epoch, then remove all but the last `keep`.

    Raises:
        CheckpointError: the disk is full or cannot be written; the previous checkpoints stay.
    """
    path = folder / _CHECKPOINT.replace("*", f"{epoch:07d}")
    with _explained(path, "written"):
        folder.mkdir(parents=True, exist_ok=True)
        remove_leftovers(folder)
    save_tree(path, tree, kind="checkpoint")
    for old in checkpoints(folder)[keep:]:
        with suppress(OSError):
            old.unlink()
    return path


def load_checkpoint(folder: Path, like: Any) -> Loaded | None:
    """The newest readable checkpoint, None if there are no checkpoints.

    Raises:
        CheckpointError: there are checkpoints, but none can be read.
    """
    problems: list[CheckpointError] = []
    for path in checkpoints(folder):
        try:
            tree = load_tree(path, like, kind="checkpoint")
        except CheckpointError as error:
            problems.append(error)
            continue
        return Loaded(tree, path, tuple(str(problem) for problem in problems))
    if problems:
        raise problems[0]
    return None


def checkpoints(folder: Path) -> list[Path]:
    """Checkpoint files of a folder, newest first."""
    return sorted(folder.glob(_CHECKPOINT), reverse=True)


def save_tree(path: Path, tree: Any, *, kind: str) -> None:
    """Write a pytree of arrays atomically.

    Args:
        path: the file.
        tree: arrays of any type that safetensors supports, and typed random keys.
        kind: what the file is, such as `checkpoint`; the reader must ask for the same kind.

    Raises:
        CheckpointError: the disk is full or cannot be written; an earlier file stays.
    """
    arrays, keys = {}, {}
    for name, leaf in _named_leaves(tree).items():
        if _is_key(leaf):
            keys[name] = str(jax.random.key_impl(leaf))
            leaf = jax.random.key_data(leaf)  # noqa: PLW2901
        arrays[name] = np.array(leaf, order="C")  # ascontiguousarray would add an axis to scalars
    header = msgspec.json.encode(_Header(kind, VERSION, keys)).decode()
    with _explained(path, "written"):
        write_atomically(path, save(arrays, {_HEADER: header}))


def load_tree(path: Path, like: Tree, *, kind: str) -> Tree:
    """Read a pytree of the structure, shapes and types of `like` (arrays or their shapes).

    Raises:
        CheckpointError: no such file, a truncated or foreign one, another kind or version, or
            arrays that do not fit.
    """
    expected = {name: _stored(leaf) for name, leaf in _named_leaves(like).items()}
    with _opened(path) as file:
        header = _header(path, file.metadata() or {}, kind)
        found = {name: _type_text(file.get_slice(name)) for name in file.keys()}  # noqa: SIM118
        for name in sorted(set(expected) - set(found)):
            raise CheckpointError(
                f"{path}: the array {name!r} is missing; it does not fit this task"
            )
        for name in sorted(set(found) - set(expected)):
            raise CheckpointError(
                f"{path}: unexpected array {quoted(name)}; it does not fit this task"
            )
        for name, wanted in expected.items():  # all of them before any is read
            if found[name] != f"{wanted.dtype}{list(wanted.shape)}":
                raise CheckpointError(
                    f"{path}: {name!r} is {found[name]}, expected {wanted.dtype}"
                    f"{list(wanted.shape)}; it does not fit this task"
                )
        arrays = {name: file.get_tensor(name) for name in expected}
    leaves = [
        _restored(path, name, arrays[name], header, leaf)
        for name, leaf in _named_leaves(like).items()
    ]
    return jax.tree.unflatten(jax.tree.structure(like), leaves)


def require_finite(parameters: Any, what: str) -> None:
    """Refuse weights with NaN or infinite entries; `what` says where they come from.

    Raises:
        DivergedError: with the name of the first such array.
    """
    for name, leaf in _named_leaves(parameters).items():
        if not np.isfinite(np.asarray(leaf)).all():
            raise DivergedError(f"{what}: the weights {name!r} contain numbers that are not finite")


def write_atomically(path: Path, data: bytes) -> None:
    """Replace a file: a reader sees the old content or the new, never a part.

    Raises:
        OSError: as from the file system; the old file is untouched.
    """
    handle, temporary = tempfile.mkstemp(_TEMPORARY, f".{path.name}.", path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise
    _sync_folder(path.parent)


def remove_leftovers(folder: Path) -> None:
    """Remove temporary files of writers that were killed."""
    for leftover in folder.glob(f".*{_TEMPORARY}"):
        with suppress(OSError):
            leftover.unlink()


def _sync_folder(folder: Path) -> None:
    """Make a rename durable, where folders can be flushed (not on Windows)."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextmanager
def _explained(path: Path, verb: str) -> Iterator[None]:
    """Turn an OSError into a CheckpointError that names the file and the reason."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise CheckpointError(f"{path}: cannot be {verb}: {reason}") from error


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A safetensors file; what it holds that cannot be read is a CheckpointError."""
    with _explained(path, "read"):
        with path.open("rb") as file:  # safetensors reports a missing file without its reason
            size = int.from_bytes(file.read(8), "little")
        if size > LARGEST_HEADER:
            raise CheckpointError(
                f"{path}: not a complete safetensors file (a header of {size:,} bytes); at most "
                f"{LARGEST_HEADER:,} are read"
            )
        try:
            with safe_open(path, framework="np") as file:
                yield file
        except UserError:
            raise
        except (SafetensorError, TypeError, ValueError, KeyError, MemoryError) as error:
            raise CheckpointError(
                f"{path}: not a complete safetensors file ({error}); it is truncated or of "
                "another kind"
            ) from error


def _header(path: Path, metadata: dict[str, str], kind: str) -> _Header:
    """What this program has written about the file."""
    if _HEADER not in metadata:
        raise CheckpointError(f"{path}: not written by this program (its header is missing)")
    try:
        header = msgspec.json.decode(metadata[_HEADER], type=_Header)
    except msgspec.ValidationError as error:
        raise CheckpointError(f"{path}: not written by this program: header: {error}") from error
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise CheckpointError(f"{path}: its header is not valid JSON: {error}") from error
    if header.version != VERSION:
        raise CheckpointError(
            f"{path}: version {header.version} is not known; this program reads version {VERSION}"
        )
    if header.kind != kind:
        raise CheckpointError(f"{path}: is a {quoted(header.kind)} file, not a {kind!r} file")
    return header


def _stored(leaf: Any) -> Any:
    """Shape and type of the array that stands for a leaf in a file."""
    return jax.eval_shape(jax.random.key_data, leaf) if _is_key(leaf) else leaf


def _type_text(array: Any) -> str:
    """Type and shape of an array that is not read yet: `float32[2, 3]`."""
    kind = array.get_dtype()
    return f"{_TYPES.get(kind, kind)}{array.get_shape()}"


def _restored(path: Path, name: str, array: np.ndarray, header: _Header, leaf: Any) -> jax.Array:
    """The leaf that a stored array stands for."""
    if not _is_key(leaf):
        return jnp.asarray(array)
    kind = header.keys.get(name)
    try:
        key = jax.random.wrap_key_data(jnp.asarray(array), impl=kind)
    except (TypeError, ValueError) as error:
        raise CheckpointError(
            f"{path}: {name!r} is a random key of unknown type {quoted(str(kind))}"
        ) from error
    if key.dtype != leaf.dtype:
        raise CheckpointError(f"{path}: {name!r} is a {key.dtype}, expected a {leaf.dtype}")
    return key


def _named_leaves(tree: Any) -> dict[str, Any]:
    """Leaves of a pytree by their path, such as `learner/parameters/log_std`."""
    leaves, _ = jax.tree_util.tree_flatten_with_path(tree)
    return {jax.tree_util.keystr(path, simple=True, separator="/"): leaf for path, leaf in leaves}


def _is_key(leaf: Any) -> bool:
    return jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)
