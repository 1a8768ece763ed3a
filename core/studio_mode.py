"""The `studio` mode of the grounded MDP: what makes learning take seconds (design section 6).

An episode ends at the first violated task, so while it lives the progress p is a function of
time alone: the number of subgoals whose windows have closed. The robot travels to the next
subgoal that opens, or stays in the one that is open. Windows may overlap; an open stay then acts
as a constraint on the way to the next subgoal.

A simulation that breaks down ends its episode like a violation.

Reward: shape * (distance before - distance after) along the geodesic field of the present leg
(potential shaping; lengths in units of the robot's), lambda_2 per subgoal, lambda_3 for the last
one, lambda_4 for a violation.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.episode import (
    Checks,
    Episode,
    check,
    is_sound,
    worst_open,
    worst_open_constraint,
)
from core.problem import Problem, closed_doors, extended_margins
from core.protocols import Array, Robot, World
from core.windows import Windows, field_index


class Sense(NamedTuple):
    """What the robot perceives in one augmented state."""

    checks: Checks
    distance: Array  # [] geodesic distance to the present subgoal [m]
    direction: Array  # [d] unit direction of travel
    rank: Array  # [] the present subgoal, in order of start
    doors: Array  # [] combination of closed doors
    live: Array  # [] whether a subgoal is left
    holding: Array  # [] whether the present subgoal is open and to be kept


@dataclass(frozen=True)
class StudioMode:
    """Weights of the reward; `scale` multiplies all of it."""

    shape: float = 2.0
    progress: float = 20.0
    success: float = 20.0
    violation: float = -3.0
    scale: float = 0.05
    exploring: float = 0.5
    """Share of exploring starts among the episodes that follow a finished one."""
    gradual_stays: bool = False
    """Whether lambda_2 of a stay is paid step by step and exploring starts lie within stays too.

    For robots that cannot stop at once: they learn the end of a stay first, then the rest.
    """

    def begin(
        self, robot: Robot, world: World, problem: Problem, windows: Windows, state: Array, tau
    ) -> tuple[Episode, Sense]:
        """Episode that starts in `state` [n] at step `tau`, as if all before had gone well."""
        sense = self._sense(robot, world, problem, windows, state, tau)
        worst = worst_open(sense.checks)
        progress = (windows.end <= tau).sum()
        episode = Episode(
            state,
            tau,
            progress,
            progress,
            sense.holding.astype(jnp.int32),
            jnp.ones_like(windows.constraint_start),
            (worst >= 0).astype(jnp.float32),
            worst,
        )
        return episode, sense

    def advance(
        self,
        robot: Robot,
        world: World,
        problem: Problem,
        windows: Windows,
        episode: Episode,
        sense: Sense,
        action: Array,
    ) -> tuple[Episode, Sense, Array, Array]:
        """One step: the next augmented state, what it shows, its reward and whether it ends."""
        state = robot.step(episode.state, action)
        tau = episode.tau + 1
        after = self._sense(robot, world, problem, windows, state, tau)
        sound = is_sound(state)
        worst = jnp.where(sound, worst_open(after.checks), -jnp.inf)
        alive = (worst >= 0).astype(jnp.float32) * episode.alive
        progress = jnp.where(alive > 0, (windows.end <= tau).sum(), episode.progress)
        gained = progress - episode.progress
        same = (after.rank == sense.rank) & (after.doors == sense.doors)
        travelled = sense.distance - jnp.where(same, after.distance, 0.0)
        limit = 1.5 * robot.speed
        travelled = jnp.clip(jnp.where(same | (alive > 0), travelled, 0.0), -limit, limit)
        reward = (
            self.shape / robot.length * travelled * sense.live
            + self.progress * self._earned(windows, tau, alive, gained)
            + self.success * ((progress == windows.count) & (gained > 0))
            + self.violation * (worst_open_constraint(after.checks) < 0)
        )
        reward = jnp.where(sound, reward, self.violation)
        following = Episode(
            state,
            tau,
            episode.progress,
            progress,
            after.holding.astype(jnp.int32),
            episode.satisfied * ~(after.checks.constraint_open & (after.checks.constraint < 0)),
            alive,
            jnp.minimum(episode.robustness, worst),
        )
        ends = (alive == 0) | (tau >= windows.last)
        return following, after, self.scale * reward, ends

    def _earned(self, windows: Windows, tau: Array, alive: Array, gained: Array) -> Array:
        """Subgoals achieved by this step: whole ones, or shares of stays."""
        if not self.gradual_stays:
            return gained
        lasting = windows.end - windows.start + 1
        now = jnp.clip((tau + 1 - windows.start) / lasting, 0, 1)
        before = jnp.clip((tau - windows.start) / lasting, 0, 1)
        return alive * (now - before).sum()

    def succeeded(self, windows: Windows, episode: Episode) -> Array:
        """Whether every task held until everything was decided."""
        return (episode.alive > 0) & (episode.tau >= windows.last)

    def policy_features(
        self, robot: Robot, problem: Problem, windows: Windows, episode: Episode, sense: Sense
    ) -> Array:
        """Task-agnostic features [f] in the robot's frame: 20 numbers and its own for d = 2."""
        last = windows.order.shape[0] - 1
        rank, following = jnp.minimum(sense.rank, last), jnp.minimum(sense.rank + 1, last)
        position = robot.position(episode.state)
        live = sense.live
        next_live = (sense.rank + 1 < windows.count).astype(jnp.float32) * live
        distance = sense.distance / robot.length
        opens, closes = windows.start[rank] - episode.tau, windows.end[rank] - episode.tau
        opens_next = windows.start[following] - episode.tau
        hurry = jnp.clip(sense.distance / (jnp.maximum(opens, 1.0) * robot.speed), 0, 2)
        direction = sense.direction * jnp.minimum(1.0, 4 * distance) * live
        centers = (problem.center[windows.order] - position) / robot.length
        center, onward = centers[rank] * live, centers[following] * next_live
        margin, obstacle = _nearest_danger(windows, episode.tau, sense, robot.length)
        vectors = jnp.stack(
            [
                direction,
                direction * hurry,
                center / jnp.maximum(1.0, jnp.linalg.norm(center)),
                obstacle,
                onward / 5,
            ]
        )
        scalars = jnp.stack(
            [
                jnp.minimum(distance, 6.0) / 3,
                hurry,
                jnp.clip(opens / 20, -1, 3) * live,
                jnp.clip(closes / 20, -1, 3) * live,
                sense.holding * 1.0,
                live,
                jnp.clip(-margin, -2, 1),
                jnp.clip(opens_next / 20, -1, 3) * next_live,
            ]
        )
        framed = robot.to_frame(episode.state, vectors).reshape(-1)
        return jnp.concatenate([robot.observe(episode.state), framed, scalars])

    def critic_features(
        self,
        problem: Problem,
        windows: Windows,
        slack: Array,
        shortfall: Array,
        episode: Episode,
        sense: Sense,
        features: Array,
    ) -> Array:
        """The policy's features, the schedule, the progress and the reserve of each leg."""
        size = windows.order.shape[0]
        horizon = problem.formula.horizon
        ahead = jnp.arange(size) >= sense.rank
        return jnp.concatenate(
            [
                features,
                windows.schedule / horizon,
                jax.nn.one_hot(sense.rank, size + 1),
                jnp.clip(slack / 20, -2, 2) * ahead,
                jnp.stack([episode.tau / horizon, shortfall / 20, episode.alive]),
            ]
        )

    def _sense(
        self, robot: Robot, world: World, problem: Problem, windows: Windows, state: Array, tau
    ) -> Sense:
        position = robot.position(state)
        mu, gradient = extended_margins(robot, world, problem, state)
        checks = check(problem, windows, tau, mu, gradient)
        rank, holding = _target(windows, tau)
        live = (rank < windows.count).astype(jnp.float32)
        doors = closed_doors(problem, windows.constraint_start, windows.constraint_end, tau)
        subgoal = windows.order[jnp.minimum(rank, windows.order.shape[0] - 1)]
        distance, direction = world.field(problem.world, field_index(subgoal, doors), position)
        return Sense(checks, distance * live, direction, rank, doors, live, holding)


