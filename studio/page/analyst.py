"""Questions to a controller, answered on a thread of their own: plans, rollouts, and the map.

The newest request comes first, then the next map, then the share of starts that succeed, and last
what simulation says of the map's cells. A map that is due waits for one answer at most: while a
region is dragged, requests never end. Nothing is queued: a request replaces the one before it,
and an answer that comes too late is dropped. Shared values are replaced as a whole, never mutated.
"""

import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax

from core.ascent import ascent_jobs
from core.attempts import tries
from core.compilation import compile_together
from core.errors import UserError
from core.evaluation import evaluate
from core.nudges import PARENTS
from core.replanning import replan_jobs
from core.task.task import Task
from studio.page.asking import Answer, Move, moved_on, planned, random_starts, rolled_out
from studio.page.picture import MapView, Picture, Simulated, draw_picture, simulate_picture
from studio.page.subject import Subject
from studio.page.trainer import Training
from studio.page.worker import Worker

STARTS = 64
"""Random starts of which the share that succeeds is measured."""

PERIOD = 0.7
"""Minimum time between the starts of two heatmaps [s]."""

REST = 0.3
"""How long a scene must have stood before starts and cells are tried [s]: an edit comes first."""


class Share(NamedTuple):
    """How many random starts succeed with the schedule that the critic chooses for each."""

    subject: Subject
    succeeded: int
    starts: int


class _Drawn(NamedTuple):
    """What a map was drawn of."""

    subject: Subject | None = None
    view: MapView = MapView()
    start: tuple[float, ...] | None = None
    plan: tuple[int, ...] | None = None

    def same(self, other: "_Drawn") -> bool:
        """Whether the map would be the same."""
        return self.subject is other.subject and self[1:] == other[1:]


@dataclass(frozen=True)
class _Request:
    """A schedule to roll out, None for a plan; a sample of random starts; or a move."""

    schedule: tuple[int, ...] | None = None
    sample: bool = False
    asked: bool = True
    move: Move | None = None


