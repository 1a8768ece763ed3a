"""What a mode of the grounded MDP is: its reward and what its networks see."""

from typing import Any, ClassVar, NamedTuple, Protocol

import jax
import jax.numpy as jnp

from core.mdp.episode import Episode
from core.mdp.grounded import AXES, GroundedMdp, ground_schedule
from core.task.problem import Problem
from core.task.protocols import Array


class Mode(Protocol):
    """A hashable value; its functions treat one episode. `Sense` is the mode's own pytree."""

    name: ClassVar[str]
    """Identifier, as in files and on the page."""
    pays_robustness: ClassVar[bool]
    """Whether the formula's robustness is added to an episode's last reward."""

    @property
    def scale(self) -> float:
        """Factor of all rewards."""
        ...

    @property
    def exploring(self) -> float:
        """Share of exploring starts among the episodes that follow a finished one."""
        ...

    @property
    def gradual_stays(self) -> bool:
        """Whether exploring starts lie within stays too."""
        ...

    @property
    def early_end(self) -> bool:
        """Whether an episode ends as soon as it has failed; nothing is learnt from then on."""
        ...

    def begin(self, mdp: GroundedMdp, state: Array, tau: Array) -> tuple[Episode, Any]:
        """Episode that starts in a state [n] at step tau, and what is sensed there."""
        ...

    def observe(self, mdp: GroundedMdp, episode: Episode, state: Array) -> tuple[Episode, Any]:
        """The episode one step on, where the robot was found in a state [n]; what is sensed."""
        ...

    def reward(
        self, mdp: GroundedMdp, before: tuple[Episode, Any], after: tuple[Episode, Any]
    ) -> tuple[Array, Array]:
        """Reward [] of the step between two episodes, and whether it ends the episode."""
        ...

    def succeeded(self, mdp: GroundedMdp, episode: Episode) -> Array:
        """Whether an episode that has ended was a success, as far as the mode can tell."""
        ...

    def policy_features(self, mdp: GroundedMdp, episode: Episode, sense: Any) -> Array:
        """What the policy sees [f]."""
        ...

    def critic_features(
        self, mdp: GroundedMdp, episode: Episode, sense: Any, features: Array
    ) -> Array:
        """What the critic sees [g], given what the policy sees."""
        ...


class View(NamedTuple):
    """An episode with what it perceives."""

    episode: Episode
    sense: Any
    policy: Array  # [f]
    critic: Array  # [g]


def view_of(mode: Mode, mdp: GroundedMdp, episode: Episode, sense: Any) -> View:
    """The features of an episode, beside it."""
    policy = mode.policy_features(mdp, episode, sense)
    return View(episode, sense, policy, mode.critic_features(mdp, episode, sense, policy))


def begin(mode: Mode, mdp: GroundedMdp, state: Array, tau: Array) -> View:
    """Episode from a state [n] at step tau."""
    return view_of(mode, mdp, *mode.begin(mdp, state, tau))


def advance(mode: Mode, mdp: GroundedMdp, view: View, state: Array) -> tuple[View, Array, Array]:
    """The view after the robot has come to a state [n], the reward and whether it ends."""
    episode, sense = mode.observe(mdp, view.episode, state)
    reward, ends = mode.reward(mdp, (view.episode, view.sense), (episode, sense))
    return view_of(mode, mdp, episode, sense), reward, ends


def first_views(
    mode: Mode, problem: Problem, states: Array, schedules: Array, reserve: float
) -> tuple[GroundedMdp, View]:
    """The MDPs of schedules [N, V] from states [N, n], and their episodes at step 0."""

    def ground(state: Array, schedule: Array) -> GroundedMdp:
        mdp = ground_schedule(problem, problem.robot.position(state), schedule, reserve=reserve)
        return mdp._replace(problem=None)  # pyright: ignore[reportArgumentType]

    mdps = jax.vmap(ground)(states, schedules)._replace(problem=problem)
    tau = jnp.float32(0)
    views = jax.vmap(lambda mdp, state: begin(mode, mdp, state, tau), (AXES, 0))(mdps, states)
    return mdps, views
