"""Settings of a training on the page, beyond the scene."""

import math
from dataclasses import dataclass, replace

from core.methods import METHODS
from core.methods.training import TrainingConfig
from scenes import Scene, robot_of

MODES = ("studio", "paper")
METHOD_NAMES = tuple(METHODS)
EXACT = "exact"
"""Chosen like a method; nothing is trained, see `studio.page.exact`."""
LARGEST_SEED = 2**31 - 1
FOREVER = 10**6
"""More epochs than a training can reach within any time limit of the page."""


@dataclass
class Settings:
    """Values of the controls, shared by all clients."""

    time_limit: float = 60.0
    """Maximum training time, not counting compilation [s]."""
    seed: int | None = None
    """None for the scene's."""
    mode: str = "studio"
    method: str = "tgpo-star"
    from_weights: bool = True
    """Whether training begins with the robot's weights, where there are some."""

    def applied(self, config: TrainingConfig, scene: Scene) -> TrainingConfig:
        """The configuration, with those choices that differ from the defaults."""
        if self.seed is not None:
            config = replace(config, seed=self.seed)
        if (self.mode, self.method) != (MODES[0], METHOD_NAMES[0]) and self.method != EXACT:
            algorithm = METHODS[self.method].preset(self.mode, robot_of(scene))
            config = replace(config, algorithm=algorithm, method=self.method)
        return config

    def set_seed(self, seed: float) -> None:
        """Set the seed from a control, clipped to its range."""
        if math.isfinite(seed):
            self.seed = min(max(int(seed), 0), LARGEST_SEED)

    def choose(self, mode: str, method: str) -> None:
        """Take mode and method from controls; what is not offered is ignored."""
        if mode in MODES and method in (*METHOD_NAMES, EXACT):
            self.mode, self.method = mode, method


def prolonged(config: TrainingConfig, seconds: float, more: float) -> TrainingConfig:
    """The configuration for training longer: past the target, with more time.

    Args:
        config: of the training so far.
        seconds: its training time [s].
        more: time to add [s].
    """
    return replace(config, target=2.0, time_limit=seconds + more, epochs=FOREVER)
