"""Regions as linear programs know them: signed distances between maxima of affine functions.

With sd the signed distance to a region's boundary (negative inside), an outline promises

    lower(p) <= sd(p) <= upper(p),    each of the form max over its facets of n . p - o,

at every position p. A box is exact but where it is passed diagonally at a corner; a ball is
bounded by polygons around and in it. Wanted and avoided regions take different sides of it:

    inner: whoever keeps to it has at least the robustness that it promises;
    outer: it promises at least the robustness that anybody has.

Dimensions: F facets, d position.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Facets(NamedTuple):
    """The function max over facets of n . p - o."""

    normals: np.ndarray  # [F, d]
    offsets: np.ndarray  # [F] [m]

    def values(self, position: np.ndarray) -> np.ndarray:
        """Of every facet at a position [d]: [F] [m]."""
        return self.normals @ position - self.offsets

    def least(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Least values [F] of the facets in a box with corners [d]."""
        return np.minimum(self.normals * low, self.normals * high).sum(1) - self.offsets

    def most(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Largest values [F] of the facets in a box with corners [d]."""
        return np.maximum(self.normals * low, self.normals * high).sum(1) - self.offsets


@dataclass(frozen=True, eq=False)
class Outline:
    """Bounds on the signed distance to a region's boundary."""

    lower: Facets
    upper: Facets

    @property
    def inner(self) -> "Sides":
        """What promises no more than it keeps."""
        return Sides(self.upper, self.lower)

    @property
    def outer(self) -> "Sides":
        """What promises no less than anybody can have."""
        return Sides(self.lower, self.upper)


class Sides(NamedTuple):
    """What stands for a region where it is wanted: all facets, and where it is avoided: one."""

    wanted: Facets
    avoided: Facets
