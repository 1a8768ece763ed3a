"""The `paper` mode of the grounded MDP, as in Sec. 4.2 of the paper.

Transition: p_prev' = p, r' = h(r, x', tau', p), p' = p + 1(r' = 2), chi' as in the paper. The
flag r checks a stay at its entry and its exit only. Only a
simulation that diverges ends an episode before its horizon.

Reward: R = lambda_1 mu_p(x) + lambda_2 1(p_prev != p) + lambda_3 1(p = N_g and chi = 1)
+ lambda_4 1(some chi_k = 0); the formula's robustness is added at the final step by the learner.
All of it is multiplied by `scale`, which changes nothing about which policy is best.

The paper's h is written with p' on both sides of p' = p + 1(r' = 2); we read the inner p' as p.
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax.numpy as jnp

from core.documents import Positive, Share, Weight
from core.mdp.augmented import augmented_state
from core.mdp.episode import (
    Checks,
    Episode,
    check,
    check_between,
    is_sound,
    violated_constraints,
    worst_open,
)
from core.mdp.grounded import GroundedMdp
from core.task.problem import extended_margins
from core.task.protocols import Array
from core.task.windows import Windows


class PaperSense(NamedTuple):
    """Margins of the tasks in one augmented state."""

    checks: Checks


@dataclass(frozen=True)
class PaperMode:
    """The paper's weights of the reward (App. A.1)."""

    name: ClassVar[str] = "paper"
    pays_robustness: ClassVar[bool] = True

    distance: Weight = 0.5
    progress: Weight = 20.0
    success: Weight = 20.0
    violation: Weight = -3.0
    scale: Positive = 0.02
    """Multiplies all rewards: values in the hundreds take the critic tens of epochs to reach, and
    until then its error dominates the gradient, whose norm PPO clips."""
    exploring: Share = 0.0
    gradual_stays: bool = False
    time: bool = True
    """Whether the time index tau is in the state (Table 1b: t)."""
    flags: bool = True
    """Whether p_prev, p, r and chi are in the state (Table 1b: flags)."""

    @property
    def early_end(self) -> bool:
        """Never: episodes last until the horizon."""
        return False

    def begin(self, mdp: GroundedMdp, state: Array, tau) -> tuple[Episode, PaperSense]:
        """Episode that starts in `state` [n] at step `tau` with no progress."""
        sense = self._sense(mdp, state, tau)
        nothing = jnp.zeros((), jnp.int32)
        certificate = _certificate(mdp.windows, sense.checks, nothing, nothing, tau)
        progress = (certificate == 2).astype(jnp.int32)
        episode = Episode(
            state,
            tau,
            nothing,
            progress,
            certificate,
            _kept(sense.checks),
            jnp.ones(()),
            worst_open(sense.checks),
        )
        return episode, sense

    def observe(
        self, mdp: GroundedMdp, episode: Episode, state: Array
    ) -> tuple[Episode, PaperSense]:
        """The next augmented state, where the robot was found in `state`."""
        tau = episode.tau + 1
        checks = self._sense(mdp, state, tau).checks
        moved = episode.state, state
        sense = PaperSense(check_between(mdp.problem, mdp.windows, tau, checks, moved))
        certificate = _certificate(
            mdp.windows, sense.checks, episode.certificate, episode.progress, tau
        )
        worst = jnp.minimum(episode.robustness, worst_open(sense.checks))
        following = Episode(
            state,
            tau,
            episode.progress,
            episode.progress + (certificate == 2),
            certificate,
            episode.satisfied * _kept(sense.checks),
            episode.alive,
            jnp.where(is_sound(state), worst, -jnp.inf),
        )
        return following, sense

    def reward(
        self,
        mdp: GroundedMdp,
        before: tuple[Episode, PaperSense],
        after: tuple[Episode, PaperSense],
    ) -> tuple[Array, Array]:
        """Reward of a step, and whether it ends the episode."""
        del before
        episode, sense = after
        sound, last = is_sound(episode.state), mdp.windows.start.shape[0] - 1
        complete = episode.progress >= mdp.windows.count
        present = sense.checks.subgoal[jnp.minimum(episode.progress, last)]
        kept = episode.satisfied.min() > 0
        reward = (
            self.distance / mdp.problem.robot.length * jnp.where(complete, 0.0, present)
            + self.progress * (episode.progress != episode.previous_progress)
            + self.success * (complete & kept)
            + self.violation * ~kept
        )
        reward = jnp.where(sound, reward, self.violation)
        return self.scale * reward, (episode.tau >= mdp.problem.formula.horizon) | ~sound

    def succeeded(self, mdp: GroundedMdp, episode: Episode) -> Array:
        """Whether the progress pointer and the flags say that all was achieved."""
        achieved = (episode.progress >= mdp.windows.count) & (episode.satisfied.min() > 0)
        return achieved & (episode.robustness > -jnp.inf)

    def policy_features(self, mdp: GroundedMdp, episode: Episode, sense: PaperSense) -> Array:
        """The augmented state and the schedule (Sec. 4.2)."""
        del sense
        return augmented_state(mdp, episode, time=self.time, flags=self.flags)

    def critic_features(
        self, mdp: GroundedMdp, episode: Episode, sense: PaperSense, features: Array
    ) -> Array:
        """The same as the policy's."""
        del mdp, episode, sense
        return features

    def _sense(self, mdp: GroundedMdp, state: Array, tau) -> PaperSense:
        mu, gradient = extended_margins(mdp.problem, state, tau)
        return PaperSense(check(mdp.problem, mdp.windows, tau, mu, gradient))


def _certificate(
    windows: Windows, checks: Checks, certificate: Array, progress: Array, tau: Array
) -> Array:
    """h(r, x', tau', p) of Sec. 4.2, in {0, 1, 2}."""
    rank = jnp.minimum(progress, windows.start.shape[0] - 1)
    start, end, inside = windows.start[rank], windows.end[rank], checks.subgoal[rank] >= 0
    enters = (start != end) & (tau == start) & inside
    leaves = ((certificate == 1) | (start == end)) & (tau == end) & inside
    value = jnp.where(enters, 1, jnp.where(leaves, 2, certificate))
    return jnp.where((certificate == 2) | (progress >= windows.count), 0, value).astype(jnp.int32)


def _kept(checks: Checks) -> Array:
    return 1.0 - violated_constraints(checks)
