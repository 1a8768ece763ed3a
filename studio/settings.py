"""What the page asks of a training beyond the scene."""

import math
from dataclasses import dataclass, replace
from typing import cast

from core.algorithm import Algorithm, MethodName, ModeName, make_algorithm
from core.paper_mode import PaperMode
from core.training import TrainingConfig
from scenes import Scene

MODES: tuple[ModeName, ...] = ("studio", "paper")
METHODS: tuple[MethodName, ...] = ("tgpo-star", "tgpo")
LARGEST_SEED = 2**31 - 1
FOREVER = 10**6
"""Epochs that no time limit of the page lets a training reach."""


@dataclass
class Settings:
    """Values of the controls; the same for all clients."""

    time_limit: float = 60.0
    """Most seconds of a training, compilation apart."""
    seed: int | None = None
    """None for the scene's."""
    mode: ModeName = "studio"
    method: MethodName = "tgpo-star"

    def applied(self, config: TrainingConfig, scene: Scene) -> TrainingConfig:
        """A configuration with the choices in it that differ from the defaults."""
        if self.seed is not None:
            config = replace(config, seed=self.seed)
        if (self.mode, self.method) != (MODES[0], METHODS[0]):
            config = replace(config, algorithm=make_algorithm(self.mode, self.method, scene.robot))
        return config

    def set_seed(self, seed: float) -> None:
        """Take a seed from a control; what is out of range is brought into it."""
        if math.isfinite(seed):
            self.seed = min(max(int(seed), 0), LARGEST_SEED)

    def choose(self, mode: str, method: str) -> None:
        """Take mode and method from controls; what is not offered is ignored."""
        if mode in MODES and method in METHODS:
            self.mode, self.method = cast(ModeName, mode), cast(MethodName, method)


def mode_of(algorithm: Algorithm) -> ModeName:
    """By what a bundle calls it."""
    return "paper" if isinstance(algorithm.mode, PaperMode) else "studio"


def method_of(algorithm: Algorithm) -> MethodName:
    """By what a bundle calls it."""
    return "tgpo-star" if algorithm.share_mcmc + algorithm.share_elite > 0 else "tgpo"


def prolonged(config: TrainingConfig, seconds: float, more: float) -> TrainingConfig:
    """A configuration to train longer: past the target, for so many seconds more.

    Args:
        config: of the training so far.
        seconds: that it took [s].
        more: seconds to add [s].
    """
    return replace(config, target=2.0, time_limit=seconds + more, epochs=FOREVER)
