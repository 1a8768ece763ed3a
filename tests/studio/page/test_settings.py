import math

import pytest

from core.methods.tgpo.algorithm import make_algorithm
from core.methods.training import TrainingConfig
from envs import Linear
from scenes import load_task
from studio.page.settings import LARGEST_SEED, Settings, prolonged

SCENE = load_task("linear-08")
ALGORITHM = make_algorithm("studio", "tgpo-star", Linear())


def test_defaults_leave_a_configuration_as_it_is():
    config = TrainingConfig(ALGORITHM, seed=3)
    assert Settings().applied(config, SCENE) == config


def test_choices_are_applied():
    settings = Settings(seed=5)
    settings.choose("paper", "tgpo")
    config = settings.applied(TrainingConfig(ALGORITHM), SCENE)
    assert config.seed == 5
    assert (config.algorithm.mode.name, config.method) == ("paper", "tgpo")
    assert config.algorithm == make_algorithm("paper", "tgpo", Linear())


def test_values_that_no_control_sends_change_nothing():
    settings = Settings()
    settings.choose("evil", "tgpo")
    settings.set_seed(math.nan)
    assert settings == Settings()


@pytest.mark.parametrize(("given", "taken"), [(-4, 0), (1e99, LARGEST_SEED), (7.9, 7)])
def test_seeds_are_brought_into_range(given, taken):
    settings = Settings()
    settings.set_seed(given)
    assert settings.seed == taken


def test_longer_is_past_the_target():
    config = TrainingConfig(ALGORITHM, time_limit=60)
    longer = prolonged(config, 12.0, 60.0)
    assert (longer.time_limit, longer.target) == (72.0, 2.0)
    assert longer.epochs > config.epochs