class Analyst:
    """Read `picture`, `simulated`, `answer`, `share` and `error`; ask with `ask`.

    Every answer says whom it was asked of; whoever takes it drops what does not fit.
    """

    def __init__(self, news: Callable[[], None] = lambda: None) -> None:
        self._news = news
        """Called when something was found out, on the analyst's thread."""
        self.picture: Picture | None = None
        self.simulated: Simulated | None = None
        """Cells that were simulated last; of the picture shown, or of one before it."""
        self.simulating = False
        """Whether the cells of the picture are simulated."""
        self.answer: Answer | None = None
        """The rollout asked for last."""
        self.share: Share | None = None
        self.error = ""
        self.stale = ""
        """Why the weights do not answer for the scene shown, empty if they do."""
        self.watched = True
        """Whether anybody sees the heatmap; it is drawn only then."""
        self.view = MapView()
        self.sample: Answer | None = None
        """Rollouts from random starts."""
        self.start: tuple[float, ...] | None = None
        """Position at which rollouts start [d] in [m]; None for the centre of the initial set."""
        self.hurried = False
        """Whether an edit waits for the answer: a search ends with what it has."""
        self._preparing = False
        self._warm: Task | None = None
        """For which the programs of harder scenes are compiled."""
        self._samples = 0
        self._since = 0.0
        """When the scene that is asked about was shown first [s, monotonic]."""
        self._subject: Subject | None = None
        self._request: _Request | None = None
        self._closed = False
        self._lock = threading.Lock()
        """Held while requests, answers and the subject change."""
        self._wake = threading.Event()
        self._worker = Worker("analyst", self._work, self._end)

    @property
    def busy(self) -> bool:
        """Whether a rollout was requested and is not ready yet."""
        return self._request is not None

    def observe(self, training: Training) -> None:
        """Ask the weights of this training from now on, once it has any."""
        task, controller = training.task, training.controller
        if task is None or controller is None:
            return
        with self._lock:
            known = self._subject
            if known is not None and known.weights is training.weights and known.task is task:
                return
            if known is None or known.task.grounding is not task.grounding:
                self.view = MapView()
                waiting = self._request
                if waiting is not None and (waiting.schedule or waiting.move) is not None:
                    self._request = None  # of another task
            self._subject = Subject(
                training.identity,
                task,
                controller,
                training.epoch,
                training.chains,
                training.weights,
                training.general,
            )
            if known is None or known.task is not task:
                self._since = time.monotonic()
        self._wake.set()

    def choose_view(self, view: MapView) -> None:
        """Draw the next heatmap with this view."""
        self.view = view
        self._wake.set()

    def simulate(self, wanted: bool) -> None:
        """Simulate the cells of the picture shown, and of those to come, or no longer."""
        self.simulating = wanted
        self._wake.set()

    def ask(self, schedule: tuple[int, ...] | None = None, *, asked: bool = True) -> None:
        """Roll out a schedule, or find a plan; the latest request counts.

        One that nobody pressed a button for (`asked` is false) does not displace one that waits.

        Raises:
            UserError: the weights were learnt on a scene other than the one shown.
        """
        self._post(_Request(schedule, asked=asked))

    def ask_sample(self) -> None:
        """Roll out from new random starts, with the schedules that the critic chooses."""
        self._post(_Request(sample=True))

    def ask_move(self, move: Move) -> None:
        """Plan a rollout anew, with the robot somewhere else.

        Raises:
            UserError: the weights answer for another scene than the rollout's.
        """
        subject = self._subject
        if subject is None or subject.task is not move.recording.task:
            raise UserError(
                "The robot cannot be moved: the scene has changed since this rollout. Wait for "
                "the next plan."
            )
        self._post(_Request(move=move))

    def prepare_moves(self) -> None:
        """Compile what moves need while nothing else is asked."""
        self._preparing = True
        self._wake.set()

    def _post(self, request: _Request) -> None:
        if self.stale:
            raise UserError(self.stale)
        with self._lock:
            waiting = self._request
            displaced = request.asked or waiting is None or not waiting.asked
            if self._subject is not None and displaced:
                self._request = request
        self._wake.set()

    def choose_start(self, position: tuple[float, ...] | None) -> None:
        """Start rollouts, and value schedules, at a position [m]."""
        self.start = position
        self._wake.set()

    def forget(self) -> None:
        """Drop the subject and all answers."""
        with self._lock:
            self._subject = self._request = None
            self.picture = self.answer = self.sample = self.start = self.share = None
            self.simulated = None
            self.error, self.view = "", MapView()

    def close(self) -> bool:
        """End the thread; returns whether it has ended (not while it compiles)."""
        return self._worker.close()

    def _end(self) -> None:
        self._closed = True
        self._wake.set()

    def _work(self) -> None:
        drawn, due, answered = _Drawn(), 0.0, False
        while not self._closed:
            self._wake.wait(timeout=max(0.1, due - time.monotonic()))
            self._wake.clear()
            with self._lock:
                subject, request = self._subject, self._request
            try:
                if subject is None:
                    continue
                wanted = _Drawn(subject, self.view, self.start, self._plan_of(subject))
                mapped = self.watched and time.monotonic() >= due and not wanted.same(drawn)
                if request is not None and not (mapped and answered):
                    answered = True
                    self._answer(subject, request)
                elif self._preparing:
                    self._preparing = False
                    compile_together(*replan_jobs(subject.task, subject.controller))
                elif mapped:
                    answered = False
                    drawn, due = wanted, time.monotonic() + PERIOD
                    picture = draw_picture(subject, *wanted[1:])
                    self._publish(subject, picture=picture)
                    self._wake.set()  # a request may wait
                elif time.monotonic() >= self._since + REST:
                    if not (self._count(subject) or self._warm_up(subject)):
                        self._simulate(subject)
            except Exception as error:  # noqa: BLE001 - the page shows it and lives on
                traceback.print_exc()
                if subject is not None:
                    self._publish(subject, request, error=f"{type(error).__name__}: {error}")

    def _answer(self, subject: Subject, request: _Request) -> None:
        """Answer, unless a newer request has come meanwhile."""
        if request.move is not None:
            fits = request.move.recording.task is subject.task
            news = {"answer": moved_on(subject, request.move)} if fits else {}
            self._publish(subject, request, **news)
        elif request.sample:
            self._samples += 1
            sample = Answer(subject, random_starts(subject, self._samples))
            self._publish(subject, request, sample=sample)
        elif request.schedule is None:

            def interrupted() -> bool:
                newer = self._request is not request or self._subject is not subject
                return newer or self.hurried

            found = planned(subject, self.start, request.asked, interrupted)
            self._publish(subject, request, answer=found)
        else:
            recording = rolled_out(subject, self.start, request.schedule)
            self._publish(subject, request, answer=Answer(subject, (recording,)))

    def _count(self, subject: Subject) -> bool:
        """Try a few more random starts for the plan shown; False if enough are known."""
        share = self.share
        if self._plan_of(subject) is None:
            return False
        if share is None or share.subject is not subject:
            share = Share(subject, 0, 0)
        if share.starts >= STARTS:
            return False
        count = tries(subject.task)
        key = jax.random.fold_in(jax.random.key(1), share.starts)
        evaluation = evaluate(subject.task, subject.controller, key, count=count)
        succeeded = int((evaluation.robustness >= 0).sum())
        counted = Share(subject, share.succeeded + succeeded, share.starts + count)
        self._publish(subject, share=counted)
        self._wake.set()
        return True

    def _warm_up(self, subject: Subject) -> bool:
        """Compile what plans for harder scenes need; False if it has been done."""
        if not subject.general or self._warm is subject.task:
            return False
        self._warm = subject.task
        compile_together(*ascent_jobs(subject.task, subject.controller, PARENTS))
        self._wake.set()
        return True

    def _simulate(self, subject: Subject) -> None:
        """Simulate a few more cells of the picture shown, if somebody wants to see them."""
        picture, before = self.picture, self.simulated
        if not (self.simulating and self.watched) or picture is None:
            return
        if picture.subject.task is not subject.task or subject.controller.search is None:
            return
        if before is not None and before.picture is picture and before.truth.complete:
            return
        try:
            found = simulate_picture(picture, before)
        except Exception:
            self.simulating = False  # or it would fail again at once
            raise
        self._publish(subject, simulated=found)
        self._wake.set()

    def _plan_of(self, subject: Subject) -> tuple[int, ...] | None:
        """The schedule of the plan that is shown, if it is the subject's."""
        found = self.answer
        if found is None or found.subject is not subject or found.seconds is None:
            return None
        return found.recordings[0].schedule

    def _publish(self, subject: Subject, request: _Request | None = None, **news: Any) -> None:
        """Show what was found out, unless another training answers by now; it is asked again."""
        with self._lock:
            if self._subject is None or self._subject.training is not subject.training:
                return
            if self._request is request:  # a newer one stays
                self._request = None
            for name, value in {"error": "", **news}.items():
                setattr(self, name, value)
        self._news()
