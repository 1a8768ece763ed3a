"""Plain float64 NumPy geometry of regions, written apart from `scenes.margins`."""

import math
from itertools import product

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from scenes import Region, Scene

AXIS = np.linspace(-5.0, 5.0, 101)  # [m] nodes of the planning grid on each axis
NODES = np.stack(np.meshgrid(AXIS, AXIS, indexing="ij"), -1)  # [101, 101, 2]
AXES = {
    "linear": (AXIS, AXIS),
    "unicycle": (AXIS, AXIS),
    "panda": (np.arange(0.1, 0.88, 0.03), np.arange(-0.69, 0.7, 0.03), np.arange(0, 1.0, 0.03)),
    "ant": (np.linspace(-3, 3, 61), np.linspace(-3, 3, 61)),
    "quadrotor": (np.linspace(-5, 5, 41), np.linspace(-5, 5, 41), np.linspace(0, 5, 21)),
}
"""Nodes in [m] of each robot's planning grid on each axis, equally spaced."""
STEPS = {
    2: [(1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2)],
    3: [
        step
        for step in product((-2, -1, 0, 1, 2), repeat=3)
        if step > (0, 0, 0) and math.gcd(*step) == 1 and sum(map(abs, step)) <= 3
    ],
}
"""Half of a node's neighbours, by dimension."""


def margin(region: Region, point) -> float:
    """Signed Euclidean distance in [m] from a point [d] to the boundary, case by case."""
    offset = [abs(p - c) for p, c in zip(point, region.center, strict=True)]
    match region.kind:
        case "circle" | "sphere":
            return region.size[0] - math.hypot(*offset)
        case "rectangle" | "box":
            return _block(offset, region.size)
        case "cylinder":
            return _block([math.hypot(*offset[:2]), offset[2]], region.size)
    raise AssertionError(region.kind)


def margins_table(scene: Scene, points) -> np.ndarray:
    """Margins [..., A] in [m] of a scene's regions at points [..., d], vectorised."""
    return np.stack([margins_of(region, points) for region in scene.regions], -1)


def margins_of(region: Region, points) -> np.ndarray:
    """Margins [...] in [m] of one region at points [..., d]."""
    offset = np.asarray(points, float) - region.center
    if region.kind in ("circle", "sphere"):
        return region.size[0] - np.linalg.norm(offset, axis=-1)
    if region.kind == "cylinder":
        offset = np.stack([np.linalg.norm(offset[..., :2], axis=-1), offset[..., 2]], -1)
    excess = np.abs(offset) - region.size
    outside = np.linalg.norm(np.maximum(excess, 0.0), axis=-1)
    return -outside - np.minimum(excess.max(-1), 0.0)


def separation(first: Region, second: Region) -> float:
    """Distance in [m] between regions; <= 0 when they touch or overlap.

    Exact in the plane; in space from points that are within a tenth of the first one's size.
    """
    if first.dimension == 3:
        return -float(margins_of(second, _points_of(first)).max())
    offset = np.abs(np.subtract(first.center, second.center))
    radius = 0.0
    for region in (first, second):
        if region.kind == "circle":
            radius += region.size[0]
        else:
            offset = offset - region.size
    if offset.max() <= 0:
        return float(offset.max()) - radius
    return float(np.linalg.norm(np.maximum(offset, 0.0))) - radius


def distance_from(scene: Scene, goal: str, blocked: set[str], clearance: float) -> np.ndarray:
    """Lengths [*grid] in [m] of the shortest grid paths to a goal's center.

    Nodes closer than the clearance to a blocked region are closed; 16 neighbours a node in the
    plane, 50 in space, where paths come out up to 6 % longer than they are.
    """
    names, axes = scene.region_names, AXES[scene.robot]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    table = margins_table(scene, nodes)
    columns = [names.index(name) for name in blocked]
    closed = np.any(table[..., columns] > -clearance, axis=-1)
    graph = _graph(np.asarray(closed), float(axes[0][1] - axes[0][0]))
    center = scene.regions[names.index(goal)].center
    source = int(np.argmin(np.linalg.norm(nodes - center, axis=-1)))
    return dijkstra(graph, indices=source).reshape(closed.shape)


def at(scene: Scene, field: np.ndarray, point) -> float:
    """Value of a field at the node nearest to a point [d]."""
    pairs = zip(AXES[scene.robot], point, strict=True)
    return float(field[tuple(int(np.argmin(abs(axis - value))) for axis, value in pairs)])


def _points_of(region: Region) -> np.ndarray:
    """Points [P, 3] of a region of space, its poles and edges included."""
    half = np.resize(region.size, 3)
    if region.kind == "cylinder":
        half = np.array([region.size[0], region.size[0], region.size[1]])
    unit = np.stack(np.meshgrid(*[np.linspace(-1, 1, 21)] * 3, indexing="ij"), -1).reshape(-1, 3)
    points = np.asarray(region.center) + unit * half
    return points[margins_of(region, points) >= -1e-9]


def _block(offset, size) -> float:
    excess = [o - s for o, s in zip(offset, size, strict=True)]
    if max(excess) <= 0:
        return -max(excess)
    return -math.hypot(*(max(e, 0.0) for e in excess))


def _graph(closed: np.ndarray, spacing: float):
    index = np.arange(closed.size).reshape(closed.shape)
    rows, columns, lengths = [], [], []
    for step in STEPS[closed.ndim]:
        sizes = list(zip(step, closed.shape, strict=True))
        here = tuple(slice(max(0, -d), n - max(0, d)) for d, n in sizes)
        there = tuple(slice(max(0, d), n - max(0, -d)) for d, n in sizes)
        free = ~(closed[here] | closed[there])
        rows.append(index[here][free])
        columns.append(index[there][free])
        lengths.append(np.full(rows[-1].size, math.hypot(*step) * spacing))
    entries = (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns)))
    graph = coo_matrix(entries, shape=(closed.size, closed.size))
    return (graph + graph.T).tocsr()
