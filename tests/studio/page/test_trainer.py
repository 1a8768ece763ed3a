import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from core.errors import UserError
from core.methods.tgpo.algorithm import Algorithm
from core.methods.training import TrainingConfig
from studio.page import trainer as module
from studio.page.trainer import Phase, Trainer
from tests.studio.waiting import wait_for

CONFIG = TrainingConfig(Algorithm())
TASK = cast(Any, "task")


def progress(epoch, success=None, best="best"):
    evaluation = None if success is None else SimpleNamespace(success_rate=success)
    state = SimpleNamespace(
        best=best,
        best_success=-1.0 if success is None else success,
    )
    state._replace = lambda **_: SimpleNamespace(epoch=epoch, seconds=0.5 * epoch)
    return SimpleNamespace(
        epoch=epoch,
        env_steps=1000 * epoch,
        train_seconds=0.5 * epoch,
        batch_success=0.1 * epoch,
        batch_return=0.0,
        diverged=0,
        evaluation=evaluation,
        weights=f"weights{epoch}",
        schedules=f"chains{epoch}",
        state=state,
    )


class ScriptedTrainer(Trainer):
    """A trainer that goes through `script`, a step for each release of `gate`."""

    def __init__(self):
        self.gate = threading.Semaphore(0)
        self.script: list = []
        super().__init__()


@pytest.fixture
def trainer(monkeypatch):
    trainer = ScriptedTrainer()

    def train(task, config, state=None):
        for step in trainer.script:
            trainer.gate.acquire()
            if isinstance(step, Exception):
                raise step
            yield step

    monkeypatch.setattr(module, "train", train)
    yield trainer
    for _ in range(100):
        trainer.gate.release()
    trainer.close()


def test_every_epoch_is_published(trainer):
    trainer.script = [progress(1), progress(2, 0.75)]
    trainer.start(TASK, CONFIG)
    assert trainer.snapshot.phase is Phase.COMPILING
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.epoch == 1)
    first = trainer.snapshot
    assert (first.phase, first.weights, first.success) == (Phase.TRAINING, "weights1", None)
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert trainer.snapshot.success == 0.75
    assert [point.epoch for point in trainer.snapshot.curve] == [1, 2]
    assert first.epoch == 1, "a snapshot never changes"


def test_the_best_weights_stay_at_the_end(trainer):
    trainer.script = [progress(1, 0.5, best="weights1"), progress(2, 0.2, best="weights1")]
    trainer.start(TASK, CONFIG)
    trainer.gate.release(2)
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert trainer.snapshot.weights == "weights1"


def test_without_an_evaluation_the_last_weights_stay(trainer):
    trainer.script = [progress(1), progress(2)]
    trainer.start(TASK, CONFIG)
    trainer.gate.release(2)
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert trainer.snapshot.weights == "weights2"


def test_stop_ends_after_the_epoch(trainer):
    trainer.script = [progress(1), progress(2), progress(3)]
    trainer.start(TASK, CONFIG)
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.epoch == 1)
    trainer.stop()
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.STOPPED)
    assert trainer.snapshot.epoch == 2
    assert not trainer.snapshot.running


@pytest.mark.parametrize(
    ("error", "text"),
    [(UserError("say so"), "say so"), (RuntimeError("out of memory"), "RuntimeError: out of")],
)
def test_an_error_is_shown_and_the_next_training_runs(trainer, error, text, capsys):
    trainer.script = [error]
    trainer.start(TASK, CONFIG)
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.FAILED)
    assert trainer.snapshot.error.startswith(text)
    trainer.script = [progress(1)]
    trainer.start(TASK, CONFIG)
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert trainer.snapshot.error == ""


def test_a_new_training_replaces_the_old(trainer):
    trainer.script = [progress(7)]
    trainer.start(TASK, CONFIG)
    trainer.script = [progress(1)]
    trainer.start(cast(Any, "other"), CONFIG)
    trainer.gate.release(2)
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert (trainer.snapshot.task, trainer.snapshot.epoch) == ("other", 1)


