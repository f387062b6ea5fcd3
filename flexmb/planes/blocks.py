"""Blocks of quadrilaterals between two curves, joined into one mesh of any kind of cells."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from flexmb.errors import InputError
from flexmb.planes.cell_kinds import KINDS
from flexmb.planes.mesh import PlaneMesh

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Curve = Callable[[Array], Array]
"""Function of numbers s (n,) from 0 to 1 that returns the points of a curve (n, 2) [m]."""

SAME_PLACE = 1e-7
"""Distance over the size of the mesh [1] below which nodes of two blocks are one."""


MOST_NODES = 4_000_000
"""Largest number of nodes of a block; more is a length in millimetres or a slip of the size."""


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
        found: Array = c + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return found

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
    cells = _as_kind(points[_first_of(nodes)], cells, kind)
    used, numbers = np.unique(cells, return_inverse=True)
    return PlaneMesh(points[_first_of(nodes)][used], numbers.reshape(cells.shape), kind, name=name)


def with_sets(mesh: PlaneMesh, sets: dict[str, npt.NDArray[np.bool_]]) -> PlaneMesh:
    """The mesh with named sets, given as one truth value a node each."""
    chosen = {name: np.flatnonzero(inside) for name, inside in sets.items()}
    return PlaneMesh(mesh.points, mesh.cells, mesh.kind, chosen, mesh.regions, mesh.name)


def on_circle(points: Array, centre: Sequence[float], radius: float) -> npt.NDArray[np.bool_]:
    """Whether points lie on a circle."""
    near: npt.NDArray[np.bool_] = np.abs(np.linalg.norm(points - np.asarray(centre), axis=1) - radius) < 1e-6 * radius
    return near


def _merged(points: Array) -> Indices:
    """Number of the node of each point; points at the same place are one node."""
    reach = SAME_PLACE * float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    labels = connected_components(links, directed=False)[1]
    found: Indices = labels.astype(np.int64)
    return found


def _first_of(nodes: Indices) -> Indices:
    """First point of each node."""
    return np.unique(nodes, return_index=True)[1]


def _cells_of(grid: Array) -> Indices:
    """Nodes of the cells (m, 9) of a grid, counter-clockwise."""
    rows, columns = grid.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    places = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
    if _turns_left(grid):
        places = [(j, i) for i, j in places]
    cells = [number[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i, j in places]
    return np.stack(cells, axis=1)


def _turns_left(grid: Array) -> bool:
    """Whether the first index turns counter-clockwise into the second one."""
    down, right = grid[2, 0] - grid[0, 0], grid[0, 2] - grid[0, 0]
    return bool(down[0] * right[1] - down[1] * right[0] > 0.0)


def _as_kind(points: Array, cells: Indices, kind: str) -> Indices:
    """Cells of nine nodes as cells of another kind."""
    return cells[:, : KINDS[kind].nodes] if kind.startswith("quad") else halved(points, cells, kind)


def halved(points: Array, cells: Indices, kind: str) -> Indices:
    """Triangles of quadrilaterals, halved along their shorter diagonals: the first halves, then the second ones.

    Nodes are (n, 2) [m], quadrilaterals (m, 4) for "tri3" or (m, 9) for "tri6".
    """
    corner = points[cells[:, :4]]
    diagonals = np.linalg.norm(corner[:, :2] - corner[:, 2:], axis=2)
    other = diagonals[:, 1] < (1.0 - 1e-6) * diagonals[:, 0]
    turns = [1, 2, 3, 0, 5, 6, 7, 4, 8][: cells.shape[1]]
    turned = np.where(other[:, None], cells[:, turns], cells)
    n = KINDS[kind].nodes
    return np.concatenate([turned[:, [0, 1, 2, 4, 5, 8][:n]], turned[:, [0, 2, 3, 8, 6, 7][:n]]])
