"""Fixtures shared by the tests, and how they compile, which is what costs most of their time.

Compiled programs are kept on disk. Those of a test run once or twice, so that the optimisation of
their machine code does not pay: only tests marked `optimised` have it, and all else is compiled
from the same HLO with the same library calls. Tests' own programs do without the fusion emitters,
too; a `Program` of core says by itself whether it uses them.
"""

import os

import pytest

# Subprocesses inherit both. `JAX_DISABLE_MOST_OPTIMIZATIONS=0 make test` optimises everything.
os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} --xla_cpu_use_fusion_emitters=false"
QUICKLY = os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1") == "1"

MOST_MEMORY = 1.5e9
"""Above it compiled programs are dropped [bytes]; they are found on disk when asked for again."""


def pytest_configure():
    compile_as_tests_do(optimised=False)


def pytest_runtest_setup(item):
    # The command line, when a test runs it, sets the cache as it needs it.
    compile_as_tests_do(optimised=item.get_closest_marker("optimised") is not None)


def pytest_runtest_teardown():
    from tests.memory import release_programs, resident

    if resident() > MOST_MEMORY:
        release_programs()


def compile_as_tests_do(*, optimised: bool) -> None:
    """Keep all programs on disk, not only the larger ones."""
    import jax

    from core.compilation import use_disk_cache

    use_disk_cache()
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_disable_most_optimizations", QUICKLY and not optimised)


@pytest.fixture(scope="session")
def disk_cache():
    """Asked for by what compiles much: `make quick` leaves it out."""


@pytest.fixture(scope="session")
def small_algorithm(disk_cache):
    """TGPO* in studio mode, small enough to train an epoch in milliseconds; learns nothing."""
    from core.methods.tgpo.algorithm import make_algorithm
    from envs import Linear
    from tests.small import shrink

    return shrink(make_algorithm("studio", "tgpo-star", Linear()))


@pytest.fixture(scope="session")
def linear_task():
    """linear-08 (`F_[0:90](A1) & F_[40:80](A2 & F_[10:20](G_[0:10](A3))) & ...`)."""
    from scenes import load_task
    from studio.runs.tasks import build_task

    return build_task(load_task("linear-08"))


SLOW_FOLDERS = ("core/mdp", "core/methods", "core/task", "envs", "scenes", "studio/runs", "tools")
SLOW_FIXTURES = {"chromium_path", "disk_cache", "small_algorithm", "linear_task"}


def pytest_collection_modifyitems(items):
    """Mark what opens a browser, and what is slow: `make quick` leaves it out."""
    for item in items:
        if "chromium_path" in item.fixturenames:
            item.add_marker("browser")
        place = item.path.relative_to(item.config.rootpath / "tests").as_posix()
        alone = place.count("/") == 0 and place != "test_layers.py"
        whole_page = place.startswith("studio/page/test_")
        if alone or whole_page or place.startswith(SLOW_FOLDERS):
            item.add_marker("slow")
        elif SLOW_FIXTURES & set(item.fixturenames):
            item.add_marker("slow")
