"""Memory that is still free, so that what cannot fit is refused instead of aborting the process."""

from pathlib import Path
from typing import Any

import jax

from core.errors import UserError

_GROUP = Path("/sys/fs/cgroup")
_MEMINFO = Path("/proc/meminfo")


COPIES = 4
"""How often an epoch holds its batch: collected, flattened, dealt into minibatches."""


def require_memory(batch: Any, steps: int, environments: int, *, beside: int = 0) -> None:
    """Refuse a batch that does not fit.

    Args:
        batch: a pytree of arrays or of their shapes, held `COPIES` times.
        steps: length of its episodes.
        environments: number of its episodes.
        beside: further bytes that grow with the steps.

    Raises:
        UserError: with what would fit.
    """
    size = sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(batch))
    needed, free = COPIES * size + beside, free_bytes()
    if free is not None and needed > free:
        raise UserError(
            f"episodes of {steps:,} steps in {environments:,} environments need about "
            f"{needed / 1e9:.1f} GB of memory, but {free / 1e9:.1f} GB are free; about "
            f"{max(0, int(steps * free / needed)):,} steps would fit"
        )


def free_bytes() -> int | None:
    """Bytes that arrays may still take where programs run; None where nobody tells."""
    device = jax.local_devices()[0]
    if device.platform != "cpu":
        stats = device.memory_stats() or {}
        limit = stats.get("bytes_limit")
        return None if limit is None else limit - stats.get("bytes_in_use", 0)
    return min((free for free in (_of_machine(), _of_group()) if free is not None), default=None)


def _of_machine() -> int | None:
    """What Linux says that programs may take without swapping."""
    try:
        rows = dict(line.split(":") for line in _MEMINFO.read_text().splitlines())
        return int(rows["MemAvailable"].split()[0]) * 1024
    except (OSError, KeyError, ValueError):
        return None


def _of_group() -> int | None:
    """What the limit of a container leaves; cached files that can be dropped count as free."""
    try:
        limit = int((_GROUP / "memory.max").read_text())  # "max" where there is none
        used = int((_GROUP / "memory.current").read_text())
        stat = dict(line.split() for line in (_GROUP / "memory.stat").read_text().splitlines())
        return limit - used + int(stat.get("inactive_file", 0))
    except (OSError, ValueError):
        return None
