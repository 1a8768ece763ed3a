"""The `paper` mode of the grounded MDP: Sec. 4.2 of the paper to the letter.

Transition: p_prev' = p, r' = h(r, x', tau', p), p' = p + 1(r' = 2), chi' as in the paper. The
flag r checks a stay at its entry and its exit only. Nothing ends an episode before
its horizon but a simulation that breaks down.

Reward: R = lambda_1 mu_p(x) + lambda_2 1(p_prev != p) + lambda_3 1(p = N_g and chi = 1)
+ lambda_4 1(some chi_k = 0); the formula's robustness is added at the final step by the learner.

The paper's h is written with p' on both sides of p' = p + 1(r' = 2); we read p in its place.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.episode import Checks, Episode, check, is_sound, worst_open
from core.problem import Problem, extended_margins
from core.protocols import Array, Robot, World
from core.windows import Windows


class PaperSense(NamedTuple):
    """Margins of the tasks in one augmented state."""

    checks: Checks


@dataclass(frozen=True)
class PaperMode:
    """The paper's weights of the reward (App. A.1)."""

    distance: float = 0.5
    progress: float = 20.0
    success: float = 20.0
    violation: float = -3.0
    scale: float = 1.0
    exploring: float = 0.0
    gradual_stays: bool = False

    def begin(
        self, robot: Robot, world: World, problem: Problem, windows: Windows, state: Array, tau
    ) -> tuple[Episode, PaperSense]:
        """Episode that starts in `state` [n] at step `tau` with no progress."""
        sense = self._sense(robot, world, problem, windows, state, tau)
        nothing = jnp.zeros((), jnp.int32)
        certificate = _certificate(windows, sense.checks, nothing, nothing, tau)
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

    def advance(
        self,
        robot: Robot,
        world: World,
        problem: Problem,
        windows: Windows,
        episode: Episode,
        sense: PaperSense,
        action: Array,
    ) -> tuple[Episode, PaperSense, Array, Array]:
        """One step: the next augmented state, what it shows, its reward and whether it ends."""
        del sense
        state = robot.step(episode.state, action)
        tau = episode.tau + 1
        sound = is_sound(state)
        after = self._sense(robot, world, problem, windows, state, tau)
        certificate = _certificate(
            windows, after.checks, episode.certificate, episode.progress, tau
        )
        progress = episode.progress + (certificate == 2)
        satisfied = episode.satisfied * _kept(after.checks)
        complete = progress >= windows.count
        present = after.checks.subgoal[jnp.minimum(progress, windows.start.shape[0] - 1)]
        reward = (
            self.distance / robot.length * jnp.where(complete, 0.0, present)
            + self.progress * (progress != episode.progress)
            + self.success * (complete & (satisfied.min() > 0))
            + self.violation * (satisfied.min() == 0)
        )
        reward = jnp.where(sound, reward, self.violation)
        following = Episode(
            state,
            tau,
            episode.progress,
            progress,
            certificate,
            satisfied,
            episode.alive,
            jnp.where(sound, jnp.minimum(episode.robustness, worst_open(after.checks)), -jnp.inf),
        )
        ends = (tau >= problem.formula.horizon) | ~sound
        return following, after, self.scale * reward, ends

    def succeeded(self, windows: Windows, episode: Episode) -> Array:
        """Whether the progress pointer and the flags say that all was achieved."""
        achieved = (episode.progress >= windows.count) & (episode.satisfied.min() > 0)
        return achieved & (episode.robustness > -jnp.inf)

    def policy_features(
        self,
        robot: Robot,
        problem: Problem,
        windows: Windows,
        episode: Episode,
        sense: PaperSense,
    ) -> Array:
        """The augmented state and the schedule (Sec. 4.2), scaled to about one."""
        del sense
        size = windows.order.shape[0]
        horizon = problem.formula.horizon
        return jnp.concatenate(
            [
                robot.position(episode.state) / (5 * robot.length),
                robot.observe(episode.state),
                jnp.stack([episode.tau / horizon, episode.previous_progress / size]),
                jax.nn.one_hot(episode.progress, size + 1),
                jax.nn.one_hot(episode.certificate, 3),
                episode.satisfied,
                windows.schedule / horizon,
            ]
        )

    def critic_features(
        self,
        problem: Problem,
        windows: Windows,
        slack: Array,
        shortfall: Array,
        episode: Episode,
        sense: PaperSense,
        features: Array,
    ) -> Array:
        """The same as the policy's."""
        del problem, windows, slack, shortfall, episode, sense
        return features

    def _sense(
        self, robot: Robot, world: World, problem: Problem, windows: Windows, state: Array, tau
    ) -> PaperSense:
        mu, gradient = extended_margins(robot, world, problem, state)
        return PaperSense(check(problem, windows, tau, mu, gradient))


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
    return 1.0 - (checks.constraint_open & (checks.constraint < 0))
