"""The state of the page: the scene, what was learnt, and what is playing.

The page's handlers run on other threads; they `post` changes. Only the page's loop alters this
state, by applying the changes in `tick`.
"""

import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from queue import Empty, SimpleQueue

from core.errors import UserError
from core.methods.training import TrainingConfig
from scenes import Scene, load_task, workspace_of
from studio.page.analyst import Analyst
from studio.page.editing.document import Document
from studio.page.editing.editor import Editor
from studio.page.editing.judge import Judge
from studio.page.editing.meaning import differences, stale_text
from studio.page.editing.specification import Specification, specify
from studio.page.exact import ExactPlanner, offered
from studio.page.memory import give_back
from studio.page.planner import Planner
from studio.page.playing.gallery import Gallery
from studio.page.playing.hand import Hand
from studio.page.playing.player import Player
from studio.page.policies import adopt, policy_of
from studio.page.relay import Relay
from studio.page.settings import EXACT, Settings, prolonged
from studio.page.trainer import Trainer, Training
from studio.runs.bundle import Policy

DEBOUNCE = 0.35
"""Pause in typing or dragging after which a formula or a scene is judged [s]."""

MakeConfig = Callable[[Scene, float], TrainingConfig]
"""From a scene and a time limit [s] to the training that the button starts."""


