"""Judges scenes as they are edited: the formula at once, the distance fields on a thread.

Parsing, decomposing and asking whether the mission is possible take tens of milliseconds, the
fields up to seconds in 3D; a page that waited for them would freeze. The last task stays until the
new one is ready. Only the latest scene counts: a task whose scene was edited again in the meantime
is dropped.
"""

import threading
import traceback
from collections.abc import Callable
from dataclasses import replace

from core.errors import UserError
from scenes import Scene
from studio.page.editing.specification import Specification, edited, same_task
from studio.page.worker import Worker
from studio.runs.findings import require_possible
from studio.runs.tasks import ground_scene


class Judge:
    """Read `specification` and `building`; call `take` and `collect` from one thread only."""

    def __init__(
        self, specification: Specification, news: Callable[[], None] = lambda: None
    ) -> None:
        self._news = news
        """Called when a task is ready, on the judge's thread."""
        self.specification = specification
        """The latest judged scene; while `building`, its task is an earlier scene's."""
        self._right = specification
        """The specification that the current task belongs to."""
        self._wanted: Specification | None = None
        self._answer: tuple[Scene, Specification] | None = None
        self._changed = threading.Condition()
        self._closed = False
        self._worker = Worker("judge", self._work, self._end)

    @property
    def building(self) -> bool:
        """Whether the task of the latest scene is not ready yet."""
        return self._wanted is not None

    def put(self, specification: Specification) -> None:
        """Continue from a specification that was judged elsewhere."""
        self._want(None)
        self.specification = self._right = specification

    def refuse(self, error: str) -> None:
        """Report why the typed text does not even make a scene."""
        self._want(None)
        self.specification = replace(self.specification, task=self._right.task, error=error)

    def take(self, scene: Scene) -> None:
        """Judge a scene: its formula now; the rest arrives in `collect`."""
        right = self._right
        if right.task is not None and same_task(right, scene):
            self.put(replace(right, scene=scene))
            return
        try:
            ground_scene(scene)
            findings = require_possible(scene)
        except UserError as error:
            self._want(None)
            self.specification = Specification(scene, right.task, str(error))
            return
        self.specification = Specification(scene, right.task, findings=findings)
        self._want(self.specification)

    def collect(self) -> None:
        """Replace the last task by the new one once it is ready."""
        with self._changed:
            answer, wanted = self._answer, self._wanted
            if answer is None or wanted is None or answer[0] is not wanted.scene:
                return
            self._answer = self._wanted = None
        self.specification = answer[1]
        if not self.specification.error:
            self._right = self.specification

    def finish(self) -> None:
        """Wait for the task of the latest scene."""
        with self._changed:
            self._changed.wait_for(self._settled)
        self.collect()

    def close(self) -> bool:
        """End the thread; returns whether it has ended."""
        return self._worker.close()

    def _end(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _settled(self) -> bool:
        """Whether there is nothing to wait for."""
        wanted, answer = self._wanted, self._answer
        done = wanted is None or (answer is not None and answer[0] is wanted.scene)
        return done or self._closed

    def _want(self, wanted: Specification | None) -> None:
        with self._changed:
            self._wanted, self._answer = wanted, None
            self._changed.notify_all()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or not self._settled())
                wanted = self._wanted
                if self._closed:
                    return
            if wanted is None:
                continue
            answer = _built(wanted)
            with self._changed:
                if self._wanted is wanted:
                    self._answer = wanted.scene, answer
                    self._changed.notify_all()
            self._news()


def _built(wanted: Specification) -> Specification:
    """The specification with the scene's own task, or with the error that prevents one."""
    scene = wanted.scene
    try:
        # Judged from scratch: the task that `wanted` carries is an earlier scene's.
        found = edited(Specification(scene, None), scene)
    except Exception as error:  # noqa: BLE001 - the page shows it and lives on
        traceback.print_exc()
        return replace(wanted, error=f"{type(error).__name__}: {error}")
    return replace(wanted, error=found.error) if found.error else found
