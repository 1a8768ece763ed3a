"""`--pretrain`: weights for every task of a robot, learnt on random missions.

A pretraining is a training whose layouts are missions (see `core.methods.tgpo.layouts`): two of
32 are new in every epoch. Sixty per cent are random missions of the trained families, the others
perturbed layouts of shipped tasks; robots without shipped tasks have random missions only. Its
run directory can be resumed like any other, and holds at the end `weights.safetensors` and their
card, `weights.json`.
"""

from dataclasses import replace
from typing import Any

import msgspec

from core.methods import METHODS
from core.methods.tgpo.algorithm import many_missions
from core.methods.tgpo.controller import TgpoController
from core.methods.training import TrainingConfig, best_weights
from envs import make_robot
from scenes.missions import TRAINED
from studio.runs.config import RunConfig, with_budget
from studio.runs.held_out import held_out_results
from studio.runs.json_documents import algorithm_document
from studio.runs.missions import SHIPPED, VALIDATION, RandomMissions
from studio.runs.outcomes import outcome_critic
from studio.runs.pretrained import FORMAT, Card, save_weights
from studio.runs.run import Run

METHOD, MODE = "tgpo", "studio"
EPOCHS = 400
"""Epochs of a pretraining by default."""

EVALUATED_STATES = 64
"""Initial states of each mission in an evaluation on the way."""


def pretraining_config(
    robot_name: str,
    *,
    seed: int | None = None,
    epochs: int | None = None,
    time_limit: float | None = None,
) -> RunConfig:
    """Configuration of a pretraining; None stands for the default.

    Raises:
        UserError: no such robot, or a budget that is not allowed.
    """
    robot, budget = make_robot(robot_name), EPOCHS if epochs is None else epochs
    algorithm = many_missions(METHODS[METHOD].preset(MODE, robot), budget)
    algorithm = replace(algorithm, evaluation_states=EVALUATED_STATES)
    training = TrainingConfig(
        algorithm,
        METHOD,
        seed=1007 if seed is None else seed,
        epochs=budget,
        target=2.0,
        evaluate_every=20,
    )
    training = with_budget(training, time_limit=time_limit)
    scene = RandomMissions(robot_name, VALIDATION)(0).scene
    return RunConfig(scene, MODE, training, missions=True)


def finish_pretraining(run: Run, summary: dict[str, Any]) -> dict[str, Any]:
    """Measure the weights on what they were not trained on; write them and their card.

    Args:
        run: that has ended.
        summary: of the run.

    Returns:
        The card, for the last line that is printed.
    """
    config, state = run.config, run.state
    assert state is not None
    training, robot = config.training, config.scene.robot
    weights = best_weights(run.task, training, state)
    controller = TgpoController(training.algorithm, weights)
    outcome = outcome_critic(robot, controller, training.seed)
    weights = weights._replace(outcome=outcome)
    algorithm = replace(training.algorithm, outcome=True)
    card = Card(
        format=FORMAT,
        robot=robot,
        mode=config.mode,
        method=config.method,
        seed=training.seed,
        epochs=run.epochs,
        env_steps=summary["env_steps"],
        train_seconds=summary["train_seconds"],
        families=(*TRAINED, SHIPPED),
        held_out=tuple(held_out_results(robot, TgpoController(algorithm, weights))),
        algorithm=algorithm_document(algorithm),
    )
    path = run.folder / "weights.safetensors"
    save_weights(path, weights, card)
    kept = {name: value for name, value in msgspec.to_builtins(card).items() if name != "algorithm"}
    return {**kept, "out": str(path)}