class Session:
    """One for all clients of a server."""

    def __init__(self, scene: Scene, formula: str | None, make_config: MakeConfig) -> None:
        self.news = threading.Event()
        """Set when something was posted or found out; the loop clears it."""
        self.judge = Judge(specify(scene, formula), self.news.set)
        self.document = Document(self.specification.scene)
        self.editor = Editor(self.document)
        self.trainer, self.analyst, self.player = Trainer(), Analyst(self.news.set), Player()
        self.planner, self.exact = Planner(), ExactPlanner()
        self.settings = Settings()
        self.queued: Specification | None = None
        """Trained on when the current training has ended."""
        self.leaving: Callable[[], None] | None = None
        """A change of scene that waits for confirmation, because something would be lost."""
        self.error = ""
        self.gallery = Gallery()
        self.relay = Relay(self.analyst, self.player, self.gallery)
        self.hand = Hand(
            self.player, self.analyst, lambda: workspace_of(self.specification.scene).arena
        )
        self.highlighted: tuple[str, ...] = ()
        """Regions highlighted in the scene."""
        self.following = self.choosing_start = False
        """Whether the camera follows the robot; whether a click on the initial set starts there."""
        self._make_config = make_config
        self._changes: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._draft: tuple[str, float] | None = None
        self._refused: str | None = None
        self._judged = 0

    @property
    def specification(self) -> Specification:
        """The scene as last judged."""
        return self.judge.specification

    @property
    def training(self) -> Training:
        """The latest snapshot."""
        return self.trainer.snapshot

    @property
    def subject(self) -> Training:
        """Who answers for the scene shown: what was trained on it, else the robot's weights."""
        training, planned = self.training, self.planner.training
        if planned is None or (training.weights is not None and not self.stale):
            return training
        return planned

    @property
    def trained(self) -> Scene | None:
        """The scene that was trained on."""
        return self.training.scene

    @property
    def text(self) -> str:
        """The formula as last typed, judged or not."""
        if self._draft is not None:
            return self._draft[0]
        return self.document.scene.formula if self._refused is None else self._refused

    @property
    def stale_reasons(self) -> tuple[str, ...]:
        """What has changed since the training, in words; nothing if what was learnt holds."""
        trained = self.trained
        return () if trained is None else differences(trained, self.document.scene)

    @property
    def stale(self) -> bool:
        """Whether what was learnt belongs to a scene other than the one shown."""
        return bool(self.stale_reasons)

    @property
    def unsaved(self) -> bool:
        """Whether opening another scene would lose edits, including text being typed."""
        return self.document.modified or self._draft is not None or self._refused is not None

    def post(self, change: Callable[[], None]) -> None:
        """Have the next tick, which follows at once, apply a change; callable from any thread."""
        self._changes.put(change)
        self.news.set()

    def tick(self, now: float) -> None:
        """Apply what was posted and pass on news.

        Args:
            now: monotonic time [s].
        """
        while True:
            try:
                change = self._changes.get_nowait()
            except Empty:
                break
            self._apply(change)
        if self._draft is not None and now >= self._draft[1]:
            self._apply(self._take_draft)
        answered = not (self.judge.building or self.analyst.busy)
        if self.document.revision != self._judged and (answered or not self.editor.dragging):
            self._apply(self._judge, keep_error=True)
        self.analyst.hurried = self.document.revision != self._judged
        self.judge.collect()
        waiting = self.queued
        if waiting is not None and not self.training.busy:
            self._apply(partial(self._start, waiting), keep_error=True)
        self.planner.observe(self.specification)
        subject = self.subject
        stale = "" if subject is not self.training else stale_text(self.stale_reasons)
        exact = self.exact.news()
        if exact is not None and not differences(exact.scene, self.document.scene):
            self.player.load(exact.recording)
        idle = not self.analyst.busy  # asked before answers are handed on: none is missed
        self.relay.pass_on(subject, stale)
        self.hand.tick(idle)
        self.player.tick(now)

    def leave(self, change: Callable[[], None]) -> None:
        """Change scene: now, or after `confirm` if a training or edits would be lost."""
        if self.training.busy or self.unsaved:
            self.leaving = change
        else:
            change()

    def confirm(self, go: bool) -> None:
        """Carry out or drop the change of scene that waits."""
        change, self.leaving = self.leaving, None
        if go and change is not None:
            change()

    def choose_task(self, name: str) -> None:
        """Open a shipped task; what was learnt on the last one is dropped."""
        self.open(load_task(name))

    def load(self, policy: Policy, origin: str) -> None:
        """Open the scene of a loaded policy and show what it does."""
        self.open(policy.scene)
        self._adopt(policy, origin)

    def open(self, scene: Scene, *, saved: bool = True) -> None:
        """Open another scene; `saved` says whether it is stored in a file."""
        specification = specify(scene)
        self.trainer.forget()
        self.exact.forget()
        self.analyst.forget()
        self.gallery.clear()
        self.player.load(None)
        self.queued = self.leaving = None
        self._draft = self._refused = None
        self.relay.forget()
        self.document = Document(scene, saved=saved)
        self.editor = Editor(self.document)
        self._judged = self.document.revision
        self.judge.put(specification)
        give_back()

    def edit(self, text: str) -> None:
        """Set the formula as typed; it is judged when typing pauses."""
        self._draft = (text, time.monotonic() + DEBOUNCE)

    def undo(self) -> None:
        """Undo the last step, including typing."""
        self._take_draft()
        if self.editor.dragging:
            self.editor.cancel()
        else:
            self.document.undo()
        self.editor.check_selection()

    def redo(self) -> None:
        """Redo the step that was last undone."""
        self._take_draft()
        self.document.redo()
        self.editor.check_selection()

    @property
    def exactly(self) -> bool:
        """Whether the button searches for an exact plan instead of training."""
        return self.settings.method == EXACT and offered(self.document.scene)

    def train(self) -> None:
        """Train on the formula, if valid, now or after the running training; or plan exactly."""
        self._take_draft()
        self._judge()
        self.judge.finish()
        specification = self.specification
        if specification.error or specification.task is None:
            raise UserError("Correct the formula before training.")
        if self.exactly:
            start, limit = self.analyst.start, self.settings.time_limit
            self.exact.start(specification.task, specification.scene, start, limit)
        elif self.training.busy:
            self.queued = specification
        else:
            self._start(specification)

    def train_longer(self) -> None:
        """Continue past the target, for one more time limit."""
        training = self.training
        if self.analyst.stale or training.config is None:
            raise UserError(self.analyst.stale or "There is no training to continue.")
        limit = self.settings.time_limit
        self.trainer.proceed(prolonged(training.config, training.trained_seconds, limit))

    def policy(self) -> Policy:
        """The trained policy, or the robot's weights on this scene, for export.

        Raises:
            UserError: there is none yet.
        """
        training = self.training
        if training.weights is None and self.planner.training is not None:
            training = self.planner.training
        return policy_of(training)

    def close(self) -> bool:
        """End the threads; whether all have ended."""
        threads = (self.trainer, self.exact, self.analyst, self.judge)
        return all([each.close() for each in threads])

    def _start(self, specification: Specification) -> None:
        assert specification.task is not None
        self.queued = None
        self.analyst.forget()
        self.gallery.clear()
        self.player.load(None)
        self.relay.forget()
        scene = specification.scene
        config = self.settings.applied(self._make_config(scene, self.settings.time_limit), scene)
        state = None
        if self.settings.from_weights:
            state = self.planner.first_state(specification.task, config)
            config = replace(config, warm=state is not None)
        self.trainer.start(specification.task, config, scene, state)

    def _adopt(self, policy: Policy, origin: str) -> None:
        adopt(self.trainer, policy, self.specification, origin)
        self.relay.forget()

    def _take_draft(self) -> None:
        """Put the typed formula into the document; one that is refused stays visible."""
        if self._draft is None:
            return
        text, self._draft = self._draft[0], None
        try:
            self.document.set_formula(text)
            self._refused = None
            self._judge()
        except UserError as error:
            self._refused = text
            self.judge.refuse(str(error))

    def _judge(self) -> None:
        """Have the document's scene judged if it has changed."""
        if self.document.revision != self._judged:
            self._judged, self._refused = self.document.revision, None
            self.judge.take(self.document.scene)

    def _apply(self, change: Callable[[], None], *, keep_error: bool = False) -> None:
        try:
            self.error = self.error if keep_error else ""
            change()
        except UserError as error:
            self.error = str(error)
        except Exception as error:  # noqa: BLE001 - the page shows it and lives on
            traceback.print_exc()
            self.error = f"{type(error).__name__}: {error}"
