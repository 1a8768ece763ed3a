"""Robots bring what they are trained with; the presets of the shipped ones stay what they are."""

from dataclasses import replace

import pytest

from core.errors import UserError
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from core.methods.tgpo.algorithm import PAPER, Algorithm, make_algorithm
from envs import ENVS, VARIANTS, Linear, make_robot
from scenes import load_task
from studio.runs.config import make_config

VIOLATION = {"linear": -3.0, "unicycle": -3.5, "panda": -3.0, "quadrotor": -3.0, "ant": -1.5}
"""lambda_4 of Table A.1."""

STUDIO = {
    "linear": {"learning_rate": 2e-3, "model_epochs": 10**6, "evaluation_states": 512},
    "unicycle": {"learning_rate": 2e-3, "model_epochs": 10**6, "evaluation_states": 512},
    "panda": {"learning_rate": 2e-3, "model_epochs": 10**6, "evaluation_states": 512},
    "quadrotor": {"learning_rate": 2.5e-3, "model_epochs": 10**6, "evaluation_states": 512},
    "ant": {"learning_rate": 2.5e-3, "model_epochs": 50, "evaluation_states": 128},
}
EPOCHS = {"linear": 200, "unicycle": 200, "panda": 200, "quadrotor": 200, "ant": 60}
GRADUAL = {"quadrotor", "ant"}


@pytest.mark.parametrize("robot", STUDIO)
def test_studio_presets(robot):
    mode = StudioMode(
        violation=VIOLATION[robot],
        gradual_stays=robot in GRADUAL,
        dangers=2,
        ahead=(0.5, 1.2),
    )
    expected = replace(Algorithm(mode=mode), **STUDIO[robot])
    assert make_algorithm("studio", "tgpo-star", ENVS[robot]) == expected
    uniform = replace(expected, share_mcmc=0.0, share_elite=0.0)
    assert make_algorithm("studio", "tgpo", ENVS[robot]) == uniform


@pytest.mark.parametrize("robot", STUDIO)
def test_paper_presets(robot):
    expected = replace(PAPER, mode=PaperMode(violation=VIOLATION[robot]))
    assert (expected.learning_rate, expected.evaluation_states) == (3e-4, 512)
    assert make_algorithm("paper", "tgpo-star", ENVS[robot]) == expected


@pytest.mark.parametrize("robot", STUDIO)
def test_epochs(robot):
    scene = load_task(f"{robot}-demo")
    assert make_config(scene).training.epochs == EPOCHS[robot]
    assert make_config(scene, mode="paper").training.epochs == 1000


def test_variants_are_tuned_like_their_robot():
    for name, variants in VARIANTS.items():
        for variant in variants:
            assert make_robot(name, variant).tuning == ENVS[name].tuning


def test_what_is_not_offered_is_named():
    with pytest.raises(UserError, match=r"unknown mode 'fast'. Available: \['paper', 'studio'\]"):
        make_algorithm("fast", "tgpo", Linear())  # pyright: ignore[reportArgumentType]
    with pytest.raises(UserError, match=r"unknown method 'ppo'. Available: \['tgpo', 'tgpo-star'"):
        make_algorithm("studio", "ppo", Linear())  # pyright: ignore[reportArgumentType]
