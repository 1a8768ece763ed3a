"""Obstacles that are thinner than a step is long: warned of, and never passed unseen."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from core.evaluation import verdicts
from core.task.problem import trace_margins
from envs import ENVS
from scenes import Region, Scene, format_scene, load_task, parse_scene
from studio.runs.findings import findings_of
from studio.runs.recording import record
from studio.runs.tasks import build_task

HALF, THIN = 1.5, 0.035
WALLS = (
    Region("left", "rectangle", (-HALF, 0.0), (THIN, HALF)),
    Region("right", "rectangle", (HALF, 0.0), (THIN, HALF)),
    Region("below", "rectangle", (0.0, -HALF), (HALF, THIN)),
    Region("above", "rectangle", (0.0, HALF), (HALF, THIN)),
)
GOAL = Region("A", "circle", (0.0, 3.0), (0.6,))


def closed_room(*, between_steps: bool) -> Scene:
    """The robot starts in a room without a door; the goal lies outside."""
    formula = "F_[0:20](A) & " + " & ".join(f"G_[0:20](!{wall.name})" for wall in WALLS)
    initial = Region("initial", "circle", (0.0, 0.0), (0.3,))
    return replace(
        load_task("linear-01"),
        regions=(GOAL, *WALLS),
        initial=initial,
        formula=formula,
        horizon=20,
        between_steps=between_steps,
    )


@pytest.fixture(scope="module")
def tasks():
    return {asked: build_task(closed_room(between_steps=asked)) for asked in (False, True)}


def escapes() -> np.ndarray:
    """Ways [L + 1, R, 2] up and out at 0.4 m a step, each jumping over the wall above."""
    random = np.random.default_rng(0)
    start = np.stack([random.uniform(-0.2, 0.2, 200), random.uniform(-0.2, 0.2, 200)], 1)
    steps = np.minimum(np.arange(33), 8)[:, None, None] * np.array([0.0, 0.38])
    return (start + steps).astype(np.float32)


def test_a_closed_wall_is_never_called_satisfied_between_the_steps(tasks):
    states = escapes()
    margins = np.asarray(trace_margins(tasks[False].problem, jnp.asarray(states)))
    without = verdicts(tasks[False], states, margins) >= 0
    assert 0.5 < without.mean() < 1.0
    assert not (verdicts(tasks[True], states, margins) >= 0).any()


def test_a_recording_says_where_it_went_through(tasks):
    states = escapes()
    margins = np.asarray(trace_margins(tasks[False].problem, jnp.asarray(states)))
    row = int((verdicts(tasks[False], states, margins) >= 0).argmax())
    actions = np.zeros((len(states) - 1, 2), np.float32)
    for asked, task in tasks.items():
        found = record(task, (8,), states[:, row], actions, margins[:, row])
        assert found.satisfied != asked and not found.between.holds
        assert found.between.position[1] == pytest.approx(HALF, abs=0.01)
        assert found.between.margin == pytest.approx(-THIN, abs=1e-3)
        assert ("cuts above by 0.035 m" in found.diagnosis.sentence) == asked


def test_thin_walls_are_warned_of_unless_they_are_looked_at():
    (finding,) = findings_of(closed_room(between_steps=False))
    assert not finding.proved and finding.tasks == ("!left", "!right", "!below", "!above")
    assert str(finding).startswith(
        "warning: left, right, below, above are 0.07 m thick, but the robot moves about 0.40 m a "
        "step: it may go through between two steps"
    )
    assert findings_of(closed_room(between_steps=True)) == ()


@pytest.mark.parametrize(("size", "warned"), [((0.19, 3.0), True), ((0.21, 3.0), False)])
def test_what_counts_as_thin(size, warned):
    """Linear moves 0.4 m a step."""
    wall = Region("left", "rectangle", (-HALF, 0.0), size)
    room = closed_room(between_steps=False)
    room = replace(room, regions=(GOAL, wall), formula="F_[0:20](A) & G_[0:20](!left)")
    assert bool(findings_of(room)) == warned
    assert findings_of(replace(room, formula="F_[0:20](A) & !left")) == ()  # at one step only


@pytest.mark.parametrize("robot", ENVS)
def test_the_option_is_written_only_where_it_is_set(robot):
    demo = load_task(f"{robot}-demo")
    assert "between_steps" not in format_scene(demo)
    asked = replace(demo, between_steps=True)
    assert parse_scene(format_scene(asked), "text") == asked
