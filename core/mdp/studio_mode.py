"""The `studio` mode of the grounded MDP: what makes learning take seconds (docs/method.md).

An episode ends at the first violated task, so until then the progress p is a function of time
alone: the number of subgoals whose windows have closed. The robot travels to the next
subgoal that opens, or stays in the one that is open. Windows may overlap; an open stay then acts
as a constraint on the way to the next subgoal.

A simulation that diverges ends its episode like a violation.

Where regions move, ways lead to where the current subgoal will be: when its window opens, or at
the next step once it is open. Dangers are perceived as they are about to be (`core.mdp.dangers`).

Reward: shape * (distance before - distance after) along the geodesic field of the current leg
(potential shaping; lengths in units of the robot's), lambda_2 per subgoal, lambda_3 for the last
one, lambda_4 for a violation.
"""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
from msgspec import Meta

from core.documents import Positive, Share, Weight
from core.mdp.augmented import augmented_state
from core.mdp.dangers import coming_checks, nearest_dangers
from core.mdp.episode import (
    Checks,
    Episode,
    check,
    check_between,
    is_sound,
    violated_constraints,
    worst_open,
    worst_open_constraint,
)
from core.mdp.grounded import GroundedMdp
from core.mdp.way import geodesic_way, straight_way
from core.task.problem import Problem, closed_doors, extended_margins
from core.task.protocols import Array
from core.task.sites import center_at
from core.task.sizes import STANDARD
from core.task.windows import Windows

VARIABLES_SEEN, LEGS_SEEN = STANDARD.variables, STANDARD.subgoals
"""What the critic sees of schedules and legs, whatever the sizes of the formula's arrays."""


class Sense(NamedTuple):
    """What the robot perceives in one augmented state."""

    checks: Checks
    coming: Checks | None  # as they are about to be; None where nothing moves
    distance: Array  # [] geodesic distance to the current subgoal [m]
    direction: Array  # [d] unit direction of travel
    ahead: Array  # [K, d] unit directions of travel further along the way
    rank: Array  # [] the current subgoal, in order of start
    doors: Array  # [] combination of closed doors
    live: Array  # [] whether a subgoal is left
    holding: Array  # [] whether the current subgoal is an open stay

    @property
    def dangers(self) -> Checks:
        """What may be violated next."""
        return self.checks if self.coming is None else self.coming


