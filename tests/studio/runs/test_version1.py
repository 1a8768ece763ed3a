"""Files of version 1 open in every later program.

`version1/` was written by commit 077690f: a run of linear that was interrupted after two epochs,
with its bundle, a configuration in paper mode, and a project. The bundle's programs
are left out: loading asks for them but does not read them.
"""

import shutil
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import pytest

from core.mdp.paper_mode import PaperMode
from scenes import Region, format_scene, load_scene, load_task
from studio.runs.bundle import PROGRAMS, bundle_folder, load_bundle
from studio.runs.config import make_config, read_config
from studio.runs.run import Run

WRITTEN = Path(__file__).parent / "version1"


@pytest.fixture
def run_folder(tmp_path) -> Path:
    """A copy of the run, with every file that its bundle must have."""
    folder = tmp_path / "run"
    shutil.copytree(WRITTEN / "run", folder)
    for name in PROGRAMS:
        (folder / "bundle" / name).touch()
    return folder


def test_the_configuration_is_read(run_folder):
    config = read_config(run_folder)
    training, algorithm = config.training, config.training.algorithm
    assert (config.mode, config.method) == ("studio", "tgpo-star")
    assert (config.scene.name, config.scene.formula) == ("north", "F_[0:9](A1)")
    assert (training.seed, training.epochs, training.time_limit) == (3, 4, 60.0)
    assert (training.target, training.evaluate_every) == (2.0, 2)
    assert (algorithm.environments, algorithm.hidden) == (4, (2,))
    assert algorithm.mcmc_strides == (1, 2, 4, 8) and algorithm.learning_rate == 2e-3
    assert algorithm.mode.violation == -3.0 and algorithm.mode.exploring == 0.5


def test_the_run_goes_on(run_folder):
    with Run.resume(run_folder) as run:
        assert run.epochs == 2 and run.notes == ()
    assert len((run_folder / "metrics.jsonl").read_text().splitlines()) == 2


def test_the_bundle_is_read(run_folder):
    policy = load_bundle(bundle_folder(run_folder))
    assert (policy.mode, policy.method, policy.seed, policy.epochs) == ("studio", "tgpo-star", 3, 2)
    assert policy.success_rate == 0.0 and policy.robustness_mean == -5.1473388671875
    assert policy.algorithm == read_config(run_folder).training.algorithm
    leaves = jax.tree.leaves(policy.weights)
    assert all(np.isfinite(leaf).all() for leaf in leaves) and np.std(leaves[0]) > 0


def test_a_configuration_in_paper_mode_is_read(tmp_path):
    shutil.copy(WRITTEN / "paper.json", tmp_path / "config.json")
    config = read_config(tmp_path)
    assert isinstance(config.training.algorithm.mode, PaperMode)
    assert config.training.time_limit == np.inf, "null stands for no limit"
    today = make_config(load_task("unicycle-08"), mode="paper", method="tgpo", seed=5)
    preset = today.training.algorithm  # has had other minibatches, and a unit of rewards, since
    algorithm = replace(preset, minibatches=8, mode=replace(preset.mode, scale=1.0))
    assert config == replace(today, training=replace(today.training, algorithm=algorithm))


def test_the_project_is_read_and_written_as_it_was():
    scene = load_scene(WRITTEN / "project.stl.toml")
    assert (scene.robot, scene.variant, scene.title) == ("panda", "links", 'A "quoted" title')
    assert scene.formula == 'F_[0:20](A) &\n  G_[0:30](!"wall 1")'
    assert scene.region_names == ("A", "wall 1", "post")
    assert scene.regions[2] == Region("post", "cylinder", (0.3, -0.4, 0.2), (0.05, 0.2))
    assert format_scene(scene) == (WRITTEN / "project.stl.toml").read_text(encoding="utf-8")