def _target(windows: Windows, tau: Array) -> tuple[Array, Array]:
    """Rank of the subgoal to travel to or to stay in at step tau, and whether it is a stay."""
    size = windows.start.shape[0]
    entered = (windows.start <= tau).sum()
    open_ = (windows.start <= tau) & (tau < windows.end) & (jnp.arange(size) < windows.count)
    held = jnp.where(open_, jnp.arange(size), -1).max()
    next_start = jnp.where(
        entered < windows.count, windows.start[jnp.minimum(entered, size - 1)], jnp.inf
    )
    keep = (held >= 0) & (next_start > windows.end[held])
    return jnp.where(keep, held, entered), keep


def _nearest_danger(
    windows: Windows, tau: Array, sense: Sense, length: float
) -> tuple[Array, Array]:
    """Margin [] and direction [d], fading with distance, of what is nearest to being violated.

    The margin is in units of `length`. Candidates are the constraints that hold at the next step
    and the stays that are open.
    """
    checks = sense.checks
    soon = tau + 1
    constraint = (windows.constraint_start <= soon) & (soon <= windows.constraint_end)
    stay = (windows.start <= tau) & (soon <= windows.end)
    margin = jnp.where(
        jnp.concatenate([stay, constraint]),
        jnp.concatenate([checks.subgoal, checks.constraint]),
        9.0 * length,
    )
    nearest = margin.argmin()
    value = margin[nearest] / length
    return value, -checks.gradient[nearest] * jnp.exp(-3 * jnp.clip(value, -0.3, 3.0))