@dataclass(frozen=True)
class StudioMode:
    """Weights of the reward; `scale` multiplies all of it."""

    name: ClassVar[str] = "studio"
    pays_robustness: ClassVar[bool] = False

    shape: Weight = 2.0
    progress: Weight = 20.0
    success: Weight = 20.0
    violation: Weight = -3.0
    scale: Positive = 0.05
    exploring: Share = 0.5
    """Share of exploring starts among the episodes that follow a finished one."""
    gradual_stays: bool = False
    """Whether a stay's lambda_2 is paid step by step, with exploring starts within stays too.

    For robots that cannot stop at once: they learn the end of a stay first, then the rest.
    """
    dangers: Annotated[int, Meta(ge=1, le=4)] = 1
    """How many of the tasks closest to being violated are perceived; 1 in version 1."""
    ahead: Annotated[tuple[Positive, ...], Meta(max_length=4)] = ()
    """Distances in robot lengths at which the way's further direction is perceived."""
    fields: bool = True
    """Whether ways lead around the obstacles; if not, straight to the subgoal."""
    early_end: bool = True
    """Whether an episode ends at the first violated task or when all is decided.

    If not, at the horizon; violated constraints are paid at every step."""
    features: bool = True
    """Whether the networks see features that are the same for every task.

    If not, the paper's augmented state."""

    def begin(self, mdp: GroundedMdp, state: Array, tau) -> tuple[Episode, Sense]:
        """Episode that starts in `state` [n] at step `tau`, as if all before had gone well."""
        sense = self._sense(mdp, state, tau)
        worst = worst_open(sense.checks)
        progress = (mdp.windows.end <= tau).sum()
        episode = Episode(
            state,
            tau,
            progress,
            progress,
            sense.holding.astype(jnp.int32),
            jnp.ones_like(mdp.windows.constraint_start),
            (worst >= 0).astype(jnp.float32),
            worst,
        )
        return episode, sense

    def observe(self, mdp: GroundedMdp, episode: Episode, state: Array) -> tuple[Episode, Sense]:
        """The episode one step on, where the robot was found in `state`."""
        windows, tau = mdp.windows, episode.tau + 1
        sense = self._sense(mdp, state, tau)
        moved = episode.state, state
        checks = check_between(mdp.problem, windows, tau, sense.checks, moved)
        sense = sense._replace(checks=checks)
        worst = jnp.where(is_sound(state), worst_open(sense.checks), -jnp.inf)
        alive = (worst >= 0).astype(jnp.float32) * episode.alive
        progress = jnp.where(alive > 0, (windows.end <= tau).sum(), episode.progress)
        violated = violated_constraints(sense.checks)
        following = Episode(
            state,
            tau,
            episode.progress,
            progress,
            sense.holding.astype(jnp.int32),
            episode.satisfied * ~violated,
            alive,
            jnp.minimum(episode.robustness, worst),
        )
        return following, sense

    def reward(
        self, mdp: GroundedMdp, before: tuple[Episode, Sense], after: tuple[Episode, Sense]
    ) -> tuple[Array, Array]:
        """Reward of a step, and whether it ends the episode."""
        (_, sensed), (episode, sense) = before, after
        windows, robot, tau = mdp.windows, mdp.problem.robot, episode.tau
        alive, gained = episode.alive, episode.progress - episode.previous_progress
        same = (sense.rank == sensed.rank) & (sense.doors == sensed.doors)
        travelled = sensed.distance - jnp.where(same, sense.distance, 0.0)
        limit = 1.5 * robot.speed
        travelled = jnp.clip(jnp.where(same | (alive > 0), travelled, 0.0), -limit, limit)
        reward = (
            self.shape / robot.length * travelled * sensed.live
            + self.progress * self._earned(windows, tau, alive, gained)
            + self.success * ((episode.progress == windows.count) & (gained > 0))
            + self.violation * (worst_open_constraint(sense.checks) < 0)
        )
        reward = jnp.where(is_sound(episode.state), reward, self.violation)
        if not self.early_end:
            over = tau >= mdp.problem.formula.horizon
            return self.scale * reward, over | ~is_sound(episode.state)
        return self.scale * reward, (alive == 0) | (tau >= windows.last)

    def _earned(self, windows: Windows, tau: Array, alive: Array, gained: Array) -> Array:
        """Subgoals achieved by this step: whole ones, or shares of stays."""
        if not self.gradual_stays:
            return gained
        lasting = windows.end - windows.start + 1
        now = jnp.clip((tau + 1 - windows.start) / lasting, 0, 1)
        before = jnp.clip((tau - windows.start) / lasting, 0, 1)
        return alive * (now - before).sum()

    def succeeded(self, mdp: GroundedMdp, episode: Episode) -> Array:
        """Whether every task held until everything was decided."""
        return (episode.alive > 0) & (episode.tau >= mdp.windows.last)

    def policy_features(self, mdp: GroundedMdp, episode: Episode, sense: Sense) -> Array:
        """Task-agnostic features [f] in the robot's frame.

        For d = 2: 17 numbers, 3 for each danger, and the robot's own.
        """
        if not self.features:
            return augmented_state(mdp, episode)
        problem, windows, robot = mdp.problem, mdp.windows, mdp.problem.robot
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
        centers = (_centers(problem, windows, episode.tau) - position) / robot.length
        center, onward = centers[rank] * live, centers[following] * next_live
        margins, obstacles = nearest_dangers(
            windows, episode.tau, sense.dangers, robot.length, self.dangers
        )
        vectors = jnp.stack(
            [
                direction,
                direction * hurry,
                center / jnp.maximum(1.0, jnp.linalg.norm(center)),
                obstacles[0],
                onward / 5,
                *obstacles[1:],
                *sense.ahead * jnp.minimum(1.0, 4 * distance) * live,
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
                jnp.clip(-margins[0], -2, 1),
                jnp.clip(opens_next / 20, -1, 3) * next_live,
                *jnp.clip(-margins[1:], -2, 1),
            ]
        )
        framed = robot.to_frame(episode.state, vectors).reshape(-1)
        return jnp.concatenate([robot.observe(episode.state), framed, scalars])

    def critic_features(
        self, mdp: GroundedMdp, episode: Episode, sense: Sense, features: Array
    ) -> Array:
        """The policy's features, the schedule, the progress and the reserve of each leg.

        Of a longer mission, the first variables and the next legs: as many as weights know.
        """
        if not self.features:
            return features
        windows = mdp.windows
        horizon = mdp.problem.formula.horizon
        first = jnp.clip(windows.count - LEGS_SEEN, 0, sense.rank)
        slack = jax.lax.dynamic_slice(mdp.slack, (first,), (LEGS_SEEN,))
        ahead = first + jnp.arange(LEGS_SEEN) >= sense.rank
        return jnp.concatenate(
            [
                features,
                windows.schedule[:VARIABLES_SEEN] / horizon,
                jax.nn.one_hot(sense.rank - first, LEGS_SEEN + 1),
                jnp.clip(slack / 20, -2, 2) * ahead,
                jnp.stack([episode.tau / horizon, mdp.shortfall / 20, episode.alive]),
            ]
        )

    def _sense(self, mdp: GroundedMdp, state: Array, tau) -> Sense:
        problem, windows = mdp.problem, mdp.windows
        position = problem.robot.position(state)
        mu, gradient = extended_margins(problem, state, tau)
        checks = check(problem, windows, tau, mu, gradient)
        rank, holding = _target(windows, tau)
        live = (rank < windows.count).astype(jnp.float32)
        doors = closed_doors(problem, windows.constraint_start, windows.constraint_end, tau)
        if self.fields:
            way = geodesic_way(problem, windows, tau, position, rank, doors, self.ahead)
        else:
            way = straight_way(checks, rank, self.ahead)
        coming = None if problem.sites is None else coming_checks(problem, windows, tau, state)
        distance = way.distance * live
        return Sense(checks, coming, distance, way.direction, way.ahead, rank, doors, live, holding)


def _centers(problem: Problem, windows: Windows, tau: Array) -> Array:
    """Centres [G, d] of the subgoals in order of start: where they will be when they open [m]."""
    if problem.sites is None:
        return problem.center[windows.order]
    due = jnp.maximum(windows.start, tau + 1)
    return jax.vmap(partial(center_at, problem.sites))(windows.order, due)


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
