"""Train the policies that the page opens with, and write them to static/policies.

    python -m tests.tools.ship_policies [TASK ...]

Deterministic in the seed up to the arithmetic of the machine; the time limit is generous, so that
the target or the number of epochs ends the training.
"""

import sys
from pathlib import Path

from core.programs import use_disk_cache
from core.training import final_evaluation, train
from scenes import load_task
from scenes.scene import DEMO
from studio.files.bundle import Policy
from studio.files.shipped import SHIPPED, save_shipped
from studio.headless.config import make_config
from studio.headless.run import best_parameters
from studio.tasks import build_task

FOLDER = Path(__file__).parents[2] / "static" / "policies"
EPOCHS, SECONDS, TARGET = 200, 1200.0, 0.995
REQUIRED = 0.98

ENDLESS = 2.0
"""A target that no success rate reaches."""

DEMO_EPOCHS = 80
"""Of the demos, target or not: by then both orders of their goals are learnt."""


def main(names: list[str]) -> None:
    """Train, check and write."""
    use_disk_cache()
    for name in names or SHIPPED:
        policy = trained(name)
        if policy.success_rate < REQUIRED:
            raise SystemExit(f"{name}: only {policy.success_rate:.3f} after {policy.epochs} epochs")
        save_shipped(policy, FOLDER)
        print(f"{name}: {policy.success_rate:.4f} after {policy.epochs} epochs")


def trained(name: str) -> Policy:
    """Train one policy with the seed of its scene; of a demo the last weights are kept."""
    scene, demo = load_task(name), name.endswith(DEMO)
    epochs, target = (DEMO_EPOCHS, ENDLESS) if demo else (EPOCHS, TARGET)
    config = make_config(scene, epochs=epochs, time_limit=SECONDS, target=target)
    task, state = build_task(scene), None
    for progress in train(task, config.training):
        state = progress.state
    assert state is not None
    parameters = state.learner.parameters if demo else best_parameters(state)
    evaluation = final_evaluation(task, config.training, parameters)
    return Policy(
        scene,
        config.mode,
        config.method,
        config.training.seed,
        config.training.algorithm,
        parameters,
        evaluation.success_rate,
        evaluation.robustness_mean,
        int(state.epoch),
    )


if __name__ == "__main__":
    main(sys.argv[1:])
