"""What does not fit into memory is refused with numbers, before anything is compiled."""

import pytest

from core import memory
from core.errors import UserError
from core.methods.training import TrainingConfig, train


def test_a_training_that_does_not_fit_is_refused(linear_task, small_algorithm, monkeypatch):
    """16 environments, 112 steps, 369 bytes a step four times over and 128 of activations."""
    config = TrainingConfig(small_algorithm, epochs=1)
    monkeypatch.setattr(memory, "free_bytes", lambda: 1_000_000)
    with pytest.raises(
        UserError, match=r"112 steps in 16 environments need about 0\.0 GB.*but"
    ) as e:
        next(train(linear_task, config))
    steps = int(str(e.value).split("about ")[-1].split(" steps")[0])
    assert 1_000_000 / (16 * (4 * 390 + 128)) < steps < 1_000_000 / (16 * (4 * 350 + 128))


@pytest.mark.parametrize("free", [None, 10**12])
def test_a_training_that_fits_is_not(linear_task, small_algorithm, monkeypatch, free):
    monkeypatch.setattr(memory, "free_bytes", lambda: free)
    learner = TrainingConfig(small_algorithm).learner(linear_task)
    assert learner.jobs(learner.fresh(0))


def test_free_memory_is_that_of_the_container_where_it_is_less(tmp_path, monkeypatch):
    (tmp_path / "meminfo").write_text("MemTotal: 100 kB\nMemAvailable:   50 kB\n")
    monkeypatch.setattr(memory, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory, "_GROUP", tmp_path)
    assert memory.free_bytes() == 51_200
    (tmp_path / "memory.max").write_text("max\n")
    assert memory.free_bytes() == 51_200
    (tmp_path / "memory.max").write_text("40000\n")
    (tmp_path / "memory.current").write_text("30000\n")
    (tmp_path / "memory.stat").write_text("anon 1\ninactive_file 5000\n")
    assert memory.free_bytes() == 15_000
    monkeypatch.setattr(memory, "_MEMINFO", tmp_path / "nothing")
    (tmp_path / "memory.max").unlink()
    assert memory.free_bytes() is None
