"""Outcomes of a finished policy on missions, and the critic that is fitted to them."""

from functools import partial
from typing import Any

import jax
import numpy as np

from core.compilation import program
from core.evaluation import rollout_robustness
from core.methods.tgpo.controller import TgpoController
from core.methods.tgpo.outcome import (
    OutcomeCritic,
    fit_outcome,
    outcome_features,
    outcome_targets,
)
from core.rollout import roll_out, start_states
from core.task.physics import physics_of
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.schedules import feasible_schedules
from envs import make_robot
from studio.runs.missions import curriculum

STREAM = 2**21
"""Added to a training's seed: the missions are others than those of training."""

MISSIONS, ROLLOUTS = 2000, 64
"""Missions, and rollouts of each from random initial states, one schedule each."""

MISSIONS_IN_PHYSICS, ROLLOUTS_IN_PHYSICS = 400, 16


def outcome_critic(robot_name: str, controller: TgpoController, seed: int) -> OutcomeCritic:
    """The critic of outcomes of a controller, fitted to its rollouts on many missions.

    Args:
        robot_name: of the robot.
        controller: of the finished policy.
        seed: of the training; draws missions, schedules and the fit.
    """
    source, robot = curriculum(robot_name, seed + STREAM), make_robot(robot_name)
    physical = physics_of(robot) is not None
    most, count = (MISSIONS_IN_PHYSICS, ROLLOUTS_IN_PHYSICS) if physical else (MISSIONS, ROLLOUTS)
    features, targets = [], []
    for number in range(most):
        task, key = source(number).task, jax.random.fold_in(jax.random.key(seed + STREAM), number)
        start_key, draw_key = jax.random.split(key)
        states = start_states(task.problem, start_key, count=count)
        schedules, seen = _drawn(task.problem, controller, draw_key, states)
        rollout = roll_out(task, controller, states, schedules)
        robustness = rollout_robustness(task, rollout)
        features.append(np.asarray(seen))
        targets.append(outcome_targets(robustness, robot.length))
    return fit_outcome(np.stack(features), np.stack(targets), seed)


@program
def _drawn(problem: Problem, controller: TgpoController, key: Array, states: Array) -> Any:
    """A schedule for each state [R, n], half of them drawn forward in time: [R, V], [R, h]."""
    schedules = feasible_schedules(
        problem, controller.search, key, states, forward=states.shape[0] // 2
    )
    features = partial(outcome_features, controller.algorithm, problem)
    return schedules, jax.vmap(features)(states, schedules)
