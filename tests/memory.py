"""Memory of a session of tests: programs that one module has compiled are of no use to most others.

JAX's caches and every `Program` hold what they have compiled for ever; a session of all the tests
would hold 8 GB.
"""

import ctypes
import gc
from pathlib import Path

import jax

from core.compilation import Program

STATM = Path("/proc/self/statm")
PAGE = 4096


def resident() -> int:
    """Memory of this process [bytes]; 0 where the system is not Linux."""
    return int(STATM.read_text().split()[1]) * PAGE if STATM.exists() else 0


def release_programs() -> None:
    """Forget all compiled programs, and give their memory back to the system."""
    for found in gc.get_objects():
        if isinstance(found, Program):
            found._traced.clear()
    jax.clear_caches()
    gc.collect()
    if STATM.exists():
        ctypes.CDLL(None).malloc_trim(0)
