"""`--explain`: how a formula is read, without planning or training."""

from core.decompose import to_text
from core.stl import sentences
from core.stl import to_text as formula_text
from scenes import Scene, robot_of, scene_reading
from studio.options import Options
from studio.runs.commands import chosen_scene
from studio.runs.tasks import decompose_scene


def explain(options: Options) -> int:
    """Print the formula, its sentences in English and its tasks; returns the exit status.

    Raises:
        UserError: no such task, or a formula that cannot be read or does not decompose.
    """
    scene = chosen_scene(options)
    print("\n".join(_lines(scene)))
    print()
    print(to_text(decompose_scene(scene)), flush=True)
    return 0


def _lines(scene: Scene) -> list[str]:
    formula = scene_reading(scene).formula
    return [formula_text(formula), "", *sentences(formula, robot_of(scene).dt)]
