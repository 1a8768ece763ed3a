"""Edited scenes judged without waiting for the fields."""

import threading
from dataclasses import replace

import pytest

import studio.page.editing.judge as module
from core.errors import UserError
from scenes import load_task
from studio.page.editing.judge import Judge
from studio.page.editing.specification import edited, specify, with_text
from tests.studio.waiting import wait_for

SCENE = load_task("linear-08")
LATER, LATEST = with_text(SCENE, "F_[0:90](A2)"), with_text(SCENE, "F_[0:80](A1)")


class Fields:
    """Builds of tasks that wait for `go`."""

    def __init__(self):
        self.go, self.asked, self.error = threading.Event(), [], None

    def __call__(self, specification, scene):
        self.asked.append(scene)
        self.go.wait(20)
        if self.error is not None:
            raise self.error
        return edited(specification, scene)


@pytest.fixture
def fields(monkeypatch):
    fields = Fields()
    monkeypatch.setattr(module, "edited", fields)
    yield fields
    fields.go.set()


@pytest.fixture
def judge(fields):
    judge = Judge(specify(SCENE))
    yield judge
    fields.go.set()
    assert judge.close()


def built(judge):
    judge.collect()
    return not judge.building


def test_the_old_task_stays_until_the_new_one_is_there(judge, fields):
    task = judge.specification.task
    judge.take(LATER)
    assert judge.building
    judge.collect()
    assert (judge.specification.scene, judge.specification.task) == (LATER, task)
    fields.go.set()
    assert wait_for(lambda: built(judge))
    assert str(judge.specification.decomposition) == str(specify(LATER).decomposition)


def test_the_latest_scene_counts(judge, fields):
    judge.take(LATER)
    assert wait_for(lambda: fields.asked == [LATER])
    judge.take(SCENE)
    judge.take(LATEST)
    fields.go.set()
    judge.finish()
    assert fields.asked == [LATER, LATEST]
    assert str(judge.specification.decomposition) == str(specify(LATEST).decomposition)


def test_going_back_needs_no_new_task(judge, fields):
    task = judge.specification.task
    judge.take(LATER)
    judge.take(SCENE)
    assert not judge.building
    fields.go.set()
    judge.collect()
    assert (judge.specification.scene, judge.specification.task) == (SCENE, task)


def test_an_error_in_the_formula_is_there_at_once(judge, fields):
    task = judge.specification.task
    judge.take(LATER)
    judge.take(with_text(SCENE, "F_[0:90](A7)"))
    assert not judge.building
    assert "A7" in judge.specification.error
    assert judge.specification.task is task


def test_an_error_in_the_fields_comes_with_them(judge, fields):
    fields.error = UserError("no position is in A1")
    task = judge.specification.task
    judge.take(LATER)
    assert judge.specification.error == ""
    fields.go.set()
    judge.finish()
    assert "no position is in A1" in judge.specification.error
    assert judge.specification.task is task


def test_a_change_of_looks_alone_builds_nothing(judge, fields):
    judge.take(replace(SCENE, title="Other"))
    assert not judge.building
    assert judge.specification.scene.title == "Other"
    assert fields.asked == []


def test_what_is_impossible_is_said_at_once(judge, fields):
    task = judge.specification.task
    judge.take(with_text(SCENE, "F_[0:3](A1)"))
    assert not judge.building
    assert judge.specification.error.startswith("impossible: the start to A1 is at least")
    assert judge.specification.task is task
    assert fields.asked == []


def test_warnings_are_there_at_once_and_stay(judge, fields):
    scene = with_text(SCENE, "F_[0:90](A1) & (!A2) U_[0:80] A2")
    judge.take(scene)
    (finding,) = judge.specification.findings
    assert judge.building and "only a boundary allows" in finding.words
    fields.go.set()
    judge.finish()
    assert judge.specification.findings == (finding,)
    assert judge.specification.task.findings == (finding,)