def test_what_is_forgotten_does_not_come_back(trainer):
    trainer.script = [progress(1)]
    trainer.start(TASK, CONFIG)
    trainer.forget()
    trainer.gate.release()
    trainer.close()
    assert trainer.snapshot.phase is Phase.IDLE


def test_a_pause_halts_after_the_epoch_and_goes_on_from_its_state(trainer, monkeypatch):
    trainer.script = [progress(1), progress(2), progress(3)]
    trainer.start(TASK, CONFIG)
    trainer.pause()
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.PAUSED)
    halted = trainer.snapshot
    assert (halted.epoch, halted.busy, halted.running) == (1, True, False)
    resumed = []

    def train(task, config, state=None):
        resumed.append(state)
        yield progress(2)

    monkeypatch.setattr(module, "train", train)
    trainer.proceed()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert resumed[0].epoch == 1
    assert [point.epoch for point in trainer.snapshot.curve] == [1, 2]


def test_a_halted_training_can_be_stopped(trainer):
    trainer.script = [progress(1, 0.5)]
    trainer.start(TASK, CONFIG)
    trainer.pause()
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.PAUSED)
    trainer.stop()
    assert trainer.snapshot.phase is Phase.STOPPED
    assert trainer.snapshot.weights == "best"


def test_there_must_be_something_to_go_on_with(trainer):
    with pytest.raises(UserError, match="no training"):
        trainer.proceed()


def test_loaded_weights_take_the_place_of_a_training(trainer):
    trainer.adopt(TASK, CONFIG, cast(Any, "weights"), epoch=9, success=0.99, origin="a file")
    snapshot = trainer.snapshot
    assert (snapshot.phase, snapshot.weights) == (Phase.LOADED, "weights")
    assert (snapshot.epoch, snapshot.success, snapshot.origin) == (9, 0.99, "a file")


def test_stop_after_pause_stops(trainer):
    trainer.script = [progress(1), progress(2, 0.5), progress(3)]
    trainer.start(TASK, CONFIG)
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.epoch == 1)
    trainer.pause()
    trainer.stop()
    trainer.gate.release()
    assert wait_for(lambda: not trainer.snapshot.running)
    assert trainer.snapshot.phase is Phase.STOPPED
    assert trainer.snapshot.weights == "best"


def test_stop_at_the_moment_of_pausing_is_not_lost(trainer, monkeypatch):
    pressed = []

    def replaced(snapshot, **changes):
        if changes.get("phase") is Phase.PAUSED and not pressed:
            pressed.append(threading.Thread(target=trainer.stop))
            pressed[0].start()
            pressed[0].join(0.3)  # time enough to come in between, were it not kept out
        return replace(snapshot, **changes)

    monkeypatch.setattr(module, "replace", replaced)
    trainer.script = [progress(1, 0.5), progress(2)]
    trainer.start(TASK, CONFIG)
    trainer.pause()
    trainer.gate.release()
    assert wait_for(lambda: bool(pressed) and not pressed[0].is_alive())
    assert wait_for(lambda: trainer.snapshot.phase is Phase.STOPPED)
    assert trainer.snapshot.weights == "best"


@pytest.mark.parametrize(("success", "told"), [(0.0, "B fails"), (0.2, ""), (None, "")])
def test_a_training_that_never_succeeds_tells_what_stands_in_the_way(
    trainer, monkeypatch, success, told
):
    learner = SimpleNamespace(evaluation_states=8)
    monkeypatch.setattr(TrainingConfig, "learner", lambda *_: learner)
    monkeypatch.setattr(module, "what_fails", lambda *_, count: "B fails" if count == 8 else "")
    trainer.script = [progress(1, success)]
    trainer.start(TASK, CONFIG)
    trainer.gate.release()
    assert wait_for(lambda: trainer.snapshot.phase is Phase.DONE)
    assert trainer.snapshot.obstacle == told
