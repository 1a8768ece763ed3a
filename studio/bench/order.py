"""What the process of a run is told."""

import msgspec

from studio.bench.matrix import Job


class Order(msgspec.Struct, frozen=True):
    """A job, and what of the machine it may use."""

    job: Job
    concurrent: int = 1
    """Runs at the same time on this machine."""
    cores: tuple[int, ...] = ()
    """Numbers of the processor's cores that the run keeps to; none: all of them."""
