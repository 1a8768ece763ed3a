"""The formula of a scene, read with its robot's time step, its regions and its horizon."""

from functools import lru_cache

from core.stl import Formula, Reading, read
from scenes.scene import Scene, robot_of


def scene_formula(scene: Scene) -> Formula:
    """The syntax tree of a scene's formula.

    Raises:
        FormulaError: with the place in the text.
    """
    return scene_reading(scene).formula


def scene_reading(scene: Scene) -> Reading:
    """The same with notes on what the text left open."""
    return _read(scene.formula, robot_of(scene).dt, scene.region_names, scene.horizon)


@lru_cache(maxsize=32)
def _read(text: str, dt: float, names: tuple[str, ...], horizon: int) -> Reading:
    """Kept, since a scene is read anew whenever one of its regions is moved."""
    return read(text, dt=dt, names=names, horizon=horizon)
