"""The store of a benchmark: a folder with one Parquet file a run, read as one table.

    DIR/runs/<key>.parquet   one row, written by a rename: it is there as a whole or not at all
    DIR/logs/<key>.log       what the run's process had to say
    DIR/lock                 held by the process that adds runs

A run is finished exactly if its file exists.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from core.checkpoint import remove_leftovers, write_atomically
from core.errors import UserError

try:
    import pyarrow as pa
    from pyarrow import parquet
except ImportError as error:
    raise UserError("tgpo-bench needs pyarrow: pip install 'tgpo-studio[bench]'") from error

_POINT = pa.struct(
    {
        "epoch": pa.int64(),
        "seconds": pa.float64(),
        "cpu_seconds": pa.float64(),
        "env_steps": pa.int64(),
        "success_rate": pa.float64(),
        "robustness_mean": pa.float64(),
    }
)

_MAP = pa.struct(
    {
        "first": pa.list_(pa.int64()),  # steps, of the first variable
        "second": pa.list_(pa.int64()),
        "scores": pa.list_(pa.float32()),  # row by row; NaN where legs are too short
    }
)

_CASE = pa.struct(
    {
        "case": pa.string(),
        "formula": pa.string(),
        "first_seconds": pa.float64(),  # of the library, compilation included
        "seconds": pa.float64(),
        "own_first_seconds": pa.float64(),
        "own_seconds": pa.float64(),
        "difference": pa.float64(),  # m, the largest
    }
)

SCHEMA = pa.schema(
    {
        "key": pa.string(),
        "status": pa.string(),  # finished, or refused: what the method or the scene does not allow
        "message": pa.string(),  # why it was refused
        "robot": pa.string(),
        "task": pa.string(),
        "method": pa.string(),
        "mode": pa.string(),
        "variant": pa.string(),
        "weights": pa.string(),
        "horizon": pa.int64(),  # steps of an episode
        "seed": pa.int64(),
        "success_rate": pa.float64(),
        "robustness_mean": pa.float64(),  # m
        "middle_robustness": pa.float64(),  # m, from the middle of the initial set; Linear only
        "bound": pa.float64(),  # m, that no trace from there exceeds; of the exact planner
        "epochs": pa.int64(),
        "env_steps": pa.int64(),
        "stopped": pa.string(),  # by what the training ended: target, epochs, seconds, cpu_seconds
        "train_seconds": pa.float64(),  # evaluations during training included, compilation not
        "train_cpu_seconds": pa.float64(),  # the same, of all threads of the processor
        "compile_seconds": pa.float64(),
        "wall_seconds": pa.float64(),  # all of the run, from the process's start on
        "cpu_seconds": pa.float64(),  # the same, of all threads of the processor
        "concurrent": pa.int64(),  # runs at the same time on this machine, itself included
        "cores": pa.int64(),  # that the run was allowed to use
        "peak_bytes": pa.int64(),
        "curve": pa.list_(_POINT),  # the evaluations during training
        "critic_scores": pa.list_(pa.float32()),  # of random schedules
        "critic_robustness": pa.list_(pa.float32()),  # m, of their rollouts
        "critic_map": _MAP,
        "cases": pa.list_(_CASE),  # of robustness by another library
        "started": pa.string(),  # ISO 8601, UTC
        "revision": pa.string(),
        "versions": pa.map_(pa.string(), pa.string()),
        "machine": pa.map_(pa.string(), pa.string()),
        "job": pa.string(),  # the whole job as JSON
        "configuration": pa.string(),  # all hyper-parameters as JSON
    }
)

_COMPRESSION: dict[str, Any] = {
    "compression": "zstd",
    "compression_level": 19,
    "use_dictionary": [name for name in SCHEMA.names if not name.startswith("critic")],
    # Thousands of numbers, which compress better byte by byte.
    "use_byte_stream_split": ["critic_scores.list.element", "critic_robustness.list.element"],
}


class Store:
    """A folder of runs."""

    def __init__(self, folder: Path):
        self.folder = folder

    def path(self, key: str) -> Path:
        """The file of a run."""
        return self.folder / "runs" / f"{key}.parquet"

    def log(self, key: str) -> Path:
        """The log of a run."""
        return self.folder / "logs" / f"{key}.log"

    def open(self) -> None:
        """Make the folders, and remove what killed writers have left.

        Raises:
            UserError: they cannot be made.
        """
        try:
            for part in ("runs", "logs"):
                (self.folder / part).mkdir(parents=True, exist_ok=True)
            remove_leftovers(self.folder / "runs")
        except OSError as error:
            raise UserError(f"{self.folder}: cannot be made: {error.strerror}") from error

    def finished(self, key: str) -> bool:
        """Whether a run is in the store."""
        return self.path(key).is_file()

    def __len__(self) -> int:
        return sum(1 for _ in (self.folder / "runs").glob("*.parquet"))

    def add(self, row: dict[str, Any]) -> None:
        """Keep the row of a run."""
        write_rows(self.path(row["key"]), [row])

    def rows(self) -> list[dict[str, Any]]:
        """All runs, by their keys.

        Raises:
            UserError: not a store, or a file that is damaged.
        """
        if not (self.folder / "runs").is_dir():
            raise UserError(f"{self.folder}: not a benchmark's folder (runs/ is missing)")
        found: list[dict[str, Any]] = []
        for path in sorted((self.folder / "runs").glob("*.parquet")):
            found += read_rows(path)
        return found

    def merge(self, origin: Path) -> int:
        """Add the runs of another store's folder, or of one table; returns how many were new.

        Raises:
            UserError: neither of the two, or a file that is damaged.
        """
        rows = Store(origin).rows() if origin.is_dir() else read_rows(origin)
        new = [row for row in rows if not self.finished(row["key"])]
        for row in new:
            self.add(row)
        return len(new)


def read_rows(path: Path) -> list[dict[str, Any]]:
    """The runs of a Parquet file.

    Raises:
        UserError: it cannot be read, or holds something else.
    """
    try:
        return parquet.read_table(path, schema=SCHEMA).to_pylist(maps_as_pydicts="strict")
    except (OSError, pa.ArrowException) as error:
        raise UserError(f"{path}: cannot be read: {error}") from error


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Keep runs in one compressed Parquet file, which a store can take over again."""
    sink = pa.BufferOutputStream()
    table = pa.Table.from_pylist(rows, SCHEMA)
    parquet.write_table(table, sink, **_COMPRESSION)
    write_atomically(path, sink.getvalue().to_pybytes())
