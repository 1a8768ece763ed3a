"""The formula of a scene, read with its robot's time step, its regions and its horizon."""

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
    dt = robot_of(scene).dt
    return read(scene.formula, dt=dt, names=scene.region_names, horizon=scene.horizon)
