"""A scene with its formula judged."""

from dataclasses import dataclass, replace

from core.decompose import Decomposition
from core.errors import UserError
from core.task import Task
from scenes import Scene
from studio.tasks import build_task


@dataclass(frozen=True, eq=False)
class Specification:
    """What a person asks for.

    Attributes:
        scene: the scene that was judged.
        task: the grounded task, or that of the last scene that was right; None before one.
        error: why the scene's formula cannot be used, empty if it can.
    """

    scene: Scene
    task: Task | None
    error: str = ""

    @property
    def text(self) -> str:
        """The formula that was judged."""
        return self.scene.formula

    @property
    def decomposition(self) -> Decomposition | None:
        """Of the formula that was right last."""
        return None if self.task is None else self.task.grounding.decomposition


def specify(scene: Scene, text: str | None = None) -> Specification:
    """Judge a formula over a scene, the scene's own if none is given."""
    return edited(Specification(scene, None), scene if text is None else with_text(scene, text))


def edited(specification: Specification, scene: Scene) -> Specification:
    """Judge an edited scene; where its formula is wrong, the last right task stays."""
    if specification.task is not None and same_task(specification, scene):
        return replace(specification, scene=scene)
    try:
        task = build_task(scene)
    except UserError as error:
        return replace(specification, scene=scene, error=str(error))
    return Specification(scene, task)


def with_text(scene: Scene, text: str) -> Scene:
    """The same scene with another formula."""
    return replace(scene, formula=text)


def same_task(specification: Specification, scene: Scene) -> bool:
    """Whether nothing changed but how the scene looks."""
    return not specification.error and _plain(specification.scene) == _plain(scene)


def _plain(scene: Scene) -> Scene:
    regions = tuple(replace(region, color=None) for region in scene.regions)
    return replace(scene, title="-", seed=0, regions=regions)
