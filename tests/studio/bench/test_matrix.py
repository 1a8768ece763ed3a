"""Files of benchmarks: what they expand to, and what is wrong with them."""

import msgspec
import pytest

from core.errors import UserError
from core.methods import METHODS
from core.stl import horizon, parse
from scenes import load_task, scene_formula, task_names
from studio.bench.horizons import stretched, with_horizon
from studio.bench.matrix import Job, load_matrix, on_processor, parse_matrix
from studio.bench.others import OTHERS
from studio.bench.shipped import shipped_matrices
from studio.bench.worker import configuration
from tests.studio.bench.tiny import TINY, job


def parsed(runs: str, variants: str = ""):
    return parse_matrix(f'format = 1\ntitle = "t"\n{variants}\n[[runs]]\n{runs}\n', "m.toml").jobs


def test_a_product_is_expanded_once():
    jobs = parsed('tasks = ["linear", "linear-01"]\nmethods = ["all", "tgpo"]\nseeds = [1, 2, 2]')
    assert len(jobs) == 10 * len(METHODS) * 2
    assert {one.task for one in jobs} == set(task_names("linear"))
    assert [one.seed for one in jobs] == sorted(one.seed for one in jobs)
    assert len({one.key for one in jobs}) == len(jobs)


def test_equal_jobs_have_equal_keys_and_others_others():
    assert job().key == job().key == msgspec.json.decode(msgspec.json.encode(job()), type=Job).key
    different = [
        job(),
        job(seed=2),
        job(epochs=3),
        job(horizon=50),
        job(changes={"prune": False}),
        job(changes={"prune": True}),
        job(weights="shipped"),
    ]
    assert len({one.key for one in different}) == len(different)


@pytest.mark.parametrize("name", shipped_matrices())
def test_shipped_files_can_be_read(name):
    matrix = load_matrix(name)
    assert matrix.title and matrix.jobs
    for one in (matrix.jobs[0], matrix.jobs[-1]):
        assert one.method in OTHERS or configuration(one)


def test_the_smoke_file_has_every_method():
    assert {one.method for one in load_matrix("smoke").jobs} == set(METHODS)


def test_budgets_can_be_taken_in_seconds_of_the_processor():
    taken = on_processor(job(seconds=30.0))
    assert (taken.seconds, taken.cpu_seconds) == (None, 30.0) and taken.key != job().key
    for same in (job(), job(cpu_seconds=4.0), job(method="exact", seconds=9.0)):
        assert on_processor(same) is same
    assert on_processor(job(method="sb3-ppo", seconds=9.0)).cpu_seconds == 9.0


def test_a_job_without_newer_fields_keeps_its_key():
    text = msgspec.json.encode(job()).decode()
    assert "cpu_seconds" not in text and "critic_samples" not in text
    assert configuration(job()).training.seed == 1


def test_a_variant_changes_hyper_parameters():
    (tiny, _) = parse_matrix(TINY, "tiny").jobs
    training = configuration(tiny).training
    assert (training.algorithm.environments, training.algorithm.hidden) == (16, (16,))
    assert (training.epochs, training.evaluate_every, training.seed) == (2, 1, 1)
    shaped = configuration(job(changes={"mode": {"shape": 0.0}})).training.algorithm
    assert shaped.mode.shape == 0 and shaped.mode.progress == 20
    shipped = configuration(job(weights="shipped"))
    assert shipped.weights == "shipped" and shipped.training.warm


@pytest.mark.parametrize(
    ("runs", "message"),
    [
        ('tasks = ["linaer"]\nseeds = [1]', r"runs\[0\].tasks: unknown 'linaer'. Allowed: linear"),
        ('tasks = ["linear"]\nseeds = []', r"runs\[0\].seeds: \[\] must be a list"),
        ('tasks = ["linear"]', r"runs\[0\].seeds: this field is missing"),
        ('tasks = ["linear"]\nseeds = [-1]', r"runs\[0\].seeds\[0\]: -1 must be an integer from 0"),
        ('tasks = ["linear"]\nseeds = [1]\nmethods = ["ppo"]', "methods: unknown 'ppo'. Allowed"),
        ('tasks = ["linear"]\nseeds = [1]\nmodes = ["fast"]', "'fast' must be 'paper' or 'studio'"),
        (
            'tasks = ["linear"]\nseeds = [1]\nepoch = 3',
            r"runs\[0\].epoch: unknown. Allowed: epochs",
        ),
        ('tasks = ["linear"]\nseeds = [1]\nvariants = ["x"]', "variants: unknown 'x'"),
    ],
)
def test_what_is_wrong_is_said(runs, message):
    with pytest.raises(UserError, match=f"^m.toml: .*{message}"):
        parsed(runs)


@pytest.mark.parametrize(
    ("variant", "message"),
    [("prunes = true", "prunes: unknown"), ("discount = 2.0", "discount: 2.0 must be a number")],
)
def test_a_wrong_hyper_parameter_is_found_before_anything_runs(variant, message):
    with pytest.raises(UserError, match=f"variants.x: .*{message}"):
        parsed('tasks = ["linear"]\nseeds = [1]\nvariants = ["x"]', f"[variants.x]\n{variant}")


def test_a_file_that_is_none(tmp_path):
    with pytest.raises(UserError, match="matrix: unknown 'smok'. Allowed: smoke"):
        load_matrix("smok")
    with pytest.raises(UserError, match="cannot be read"):
        load_matrix(str(tmp_path / "no.toml"))
    with pytest.raises(UserError, match="not valid TOML"):
        parse_matrix("[[", "m.toml")
    with pytest.raises(UserError, match="format: 2 is not known"):
        parse_matrix(TINY.replace("format = 1", "format = 2"), "m.toml")


def test_formulas_are_stretched():
    formula = parse("F_[10:20](A & G_[0:5](!B)) & (A)U_[0:100](B)")
    assert stretched(formula, 50, 100) == parse("F_[5:10](A & G_[0:2](!B)) & (A)U_[0:50](B)")
    assert stretched(formula, 1000, 100) == parse(
        "F_[100:200](A & G_[0:50](!B)) & (A)U_[0:1000](B)"
    )
    scene = load_task("linear-05")
    longer = with_horizon(scene, 300)
    assert longer.horizon == 300 and longer.regions == scene.regions
    assert horizon(scene_formula(longer)) == 3 * horizon(scene_formula(scene))
    assert with_horizon(scene, None) is scene
