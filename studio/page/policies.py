"""Between the page's trainings and the policies of files."""

from core.errors import UserError
from core.methods.training import TrainingConfig
from studio.page.editing.specification import Specification
from studio.page.trainer import Trainer, Training
from studio.runs.bundle import Policy


def policy_of(training: Training) -> Policy:
    """What a training has learnt, for export.

    Raises:
        UserError: nothing yet.
    """
    config, scene = training.config, training.scene
    if training.weights is None or config is None or scene is None:
        raise UserError("There is no policy yet. Train first, or load one.")
    success = training.success
    return Policy(
        scene,
        config.algorithm.mode_name,
        config.method,
        config.seed,
        config.algorithm,
        training.weights,
        float("nan") if success is None else success,
        float("nan"),
        training.epoch,
    )


def adopt(trainer: Trainer, policy: Policy, specification: Specification, origin: str) -> None:
    """Show what a policy does on a judged scene.

    Raises:
        UserError: the scene's formula cannot be used.
    """
    if specification.task is None:
        raise UserError(specification.error)
    trainer.adopt(
        specification.task,
        TrainingConfig(policy.algorithm, policy.method, seed=policy.seed),
        policy.weights,
        specification.scene,
        epoch=policy.epochs,
        success=policy.success_rate,
        origin=origin,
    )
