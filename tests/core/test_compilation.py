"""How many compiled programs are kept."""

import jax
import jax.numpy as jnp

from core import compilation
from core.compilation import Program


def live_programs() -> int:
    return len(jax.devices()[0].client.live_executables())


def test_a_program_keeps_the_combinations_used_last(monkeypatch):
    monkeypatch.setattr(compilation, "MOST_KEPT", 3)
    traces = []

    def double(x, *, times):
        traces.append(times)
        return times * x

    program = Program(double)
    for times in (1, 2, 3, 1, 4):  # 4 takes the place of 2
        assert float(program(jnp.float32(2), times=times)) == 2 * times
    assert traces == [1, 2, 3, 4]
    program(jnp.float32(2), times=1)
    program(jnp.float32(2), times=3)
    assert traces == [1, 2, 3, 4]
    program(jnp.float32(2), times=2)
    assert traces == [1, 2, 3, 4, 2]


def test_memory_for_programs_is_bounded(monkeypatch):
    monkeypatch.setattr(compilation, "MOST_KEPT", 3)
    program = Program(lambda x, *, times: jnp.sin(times * x))
    argument = jnp.float32(2)
    for times in range(4):
        program(argument, times=times)
    before = live_programs()
    for times in range(4, 14):
        program(argument, times=times)
    assert live_programs() <= before
