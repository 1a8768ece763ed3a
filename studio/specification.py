"""A scene with the formula as it stands in the editor, judged."""

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
        scene: the scene; its formula is the one it was loaded with.
        text: the formula as typed.
        task: the grounded task of `text`, or of the last text that was right; None before one.
        error: why `text` cannot be used, empty if it can.
    """

    scene: Scene
    text: str
    task: Task | None
    error: str = ""

    @property
    def decomposition(self) -> Decomposition | None:
        """Of the formula that was right last."""
        return None if self.task is None else self.task.grounding.decomposition


def specify(scene: Scene, text: str | None = None) -> Specification:
    """Judge a formula over a scene, the scene's own if none is given."""
    text = scene.formula if text is None else text
    return edited(Specification(scene, text, None), text)


def edited(specification: Specification, text: str) -> Specification:
    """The same scene with another formula; where that is wrong, the last right task stays."""
    try:
        task = build_task(specification.scene, text)
    except UserError as error:
        return replace(specification, text=text, error=str(error))
    return replace(specification, text=text, task=task, error="")
