"""Where the subgoals of a formula are to be met when regions move, step by step.

A place whose regions move is worked out at some steps (its distance field, its centre, positions
in it). At all others, what was worked out for the nearest of these steps counts, moved by the way
that the place has gone since.

Dimensions: T steps (padded), G subgoals, N places that were worked out (padded), S samples, d
position.
"""

from typing import NamedTuple

import jax.numpy as jnp

from core.task.protocols import Array


class Sites(NamedTuple):
    """The places of the subgoals as data."""

    since: Array  # [] steps of the episode that have gone by where the problem begins
    row: Array  # [T + 1, G] int32 of the tables below
    drift: Array  # [T + 1, G, d] way from where it was worked out [m]
    center: Array  # [N, d] deepest position [m]
    inside: Array  # [N, S, d] positions in it [m]
    depth: Array  # [N] margin at the centre, 0 where that is outside [m]
    moves: Array  # [G] bool: whether the subgoal's place moves


def center_at(sites: Sites, subgoal: Array, step: Array) -> Array:
    """The deepest position [d] of a subgoal's place at a step of the problem [m]."""
    number = _number(sites, step)
    return sites.center[sites.row[number, subgoal]] + sites.drift[number, subgoal]


def depth_at(sites: Sites, subgoal: Array, step: Array) -> Array:
    """Margin [] at that position, 0 where the place is empty [m]."""
    return sites.depth[sites.row[_number(sites, step), subgoal]]


def inside_at(sites: Sites, subgoal: Array, sample: Array, step: Array) -> Array:
    """One of the positions [d] in a subgoal's place at a step of the problem [m]."""
    number = _number(sites, step)
    return sites.inside[sites.row[number, subgoal], sample] + sites.drift[number, subgoal]


def step_row(step: Array, steps: int) -> Array:
    """Row [] of a table with an entry for each of T = `steps` steps and the first, at any step."""
    return jnp.clip(jnp.round(step), 0, steps).astype(jnp.int32)


def _number(sites: Sites, step: Array) -> Array:
    return step_row(sites.since + step, sites.row.shape[0] - 1)
