"""The paper's augmented state as features (Sec. 4.2), for networks that know one task only."""

import jax
import jax.numpy as jnp

from core.mdp.episode import Episode
from core.mdp.grounded import GroundedMdp
from core.task.protocols import Array


def augmented_state(
    mdp: GroundedMdp, episode: Episode, *, time: bool = True, flags: bool = True
) -> Array:
    """The augmented state and the schedule, scaled to about one.

    Args:
        mdp: of the schedule.
        episode: the augmented state.
        time: whether tau is among them.
        flags: whether p_prev, p, r and chi are.
    """
    windows, robot = mdp.windows, mdp.problem.robot
    size = windows.order.shape[0]
    horizon = mdp.problem.formula.horizon
    progress = [episode.tau / horizon] if time else []
    progress += [episode.previous_progress / size] if flags else []
    parts = [
        robot.position(episode.state) / (5 * robot.length),
        robot.observe(episode.state),
    ]
    if progress:
        parts.append(jnp.stack(progress))
    if flags:
        parts += [
            jax.nn.one_hot(episode.progress, size + 1),
            jax.nn.one_hot(episode.certificate, 3),
            episode.satisfied,
        ]
    return jnp.concatenate([*parts, windows.schedule / horizon])
