"""Shipped tasks as Gymnasium environments, `gymnasium.make("tgpo/linear-08-v0")`.

Nothing is imported here: Gymnasium reads `registration` when it is imported itself, by the entry
point of the distribution, and must not wait for JAX.
"""
