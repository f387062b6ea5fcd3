"""Fillings of outlines with cells: triangles between even boundary nodes, blocks of quadrilaterals.

An edge is one of Delaunay's triangulation when no other node lies in the circle around it.  Nodes of the lattice keep
clear of the boundary, so the boundary is met unless two parts of it are closer than the cells are long, which is
refused.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, cKDTree

from flexmb.elastic.meshes.cell_kinds import KINDS
from flexmb.elastic.meshes.mesh import PlaneMesh
from flexmb.errors import InputError
from flexmb.planar import Array, Indices

# Blocks of quadrilaterals between two curves, joined into one mesh of any kind of cells

Curve = Callable[[Array], Array]  # function of numbers s (n,) from 0 to 1 that returns points of a curve (n, 2) [m]
SAME_PLACE = 1e-7  # distance over the size of the mesh [1] below which nodes of two blocks are one
MOST_NODES = 4_000_000  # largest number of nodes of a block; more is a length in millimetres or a slip of the size


def require_few(nodes: float) -> None:
    """Refuse a block of more nodes than `MOST_NODES`."""
    if not nodes <= MOST_NODES:
        raise InputError(f"meshes: a block would have {nodes:.3g} nodes. Take larger cells; all lengths are in m.")


def segment(start: Sequence[float], end: Sequence[float]) -> Curve:
    """A straight line between two points [m]."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    return lambda s: a + s[:, None] * (b - a)


def arc(centre: Sequence[float], radius: float, start: float, end: float) -> Curve:
    """An arc of a circle with this centre and radius [m] between two angles [rad]."""
    c = np.asarray(centre, dtype=float)

    def points(s: Array) -> Array:
        angle = start + s * (end - start)
        return np.asarray(c + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))

    return points


def sampled(curves: Sequence[Curve], counts: Sequence[int]) -> Array:
    """Nodes (2 n + 1, 2) of quadratic edges along curves that follow each other, n the sum of the counts."""
    require_few(2.0 * sum(counts))
    pieces = [curve(np.arange(2 * n) / (2 * n)) for curve, n in zip(curves, counts, strict=True)]
    return np.concatenate([*pieces, curves[-1](np.ones(1))])


def cells_along(length: float, size: float) -> int:
    """Number of cells of about a size along a length, 1 at least."""
    require_few(length / size)
    return max(1, math.ceil(length / size - 1e-9))


def ruled(first: Array, last: Array, count: int) -> Array:
    """Grid (2 count + 1, 2 n + 1, 2) of nodes on straight lines between the nodes of two curves (2 n + 1, 2)."""
    require_few(2.0 * count * len(first))
    t = (np.arange(2 * count + 1) / (2 * count))[:, None, None]
    return (1.0 - t) * first + t * last


def joined(grids: Sequence[Array], kind: str, name: str) -> PlaneMesh:
    """One mesh of blocks given as grids of nodes (2 i + 1, 2 j + 1, 2) [m], which meet in nodes at the same places."""
    points = np.concatenate([grid.reshape(-1, 2) for grid in grids])
    starts = np.cumsum([0, *(grid.shape[0] * grid.shape[1] for grid in grids)])
    nodes = _merged(points)
    cells = np.concatenate([nodes[_cells_of(grid) + start] for grid, start in zip(grids, starts[:-1], strict=True)])
    quads = kind.startswith("quad")
    cells = cells[:, : KINDS[kind].nodes] if quads else halved(points[_first_of(nodes)], cells, kind)
    used, numbers = np.unique(cells, return_inverse=True)
    return PlaneMesh(points[_first_of(nodes)][used], numbers.reshape(cells.shape), kind, name=name)


def with_sets(mesh: PlaneMesh, sets: dict[str, npt.NDArray[np.bool_]]) -> PlaneMesh:
    """The mesh with named sets, given as one truth value a node each."""
    chosen = {name: np.flatnonzero(inside) for name, inside in sets.items()}
    return PlaneMesh(mesh.points, mesh.cells, mesh.kind, chosen, mesh.regions, mesh.name)


def on_circle(points: Array, centre: Sequence[float], radius: float) -> npt.NDArray[np.bool_]:
    """Whether points lie on a circle."""
    return np.asarray(np.abs(np.linalg.norm(points - np.asarray(centre), axis=1) - radius) < 1e-6 * radius)


def _merged(points: Array) -> Indices:
    """Number of the node of each point; points at the same place are one node."""
    reach = SAME_PLACE * float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    labels = connected_components(links, directed=False)[1]
    return np.asarray(labels.astype(np.int64))


