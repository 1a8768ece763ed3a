"""Questions to the networks while they learn: the heatmap, and rollouts of chosen schedules.

One thread, apart from the training's. It answers with the latest weights; a rollout goes before
the next heatmap. All that it shares is replaced as a whole, never changed.
"""

import threading
import time
import traceback
from dataclasses import dataclass, replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.algorithm import Algorithm
from core.errors import UserError
from core.grounding import MAX_VARIABLES
from core.heatmap import ALTERNATIVES, Heatmap, best_schedule, heatmap, random_schedules
from core.networks import Parameters
from core.programs import EvaluationPrograms, evaluation_programs
from core.protocols import Array
from core.task import Task
from studio.playing.recording import Recording, record
from studio.worker import Training

ROLLOUTS = 20
"""Rollouts of the only compiled program: a click needs one, a sample of random starts all."""

PERIOD = 0.7
"""Least time between the starts of two heatmaps [s]."""


class Subject(NamedTuple):
    """Whom is asked: the weights after an epoch of training on a task."""

    task: Task
    algorithm: Algorithm
    epoch: int
    parameters: Parameters
    chains: Array | None = None


@dataclass(frozen=True)
class MapView:
    """What a heatmap shows of a space of more than two variables."""

    axes: tuple[int, ...] | None = None
    """Variables on the axes; None for the first that matter."""
    fixed: tuple[tuple[int, int], ...] = ()
    """(variable, value) set by hand; the critic chooses the others."""
    best: bool = False
    """Whether each cell has the best of the times that are neither fixed nor on the axes."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A heatmap and the schedule that the critic prefers."""

    subject: Subject
    heatmap: Heatmap
    choice: tuple[int, ...]


@dataclass(frozen=True)
class _Request:
    """A schedule to roll out, None for the critic's choice; or a sample of random starts."""

    schedule: tuple[int, ...] | None = None
    sample: bool = False


