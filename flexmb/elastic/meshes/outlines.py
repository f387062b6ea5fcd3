"""Meshes of common outlines, without a mesh generator: links with eyes, crank webs, plates with holes.

Outlines are filled with blocks of quadrilaterals, or with triangles between even boundary nodes.  An edge is one of
Delaunay's triangulation when no other node lies in the circle around it.  Nodes of the lattice keep clear of the
boundary, so the boundary is met unless two parts of it are closer than the cells are long, which is refused.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, cKDTree

from flexmb import checks, planar
from flexmb.elastic.meshes.mesh import KINDS, PlaneMesh
from flexmb.errors import InputError
from flexmb.planar import Array, Indices

# Blocks of quadrilaterals between two curves, joined into one mesh of any kind of cells

Curve = Callable[[Array], Array]  # function of numbers s (n,) from 0 to 1 that returns points of a curve (n, 2) [m]
SAME_NODE = 1e-7  # distance over the size of the mesh [1] below which nodes of two blocks are one
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
    # Number of the node of each point; points at the same place are one node
    pairs = cKDTree(points).query_pairs(SAME_NODE * float(np.ptp(points, axis=0).max()), output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    nodes = np.asarray(connected_components(links, directed=False)[1].astype(np.int64))
    pieces = []  # nodes (m, 9) of the cells of each grid, counter-clockwise
    for grid, start in zip(grids, starts[:-1], strict=True):
        rows, columns = grid.shape[:2]
        number = nodes[start + np.arange(rows * columns)].reshape(rows, columns)
        places = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
        down, right = grid[2, 0] - grid[0, 0], grid[0, 2] - grid[0, 0]
        if down[0] * right[1] - down[1] * right[0] > 0.0:  # the first index turns counter-clockwise into the second one
            places = [(j, i) for i, j in places]
        own = [number[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i, j in places]
        pieces.append(np.stack(own, axis=1))
    cells, points = np.concatenate(pieces), points[np.unique(nodes, return_index=True)[1]]
    cells = cells[:, : KINDS[kind].nodes] if kind.startswith("quad") else halved(points, cells, kind)
    used, numbers = np.unique(cells, return_inverse=True)
    return PlaneMesh(points[used], numbers.reshape(cells.shape), kind, name=name)


def with_sets(mesh: PlaneMesh, sets: dict[str, npt.NDArray[np.bool_]]) -> PlaneMesh:
    """The mesh with named sets, given as one truth value a node each."""
    return replace(mesh, sets={name: np.flatnonzero(inside) for name, inside in sets.items()})


def on_circle(points: Array, centre: Sequence[float], radius: float) -> npt.NDArray[np.bool_]:
    """Whether points lie on a circle."""
    return np.asarray(np.abs(np.linalg.norm(points - np.asarray(centre), axis=1) - radius) < 1e-6 * radius)


def halved(points: Array, cells: Indices, kind: str) -> Indices:
    """Triangles of quadrilaterals by their shorter diagonals: first halves, then second ones; nodes (n, 2) [m]."""
    corner = points[cells[:, :4]]
    diagonals = np.linalg.norm(corner[:, :2] - corner[:, 2:], axis=2)
    other = diagonals[:, 1] < (1.0 - 1e-6) * diagonals[:, 0]
    turns = [1, 2, 3, 0, 5, 6, 7, 4, 8][: cells.shape[1]]
    turned, n = np.where(other[:, None], cells[:, turns], cells), KINDS[kind].nodes
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
    fixed, starts = np.concatenate(loops), np.cumsum([0, *map(len, loops)])
    rings = [first + np.arange(len(loop)) for first, loop in zip(starts[:-1], loops, strict=True)]
    edges = np.concatenate([np.stack([ring, np.roll(ring, -1)], axis=1) for ring in rings])
    # Nodes of a lattice of equal triangles that lie inside and clear of the boundary
    low, high = fixed.min(axis=0), fixed.max(axis=0)
    rows = np.arange(low[1], high[1], size * np.sqrt(0.75))
    x = np.arange(low[0] - size, high[0] + size, size) + 0.5 * size * (np.arange(len(rows)) % 2)[:, None]
    points = np.stack([x, np.broadcast_to(rows[:, None], x.shape)], axis=2).reshape(-1, 2)
    points = points[shape.contains(points)]
    points = np.concatenate([fixed, points[_is_clear(points, fixed, edges)]])
    points = np.concatenate([points, _behind_bends(points, _inside(shape, points), edges)])
    for _ in range(ROUNDS):
        cells = _inside(shape, points)
        # Points (n, 2) with inner ones at the mean of their neighbours, unless this is near the boundary
        held = len(fixed)
        total, counts = np.zeros_like(points), np.zeros(len(points))
        for a, b in ((0, 1), (1, 2), (2, 0)):
            for first, second in ((a, b), (b, a)):
                np.add.at(total, cells[:, first], points[cells[:, second]])
                np.add.at(counts, cells[:, first], 1.0)
        moved, new = points.copy(), total[held:] / np.maximum(counts[held:], 1.0)[:, None]
        good = (counts[held:] > 0.0) & _is_clear(new, fixed, edges)
        moved[held:][good] = new[good]
        points = moved
    cells = _inside(shape, points)
    sides = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1) @ np.array([len(points), 1])
    missing = ~np.isin(np.sort(edges, axis=1) @ np.array([len(points), 1]), sides)
    if missing.any():
        at = points[edges[missing][0]].mean(axis=0)
        text = f"{shape.label}: the boundary is narrow at ({at[0]:.4g}, {at[1]:.4g}) m for cells of this size"
        raise InputError(f"{text}. Take a smaller size, or move holes away from each other and from the outline.")
    return points, cells, {name: np.arange(starts[k], starts[k + 1]) for k, name in enumerate(shape.holes, start=1)}


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


def _inside(shape: Shape, points: Array) -> Indices:
    """Triangles of Delaunay whose centres lie inside, counter-clockwise."""
    cells: Indices = Delaunay(points).simplices.astype(np.int64)
    cells = cells[shape.contains(points[cells].mean(axis=1))]
    a, b = points[cells[:, 1]] - points[cells[:, 0]], points[cells[:, 2]] - points[cells[:, 0]]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    cells[area < 0.0] = cells[area < 0.0][:, [0, 2, 1]]
    # three nodes on one side of the outline may span a cell by round-off
    return np.asarray(cells[np.abs(area) > FLAT * np.median(np.abs(area))])


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


FEWEST_ON_ARC = 3  # least number of edges on an arc, so its nodes show a circle
SAME_PLACE = 1e-9  # distance over the longest edge [1] below which the ends of two arcs are one point
STRAIGHT = 1e-6  # turn of the outline at a corner up to which it is straight [rad]


def checked_fillets(label: str, fillet: float | Sequence[float], corners: int) -> Array:
    """Radius of each corner [m], 0 for sharp ones; `fillet` is one radius for all corners, or one for each [m]."""
    if isinstance(fillet, str) or np.ndim(fillet) == 0:
        return np.full(corners, checks.not_negative(label, "fillet", fillet, "m"))
    radii = [checks.not_negative(label, f"fillet[{i}]", radius, "m") for i, radius in enumerate(fillet)]  # type: ignore[arg-type]
    if len(radii) != corners:
        text = f"{label}: fillet has {len(radii)} radii, the outline {corners} corners."
        raise InputError(f"{text} Give one number, or one for each corner, 0 for a sharp one.")
    return np.array(radii)


def rounded(label: str, corners: Array, radii: Array, size: float) -> tuple[Array, list[Indices]]:
    """A polygon with arcs as fine polylines in place of its corners, and the numbers of the points on each arc."""
    # Corners (n, 2) stand counter-clockwise, and radii (n,) of 0 are sharp corners [m]; edges on the arcs have `size`
    # [m] at most. The new corners (p, 2) [m] include the tangent points of arcs. Arcs that do not fit onto an edge are
    # refused.
    after, before = np.roll(corners, -1, axis=0) - corners, corners - np.roll(corners, 1, axis=0)
    lengths = np.linalg.norm(after, axis=1)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.asarray(np.arctan2(cross, (before * after).sum(axis=1)))
    tangents = radii * np.tan(0.5 * np.abs(turns))  # from the corner to where the arc begins
    ends = np.roll(tangents, -1)
    lacking = tangents + ends - lengths * (1.0 + 1e-12)
    if lacking.max() > 0.0:
        i = int(lacking.argmax())
        j, most = (i + 1) % len(radii), lengths[i] / (tangents[i] + ends[i])
        text = f"{label}: the fillets of {radii[i]:g} and {radii[j]:g} m at corners {i} and {j} take"
        text += f" {tangents[i] + ends[i]:.4g} m of the edge between them, which is {lengths[i]:.4g} m long."
        raise InputError(f"{text} Make them smaller, {most:.3g} times these radii at most.")
    points, arcs = list[Array](), list[Indices]()
    count = 0
    for corner, radius, turn, reach, way, length in zip(corners, radii, turns, tangents, after, lengths, strict=True):
        if radius == 0.0 or abs(turn) < STRAIGHT:
            piece = corner[None, :]
        else:
            ahead = way / length
            inwards = np.sign(turn) * np.array([-ahead[1], ahead[0]])
            n = max(FEWEST_ON_ARC, int(np.ceil(abs(turn) * radius / size)))
            angle = np.arctan2(-inwards[1], -inwards[0]) - turn * (1.0 - np.arange(n + 1) / n)
            around = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            piece = corner + reach * ahead + radius * inwards + around
            arcs.append(count + np.arange(len(piece)))
        points.append(piece)
        count += len(piece)
    found = np.concatenate(points)
    kept = np.linalg.norm(found - np.roll(found, 1, axis=0), axis=1) > SAME_PLACE * lengths.max()
    numbers = (np.cumsum(kept) - 1) % kept.sum()  # the first point may be the last one
    return found[kept], [numbers[arc] for arc in arcs]


Hole = tuple[tuple[float, float], float]  # centre and radius [m]


def plate_with_holes(
    outline: Sequence[tuple[float, float]], holes: Mapping[str, Hole], size: float, kind: str = "tri6",
    fillet: float | Sequence[float] = 0.0,
) -> PlaneMesh:  # fmt: skip
    """A plate with straight edges, sharp or rounded corners, and round holes, which are sets of their names.

    Parameters
    ----------
    outline : corners of the outline in order [m].
    holes : centre and radius of each hole by name [m], such as {"start": ((0.0, 0.0), 0.01)}.
    size : length of a triangle's edge [m].
    kind : "tri6", whose edges on holes and fillets are curved, or "tri3".
    fillet : radius of the arcs at all corners, or one radius for each corner; 0: sharp [m].

    Raises
    ------
    InputError : an outline with less than three corners or that crosses itself, holes that overlap or leave the
        outline, walls narrower than the triangles, fillets longer than an edge.

    Notes
    -----
    At a sharp corner that points inwards stresses grow without limit with finer meshes.  A fillet has three edges at
    least, so a small one makes small triangles.
    """
    label = "meshes.plate_with_holes"
    checks.one_of(label, "kind", kind, ("tri6", "tri3"))
    size = checks.positive(label, "size", size, "m")
    given = checks.sequence(label, "outline", outline, "corners (x, y)")
    corners = np.array([checks.point(label, f"outline[{i}]", p) for i, p in enumerate(given)], dtype=float)
    if len(corners) < 3:
        raise InputError(f"{label}: outline has {len(corners)} corners; it must have three at least.")
    radii = checked_fillets(label, fillet, len(corners))
    _require_simple(label, corners)
    if planar.area(corners) < 0.0:
        corners, radii = corners[::-1], radii[::-1]
    corners, arcs = rounded(label, corners, radii, size)
    found = {}
    for name, hole in checks.mapping(label, "holes", holes).items():
        if not isinstance(hole, tuple | list) or len(hole) != 2:
            raise InputError(f"{label}: hole {name!r} is {hole!r}; it must be ((x, y), radius).")
        x, y = checks.point(label, f"centre of {name!r}", hole[0])
        found[checks.identifier(label, name)] = (x, y, checks.positive(label, f"radius of {name!r}", hole[1], "m"))
    shape = Shape(label, corners, found)
    require_apart(label, shape, list(found))
    points, cells, sets = triangles(shape, size)
    mesh = PlaneMesh(points, cells, "tri3", sets, name="plate_with_holes")
    if kind == "tri3":
        return mesh
    where = cKDTree(points)
    bends = [where.query(corners[arc])[1] for arc in arcs]
    round_sets = {str(i): nodes for i, nodes in enumerate([*sets.values(), *bends])}
    curved = PlaneMesh(points, cells, "tri3", round_sets).to_quadratic(list(round_sets))
    own = dict(zip(sets, curved.sets.values(), strict=False))  # the fillets have no names
    return PlaneMesh(curved.points, curved.cells, curved.kind, own, name="plate_with_holes")


def _require_simple(label: str, corners: np.ndarray) -> None:
    """Refuse an outline whose edges cross."""

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    edges = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
    for i, (a, b) in enumerate(edges):
        for j, (c, d) in enumerate(edges[i + 2 : len(edges) - (i == 0)], i + 2):
            lowest = np.maximum(np.minimum(a, b), np.minimum(c, d))  # of the boxes: edges on one line may be apart
            meet = bool(np.all(lowest <= np.minimum(np.maximum(a, b), np.maximum(c, d))))
            if meet and side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0:
                raise InputError(f"{label}: edges {i} and {j} of the outline cross. Give its corners in order.")


Pair = tuple[float, float]
NARROW = math.radians(50.0)  # angle of shank and eye [rad] up to which the eye's block ends on an arc; wider: on a box
LARGEST_TURN = math.radians(20.0)  # turn of a fillet along one cell [rad]
NO_CORNER = 1e-9  # distance of shank's edge from the eye's outline over its radius [1] up to which there is no corner


def rectangle(length: float, height: float, nx: int, ny: int, kind: str = "quad9") -> PlaneMesh:
    """A rectangle from (0, 0) to (length, height) with the sets "left", "right", "bottom" and "top".

    Parameters
    ----------
    length, height : sides along x and y [m].
    nx, ny : numbers of cells along x and y; triangles halve these cells.
    kind : kind of the cells.

    Raises
    ------
    InputError : sides that are not > 0, no cells, an unknown kind.
    """
    label = "meshes.rectangle"
    checks.one_of(label, "kind", kind, KINDS)
    l, h = checks.positive(label, "length", length, "m"), checks.positive(label, "height", height, "m")
    nx, ny = checks.count(label, "nx", nx), checks.count(label, "ny", ny)
    bottom, top = (sampled([segment((0.0, y), (l, y))], [nx]) for y in (0.0, h))
    mesh = joined([ruled(bottom, top, ny)], kind, f"rectangle {l:g} x {h:g}")
    x, y = mesh.points.T
    near = 1e-9 * max(l, h)
    return with_sets(mesh, {"left": x < near, "right": x > l - near, "bottom": y < near, "top": y > h - near})


def ring(inner: float, outer: float, size: float, kind: str = "quad9") -> PlaneMesh:
    """A ring about (0, 0) with the sets "inner" and "outer"; quadratic nodes lie on the circles.

    Parameters
    ----------
    inner, outer : radii [m].
    size : length of a cell's edge [m], on the outer circle and along the radius.
    kind : kind of the cells.

    Raises
    ------
    InputError : radii or size that are not > 0, an inner radius that is not smaller, an unknown kind.
    """
    label = "meshes.ring"
    checks.one_of(label, "kind", kind, KINDS)
    a, b = checks.positive(label, "inner", inner, "m"), checks.positive(label, "outer", outer, "m")
    size = checks.positive(label, "size", size, "m")
    if a >= b:
        raise InputError(f"{label}: inner is {a:g} m; it must be smaller than outer, {b:g} m.")
    around, across = max(8, cells_along(2.0 * math.pi * b, size)), cells_along(b - a, size)
    first, last = (sampled([arc((0.0, 0.0), r, 0.0, 2.0 * math.pi)], [around]) for r in (a, b))
    mesh = joined([ruled(first, last, across)], kind, f"ring {a:g}, {b:g}")
    return with_sets(mesh, {"inner": on_circle(mesh.points, (0, 0), a), "outer": on_circle(mesh.points, (0, 0), b)})


def link_with_eyes(
    length: float, eye: float | Pair, hole: float | Pair, width: float | Pair, size: float, kind: str = "quad9",
    fillet: float | Pair = 0.0,
) -> PlaneMesh:  # fmt: skip
    """A link of two eyes and a straight shank; its holes are the sets "start" at (0, 0) and "end" at (length, 0).

    Parameters
    ----------
    length : distance of the holes [m].
    eye : outer radius of both eyes, or (start, end) [m].
    hole : radius of both holes, or (start, end) [m].
    width : width of the shank where it leaves the eyes, or (start, end) [m]; at most the diameter of the eye.
    size : length of a cell's edge [m].
    kind : kind of the cells; quadratic nodes lie on the circles.
    fillet : radius of the arcs between eyes and shank, or (start, end); 0: sharp corners [m].

    Raises
    ------
    InputError : values that are not > 0, holes larger than eyes, a shank wider than an eye, eyes that overlap, fillets
        that leave no shank.

    Notes
    -----
    At sharp corners between shank and eyes stresses grow without limit with finer meshes.  A `width` equal to the
    diameter of the eyes has no corners.
    """
    label = "meshes.link_with_eyes"
    checks.one_of(label, "kind", kind, KINDS)
    length, size = checks.positive(label, "length", length, "m"), checks.positive(label, "size", size, "m")
    radii, holes, widths = (_pair(label, n, v) for n, v in (("eye", eye), ("hole", hole), ("width", width)))
    angles = []
    for end, big, wide in zip(("start", "end"), radii, widths, strict=True):
        if wide > 2.0 * big * (1.0 + 1e-12):
            raise InputError(f"{label}: width is {wide:g} m at the {end}; at most the eye's diameter, {2 * big:g} m.")
        angles.append(math.asin(min(1.0, 0.5 * wide / big)))
    fillets = _pair(label, "fillet", fillet, checks.not_negative)
    return _link(label, length, radii, holes, (angles[0], angles[1]), size, kind, fillets)


def crank_web(throw: float, eye: float | Pair, hole: float | Pair, size: float, kind: str = "quad9") -> PlaneMesh:
    """A web of two eyes joined by their common tangents, with the holes "start" at (0, 0) and "end" at (throw, 0).

    Parameters
    ----------
    throw : distance of the holes [m].
    eye : outer radius of both eyes, or (start, end) [m].
    hole : radius of both holes, or (start, end) [m].
    size : length of a cell's edge [m].
    kind : kind of the cells; quadratic nodes lie on the circles.

    Raises
    ------
    InputError : values that are not > 0, holes larger than eyes, eyes that overlap.
    """
    label = "meshes.crank_web"
    checks.one_of(label, "kind", kind, KINDS)
    throw, size = checks.positive(label, "throw", throw, "m"), checks.positive(label, "size", size, "m")
    radii, holes = _pair(label, "eye", eye), _pair(label, "hole", hole)
    lean = math.asin(max(-1.0, min(1.0, (radii[0] - radii[1]) / throw)))
    return _link(label, throw, radii, holes, (0.5 * math.pi - lean, 0.5 * math.pi + lean), size, kind)


def _link(
    label: str, length: float, radii: Pair, holes: Pair, angles: Pair, size: float, kind: str,
    fillets: Pair = (0.0, 0.0),
) -> PlaneMesh:  # fmt: skip
    """A mesh of two eyes whose shank leaves them at these angles from the axis [rad]."""
    for end, big, small in zip(("start", "end"), radii, holes, strict=True):
        if small >= big:
            raise InputError(f"{label}: hole is {small:g} m at the {end}; it must be smaller than eye, {big:g} m.")
    if sum(radii) >= length:
        text = f"{label}: the eyes of {radii[0]:g} and {radii[1]:g} m overlap at a distance of {length:g} m"
        raise InputError(f"{text}. Make the link longer or the eyes smaller.")
    corners = [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]
    slope = (corners[1][1] - corners[0][1]) / (length - corners[0][0] - corners[1][0])
    eyes = list(map(_Eye, radii, holes, angles, (slope, -slope), (size, size), fillets))
    if sum(eye.reach for eye in eyes) >= length:
        text = f"{label}: the fillets of {fillets[0]:g} and {fillets[1]:g} m leave no shank between the eyes"
        raise InputError(f"{text}, which are {length:g} m apart. Make them smaller.")
    across = max(2 * cells_along(eye.radius * math.sin(eye.angle), eye.size) for eye in eyes)
    # where the shank begins, from below
    first, last = (sampled(eye.neck[len(eye.neck) // 2 :][:1], [across]) for eye in eyes)
    mirrored = [np.array([length, 0.0]) + np.array([-1.0, 1.0]) * points for points in (eyes[1].block(across), last)]
    along = cells_along(float(np.linalg.norm(mirrored[1] - first, axis=1).max()), size)
    mesh = joined([eyes[0].block(across), mirrored[0], ruled(first, mirrored[1], along)], kind, label[7:])
    places = zip(("start", "end"), ((0.0, 0.0), (length, 0.0)), holes, strict=True)
    return with_sets(mesh, {name: on_circle(mesh.points, centre, radius) for name, centre, radius in places})


@dataclass(frozen=True)
class _Eye:
    """One eye about (0, 0) with the shank on the side x > 0."""

    radius: float  # of the eye [m]
    hole: float  # radius of its hole [m]
    angle: float  # at which the shank leaves the eye [rad]
    slope: float  # of the shank's upper edge [1]
    size: float  # length of a cell's edge [m]
    fillet: float = 0.0  # radius of the arcs between eye and shank [m]

    @property
    def corner(self) -> Pair:
        """Point where eye and upper edge of the shank meet without a fillet [m]."""
        return self.radius * math.cos(self.angle), self.radius * math.sin(self.angle)

    @cached_property
    def arcs(self) -> tuple[Curve, Curve] | None:
        """Upper and lower fillet, in the order of the outline; None for sharp corners, and where there is no corner."""
        unit = math.hypot(1.0, self.slope)
        along, normal = (1.0 / unit, self.slope / unit), (-self.slope / unit, 1.0 / unit)
        height = self.corner[0] * normal[0] + self.corner[1] * normal[1]  # of the edge above the centre of the eye
        reach = self.radius + self.fillet
        if self.fillet == 0.0 or self.radius - height < NO_CORNER * self.radius:
            return None
        run = math.sqrt(reach**2 - (height + self.fillet) ** 2)
        x, y = (run * a + (height + self.fillet) * n for a, n in zip(along, normal, strict=True))
        first, last = math.atan2(-normal[1], -normal[0]), -math.pi + math.atan2(y, x)
        return arc((x, y), self.fillet, first, last), arc((x, -y), self.fillet, -last, -first)

    @property
    def opening(self) -> float:
        """Angle from the axis at which the round outline of the eye begins [rad]."""
        if self.arcs is None:
            return self.angle
        x, y = self.arcs[0](np.ones(1))[0]
        return math.atan2(y, x)

    @property
    def reach(self) -> float:
        """Distance from the centre at which eye and fillets end [m]."""
        return self.radius if self.arcs is None else max(self.radius, float(self.arcs[0](np.zeros(1))[0, 0]))

    @cached_property
    def neck(self) -> list[Curve]:
        """Curves on which the block of the eye meets the shank, from its lower to its upper edge."""
        r, a = self.radius, self.angle
        x, y = self.corner
        if self.arcs is not None:
            x, y = self.arcs[0](np.zeros(1))[0]
        elif a <= NARROW:
            # an arc half as bent as the eye halves the angles at the corners; it keeps clear of the hole
            least = math.atan(max(0.0, (0.5 * (r + self.hole) - x) / y)) * 2.0
            bend = min(a, max(0.5 * a, least))
            radius = y / math.sin(bend)
            return [arc((x - radius * math.cos(bend), 0.0), radius, -bend, bend)]
        if x >= r:
            return [segment((x, -y), (x, y))]
        top = y + self.slope * (r - x)
        return [segment((x, -y), (r, -top)), segment((r, -top), (r, top)), segment((r, top), (x, y))]

    def block(self, across: int) -> Array:
        """Grid of the eye: from the hole along rays to the outline and to the neck."""
        opening, neck = self.opening, self.neck
        around, counts = cells_along(2.0 * (math.pi - opening) * self.radius, self.size), [across]
        if len(neck) > 1:
            side = max(1, cells_along(self.radius - float(neck[0](np.zeros(1))[0, 0]), self.size))
            counts = [side, across, side]
        outline, cells = [arc((0.0, 0.0), self.radius, opening, 2.0 * math.pi - opening)], [max(4, around)]
        if self.arcs is not None:
            ends = self.arcs[0](np.arange(2.0))
            turn = 2.0 * math.asin(min(1.0, 0.5 * float(np.linalg.norm(ends[1] - ends[0])) / self.fillet))
            along = max(2, math.ceil(turn / LARGEST_TURN), cells_along(turn * self.fillet, self.size))
            outline, cells = [self.arcs[0], *outline, self.arcs[1]], [along, *cells, along]
        outer = sampled([*neck, *outline], [*counts, *cells])
        angle = np.arctan2(outer[:, 1], outer[:, 0])
        inner = self.hole * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return ruled(inner, outer, cells_along(self.reach - self.hole, self.size))


def _pair(label: str, name: str, value: float | Pair, check: Callable[..., float] = checks.positive) -> Pair:
    """One value for both ends, or a pair (start, end) [m]."""
    both = tuple(value) if isinstance(value, Iterable) and not isinstance(value, str) else (value, value)
    if len(both) != 2:
        raise InputError(f"{label}: {name} is {value!r}; it must be one number in m, or a pair (start, end).")
    first, second = (check(label, name, v, "m") for v in both)
    return first, second
