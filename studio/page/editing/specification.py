"""A scene with the verdict on its formula."""

from dataclasses import dataclass, replace

from core.decompose import Decomposition
from core.errors import UserError
from core.task.feasibility import Finding
from core.task.task import Task
from scenes import Scene
from studio.runs.tasks import build_task


@dataclass(frozen=True, eq=False)
class Specification:
    """A judged scene.

    Attributes:
        scene: the scene that was judged.
        task: the grounded task, or that of the last valid scene; None before the first.
        error: why the scene's formula cannot be used, empty if it can.
        findings: what stands in the way of the scene's mission.
    """

    scene: Scene
    task: Task | None
    error: str = ""
    findings: tuple[Finding, ...] = ()

    @property
    def text(self) -> str:
        """The formula that was judged."""
        return self.scene.formula

    @property
    def decomposition(self) -> Decomposition | None:
        """Of the last valid formula."""
        return None if self.task is None else self.task.grounding.decomposition


def specify(scene: Scene, text: str | None = None) -> Specification:
    """Judge a formula over a scene, by default the scene's own."""
    return edited(Specification(scene, None), scene if text is None else with_text(scene, text))


def edited(specification: Specification, scene: Scene) -> Specification:
    """Judge an edited scene; if its formula is invalid, the last task stays."""
    if specification.task is not None and same_task(specification, scene):
        return replace(specification, scene=scene)
    try:
        task = build_task(scene)
    except UserError as error:
        return replace(specification, scene=scene, error=str(error), findings=())
    return Specification(scene, task, findings=task.findings)


def with_text(scene: Scene, text: str) -> Scene:
    """The same scene with another formula."""
    return replace(scene, formula=text)


def same_task(specification: Specification, scene: Scene) -> bool:
    """Whether only the appearance of the scene has changed."""
    return not specification.error and _plain(specification.scene) == _plain(scene)


def _plain(scene: Scene) -> Scene:
    regions = tuple(replace(region, color=None) for region in scene.regions)
    return replace(scene, title="-", seed=0, regions=regions)
