"""Fixtures shared by the tests. Compilation is what costs time: programs are kept on disk."""

import pytest


@pytest.fixture(scope="session")
def disk_cache():
    """Compiled programs are found again, as in the program itself."""
    from core.programs import use_disk_cache

    return use_disk_cache()


@pytest.fixture(scope="session")
def small_algorithm(disk_cache):
    """TGPO* in studio mode, small enough to train an epoch in milliseconds; learns nothing."""
    from core.algorithm import make_algorithm
    from tests.small import shrink

    return shrink(make_algorithm("studio", "tgpo-star", "linear"))


@pytest.fixture(scope="session")
def linear_task():
    """linear-08 (`F_[0:90](A1) & F_[40:80](A2 & F_[10:20](G_[0:10](A3))) & ...`)."""
    from scenes import load_task
    from studio.tasks import build_task

    return build_task(load_task("linear-08"))
