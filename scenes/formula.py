"""The formula of a scene, read with its robot's time step, its regions and its horizon."""

from functools import lru_cache

from core.stl import Formula, Reading, read, with_predicates
from scenes.scene import Scene, robot_of


def scene_formula(scene: Scene) -> Formula:
    """The syntax tree of a scene's formula.

    Raises:
        FormulaError: with the place in the text.
    """
    return scene_reading(scene).formula


def scene_reading(scene: Scene) -> Reading:
    """The same with notes on what the text left open."""
    predicates = frozenset(predicate.name for predicate in scene.predicates)
    dt = robot_of(scene).dt
    return _read(scene.formula, dt, scene.atom_names, scene.horizon, predicates)


@lru_cache(maxsize=32)
def _read(
    text: str, dt: float, names: tuple[str, ...], horizon: int, predicates: frozenset[str]
) -> Reading:
    """Kept, since a scene is read anew whenever one of its regions is moved."""
    found = read(text, dt=dt, names=names, horizon=horizon)
    if not predicates:
        return found
    return found._replace(formula=with_predicates(found.formula, predicates))
