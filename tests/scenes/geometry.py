"""Plain float64 NumPy geometry of regions, written apart from `scenes.margins`."""

import math

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from scenes import Region, Scene

AXIS = np.linspace(-5.0, 5.0, 101)  # [m] nodes of the planning grid on each axis
NODES = np.stack(np.meshgrid(AXIS, AXIS, indexing="ij"), -1)  # [101, 101, 2]


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
    """Margins [..., A] in [m] of planar regions at points [..., 2], vectorised."""
    columns = []
    for region in scene.regions:
        offset = np.asarray(points, float) - region.center
        if region.kind == "circle":
            columns.append(region.size[0] - np.linalg.norm(offset, axis=-1))
            continue
        excess = np.abs(offset) - region.size
        outside = np.linalg.norm(np.maximum(excess, 0.0), axis=-1)
        columns.append(-outside - np.minimum(excess.max(-1), 0.0))
    return np.stack(columns, -1)


def separation(first: Region, second: Region) -> float:
    """Distance in [m] between planar regions; <= 0 when they touch or overlap."""
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
    """Lengths [101, 101] in [m] of the shortest grid paths to a goal's center.

    Nodes closer than the clearance to a blocked region are closed; sixteen neighbours a node.
    """
    names = scene.region_names
    table = margins_table(scene, NODES)
    columns = [names.index(name) for name in blocked]
    closed = np.any(table[..., columns] > -clearance, axis=-1)
    graph = _graph(np.asarray(closed))
    center = scene.regions[names.index(goal)].center
    source = int(np.argmin(np.linalg.norm(NODES - center, axis=-1)))
    return dijkstra(graph, indices=source).reshape(NODES.shape[:2])


def at(field: np.ndarray, point) -> float:
    """Value of a field on `NODES` at the node nearest to a point [2]."""
    column, row = (int(np.argmin(abs(AXIS - value))) for value in point)
    return float(field[column, row])


def _block(offset, size) -> float:
    excess = [o - s for o, s in zip(offset, size, strict=True)]
    if max(excess) <= 0:
        return -max(excess)
    return -math.hypot(*(max(e, 0.0) for e in excess))


def _graph(closed: np.ndarray):
    count = closed.shape[0]
    index = np.arange(closed.size).reshape(NODES.shape[:2])
    rows, columns, lengths = [], [], []
    for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2)):
        here = (slice(0, count - dx), slice(max(0, -dy), count - max(0, dy)))
        there = (slice(dx, count), slice(max(0, dy), count + min(0, dy)))
        free = ~(closed[here] | closed[there])
        rows.append(index[here][free])
        columns.append(index[there][free])
        lengths.append(np.full(rows[-1].size, math.hypot(dx, dy) * (AXIS[1] - AXIS[0])))
    entries = (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns)))
    graph = coo_matrix(entries, shape=(closed.size, closed.size))
    return (graph + graph.T).tocsr()
