"""Colours of the tree's leaves as a style sheet: what a rollout has met and violated so far."""

import numpy as np

from core.decompose import Decomposition
from core.monitor import LeafStatus
from studio.page.figures.tree import leaf_id, leaves
from studio.theme import BAD, GOOD, themed

GOOD_INK, BAD_INK = themed("good", GOOD), themed("bad", BAD)
STYLES = {
    LeafStatus.INACTIVE: ("", "", "opacity:0.35"),
    LeafStatus.PENDING: ("", "", ""),
    LeafStatus.HOLDING: (themed("holding", "#ebfbee"), GOOD_INK, "stroke-dasharray:3 2"),
    LeafStatus.MET: (themed("met", "#b2f2bb"), GOOD_INK, ""),
    LeafStatus.VIOLATED: (themed("violated", "#ffc9c9"), BAD_INK, ""),
}
"""Background, ink and further style of a leaf."""


def leaf_style(decomposition: Decomposition, status: np.ndarray) -> str:
    """Style sheet for the leaves under the statuses [K] of the tasks.

    A leaf of several tasks is violated as soon as one of them is, and met when all are.
    """
    rules = "".join(
        _rule(leaf_id(tasks), joint_status([LeafStatus(status[task]) for task in tasks]))
        for tasks in leaves(decomposition)
    )
    return f"<style>{rules}</style>" if rules else ""


def joint_status(statuses: list[LeafStatus]) -> LeafStatus:
    """Status of several tasks as one."""
    if LeafStatus.VIOLATED in statuses:
        return LeafStatus.VIOLATED
    return min(statuses)


def _rule(leaf: str, status: LeafStatus) -> str:
    fill, ink, more = STYLES[status]
    name = f'.tg-leaf[data-tasks="{leaf}"]'
    box = f"fill:{fill} !important;stroke:{ink} !important;stroke-opacity:1;" if fill else ""
    text = f"{name} .tg-leaf-name{{fill:{ink} !important}}" if ink else ""
    return f"{name} rect{{{box}{more}}}{text}" if box or more else ""