class Analyst:
    """Read `picture`, `recording` and `error`; ask with `ask`."""

    def __init__(self) -> None:
        self.picture: Picture | None = None
        self.recording: Recording | None = None
        self.error = ""
        self.stale = ""
        """Why the weights do not answer for the scene shown, empty if they do."""
        self.watched = True
        """Whether anybody sees the heatmap; nobody's is not drawn."""
        self.view = MapView()
        self.sample: tuple[Recording, ...] = ()
        """Rollouts from random starts; whoever takes them puts an empty tuple in their place."""
        self.start: tuple[float, ...] | None = None
        """Position at which rollouts start [d] in [m]; None for the centre of the initial set."""
        self._samples = 0
        self._subject: Subject | None = None
        self._request: _Request | None = None
        self._closed = False
        self._wake = threading.Event()
        self._thread = threading.Thread(target=self._work, name="analyst", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether a rollout was asked for and is not there yet."""
        return self._request is not None

    def observe(self, training: Training) -> None:
        """Ask the weights of this training from now on, once it has any."""
        task, config, parameters = training.task, training.config, training.parameters
        if task is None or config is None or parameters is None:
            return
        known = self._subject
        if known is not None and known.parameters is parameters:
            return
        if known is None or known.task is not task:
            self.view = MapView()
        self._subject = Subject(task, config.algorithm, training.epoch, parameters, training.chains)
        self._wake.set()

    def choose_view(self, view: MapView) -> None:
        """Draw the next heatmap so."""
        self.view = view
        self._wake.set()

    def choose_axes(self, axes: tuple[int, ...]) -> None:
        """Draw the next heatmap over these variables."""
        self.choose_view(replace(self.view, axes=axes))

    def ask(self, schedule: tuple[int, ...] | None = None) -> None:
        """Roll out a schedule, or the critic's choice; the latest request counts.

        Raises:
            UserError: the weights were learnt on another scene than the one shown.
        """
        self._post(_Request(schedule))

    def ask_sample(self) -> None:
        """Roll out from random starts, other ones each time, with the schedules of the critic."""
        self._post(_Request(sample=True))

    def _post(self, request: _Request) -> None:
        if self.stale:
            raise UserError(self.stale)
        if self._subject is not None:
            self._request = request
            self._wake.set()

    def choose_start(self, position: tuple[float, ...] | None) -> None:
        """Start rollouts, and value schedules, at a position [m]."""
        self.start = position
        self._wake.set()

    def forget(self) -> None:
        """Drop the subject and all answers."""
        self._subject = self._request = None
        self.picture = self.recording = self.start = None
        self.sample = ()
        self.error, self.view = "", MapView()

    def close(self) -> bool:
        """End the thread; whether it has ended, as it does not while it compiles."""
        self._closed = True
        self._wake.set()
        self._thread.join(timeout=3)
        return not self._thread.is_alive()

    def _work(self) -> None:
        drawn, due = (None, None, None), 0.0
        while not self._closed:
            self._wake.wait(timeout=max(0.1, due - time.monotonic()))
            self._wake.clear()
            subject, request = self._subject, self._request
            wanted = (subject, self.view, self.start)
            try:
                if subject is not None and request is not None:
                    self._answer(subject, request)
                elif subject is not None and self.watched and time.monotonic() >= due:
                    if subject is not drawn[0] or wanted[1:] != drawn[1:]:
                        drawn, due = wanted, time.monotonic() + PERIOD
                        self.picture = _draw(subject, *wanted[1:])
                        self.error = ""
            except Exception as error:  # noqa: BLE001 - the page shows it and lives on
                traceback.print_exc()
                self.error = f"{type(error).__name__}: {error}"
                self._request = None

    def _answer(self, subject: Subject, request: _Request) -> None:
        """Roll out, unless a newer request has come meanwhile."""
        if request.sample:
            self._samples += 1
            self.sample = _random_starts(subject, self._samples)
            self._request = None if self._request is request else self._request
            return
        schedule, start = request.schedule, self.start
        if schedule is None:
            if self.picture is None or self.picture.subject is not subject:
                self.picture = _draw(subject, self.view, start)
            schedule = self.picture.choice
        rollout = _programs(subject).roll_out(
            subject.task.problem,
            subject.parameters,
            _repeated(initial_state(subject.task, start)),
            _repeated(jnp.asarray(_padded(schedule))),
        )
        traces = (np.asarray(field)[:, 0] for field in rollout)
        self.recording = record(subject.task, schedule, *traces)
        if self._request is request:
            self._request = None
        self.error = ""


def default_axes(task: Task, choice: tuple[int, ...]) -> tuple[int, ...]:
    """The first two time variables that have an effect in the branches of a schedule."""
    variables = task.grounding.decomposition.variables
    matter = [
        index
        for index in time_variables(task)
        if all(choice[branch] == value for branch, value in variables[index].guards)
    ]
    return tuple(matter[:2])


def time_variables(task: Task) -> tuple[int, ...]:
    """Indices of the variables that are times (the others choose branches)."""
    variables = task.grounding.decomposition.variables
    return tuple(i for i, variable in enumerate(variables) if variable.kind == "time")


def initial_state(task: Task, start: tuple[float, ...] | None = None) -> Array:
    """At rest at a position, by default the centre of the initial set [n]."""
    data = task.problem.world
    position = (data.initial_low + data.initial_high) / 2 if start is None else start
    return task.robot.rest(jax.random.key(0), jnp.asarray(position, jnp.float32))


def _random_starts(subject: Subject, seed: int) -> tuple[Recording, ...]:
    """Rollouts from random initial states, each with the schedule that the critic chooses."""
    programs, task = _programs(subject), subject.task
    initial_key, choice_key = jax.random.split(jax.random.key(seed))
    states = programs.initial(task.problem, initial_key)
    schedules, _ = programs.choose(task.problem, subject.parameters, choice_key, states)
    rollout = programs.roll_out(task.problem, subject.parameters, states, schedules)
    traces = [np.asarray(field) for field in rollout]
    return tuple(
        record(task, schedule, *(trace[:, index] for trace in traces))
        for index, schedule in enumerate(np.asarray(schedules))
    )


def _draw(subject: Subject, view: MapView, start: tuple[float, ...] | None) -> Picture:
    """The heatmap over two variables, the others as the critic likes them best or as fixed."""
    task, fixed = subject.task, dict(view.fixed)
    state = initial_state(task, start)
    if fixed:
        asked = (task, subject.algorithm, subject.parameters, state)
        choice = tuple(int(value) for value in best_schedule(*asked, fixed))
        choice = choice[: len(task.grounding.decomposition.variables)]
    else:
        choice = _choice(subject, _programs(subject), state)
    axes = default_axes(task, choice) if view.axes is None else view.axes
    rest = _alternatives(task, choice, fixed) if view.best else None
    drawn = heatmap(task, subject.algorithm, subject.parameters, state, _padded(choice), axes, rest)
    return Picture(subject, drawn, best_cell(drawn, subject.algorithm)[: len(choice)])


def _alternatives(task: Task, choice: tuple[int, ...], fixed: dict[int, int]) -> np.ndarray:
    """Schedules [K, V] in the choice's branches, the choice first."""
    branches = set(range(len(choice))) - set(time_variables(task))
    held = {branch: choice[branch] for branch in branches} | fixed
    drawn = random_schedules(task, ALTERNATIVES, held)
    drawn[0] = _padded(choice)
    return drawn


def best_cell(drawn: Heatmap, algorithm: Algorithm) -> tuple[int, ...]:
    """Schedule [V] of the cell that the critic likes best."""
    score = algorithm.preference(drawn.values, drawn.shortfall)
    row, column = np.unravel_index(np.nan_to_num(score, nan=-np.inf).argmax(), score.shape)
    return tuple(int(value) for value in drawn.schedule_at(int(row), int(column)))


def _programs(subject: Subject) -> EvaluationPrograms:
    return evaluation_programs(subject.task, subject.algorithm, rollouts=ROLLOUTS)


def _choice(subject: Subject, programs: EvaluationPrograms, state: Array) -> tuple[int, ...]:
    """The best of the schedules that the critic is offered in an evaluation."""
    schedules, values = programs.choose(
        subject.task.problem, subject.parameters, jax.random.key(0), _repeated(state)
    )
    count = len(subject.task.grounding.decomposition.variables)
    best = np.asarray(schedules)[int(np.asarray(values).argmax())]
    return tuple(int(value) for value in best[:count])


def _padded(schedule: tuple[int, ...]) -> np.ndarray:
    padded = np.zeros(MAX_VARIABLES, np.int32)
    padded[: len(schedule)] = schedule
    return padded


def _repeated(row: Array) -> Array:
    return jnp.broadcast_to(row, (ROLLOUTS, *row.shape))
