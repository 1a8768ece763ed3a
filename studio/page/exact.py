"""Exact plans on the page: one search on a thread of its own, watched and stopped from outside."""

import time
import traceback
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from core.errors import UserError
from core.planning.exact import ExactPlan, plan_exactly
from core.planning.watch import Watch
from core.task.protocols import stride_of
from core.task.task import Task
from scenes import Region, Scene, robot_of, scene_formula
from scenes.outlines import margins_of, setting_of
from studio.page.worker import Worker
from studio.runs.exact import replayed
from studio.runs.recording import Recording, record


@dataclass(frozen=True, eq=False)
class Search:
    """What is known of a search at one instant.

    Attributes:
        scene: whose formula is planned for.
        limit: of the search [s].
        began: `time.monotonic` when it was asked for [s].
        watch: what is known while it runs.
        plan: what it has found out; None while it runs, or if it failed.
        recording: the plan carried out by the robot; None if there is none.
        error: why it failed.
    """

    scene: Scene
    limit: float
    began: float
    watch: Watch
    plan: ExactPlan | None = None
    recording: Recording | None = None
    error: str = ""

    @property
    def running(self) -> bool:
        """Whether it goes on."""
        return self.plan is None and not self.error


class ExactPlanner:
    """One search at a time; a new one replaces the old. Read `search`."""

    def __init__(self) -> None:
        self.search: Search | None = None
        self._workers: list[Worker] = []
        self._told: Search | None = None

    @property
    def running(self) -> bool:
        """Whether a search goes on."""
        return self.search is not None and self.search.running

    def start(
        self, task: Task, scene: Scene, start: tuple[float, ...] | None, limit: float
    ) -> None:
        """Search for the most robust plan.

        Args:
            task: the grounded task.
            scene: that it was built from.
            start: position [d] in [m]; None for the centre of the initial set.
            limit: of the search [s].

        Raises:
            UserError: exact plans do not know the robot, or a region.
        """
        self.stop()
        if start is not None:
            here = Region(scene.initial.name, "point", start, color=scene.initial.color)
            asked = replace(scene, initial=here)
        else:
            asked = scene
        setting_of(asked)
        self.search = search = Search(scene, limit, time.monotonic(), Watch())
        work = partial(self._work, search, task, asked)
        worker = Worker("exact", work, search.watch.stop.set)
        self._workers = [each for each in self._workers if each.alive] + [worker]

    def news(self) -> Search | None:
        """The search, once, when it has ended with a plan that the robot has carried out."""
        search = self.search
        if search is self._told or search is None or search.recording is None:
            return None
        self._told = search
        return search

    def stop(self) -> None:
        """Have the search end with what it has."""
        if self.search is not None:
            self.search.watch.stop.set()

    def forget(self) -> None:
        """Stop, and drop what was found."""
        self.stop()
        self.search = None

    def close(self) -> bool:
        """Stop; whether the threads have ended."""
        return all([worker.close() for worker in self._workers])

    def _work(self, search: Search, task: Task, scene: Scene) -> None:
        try:
            found = searched(search, task, scene)
        except UserError as error:
            found = replace(search, error=str(error))
        except Exception as error:  # noqa: BLE001 - the page shows it and lives on
            traceback.print_exc()
            found = replace(search, error=f"{type(error).__name__}: {error}")
        if self.search is search:
            self.search = found


def searched(search: Search, task: Task, scene: Scene) -> Search:
    """The search with its plan, which the robot has carried out.

    Raises:
        UserError: exact plans do not know the robot, or a region.
    """
    formula, setting = scene_formula(scene), setting_of(scene)
    plan = plan_exactly(formula, setting, seconds=search.limit, watch=search.watch)
    if plan.positions is None:
        return replace(search, plan=plan)
    carried = replayed(scene, formula, plan)
    states = np.array(carried["positions"], np.float32)
    known = margins_of(scene.regions, states.astype(float))
    margins = np.stack([known[name] for name in task.grounding.atoms], axis=-1)
    recording = record(task, None, states, np.array(carried["actions"]), margins)
    return replace(search, plan=plan, recording=recording)


def offered(scene: Scene) -> bool:
    """Whether exact plans know the robot: it moves by bounded strides in the plane."""
    return scene.dimension == 2 and stride_of(robot_of(scene)) is not None
