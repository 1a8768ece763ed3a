"""Algorithms that are small enough to train an epoch in milliseconds; they learn nothing."""

from dataclasses import replace

from core.algorithm import Algorithm


def shrink(algorithm: Algorithm) -> Algorithm:
    """The same algorithm with few environments, small networks and short chains."""
    return replace(
        algorithm,
        environments=16,
        hidden=(16,),
        passes=1,
        minibatches=2,
        mcmc_steps=2,
        mcmc_warmup=0,
        elite_capacity=16,
        prune_candidates=4,
        choice_candidates=8,
    )
