"""A critic of outcomes: how well a finished policy carries out a schedule.

PPO's critic estimates discounted rewards of a policy that was still exploring, and knows nothing of
robustness. On missions that it never saw it tells good schedules from bad ones poorly. So weights
that serve every task have a third network, fitted after learning to rollouts of the deterministic
policy on many missions. Its target is 0 where the exact semantics say violated, and otherwise
grows with the robustness from `SATISFIED` to 1. It sees what the policy sees at the start and the
legs of the schedule in order of start, not the formula's variables.

Dimensions: M missions, R rollouts of each, h features.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from core.compilation import program, shape_of
from core.mdp.grounded import ground_schedule
from core.mdp.mode import begin
from core.methods.networks import Perceptron
from core.methods.tgpo.algorithm import Algorithm
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.windows import legs_of

LEGS = 8
"""Legs that are seen, the first ones."""

SATISFIED = 0.8
"""Target of a formula that is satisfied barely."""

ROBUST = 0.3
"""Robustness from which the target is 1, in robot lengths."""

HIDDEN = (32,)
"""Larger networks fit the missions better, and rank schedules of other missions worse."""

STEPS, BATCH, ROUND = 6_000, 16, 500
"""Steps of Adam, missions of each, and steps of a compiled round."""

NETWORK = Perceptron(HIDDEN, 1)
RATE, WEIGHT_DECAY = 3e-3, 1e-2
CLIP = 3.0
"""Standardised features are clipped to it: other missions may lie far outside."""


class OutcomeCritic(NamedTuple):
    """A perceptron with one output, and how its features are standardised."""

    network: Any
    shift: Array  # [h]
    scale: Array  # [h]


def outcome_features(algorithm: Algorithm, problem: Problem, state: Array, schedule: Array) -> Any:
    """What the critic of outcomes sees [h] of a schedule [V] from an initial state [n]."""
    position, reserve = problem.robot.position(state), algorithm.reserve
    mdp = ground_schedule(problem, position, schedule, reserve=reserve)
    view, windows = begin(algorithm.mode, mdp, state, jnp.float32(0)), mdp.windows
    size = windows.order.shape[0]
    leg = jnp.minimum(jnp.arange(LEGS), size - 1)
    there = (jnp.arange(LEGS) < windows.count) * 1.0
    legs = legs_of(problem, windows, position, reserve)
    each = jnp.stack(
        [
            jnp.clip(mdp.slack / 20, -1, 2),
            jnp.clip(mdp.slack / 5, -1, 1),
            jnp.clip(legs.needed / 30, 0, 2),
            jnp.clip((windows.end - windows.start) / 20, 0, 2),
            legs.overlap * 1.0,
            jnp.clip(windows.start / 100, 0, 1.5),
        ]
    )[:, leg]
    slack = jnp.where(legs.live, mdp.slack, 20.0)
    together = jnp.stack(
        [
            windows.count / 6,
            jnp.clip(slack.min() / 10, -1, 2),
            jnp.clip(jax.nn.relu(-slack).sum() / 10, 0, 3),
            jnp.clip(windows.last / 100, 0, 1.5),
            jnp.clip(mdp.shortfall / 20, 0, 5),
        ]
    )
    return jnp.concatenate([view.policy, (each * there).reshape(-1), there, together])


def outcome_value(
    algorithm: Algorithm, problem: Problem, critic: OutcomeCritic, state: Array, schedule: Array
) -> Array:
    """Expected target [] of a schedule [V] from an initial state [n], between 0 and 1."""
    features = outcome_features(algorithm, problem, state, schedule)
    return jax.nn.sigmoid(_logit(critic, features))


def outcome_targets(robustness: np.ndarray, length: float) -> np.ndarray:
    """Targets [R] of rollouts of a robustness [R] in [m]; `length` is the robot's."""
    robust = np.clip(np.nan_to_num(robustness, neginf=0.0) / (ROBUST * length), 0, 1)
    return np.where(robustness >= 0, SATISFIED + (1 - SATISFIED) * robust, 0.0)


def outcome_shapes(algorithm: Algorithm, problem: Problem) -> OutcomeCritic:
    """Stands for a critic of outcomes."""
    state = shape_of(problem.robot.state_size, dtype=jnp.float32)
    schedule = shape_of(*problem.formula.low.shape, dtype=jnp.int32)
    features = jax.eval_shape(partial(outcome_features, algorithm), problem, state, schedule)
    numbers = shape_of(*features.shape, dtype=jnp.float32)
    network = jax.eval_shape(NETWORK.init, jax.random.key(0), numbers)
    return OutcomeCritic(network, numbers, numbers)


def fit_outcome(features: np.ndarray, targets: np.ndarray, seed: int) -> OutcomeCritic:
    """The critic of outcomes that fits features [M, R, h] and targets [M, R] best.

    It minimises the cross-entropy of each rollout, and of the order of every two rollouts of a
    mission, by Adam with weight decay and a learning rate that falls to nothing.
    """
    shift, scale = features.mean((0, 1)), features.std((0, 1)) + 1e-3
    init_key, batch_key = jax.random.split(jax.random.key(seed))
    network = NETWORK.init(init_key, jnp.zeros(features.shape[-1]))
    critic = OutcomeCritic(network, jnp.asarray(shift), jnp.asarray(scale))
    carry = critic, _optimizer().init(network)
    data = jnp.asarray(features, jnp.float32), jnp.asarray(targets, jnp.float32)
    for round_key in jax.random.split(batch_key, STEPS // ROUND):
        carry = _fit(carry, *data, round_key)
    return carry[0]


def _logit(critic: OutcomeCritic, features: Array) -> Array:
    standard = jnp.clip((features - critic.shift) / critic.scale, -CLIP, CLIP)
    logits: Any = NETWORK.apply(critic.network, standard)
    return logits[..., 0]


def _optimizer() -> optax.GradientTransformation:
    return optax.adamw(optax.cosine_decay_schedule(RATE, STEPS), weight_decay=WEIGHT_DECAY)


@program
def _fit(carry: Any, features: Array, targets: Array, key: Array) -> Any:
    """`ROUND` steps of Adam."""
    optimizer = _optimizer()

    def loss(parameters: Any, critic: OutcomeCritic, chosen: Array) -> Array:
        logit, target = (
            _logit(critic._replace(network=parameters), features[chosen]),
            targets[chosen],
        )
        better = jax.nn.relu(target[:, :, None] - target[:, None, :])
        order = better * jax.nn.softplus(logit[:, None, :] - logit[:, :, None])
        single = optax.sigmoid_binary_cross_entropy(logit, target).mean()
        return single + order.sum() / jnp.maximum(better.sum(), 1.0)

    def step(carry: tuple[OutcomeCritic, Any], step_key: Array):
        critic, state = carry
        chosen = jax.random.randint(step_key, (BATCH,), 0, features.shape[0])
        gradient = jax.grad(loss)(critic.network, critic, chosen)
        updates, state = optimizer.update(gradient, state, critic.network)
        critic = critic._replace(network=optax.apply_updates(critic.network, updates))
        return (critic, state), None

    return jax.lax.scan(step, carry, jax.random.split(key, ROUND))[0]
