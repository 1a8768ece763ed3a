"""Hyper-parameters, fixed when a program is compiled."""

from dataclasses import dataclass, replace
from typing import Literal

from core.errors import UserError
from core.paper_mode import PaperMode
from core.studio_mode import StudioMode

ModeName = Literal["studio", "paper"]
MethodName = Literal["tgpo", "tgpo-star"]


SHORTFALL_PENALTY = 10.0
"""Value that a step of shortfall takes off a schedule, about half a subgoal's reward."""


@dataclass(frozen=True)
class Algorithm:
    """One method in one mode: TGPO* of the studio by default."""

    mode: StudioMode | PaperMode = StudioMode()
    environments: int = 512
    hidden: tuple[int, ...] = (64, 64)
    log_std: float = -0.5

    learning_rate: float = 2e-3
    weight_decay: float = 0.0
    gradient_norm: float = 0.5
    passes: int = 4
    """Passes of PPO over a batch."""
    minibatches: int = 16
    discount: float = 0.99
    trace: float = 0.95
    """lambda of the generalised advantage estimate."""
    clip: float = 0.2

    share_mcmc: float = 0.4
    share_elite: float = 0.1
    elite_capacity: int = 512
    elite_decay: float = 0.01
    mcmc_steps: int = 10
    mcmc_warmup: int = 0
    mcmc_strides: tuple[int, ...] = (1, 2, 4, 8)
    persistent_chains: bool = True

    model_epochs: int = 10**6
    """Epochs that learn from `robot.step` before true physics takes over, where both differ."""

    prune: bool = True
    """Whether schedules are pruned by travel time."""
    prune_candidates: int = 32
    reserve: float = 1.2
    """Planned duration of a leg over the shortest possible one."""
    evaluation_states: int = 512
    """Initial states of an evaluation while training; the final one has 512 in any case."""
    choice_candidates: int = 64
    """Schedules that the critic chooses from at inference."""

    layouts: int = 1
    """Layouts that the environments of an epoch are dealt to; 1 learns on the task's own alone."""
    fresh_layouts: int = 0
    """Layouts among them that are new in every epoch."""

    def preference(self, value, shortfall):
        """By which schedules are sampled and chosen: V(s_0, t), less for legs that are too short.

        Works on arrays of both; the shortfall [steps] counts only where schedules are pruned.
        """
        return value - SHORTFALL_PENALTY * shortfall if self.prune else value

    @property
    def count_mcmc(self) -> int:
        """Episodes of an epoch whose schedules come from the chains."""
        return self.layouts * round(self.environments // self.layouts * self.share_mcmc)

    @property
    def count_elite(self) -> int:
        """Episodes of an epoch whose schedules come from the elite buffer."""
        return round(self.environments * self.share_elite)


PAPER = Algorithm(
    mode=PaperMode(),
    hidden=(512, 512, 512),
    learning_rate=3e-4,
    weight_decay=0.1,
    minibatches=8,
    mcmc_steps=500,
    mcmc_warmup=200,
    mcmc_strides=(1,),
    persistent_chains=False,
    elite_decay=0.0,
    prune=False,
)
"""Table A.1. The paper leaves open PPO's passes, minibatches, discount, trace and clip: ours."""

PAPER_VIOLATION = {"unicycle": -3.5, "ant": -1.5}
"""lambda_4 of Table A.1 where it is not -3."""

STUDIO = {
    "quadrotor": Algorithm(mode=StudioMode(gradual_stays=True), learning_rate=2.5e-3),
    "ant": Algorithm(
        mode=StudioMode(gradual_stays=True),
        learning_rate=2.5e-3,
        model_epochs=50,
        evaluation_states=128,
    ),
}
"""Studio presets of robots that the default serves badly: they cannot stop at once, and the ant's
true physics costs ten times as much as its model."""


def many_layouts(algorithm: Algorithm) -> Algorithm:
    """The algorithm, learning on many layouts of a task, some of them new in every epoch.

    Raises:
        UserError: the paper's mode, which knows one layout.
    """
    if isinstance(algorithm.mode, PaperMode):
        raise UserError("the paper's mode learns one layout alone. Available: ['studio']")
    return replace(algorithm, layouts=16, fresh_layouts=1)


def make_algorithm(mode: ModeName, method: MethodName, robot: str) -> Algorithm:
    """The preset of a mode and a method for a robot.

    `tgpo` samples schedules uniformly; `tgpo-star` mixes in Metropolis-Hastings and the elite.

    Raises:
        UserError: unknown mode or method.
    """
    presets = {"studio": STUDIO.get(robot, Algorithm()), "paper": PAPER}
    if mode not in presets:
        raise UserError(f"unknown mode {mode!r}. Available: {sorted(presets)}")
    algorithm = presets[mode]
    violation = PAPER_VIOLATION.get(robot, -3.0)
    algorithm = replace(algorithm, mode=replace(algorithm.mode, violation=violation))
    match method:
        case "tgpo-star":
            return algorithm
        case "tgpo":
            return replace(algorithm, share_mcmc=0.0, share_elite=0.0)
    raise UserError(f"unknown method {method!r}. Available: ['tgpo', 'tgpo-star']")
