"""PPO of other libraries on the shipped Gymnasium environments, with their own defaults.

As somebody would use it who knows nothing of this program: `gymnasium.make("tgpo/linear-08-v0")`,
robustness as the reward of the last step, eight environments one after the other. Evaluated like
the baselines: 512 initial states, the best of ten attempts, the first of them deterministic.

Dimensions: R rollouts, L steps, n state, m action, A atoms.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import program
from core.errors import UserError
from core.evaluation import EVALUATION_STATES, trace_robustness
from core.rollout import start_states
from core.task.physics import physics_of
from core.task.problem import Problem, atom_margins
from core.task.protocols import Array
from core.task.task import Task
from studio.bench.matrix import Job
from studio.bench.peers.libraries import library

LIBRARIES = {"sb3-ppo": "stable_baselines3", "sbx-ppo": "sbx"}
"""Modules whose `PPO` is meant, by method."""

ENVIRONMENTS = 8
"""That take turns in a training."""

ATTEMPTS = 10
"""From each initial state, of which the best counts, as for the baselines."""

Act = Callable[[np.ndarray, bool], np.ndarray]
"""Actions [R, m] for observations [R, o], deterministic or drawn."""


def learn(job: Job) -> dict[str, Any]:
    """Train for the job's seconds; returns the columns of its row.

    Raises:
        UserError: a job without a budget of seconds, or with a horizon.
    """
    if job.horizon is not None or (job.seconds is None and job.cpu_seconds is None):
        raise UserError(f"{job.method}: needs seconds or cpu_seconds, and the scene's own horizon")
    ppo = library(LIBRARIES[job.method]).PPO
    gymnasium = library("gymnasium")
    vector = library("stable_baselines3.common.vec_env")
    began = time.perf_counter()
    made = partial(gymnasium.make, f"tgpo/{job.task}-v0")
    environments = vector.DummyVecEnv([made] * ENVIRONMENTS)
    environments.reset()
    environments.step(np.zeros((ENVIRONMENTS, *environments.action_space.shape), np.float32))
    compiled = time.perf_counter() - began
    spent = _Clock(job)
    model = ppo("MlpPolicy", environments, seed=job.seed)
    model.learn(10**12, callback=spent.callback())
    wall, cpu = spent.wall(), spent.cpu()
    task = environments.envs[0].unwrapped.task
    regions = len(environments.envs[0].unwrapped.scene.regions)

    def act(observations: np.ndarray, deterministic: bool) -> np.ndarray:
        return np.asarray(model.predict(observations, deterministic=deterministic)[0])

    found = attempted(task, act, regions, jax.random.key(job.seed))
    sound = found[np.isfinite(found)]
    rate, mean = float((found >= 0).mean()), float(sound.mean()) if sound.size else None
    point = {"epoch": 1, "seconds": wall, "cpu_seconds": cpu, "env_steps": model.num_timesteps}
    return {
        "success_rate": rate,
        "robustness_mean": mean,
        "env_steps": model.num_timesteps,
        "stopped": spent.over(),
        "train_seconds": wall,
        "train_cpu_seconds": cpu,
        "compile_seconds": compiled,
        "curve": [point | {"success_rate": rate, "robustness_mean": mean}],
        "configuration": "{}",
    }


class _Clock:
    """Time since it was made, and the callback that ends a training when it is up."""

    def __init__(self, job: Job):
        self._job = job
        self._began, self._cpu_began = time.perf_counter(), time.process_time()

    def wall(self) -> float:
        """Seconds that have gone by."""
        return time.perf_counter() - self._began

    def cpu(self) -> float:
        """Seconds of the processor that were used."""
        return time.process_time() - self._cpu_began

    def over(self) -> str:
        """Which budget is used up; empty if none is."""
        if self._job.seconds is not None and self.wall() >= self._job.seconds:
            return "seconds"
        if self._job.cpu_seconds is not None and self.cpu() >= self._job.cpu_seconds:
            return "cpu_seconds"
        return ""

    def callback(self) -> Callable[[dict[str, Any], dict[str, Any]], bool]:
        """What `learn` asks after every step whether to go on."""
        return lambda names, globals_: not self.over()


def attempted(task: Task, act: Act, regions: int, key: Array) -> np.ndarray:
    """Robustness [R] of the best attempt from each of 512 initial states."""
    states = np.asarray(start_states(task.problem, key, count=EVALUATION_STATES))
    found = [
        trace_robustness(task, _margins_of_rollouts(task, act, regions, states, attempt == 0))
        for attempt in range(ATTEMPTS)
    ]
    return np.max(found, axis=0)


def _margins_of_rollouts(
    task: Task, act: Act, regions: int, states: np.ndarray, deterministic: bool
) -> np.ndarray:
    """Margins [L + 1, R, A] of rollouts from states [R, n]; observations as in `StlEnv`."""
    physics = physics_of(task.robot)
    margins = [np.asarray(_margins(task.problem, states))]
    for step in range(task.horizon):
        share = np.full((len(states), 1), step / task.horizon)
        seen = np.concatenate([states, share, margins[-1][:, :regions]], axis=1)
        actions = act(np.nan_to_num(seen).astype(np.float32), deterministic)
        if physics is None:
            states = np.asarray(_after(task.problem, states, actions))
        else:
            states = np.asarray(physics.step(states, actions), np.float32)
        margins.append(np.asarray(_margins(task.problem, states)))
    return np.stack(margins)


@program
def _after(problem: Problem, states: Any, actions: Any) -> Array:
    return jax.vmap(problem.robot.step)(states, jnp.asarray(actions, jnp.float32))


@program
def _margins(problem: Problem, states: Any) -> Array:
    return jax.vmap(lambda state: atom_margins(problem, state)[0])(states)
