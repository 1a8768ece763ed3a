"""Which edits of a scene make a trained policy stale.

Training depends on the robot, the formula, the shapes of the regions that the formula names, the
initial set, the arena and the length of an episode. It does not depend on titles, colours, regions
that the formula does not name, the spelling of the formula, or the names of regions; the seed only
decides which of many equally good trainings is run.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

from core.errors import UserError
from core.stl import Atom, Formula, atom_names, children, horizon, quote_name, with_children
from scenes import Region, Scene, scene_formula, workspace_of
from scenes.arena import Arena

Shape = Region
"""A region without its name and colour."""


@dataclass(frozen=True)
class Meaning:
    """Everything in a scene that training depends on.

    Attributes:
        robot: its name and variant.
        formula: the formula over `0`, `1`, ... instead of names; its text if it cannot be read.
        steps: of an episode, max(T, horizon of the formula).
        shapes: of the regions that the formula names, in the order of first appearance, and the
            texts of predicates; of all, if it cannot be parsed.
        initial: shape of the initial set.
        arena: where ways are planned, (low, high) of each axis [m].
        names: of the regions in `shapes`.
        between_steps: whether invariants must hold between the steps.
        names: of the regions and predicates in `shapes`.
    """

    robot: tuple[str, str]
    formula: Formula | str
    steps: int
    shapes: tuple[Shape | str, ...]
    initial: Shape
    arena: Arena
    between_steps: bool
    names: tuple[str, ...] = field(compare=False)


@lru_cache(maxsize=64)
def meaning(scene: Scene) -> Meaning:
    """Extract what training depends on."""
    names = scene.atom_names
    shapes: dict[str, Shape | str] = {region.name: _shape(region) for region in scene.regions}
    shapes |= {predicate.name: predicate.text for predicate in scene.predicates}
    try:
        read = scene_formula(scene)
    except UserError:
        formula, used, steps = scene.formula, names, scene.horizon
    else:
        used, steps = atom_names(read), max(scene.horizon, horizon(read))
        formula = _numbered(read, {name: str(index) for index, name in enumerate(used)})
    found = tuple(shapes[name] for name in used)
    robot, arena, initial = (scene.robot, scene.variant), workspace_of(scene).arena, scene.initial
    return Meaning(robot, formula, steps, found, _shape(initial), arena, scene.between_steps, used)


def differences(trained: Scene, scene: Scene) -> tuple[str, ...]:
    """What makes a training on one scene stale for another; empty if it is not stale.

    Returns:
        Noun phrases, such as `the formula`, `region A1`, `the initial set`.
    """
    then, now = meaning(trained), meaning(scene)
    found = []
    if then.robot != now.robot:
        found.append("the robot")
    if then.formula != now.formula:
        # Operators without an upper bound reach to the horizon.
        same = trained.formula == scene.formula and trained.horizon != scene.horizon
        found.append("the horizon" if same else "the formula")
    else:
        if then.steps != now.steps:
            found.append("the horizon")
        pairs = zip(now.names, then.shapes, now.shapes, strict=False)
        found += [
            f"{'predicate' if isinstance(new, str) else 'region'} {quote_name(name)}"
            for name, old, new in pairs
            if old != new
        ]
    if then.initial != now.initial:
        found.append("the initial set")
    if then.arena != now.arena:
        found.append("the arena")
    if then.between_steps != now.between_steps:
        found.append("what counts between the steps")
    if then != now and not found:
        found.append("the regions")
    return tuple(found)


def stale_text(reasons: tuple[str, ...]) -> str:
    """The `differences` as a sentence; empty for none."""
    if not reasons:
        return ""
    *rest, last = reasons
    subject = f"{', '.join(rest)} and {last}" if rest else last
    verb = "have" if rest or last.endswith("regions") else "has"
    return f"Stale: {subject} {verb} changed since training. Train again or undo."


def _numbered(formula: Formula, numbers: dict[str, str]) -> Formula:
    if isinstance(formula, Atom):
        return Atom(numbers[formula.name])
    return with_children(formula, tuple(_numbered(part, numbers) for part in children(formula)))


def _shape(region: Region) -> Shape:
    return replace(region, name="shape", color=None)
