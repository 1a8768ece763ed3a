"""Random missions for any robot: scenes from named families, formulas along random plans."""

from scenes.missions.draw import draw
from scenes.missions.families import (
    FAMILIES,
    HELD_OUT,
    SHIPPED_HELD_OUT,
    SHIPPED_TRAINED,
    TRAINED,
)
from scenes.missions.measures import Measures, measures, mission_steps

__all__ = [
    "FAMILIES",
    "HELD_OUT",
    "SHIPPED_HELD_OUT",
    "SHIPPED_TRAINED",
    "TRAINED",
    "Measures",
    "draw",
    "measures",
    "mission_steps",
]
