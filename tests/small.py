"""Algorithms and epochs small enough for tests; they learn nothing."""

from dataclasses import replace
from types import SimpleNamespace

from core.methods.tgpo.algorithm import Algorithm


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


def scripted_epoch() -> SimpleNamespace:
    """Stands for the `Progress` of a training that has ended well after an epoch."""
    return SimpleNamespace(
        epoch=1,
        env_steps=10,
        train_seconds=0.1,
        batch_success=0.5,
        batch_return=0.0,
        diverged=0,
        evaluation=SimpleNamespace(success_rate=1.0, robustness_mean=0.1),
        weights="weights",
        schedules=None,
        state=SimpleNamespace(best="best", best_success=1.0),
    )
