"""Hyper-parameters, fixed when a program is compiled."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal, get_args

from msgspec import Meta

from core.documents import NotNegative, Positive, Share
from core.errors import UserError
from core.mdp.mode import Mode
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from core.methods.bounds import Count, Layers, LogStd, Many, ModeName, Size, Steps
from core.task.protocols import Robot
from core.task.schedules import Search
from core.task.windows import RESERVE

MethodName = Literal["tgpo", "tgpo-star"]

SHORTFALL_PENALTY = 10.0
"""Penalty on a schedule's value per step of shortfall, about half a subgoal's reward."""


@dataclass(frozen=True)
class Algorithm:
    """One method in one mode: TGPO* of the studio by default. Documents are held to the bounds."""

    mode: Mode = StudioMode()
    environments: Many = 512
    hidden: Layers = (64, 64)
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

    share_mcmc: Share = 0.4
    share_elite: Share = 0.1
    share_forward: Share = 0.0
    """Share of the other episodes whose schedules are drawn forward in time."""
    elite_capacity: Many = 512
    elite_decay: NotNegative = 0.01
    mcmc_steps: Steps = 10
    mcmc_warmup: Steps = 0
    mcmc_strides: Annotated[tuple[Size, ...], Meta(min_length=1, max_length=64)] = (1, 2, 4, 8)
    persistent_chains: bool = True

    model_epochs: Count = 10**6
    """Epochs that learn from `robot.step` before true physics takes over, if they differ."""

    prune: bool = True
    """Whether schedules are pruned by travel time."""
    prune_candidates: Size = 32
    reserve: Positive = RESERVE
    """Planned duration of a leg over the shortest possible one."""
    evaluation_states: Size = 512
    """Initial states of an evaluation during training; the final one always has 512."""
    choice_candidates: Size = 64
    """Schedules that the critic chooses from at inference."""

    outcome: bool = False
    """Whether a critic of outcomes scores schedules; it is fitted when all else is learnt."""

    layouts: Annotated[int, Meta(ge=1, le=64)] = 1
    """Layouts among which an epoch's environments are divided; 1: the task's own only."""
    fresh_layouts: Annotated[int, Meta(ge=0, le=64)] = 0
    """Layouts among them that are new in every epoch."""

    def check(self) -> None:
        """Check what the fields' own bounds do not say.

        Raises:
            UserError: numbers that contradict each other.
        """
        guided = self.share_mcmc + self.share_elite
        candidates = self.prune_candidates * self.choice_candidates
        for what, given, most in (
            ("layouts", self.layouts, self.environments),
            ("fresh_layouts", self.fresh_layouts, self.layouts),
            ("share_mcmc + share_elite", round(guided, 9), 1),
            ("episodes from the elite", self.count_elite, self.elite_capacity),
            ("minibatches", self.minibatches, 16 * self.environments),
            ("prune_candidates * environments", self.prune_candidates * self.environments, 2**20),
            ("prune_candidates * choice_candidates", candidates, 2**15),
        ):
            if given > most:
                raise UserError(f"{what}: {given} must be at most {most}")
        if self.layouts > 1 and self.mode.pays_robustness:
            raise UserError(f"layouts: {self.layouts} must be 1 in paper mode")

    @property
    def mode_name(self) -> ModeName:
        """The mode whose preset it comes from."""
        return self.mode.name  # pyright: ignore[reportReturnType]

    def preference(self, value, shortfall):
        """Score by which schedules are sampled and chosen: V(s_0, t), less if legs are too short.

        Works on arrays of both; the shortfall [steps] counts only where schedules are pruned.
        """
        return value - SHORTFALL_PENALTY * shortfall if self.prune else value

    @property
    def search(self) -> Search:
        """How schedules are drawn, for training and for the critic to choose from."""
        return Search(self.prune, self.prune_candidates, self.choice_candidates, self.reserve)

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
    minibatches=32,
    mcmc_steps=500,
    mcmc_warmup=200,
    mcmc_strides=(1,),
    persistent_chains=False,
    elite_decay=0.0,
    prune=False,
)
"""Table A.1. PPO's passes, minibatches, discount, trace and clip, not in the paper, are ours."""


def many_layouts(algorithm: Algorithm) -> Algorithm:
    """The algorithm, learning on many layouts of a task, some of them new in every epoch.

    Raises:
        UserError: paper mode, which uses a single layout.
    """
    if algorithm.mode.pays_robustness:
        raise UserError("paper mode learns a single layout only. Available: studio")
    return replace(algorithm, layouts=16, fresh_layouts=1)


def many_missions(algorithm: Algorithm, epochs: int) -> Algorithm:
    """The algorithm, learning on random missions for a number of epochs.

    Every mission has its own domains of times: schedules are drawn without chains or elite, half
    of them forward in time. A mission serves 16 epochs.
    """
    return replace(
        algorithm,
        layouts=32,
        fresh_layouts=2,
        share_mcmc=0.0,
        share_elite=0.0,
        share_forward=0.5,
        learning_rate=1.5e-3,
        decay_epochs=epochs,
        passes=3,
        minibatches=12,
    )


def make_algorithm(mode: str, method: str, robot: Robot) -> Algorithm:
    """The preset of a mode and a method, tuned for a robot.

    `tgpo` samples schedules uniformly; `tgpo-star` mixes in Metropolis-Hastings and the elite.

    Raises:
        UserError: unknown mode or method.
    """
    tuning = robot.tuning
    match mode:
        case "studio":
            algorithm = Algorithm(
                mode=StudioMode(
                    violation=tuning.violation,
                    gradual_stays=tuning.gradual_stays,
                    dangers=2,
                    ahead=(0.5, 1.2),
                ),
                learning_rate=tuning.learning_rate,
                model_epochs=tuning.model_epochs,
                evaluation_states=tuning.evaluation_states,
            )
        case "paper":
            algorithm = replace(PAPER, mode=PaperMode(violation=tuning.violation))
        case _:
            raise UserError(f"unknown mode {mode!r}. Available: {sorted(get_args(ModeName))}")
    match method:
        case "tgpo-star":
            return algorithm
        case "tgpo":
            return replace(algorithm, share_mcmc=0.0, share_elite=0.0)
    raise UserError(f"unknown method {method!r}. Available: {sorted(get_args(MethodName))}")
