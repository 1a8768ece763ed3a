"""Other libraries: what they are told, that they agree, and that learners are judged alike."""

import jax
import numpy as np
import pytest

from core.errors import UserError
from core.rollout import start_states
from core.stl import parse
from scenes import load_task
from studio.bench.matrix import parse_matrix
from studio.bench.others import OTHERS, measured
from studio.bench.peers import learners, robustness
from studio.bench.peers.learners import attempted
from studio.bench.peers.libraries import library
from studio.bench.peers.robustness import compare
from studio.bench.peers.translation import rtamt_text, sentil_text
from studio.bench.report.peers import peers
from studio.runs.tasks import build_task
from tests.studio.bench.tiny import job

SMALL = {"F and G": "F_[0:4](A | B) & G_[2:6](!B -> C)", "until": "(A)U_[0:8](B)"}


def test_formulas_are_translated():
    formula = parse("F_[1:2](A) & (B)U_[0:3](!C)", names=("A", "B", "C"))
    left = "((eventually[1,2] (margin_A >= 0)) and "
    right = "((margin_B >= 0) until[0,3] ((not (margin_C >= 0)) and (margin_B >= 0))))"
    assert rtamt_text(formula) == left + right
    assert sentil_text(formula) == rtamt_text(formula).replace(",", ", ")


@pytest.mark.parametrize("name", robustness.RIVALS)
def test_they_agree_with_ours(monkeypatch, name):
    pytest.importorskip(name, reason=f"{name} is not installed")
    monkeypatch.setattr(robustness, "CASES", SMALL)
    monkeypatch.setattr(robustness, "TRACES", 6)
    monkeypatch.setattr(robustness, "SAMPLES", 12)
    monkeypatch.setattr(robustness, "REPEATS", 1)
    rows = compare(name)
    assert [row["case"] for row in rows] == list(SMALL)
    for row in rows:
        assert row["difference"] < 1e-6
        assert min(row["seconds"], row["own_seconds"], row["first_seconds"]) > 0


def test_a_library_that_is_not_there_is_named():
    with pytest.raises(SystemExit, match=r"nowhere cannot be imported .*tgpo-studio\[peers\]"):
        library("nowhere.at_all")


def test_learners_are_judged_as_the_environment_pays(monkeypatch, disk_cache):
    environment = pytest.importorskip("studio.gym.environment", reason="needs the extra `gym`")
    monkeypatch.setattr(learners, "EVALUATION_STATES", 4)
    monkeypatch.setattr(learners, "ATTEMPTS", 2)
    scene = load_task("linear-01")
    task, key = build_task(scene), jax.random.key(3)
    seen = []

    def act(observations, deterministic):
        seen.append((observations, deterministic))
        return np.tile(np.array([0.3, 0.1] if deterministic else [-1.0, -1.0], np.float32), (4, 1))

    found = attempted(task, act, len(scene.regions), key)
    assert [one[1] for one in seen] == [True] * task.horizon + [False] * task.horizon
    starts = np.asarray(start_states(task.problem, key, count=4))
    env = environment.StlEnv("linear-01")
    for start, best in zip(starts[:2], found[:2], strict=True):
        paid = []
        for action in ([0.3, 0.1], [-1.0, -1.0]):
            first, _ = env.reset(options={"position": tuple(start[:2].tolist())})
            ended, reward = False, 0.0
            while not ended:
                _, reward, ended, _, _ = env.step(np.array(action, np.float32))
            paid.append(reward)
        assert best == pytest.approx(max(paid), abs=1e-5)
    np.testing.assert_allclose(seen[0][0][1], first, atol=1e-5)


@pytest.mark.parametrize("name", learners.LIBRARIES)
def test_a_learner_of_another_library_is_measured(monkeypatch, name, disk_cache):
    pytest.importorskip(learners.LIBRARIES[name], reason="needs the extra `peers`")
    pytest.importorskip("stable_baselines3", reason="needs the extra `peers`")
    monkeypatch.setattr(learners, "ATTEMPTS", 1)
    row = measured(job(method=name, seconds=1.0))
    assert row["stopped"] == "seconds" and row["train_seconds"] >= 1 and row["env_steps"] > 0
    assert 0 <= row["success_rate"] <= 1 and len(row["curve"]) == 1


def test_what_they_cannot_do_is_refused():
    with pytest.raises(UserError, match="neither variants nor weights"):
        measured(job(method="exact", weights="shipped"))
    with pytest.raises(UserError, match="needs seconds or cpu_seconds"):
        measured(job(method="sb3-ppo"))
    text = (
        'format = 1\ntitle = "t"\n[variants.v]\nx = 1\n'
        '[[runs]]\ntasks = ["linear"]\nvariants = ["v"]\nmethods = ["exact"]\nseeds = [1]'
    )
    with pytest.raises(UserError, match="exact has no hyper-parameters here"):
        parse_matrix(text, "m.toml")
    assert set(OTHERS) >= {"exact", "rtamt", "sbx-ppo"}


def test_the_page_has_their_times_and_factors():
    class Page:
        rows: list = []

        def heading(self, text):
            del text

        text = heading

        def table(self, key, head, rows):
            del key, head
            self.rows = rows

    case = {"case": "until", "formula": "f", "seconds": 0.4, "own_seconds": 0.01}
    case |= {"first_seconds": 2.0, "own_first_seconds": 0.5, "difference": 1e-7}
    page = Page()
    peers(page, [{"method": "rtamt", "cases": [case]}, {"method": "tgpo", "cases": None}])  # pyright: ignore[reportArgumentType]
    (line,) = page.rows
    assert line[2:8] == (400.0, 10.0, pytest.approx(40), 2000.0, 500.0, pytest.approx(4))
