"""Train the ant's gait and write its weights: `python -m envs.ant.gait_training`.

Goes on from the checkpoint in --out if there is one. With the defaults it makes the weights that
ship (`--ship` puts them there); bit by bit only on the same machine, since physics amplifies
rounding.
"""

import json
import pickle
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import tyro
from safetensors.numpy import save

from core.checkpoint import write_atomically
from envs.ant.gait import FEATURES, WEIGHTS, Gait, normalised, read_gait
from envs.ant.gait_training.chase import Chase
from envs.ant.gait_training.learner import (
    DISCOUNT,
    MINIBATCH,
    OPTIMIZER,
    PASSES,
    Samples,
    Weights,
    advantages,
    initial_weights,
    look,
    steered,
    update,
)
from envs.ant.gait_training.measure import measure
from envs.ant.model import MOTORS
from envs.ant.native import NativePhysics

ANTS, STEPS = 128, 64
REWARD_SCALE = 0.1
SHIPPED = Path(__file__).parents[3] / "static" / "ant" / WEIGHTS


@dataclass
class Options:
    """What is trained."""

    seed: int = 1007
    iterations: int = 1800
    """Of 64 steps of 128 ants; a thousand take 17 minutes on two idle cores."""
    out: Path = Path("runs/gait")
    """Folder of the checkpoint and the log."""
    every: int = 300
    """Iterations between measurements."""
    ship: bool = False
    """Put the result in the place of the gait that ships."""


class Statistics:
    """Running mean and variance of the observations [29]."""

    def __init__(self) -> None:
        self.mean, self.variance, self.count = np.zeros(FEATURES), np.ones(FEATURES), 1e-4

    @property
    def deviation(self) -> np.ndarray:
        """Standard deviation [29]."""
        return np.sqrt(self.variance + 1e-6)

    def include(self, observations: np.ndarray) -> None:
        """Count observations [B, 29] in; old ones fade after two million."""
        count, total = len(observations), self.count + len(observations)
        shift = observations.mean(0) - self.mean
        self.mean = self.mean + shift * count / total
        spread = shift**2 * self.count * count / total
        between = self.variance * self.count + observations.var(0) * count + spread
        self.variance, self.count = between / total, min(total, 2e6)

    def normalise(self, observations: np.ndarray) -> np.ndarray:
        """Observations as the networks see them."""
        return normalised(observations, self.mean, self.deviation).astype(np.float32)


def gather(chase: Chase, weights: Weights, statistics: Statistics, random) -> tuple[Samples, dict]:
    """Transitions of STEPS steps."""
    spread = np.exp(np.asarray(weights.log_std))
    rows: dict[str, list] = {name: [] for name in ("o", "raw", "a", "mean", "r", "v", "over")}
    falls, along = 0, 0.0
    for _ in range(STEPS):
        seen = statistics.normalise(chase.observation)
        mean, value = map(np.asarray, look(weights, seen))
        action = mean + spread * random.standard_normal(mean.shape)
        raw = chase.observation
        outcome = chase.act(action)
        reward = REWARD_SCALE * outcome.reward
        if outcome.truncated.any():  # what would have followed is the critic's guess
            _, onward = look(weights, statistics.normalise(outcome.observation))
            reward = reward + DISCOUNT * np.asarray(onward) * outcome.truncated
        over = outcome.fell | outcome.truncated
        for name, entry in zip(rows, (seen, raw, action, mean, reward, value, over), strict=True):
            rows[name].append(entry)
        falls, along = falls + outcome.fell.sum(), along + outcome.along.mean() / STEPS
    _, last = look(weights, statistics.normalise(chase.observation))
    value = np.stack([*rows["v"], np.asarray(last)])
    advantage = advantages(np.stack(rows["r"]), value, np.stack(rows["over"]).astype(float))
    statistics.include(np.concatenate(rows["raw"]))
    arrays = (*(np.stack(rows[name]) for name in ("o", "a", "mean")), advantage)
    arrays += (advantage + value[:-1],)
    samples = Samples(*(jnp.float32(a.reshape(-1, *a.shape[2:])) for a in arrays))
    return samples, {"falls_per_1000": 1000 * falls / (STEPS * ANTS), "speed": along}


def pack(weights: Weights, statistics: Statistics, metadata: dict[str, Any]) -> bytes:
    """The gait as a safetensors file."""
    arrays = {"mean": statistics.mean, "deviation": statistics.deviation}
    for index, (matrix, bias) in enumerate(weights.actor):
        arrays |= {f"weights{index}": np.asarray(matrix), f"bias{index}": np.asarray(bias)}
    arrays = {name: np.ascontiguousarray(a, np.float32) for name, a in arrays.items()}
    return save(arrays, {key: json.dumps(value) for key, value in metadata.items()})


def packed_gait(weights: Weights, statistics: Statistics) -> Gait:
    """The gait as it is shipped."""
    return read_gait(pack(weights, statistics, {}))


def main(options: Options) -> None:
    """Train, with a checkpoint at every measurement."""
    options.out.mkdir(parents=True, exist_ok=True)
    checkpoint = options.out / "checkpoint.pickle"  # of this program alone, never shipped
    weights = initial_weights(options.seed, FEATURES, MOTORS)
    state = (weights, OPTIMIZER.init(weights), Statistics(), 5e-4, 0, 0.0)
    if checkpoint.exists():
        state = pickle.loads(checkpoint.read_bytes())
    weights, optimizer, statistics, rate, iteration, seconds = state
    random = np.random.default_rng([options.seed, iteration])
    zero = packed_gait(weights, statistics)
    chase = Chase(NativePhysics(zero, 1.0), ANTS, options.seed + iteration)
    began = time.perf_counter() - seconds
    while iteration < options.iterations:
        samples, seen = gather(chase, weights, statistics, random)
        size = STEPS * ANTS
        order = [random.permutation(size).reshape(-1, MINIBATCH) for _ in range(PASSES)]
        weights, optimizer, divergence = update(
            weights, optimizer, samples, jnp.asarray(np.concatenate(order)), rate
        )
        rate, iteration = steered(rate, float(divergence)), iteration + 1
        seconds = time.perf_counter() - began
        if iteration % 20 == 0:
            line = {"iteration": iteration, "seconds": round(seconds, 1), "rate": rate, **seen}
            print(json.dumps(line), flush=True)
        if iteration % options.every == 0 or iteration == options.iterations:
            kept = jax.tree.map(np.asarray, (weights, optimizer))
            write_atomically(
                checkpoint, pickle.dumps((*kept, statistics, rate, iteration, seconds))
            )
            figures = measure(packed_gait(weights, statistics))
            print(json.dumps({"measured": iteration, **figures}), flush=True)
            about = {"seed": options.seed, "iterations": iteration, "seconds": round(seconds)}
            about |= {"steps": iteration * size, "measured": figures}
            write_atomically(options.out / WEIGHTS, pack(weights, statistics, about))
            began += time.perf_counter() - began - seconds  # measuring is not training
    if options.ship:
        write_atomically(SHIPPED, (options.out / WEIGHTS).read_bytes())


if __name__ == "__main__":
    main(tyro.cli(Options))