def _first_of(nodes: Indices) -> Indices:
    """First point of each node."""
    return np.unique(nodes, return_index=True)[1]


def _cells_of(grid: Array) -> Indices:
    """Nodes of the cells (m, 9) of a grid, counter-clockwise."""
    rows, columns = grid.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    places = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
    down, right = grid[2, 0] - grid[0, 0], grid[0, 2] - grid[0, 0]
    if down[0] * right[1] - down[1] * right[0] > 0.0:  # the first index turns counter-clockwise into the second one
        places = [(j, i) for i, j in places]
    cells = [number[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i, j in places]
    return np.stack(cells, axis=1)


def halved(points: Array, cells: Indices, kind: str) -> Indices:
    """Triangles of quadrilaterals by their shorter diagonals: first halves, then second ones; nodes (n, 2) [m]."""
    corner = points[cells[:, :4]]
    diagonals = np.linalg.norm(corner[:, :2] - corner[:, 2:], axis=2)
    other = diagonals[:, 1] < (1.0 - 1e-6) * diagonals[:, 0]
    turns = [1, 2, 3, 0, 5, 6, 7, 4, 8][: cells.shape[1]]
    turned = np.where(other[:, None], cells[:, turns], cells)
    n = KINDS[kind].nodes
    return np.concatenate([turned[:, [0, 1, 2, 4, 5, 8][:n]], turned[:, [0, 2, 3, 8, 6, 7][:n]]])


CLEAR = 0.7  # distance of the lattice from the boundary over the size of the cells [1]
STRETCHED = 0.85  # third side of a triangle over the two on the boundary [1], above which these are nearly one line
ROUNDS = 12  # number of rounds of smoothing
FLAT = 1e-6  # area of a triangle over the median one [1] up to which it is round-off
FEWEST = 12  # least number of nodes on a hole


@dataclass(frozen=True, eq=False)
class Shape:
    """A polygon (n, 2) with round holes (x, y, radius) [m] by name."""

    label: str
    corners: Array
    holes: Mapping[str, tuple[float, float, float]]

    def contains(self, points: Array) -> npt.NDArray[np.bool_]:
        """Whether points (p, 2) lie in the polygon and in none of the holes."""
        inside = np.zeros(len(points), dtype=bool)
        x, y = points.T
        for (x0, y0), (x1, y1) in zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True):
            if y0 != y1:
                inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        for cx, cy, radius in self.holes.values():
            inside &= np.hypot(x - cx, y - cy) > radius
        return inside

    def loops(self, size: float) -> list[Array]:
        """Nodes of the outline, then of each hole, about `size` apart [m]."""
        sides = zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True)
        outline = [np.linspace(a, b, max(1, round(np.linalg.norm(b - a) / size)), endpoint=False) for a, b in sides]
        loops = [np.concatenate(outline)]
        for cx, cy, radius in self.holes.values():
            angle = np.linspace(0.0, 2.0 * np.pi, max(FEWEST, round(2.0 * np.pi * radius / size)), endpoint=False)
            loops.append(np.array([cx, cy]) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        return loops


def triangles(shape: Shape, size: float) -> tuple[Array, Indices, dict[str, Indices]]:
    """Nodes (n, 2), triangles (m, 3) of about `size` [m], nodes of each hole; too narrow boundaries are refused."""
    extent = np.ptp(shape.corners, axis=0)
    require_few(float((extent[0] / size + 1.0) * (extent[1] / size + 1.0)))
    loops = shape.loops(size)
    fixed = np.concatenate(loops)
    starts = np.cumsum([0, *map(len, loops)])
    rings = [first + np.arange(len(loop)) for first, loop in zip(starts[:-1], loops, strict=True)]
    edges = np.concatenate([np.stack([ring, np.roll(ring, -1)], axis=1) for ring in rings])
    points = np.concatenate([fixed, _lattice(shape, fixed, edges, size)])
    points = np.concatenate([points, _behind_bends(points, _inside(shape, points), edges)])
    for _ in range(ROUNDS):
        cells = _inside(shape, points)
        points = _smoothed(points, cells, len(fixed), fixed, edges)
    cells = _inside(shape, points)
    _require_boundary(shape, points, cells, edges)
    holes = {name: np.arange(starts[k], starts[k + 1]) for k, name in enumerate(shape.holes, start=1)}
    return points, cells, holes


def _lattice(shape: Shape, fixed: Array, edges: Indices, size: float) -> Array:
    """Nodes of a lattice of equal triangles that lie inside and clear of the boundary."""
    low, high = fixed.min(axis=0), fixed.max(axis=0)
    rows = np.arange(low[1], high[1], size * np.sqrt(0.75))
    columns = np.arange(low[0] - size, high[0] + size, size)
    x = columns + 0.5 * size * (np.arange(len(rows)) % 2)[:, None]
    points = np.stack([x, np.broadcast_to(rows[:, None], x.shape)], axis=2).reshape(-1, 2)
    points = points[shape.contains(points)]
    return points[_is_clear(points, fixed, edges)]


def _behind_bends(points: Array, cells: Indices, edges: Indices) -> Array:
    """Nodes inside, for triangles with two boundary edges that are nearly one line: on an arc they would be flat."""
    ahead = np.full(len(points), -1)
    ahead[edges[:, 0]] = edges[:, 1]
    turned = np.concatenate([np.roll(cells, -k, axis=1) for k in range(3)])
    a, b, c = points[turned].transpose(1, 0, 2)
    lengths = np.linalg.norm(b - a, axis=1) + np.linalg.norm(c - b, axis=1)
    along = np.linalg.norm(c - a, axis=1) > STRETCHED * lengths
    bent = along & (ahead[turned[:, 0]] == turned[:, 1]) & (ahead[turned[:, 1]] == turned[:, 2])
    chord = (c - a)[bent]
    inwards = np.stack([-chord[:, 1], chord[:, 0]], axis=1) / np.linalg.norm(chord, axis=1)[:, None]
    return np.asarray(b[bent] + 0.5 * lengths[bent, None] * inwards)


def _is_clear(points: Array, fixed: Array, edges: Indices) -> npt.NDArray[np.bool_]:
    """Whether points are far enough from the nodes and from the middles of boundary edges."""
    ends = fixed[edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    near, of = cKDTree(ends.mean(axis=1)).query(points)
    return np.asarray(near > CLEAR * lengths[of])


def _smoothed(points: Array, cells: Indices, held: int, fixed: Array, edges: Indices) -> Array:
    """Points (n, 2) with inner ones at the mean of their neighbours, unless this is near the boundary."""
    total, counts = np.zeros_like(points), np.zeros(len(points))
    for a, b in ((0, 1), (1, 2), (2, 0)):
        for first, second in ((a, b), (b, a)):
            np.add.at(total, cells[:, first], points[cells[:, second]])
            np.add.at(counts, cells[:, first], 1.0)
    moved = points.copy()
    new = total[held:] / np.maximum(counts[held:], 1.0)[:, None]
    good = (counts[held:] > 0.0) & _is_clear(new, fixed, edges)
    moved[held:][good] = new[good]
    return moved


def _inside(shape: Shape, points: Array) -> Indices:
    """Triangles of Delaunay whose centres lie inside, counter-clockwise."""
    cells: Indices = Delaunay(points).simplices.astype(np.int64)
    cells = cells[shape.contains(points[cells].mean(axis=1))]
    a, b = points[cells[:, 1]] - points[cells[:, 0]], points[cells[:, 2]] - points[cells[:, 0]]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    cells[area < 0.0] = cells[area < 0.0][:, [0, 2, 1]]
    # three nodes on one side of the outline may span a cell by round-off
    return np.asarray(cells[np.abs(area) > FLAT * np.median(np.abs(area))])


def _require_boundary(shape: Shape, points: Array, cells: Indices, edges: Indices) -> None:
    """Refuse a triangulation that misses an edge of the boundary."""
    sides = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1) @ np.array([len(points), 1])
    missing = ~np.isin(np.sort(edges, axis=1) @ np.array([len(points), 1]), sides)
    if missing.any():
        x, y = points[edges[missing][0]].mean(axis=0)
        text = f"{shape.label}: the boundary is narrow at ({x:.4g}, {y:.4g}) m for cells of this size"
        raise InputError(f"{text}. Take a smaller size, or move holes away from each other and from the outline.")


def require_apart(label: str, shape: Shape, names: Sequence[str]) -> None:
    """Refuse holes that lie outside, cross the outline, or overlap."""
    for k, name in enumerate(names):
        x, y, radius = shape.holes[name]
        angle = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)
        rim = np.array([x, y]) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if not Shape(label, shape.corners, {}).contains(rim).all():
            raise InputError(f"{label}: hole {name!r} does not lie inside of the outline. Move it, or make it smaller.")
        for other in names[:k]:
            ox, oy, size = shape.holes[other]
            if np.hypot(x - ox, y - oy) <= radius + size:
                raise InputError(f"{label}: holes {other!r} and {name!r} overlap. Move them apart.")
