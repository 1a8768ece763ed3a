"""Hyper-parameters of the methods that carry out a formula as a whole.

They are the same methods in both modes. `studio` gives them the networks and step sizes of TGPO's
studio mode, for comparisons at equal wall-clock; `paper` those of Table A.1, which the paper states
for TGPO* and leaves open for the baselines.
"""

from dataclasses import dataclass
from typing import ClassVar

from core.documents import NotNegative, Positive, Share
from core.errors import UserError
from core.methods.bounds import Count, Layers, LogStd, Many, ModeName, Size
from core.task.windows import RESERVE


@dataclass(frozen=True)
class WholeFormula:
    """What all of them have."""

    mode: ModeName = "studio"
    hidden: Layers = (64, 64)
    evaluation_states: Size = 51
    """Initial states of an evaluation during training; the final one always has 512."""

    layouts: ClassVar[int] = 1
    """They learn the task's own layout."""
    reserve: ClassVar[float] = RESERVE
    """Of the legs in other layouts that they are evaluated on."""

    @property
    def mode_name(self) -> ModeName:
        """The mode whose preset it comes from."""
        return self.mode

    def check(self) -> None:
        """Check what the fields' own bounds do not say.

        Raises:
            UserError: numbers that contradict each other.
        """


@dataclass(frozen=True)
class PolicyGradient(WholeFormula):
    """Those that learn by PPO; an epoch is one whole episode in each environment."""

    environments: Many = 512
    log_std: LogStd = -0.5

    learning_rate: Positive = 2e-3
    decay_epochs: Count = 0
    """Epochs over which the learning rate falls to a fiftieth along a cosine; 0 keeps it."""
    weight_decay: NotNegative = 0.0
    gradient_norm: Positive = 0.5
    passes: Size = 4
    """Passes of PPO over a batch."""
    minibatches: Size = 16
    discount: Share = 0.99
    trace: Share = 0.95
    """lambda of the generalised advantage estimate."""
    clip: Positive = 0.2

    def check(self) -> None:
        """No more minibatches than the shortest batch has transitions for."""
        if self.minibatches > self.environments:
            raise UserError(
                f"minibatches: {self.minibatches} must be at most {self.environments}, the "
                "number of environments"
            )


PAPER_PPO = PolicyGradient(
    mode="paper",
    hidden=(512, 512, 512),
    learning_rate=3e-4,
    weight_decay=0.1,
    minibatches=8,
)
"""Table A.1."""
