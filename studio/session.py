"""The state of the page: what is asked for, what was learnt, what plays.

Handlers of the page run on other threads; they `post` a change. The page's loop applies the
changes in `tick` and is the only one that alters this state.
"""

import threading
import time
import traceback
from collections.abc import Callable
from functools import partial
from queue import Empty, SimpleQueue

from core.errors import UserError
from core.training import TrainingConfig
from scenes import Scene, load_task
from studio.analyst import Analyst
from studio.editing.document import Document
from studio.editing.editor import Editor
from studio.editing.judge import Judge
from studio.editing.meaning import differences, stale_text
from studio.editing.specification import Specification, specify
from studio.files.bundle import Policy
from studio.files.shipped import shipped_policy
from studio.playing.gallery import Gallery
from studio.playing.player import Player
from studio.playing.recording import Recording
from studio.settings import Settings, method_of, mode_of, prolonged
from studio.worker import Stage, Trainer, Training

DEBOUNCE = 0.35
"""Pause in typing or dragging after which a formula or a scene is judged [s]."""

MakeConfig = Callable[[Scene, float], TrainingConfig]
"""From a scene and a time limit [s] to the training that the button starts."""


class Session:
    """One for all clients of a server."""

    def __init__(self, scene: Scene, formula: str | None, make_config: MakeConfig) -> None:
        self.judge = Judge(specify(scene, formula))
        self.document = Document(self.specification.scene)
        self.editor = Editor(self.document)
        self.trainer, self.analyst, self.player = Trainer(), Analyst(), Player()
        self.settings = Settings()
        self.queued: Specification | None = None
        """What is trained on when the present training has ended."""
        self.leaving: Callable[[], None] | None = None
        """A change of scene that waits for a word on what would be lost."""
        self.error = ""
        self.gallery = Gallery()
        self.highlighted: tuple[str, ...] = ()
        """Regions pointed out in the scene."""
        self.following = self.choosing_start = False
        """Whether the camera follows the robot; whether a click on the initial set starts there."""
        self._make_config = make_config
        self._changes: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self.news = threading.Event()
        """Set when something was posted; whoever ticks clears it."""
        self._draft: tuple[str, float] | None = None
        self._refused: str | None = None
        self._judged = 0
        self._trained: Scene | None = None
        self._shown: Training | None = None
        self._received: Recording | None = None

    @property
    def specification(self) -> Specification:
        """The scene as judged last."""
        return self.judge.specification

    @property
    def training(self) -> Training:
        """The latest snapshot."""
        return self.trainer.snapshot

    @property
    def trained(self) -> Scene | None:
        """The scene that was trained on."""
        return self._trained

    @property
    def text(self) -> str:
        """The formula as typed last, judged or not."""
        if self._draft is not None:
            return self._draft[0]
        return self.document.scene.formula if self._refused is None else self._refused

    @property
    def stale_reasons(self) -> tuple[str, ...]:
        """What has changed since the training, in words; nothing if what was learnt holds."""
        if self.training.task is None or self._trained is None:
            return ()
        return differences(self._trained, self.document.scene)

    @property
    def stale(self) -> bool:
        """Whether what was learnt belongs to another scene than the one shown."""
        return bool(self.stale_reasons)

    @property
    def unsaved(self) -> bool:
        """Whether going to another scene would lose edits, a text being typed included."""
        return self.document.modified or self._draft is not None or self._refused is not None

    def post(self, change: Callable[[], None]) -> None:
        """Have a change made by the next tick, which comes at once; from any thread."""
        self._changes.put(change)
        self.news.set()

    def tick(self, now: float) -> None:
        """Apply what was posted and pass news on.

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
        if not self.editor.dragging and self.document.revision != self._judged:
            self._apply(self._judge, keep_error=True)
        self.judge.collect()
        waiting = self.queued
        if waiting is not None and not self.training.busy:
            self._apply(partial(self._start, waiting), keep_error=True)
        self._pass_on()
        self.player.tick(now)

    def leave(self, change: Callable[[], None]) -> None:
        """Go to another scene: now, or after `confirm` where a training or edits would be lost."""
        if self.training.busy or self.unsaved:
            self.leaving = change
        else:
            change()

    def confirm(self, go: bool) -> None:
        """Make the change of scene that waits, or drop it."""
        change, self.leaving = self.leaving, None
        if go and change is not None:
            change()

    def choose_task(self, name: str) -> None:
        """Go to a shipped task; what was learnt on the last one is dropped."""
        self.open(load_task(name))
        self.show_shipped()

    def show_shipped(self) -> None:
        """Show the policy that comes with the task, if there is one for the scene as it is."""
        scene, task = self.specification.scene, self.specification.task
        policy = None if task is None else shipped_policy(scene, task)
        if policy is not None:
            self._adopt(policy, "a policy that comes with the task")

    def load(self, policy: Policy, origin: str) -> None:
        """Go to the scene of a policy from elsewhere and show what it does."""
        self.open(policy.scene)
        self._adopt(policy, origin)

    def open(self, scene: Scene, *, saved: bool = True) -> None:
        """Go to another scene; one that is in no file of the user's counts as unsaved."""
        specification = specify(scene)
        self.trainer.forget()
        self.analyst.forget()
        self.gallery.clear()
        self.player.load(None)
        self.queued = self.leaving = None
        self._draft = self._refused = self._shown = self._trained = None
        self.document = Document(scene, saved=saved)
        self.editor = Editor(self.document)
        self._judged = self.document.revision
        self.judge.put(specification)

    def edit(self, text: str) -> None:
        """Take a formula as typed; it is judged when the typing pauses."""
        self._draft = (text, time.monotonic() + DEBOUNCE)

    def undo(self) -> None:
        """Take back the last step, typing included."""
        self._take_draft()
        if self.editor.dragging:
            self.editor.cancel()
        else:
            self.document.undo()
        self.editor.check_selection()

    def redo(self) -> None:
        """Do again what was taken back."""
        self._take_draft()
        self.document.redo()
        self.editor.check_selection()

    def train(self) -> None:
        """Train on the formula in the editor, if it is right: now, or after what runs."""
        self._take_draft()
        self._judge()
        self.judge.finish()
        specification = self.specification
        if specification.error or specification.task is None:
            raise UserError("Training needs a formula without errors.")
        if self.training.busy:
            self.queued = specification
        else:
            self._start(specification)

    def train_longer(self) -> None:
        """Go on past the target, for as long again as the time limit."""
        training = self.training
        if self.analyst.stale or training.config is None:
            raise UserError(self.analyst.stale or "There is no training to go on with.")
        limit = self.settings.time_limit
        self.trainer.proceed(prolonged(training.config, training.trained_seconds, limit))

    def policy(self) -> Policy:
        """What was learnt, to keep.

        Raises:
            UserError: nothing was learnt yet.
        """
        training, scene = self.training, self._trained
        if training.parameters is None or training.config is None or scene is None:
            raise UserError("There is no policy yet. Train first, or load one.")
        algorithm, success = training.config.algorithm, training.success
        return Policy(
            scene,
            mode_of(algorithm),
            method_of(algorithm),
            training.config.seed,
            algorithm,
            training.parameters,
            float("nan") if success is None else success,
            float("nan"),
            training.epoch,
        )

    def close(self) -> bool:
        """End the threads; whether all have ended."""
        return all([self.trainer.close(), self.analyst.close(), self.judge.close()])

    def _start(self, specification: Specification) -> None:
        assert specification.task is not None
        self.queued = None
        self.analyst.forget()
        self.gallery.clear()
        self.player.load(None)
        self._shown, self._trained = None, specification.scene
        config = self._make_config(specification.scene, self.settings.time_limit)
        self.trainer.start(specification.task, self.settings.applied(config, specification.scene))

    def _adopt(self, policy: Policy, origin: str) -> None:
        task = self.specification.task
        if task is None:
            raise UserError(self.specification.error)
        config = TrainingConfig(policy.algorithm, seed=policy.seed)
        self.trainer.adopt(
            task,
            config,
            policy.parameters,
            epoch=policy.epochs,
            success=policy.success_rate,
            origin=origin,
        )
        self._shown, self._trained = None, self.specification.scene

    def _take_draft(self) -> None:
        """Put the formula that was typed last into the document; one that does not fit is shown."""
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

    def _pass_on(self) -> None:
        """Give the analyst the newest weights and the player the newest rollout."""
        training = self.training
        self.analyst.stale = stale_text(self.stale_reasons)
        self.analyst.observe(training)
        ended = training.stage in (Stage.DONE, Stage.STOPPED, Stage.LOADED)
        unseen = self._shown is None or self._shown.stage is not training.stage
        wanted = self.player.recording is None and not self.analyst.stale
        if ended and unseen and training.parameters is not None and wanted:
            self.analyst.ask()
        self._shown = training
        recording = self.analyst.recording
        if recording is not self._received and (
            recording is None or recording.task is training.task
        ):
            self._received = recording
            self.player.load(recording)
            if recording is not None:
                self.gallery.add(recording)
        if self.analyst.sample is not self.gallery.sample and self.analyst.sample:
            self.gallery.sample, self.analyst.sample = self.analyst.sample, ()
