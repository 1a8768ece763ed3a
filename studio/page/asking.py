"""What a controller answers: a plan, the rollout of a schedule, rollouts from random starts."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.answer import Effort, Plan, answer, answer_jobs
from core.attempts import tries
from core.candidates import choose_schedules
from core.compilation import compile_together
from core.replanning import Past, replan, replan_jobs
from core.rollout import roll_out, start_states
from studio.page.picture import padded, repeated
from studio.page.subject import Subject
from studio.runs.recording import Recording, record
from studio.runs.tasks import initial_state

SAMPLE = 20
"""Random starts that are shown as a sample."""


class Move(NamedTuple):
    """The robot of a rollout, put somewhere else."""

    recording: Recording
    step: int
    """The first step at which it stands there."""
    state: np.ndarray  # [n] in which it stands there


class Moved(NamedTuple):
    """What was found out after a move."""

    step: int
    falsified: int | None
    """The step by which the formula was false, whatever follows; None: not proved."""
    seconds: float


class Answer(NamedTuple):
    """Rollouts, and whom they were asked of."""

    subject: Subject
    recordings: tuple[Recording, ...]
    alternatives: tuple[Recording, ...] = ()
    """Plans that visit the goals in another order, or by another branch."""
    seconds: float | None = None
    """Time that the search for the plan took; None for a schedule that was given."""
    asked: bool = True
    """Whether somebody pressed a button for it."""
    moved: Moved | None = None
    """Set where a rollout goes on after the robot was moved."""


def planned(
    subject: Subject,
    start: tuple[float, ...] | None,
    asked: bool,
    interrupted: Callable[[], bool],
) -> Answer:
    """The best plan from the start that a bounded search finds, and plans of other kinds.

    A policy that was trained on the scene shows what it can do by itself: its actions are not
    nudged.
    """
    task, controller = subject.task, subject.controller
    compile_together(*answer_jobs(task, controller))  # so that the time told is the answer's
    effort = Effort(nudging=subject.general, interrupted=interrupted)
    found = answer(task, controller, initial_state(task, start), effort=effort)
    recordings = [_recorded(subject, plan) for plan in (found.plan, *found.alternatives)]
    return Answer(subject, (recordings[0],), tuple(recordings[1:]), found.seconds, asked)


def moved_on(subject: Subject, move: Move) -> Answer:
    """The rollout of a move, planned anew from where the robot stands."""
    task, controller, before, step = subject.task, subject.controller, move.recording, move.step
    compile_together(*replan_jobs(task, controller))
    states = np.concatenate([before.states[:step], move.state[None]])
    past = Past(states, before.actions[:step])
    effort = Effort(nudging=subject.general)
    found = replan(task, controller, past, before.schedule, effort=effort)
    moves = (*(each for each in before.moves if each < step), step)
    recording = _recorded(subject, found.plan, moves)
    told = Moved(step, found.falsified, found.seconds)
    return Answer(subject, (recording,), moved=told)


def rolled_out(
    subject: Subject, start: tuple[float, ...] | None, schedule: tuple[int, ...]
) -> Recording:
    """The rollout of a schedule from the start."""
    task = subject.task
    count = tries(task)
    rollout = roll_out(
        task,
        subject.controller,
        repeated(initial_state(task, start), count),
        repeated(jnp.asarray(padded(task, schedule)), count),
    )
    return record(task, _times(subject, schedule), *(np.asarray(trace)[:, 0] for trace in rollout))


def random_starts(subject: Subject, seed: int) -> tuple[Recording, ...]:
    """Rollouts from random initial states, each with the schedule that the critic chooses."""
    task, controller, count = subject.task, subject.controller, tries(subject.task)
    found: list[Recording] = []
    key = jax.random.key(seed)
    while len(found) < SAMPLE:
        initial_key, choice_key = jax.random.split(jax.random.fold_in(key, len(found)))
        states = start_states(task.problem, initial_key, count=count)
        schedules, _ = choose_schedules(task.problem, controller, choice_key, states)
        traces = [np.asarray(field) for field in roll_out(task, controller, states, schedules)]
        found += [
            record(task, _times(subject, schedule), *(trace[:, index] for trace in traces))
            for index, schedule in enumerate(np.asarray(schedules))
        ]
    return tuple(found[:SAMPLE])


def _recorded(subject: Subject, plan: Plan, moves: tuple[int, ...] = ()) -> Recording:
    return record(
        subject.task,
        _times(subject, plan.schedule),
        plan.states,
        plan.actions,
        plan.margins,
        moves=moves,
        nudged=plan.nudged,
    )


def _times(subject: Subject, schedule: Any) -> Any | None:
    """The schedule that was carried out; None where the controller ignored it."""
    return None if subject.controller.search is None else schedule
