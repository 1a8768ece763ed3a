"""The controller that TGPO trains: its policy, time-conditioned, and its critic."""

from dataclasses import dataclass, field
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.mdp.episode import Episode, before_start
from core.mdp.grounded import GroundedMdp, ground_schedule
from core.mdp.mode import begin
from core.methods.networks import Parameters, networks_of
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.outcome import outcome_value
from core.task.grounding import NEVER
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.schedules import Search
from core.task.windows import Windows, windows_of


class Memory(NamedTuple):
    """A schedule's windows, and the augmented state of Sec. 4.2 at the last step."""

    windows: Windows
    episode: Episode


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class TgpoController:
    """Mean actions of the policy; schedules are scored by the critic (see `core.controller`)."""

    algorithm: Algorithm = field(metadata={"static": True})
    parameters: Parameters

    @property
    def search(self) -> Search:
        """As in training."""
        return self.algorithm.search

    @property
    def attempts(self) -> tuple["TgpoController"]:
        """One: the critic's choice has to do."""
        return (self,)

    def score(self, problem: Problem, state: Array, schedule: Array) -> Array:
        """How promising a schedule is.

        V(s_0, t) in units of the unscaled reward, less a penalty for legs that are too short; of
        weights that serve every task, what the critic of outcomes expects, between 0 and 1.
        """
        if self.algorithm.outcome:
            critic = self.parameters.outcome
            return outcome_value(self.algorithm, problem, critic, state, schedule)
        value, shortfall = schedule_value(self.algorithm, problem, self.parameters, state, schedule)
        return self.algorithm.preference(value, shortfall)

    def start(self, problem: Problem, state: Array, schedule: Array) -> Memory:
        """Memory before the first step."""
        constraints = problem.formula.constraints.mask.shape[0]
        return Memory(windows_of(problem, schedule), before_start(state, constraints))

    def step(self, problem: Problem, memory: Memory, state: Array) -> tuple[Memory, Array]:
        """The mean action [m] for a measured state [n], clipped to [-1, 1].

        Once the last subgoal's window has closed nothing is left to do: the robot is told to
        stand still (action 0), where the policy, which never learnt what follows, would wander.
        """
        mode, windows = self.algorithm.mode, memory.windows
        # The reserve of the legs is the critic's business, not the policy's.
        mdp = GroundedMdp(problem, windows, jnp.zeros_like(windows.start), jnp.zeros(()))
        episode, sense = mode.observe(mdp, memory.episode, state)
        features = mode.policy_features(mdp, episode, sense)
        action = networks_of(self.algorithm, problem).action(self.parameters, features)
        left = ((windows.end > episode.tau) & (windows.end < NEVER)).any()
        return Memory(windows, episode), jnp.where(left, jnp.clip(action, -1.0, 1.0), 0.0)


def schedule_value(
    algorithm: Algorithm, problem: Problem, parameters: Parameters, state: Array, schedule: Array
) -> tuple[Array, Array]:
    """V(s_0, t) [] in units of the unscaled reward, and the shortfall [] of a schedule [V]."""
    position = problem.robot.position(state)
    mdp = ground_schedule(problem, position, schedule, reserve=algorithm.reserve)
    view = begin(algorithm.mode, mdp, state, jnp.float32(0))
    value = networks_of(algorithm, problem).value(parameters, view.critic)
    return value / algorithm.mode.scale, mdp.shortfall
