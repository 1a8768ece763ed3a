"""Compilation ahead of time, beside the code that is compiled.

    @program
    def choose(problem, controller, key, *, count): ...

    seconds = compile_together(lambda: choose.compile(problem, controller, key, count=8), ...)
    choose(problem, controller, key, count=8)    # compiles nothing

A program is compiled once for each combination of shapes, of static parts of its arguments (a
problem's robot and world, say) and of keyword arguments, which are static. It can be compiled for
shapes alone. With JAX's cache on disk (`use_disk_cache`) a later process finds it there. A program
keeps its last `MOST_KEPT` combinations in memory, so that a page that stays open for days does not
grow with the tasks that it has shown.
"""

import threading
import time
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, cast

import jax
from platformdirs import user_cache_path

MOST_KEPT = 24
"""Combinations that a program keeps; the shipped tasks of all robots need fewer than a quarter."""

P = ParamSpec("P")
R = TypeVar("R")


class Program(Generic[P, R]):
    """A function of pytrees, compiled ahead of time.

    Args:
        function: traceable by JAX; keyword arguments are static and hashable.
        fused: whether the CPU backend optimises all it can and uses its fusion emitters: that
            doubles the time of compilation, and only long programs of dense algebra that run
            often are faster for it.
    """

    def __init__(self, function: Callable[P, R], *, fused: bool = False) -> None:
        self._function = function
        self._fused = fused
        self._traced: dict[Hashable, _Traced] = {}
        self._lock = threading.Lock()

    def __call__(self, *arguments: P.args, **static: P.kwargs) -> R:
        """Run, after compiling where that has not been done."""
        return self.compile(*arguments, **static)(*arguments)

    def compile(self, *arguments: P.args, **static: P.kwargs) -> Callable[..., R]:
        """The executable for arguments of these shapes; a second caller waits for the first."""
        traced = self._trace(arguments, static)
        return traced.executable(self._options())

    def shapes(self, *arguments: P.args, **static: P.kwargs) -> R:
        """Shapes of the result, without compiling anything."""
        return self._trace(arguments, static).traced.out_info

    def _trace(self, arguments: Any, static: Any) -> "_Traced":
        leaves, structure = jax.tree.flatten(arguments)
        shapes = tuple((leaf.shape, leaf.dtype) for leaf in leaves)
        key = (structure, shapes, tuple(sorted(static.items())))
        with self._lock:
            found = self._traced.pop(key, None)
            if found is None:
                function = jax.jit(partial(self._function, **static))
                found = _Traced(function, _shapes(arguments))
            self._traced[key] = found  # the last used is the last
            while len(self._traced) > MOST_KEPT:
                del self._traced[next(iter(self._traced))]
        return found

    def _options(self) -> dict[str, Any]:
        if jax.default_backend() != "cpu":
            return {}
        if self._fused:
            return {"xla_cpu_use_fusion_emitters": True}
        return {"xla_cpu_use_fusion_emitters": False, "xla_backend_optimization_level": 1}


class _Traced:
    """A function for arguments of certain shapes; traced and compiled once, when asked."""

    def __init__(self, function: Any, shapes: Any) -> None:
        self._function, self._shapes = function, shapes
        self._executable: Any = None
        self._lock = threading.RLock()

    @cached_property
    def traced(self) -> Any:
        with self._lock:
            return self._function.trace(*self._shapes)

    def executable(self, options: dict[str, Any]) -> Any:
        if self._executable is None:
            with self._lock:
                if self._executable is None:
                    lowered = self.traced.lower()
                    self._executable = lowered.compile(compiler_options=options)
        return self._executable


def program(function: Callable[P, R]) -> Program[P, R]:
    """Decorator: compile a function ahead of time (see `Program`)."""
    return Program(function)


def compile_together(*jobs: Callable[[], Any]) -> float:
    """Run compilations side by side; returns the time that they took together [s]."""
    began = time.perf_counter()
    with ThreadPoolExecutor(2) as pool:
        for job in [pool.submit(job) for job in jobs]:
            job.result()
    return time.perf_counter() - began


def use_disk_cache(folder: Path | None = None) -> Path:
    """Keep compiled programs on disk, by default in the user's cache directory."""
    if folder is None:
        folder = user_cache_path("tgpo-studio", appauthor=False) / "jax"
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return folder


def shape_of(*shape: int, dtype: Any) -> jax.Array:
    """Stands for an array where only its shape and type count."""
    return cast(jax.Array, jax.ShapeDtypeStruct(shape, dtype))


def key_shape() -> jax.Array:
    """Stands for a random key."""
    return cast(jax.Array, jax.eval_shape(lambda: jax.random.key(0)))


def _shapes(tree: Any) -> Any:
    return jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype), tree)
