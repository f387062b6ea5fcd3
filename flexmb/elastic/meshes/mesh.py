"""Plane meshes: kinds of cells, their boundary, checks; nodes, cells of one kind, named sets and groups, regions.

Each message of a check names the mesh, the cells or nodes, and the remedy.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
import skfem as fe
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import Mesh2D
from skfem.quadrature import get_quadrature

from flexmb import checks, planar
from flexmb.elastic.beams.mesh import FARTHEST, at, require_distinct
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.model.law import Material
from flexmb.planar import Array, Indices


@dataclass(frozen=True)
class CellKind:
    """One kind of cells; nodes as in VTK and gmsh: corners counter-clockwise, middles of the edges, centre."""

    name: str  # "tri3", "tri6", "quad4" or "quad9"
    nodes: int  # number of nodes
    corners: int  # number of corners
    # local nodes of each edge: both ends, then the middle of quadratic cells; the cell lies on the left
    edges: tuple[tuple[int, ...], ...]
    element: type[fe.Element]  # scikit-fem's shape functions
    mesh: type[fe.Mesh2D]  # scikit-fem's class of meshes with these cells, curved where the middles are off the chords
    # degree up to which stiffness, stress and geometric stiffness are integrated exactly; the stiffness of cells with
    # straight edges, without taper, is then exact
    stiffness_order: int
    mass_order: int  # the same for the mass; exact for all cells, curved ones included

    @property
    def is_quadratic(self) -> bool:
        """Whether edges have nodes in their middles."""
        return self.nodes > self.corners

    @property
    def reference_nodes(self) -> Array:
        """(2, nodes) coordinates of the nodes in the reference cell."""
        return np.asarray(np.asarray(self.element().doflocs, dtype=float).T)

    def shape_functions(self, places: Array) -> tuple[Array, Array]:
        """Values (nodes, q), gradients (2, nodes, q) of shape functions at places (2, q) of the reference cell."""
        element = self.element()
        pairs = [element.lbasis(places, i) for i in range(self.nodes)]
        values = np.stack([np.broadcast_to(value, places.shape[1:]) for value, _ in pairs])
        return values, np.stack([np.broadcast_to(slope, places.shape) for _, slope in pairs], axis=1)


TRIANGLE, QUADRILATERAL = ((0, 1), (1, 2), (2, 0)), ((0, 1), (1, 2), (2, 3), (3, 0))  # edges of cells by their corners
QUADRATIC = tuple((*edge, 4 + i) for i, edge in enumerate(QUADRILATERAL))  # with the middles of the edges

KINDS = {  # kinds of cells by name
    kind.name: kind
    for kind in (
        CellKind("tri3", 3, 3, TRIANGLE, fe.ElementTriP1, fe.MeshTri1, 1, 2),
        CellKind("tri6", 6, 3, tuple((*e, 3 + i) for i, e in enumerate(TRIANGLE)), fe.ElementTriP2, fe.MeshTri2, 4, 6),
        CellKind("quad4", 4, 4, QUADRILATERAL, fe.ElementQuad1, fe.MeshQuad1, 3, 3),
        CellKind("quad9", 9, 4, QUADRATIC, fe.ElementQuad2, fe.MeshQuad2, 5, 7),
    )
}


@cache
def places_of_check(kind: str) -> Array:
    """(2, q) places of a reference cell at which the Jacobian determinant is compared with 0: its nodes and inside."""
    cell = KINDS[kind]
    return np.hstack([cell.reference_nodes, get_quadrature(cell.element.refdom, cell.mass_order)[0]])


def jacobians(points: Array, cells: npt.NDArray[np.int64], kind: str) -> Array:
    """(m, q) Jacobian determinants [m^2] of all cells at `places_of_check`."""
    slopes = KINDS[kind].shape_functions(places_of_check(kind))[1]
    J = np.einsum("mka,bkq->abmq", points[cells], slopes, optimize=True)
    return np.asarray(J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0])


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of all cells, each edge once."""

    # (e, 2) or (e, 3) first node, last node and middle of each edge, as its first cell has it on the left
    nodes: Indices
    cells: Indices  # (e, 2) both cells of an edge; -1 for the missing one of a boundary edge
    counts: Indices  # (e,) number of cells of each edge
    folded: npt.NDArray[np.bool_]  # (e,) whether the first two cells of an edge lie on the same side of it

    @property
    def boundary(self) -> Indices:
        """(b, 2) or (b, 3) nodes of the edges of the boundary, with the body on the left."""
        return np.asarray(self.nodes[self.counts == 1])


def tributary_lengths(points: Array, edges: Indices) -> Array:
    """(n,) integral [m] of the nodes' shape functions along boundary edges (b, 2) or (b, 3); points (n, 2) [m]."""
    lengths = np.zeros(len(points))
    values, slopes, weights = edge_rule(edges.shape[1])
    speed = np.linalg.norm(np.einsum("bka,kq->bqa", points[edges], slopes), axis=2)
    np.add.at(lengths, edges, np.einsum("bq,kq,q->bk", speed, values, weights))
    return lengths


def edge_rule(nodes: int) -> tuple[Array, Array, Array]:
    """Values and slopes (nodes, q) of shape functions of an edge, its middle last; weights (q,), on 0 ... 1."""
    x, weights = np.polynomial.legendre.leggauss(4)
    s, weights = 0.5 * (x + 1.0), 0.5 * weights
    if nodes == 2:
        return np.stack([1.0 - s, s]), np.stack([-np.ones_like(s), np.ones_like(s)]), weights
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)])
    return values, np.stack([4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s]), weights


FLAT = 1e-6  # Jacobian determinant over the square of a cell's longest side [1] up to which the cell counts as flat
ON_EDGE = 1e-6  # distance of a node from another cell's edge over the edge's length [1] up to which it is on the edge


def checked_points(label: str, points: Any) -> Array:
    """Nodes (n, 2) as read-only floats."""
    try:
        found = np.array(points, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{label}: points are {points!r}; they must be (n, 2) numbers in m.") from None
    if found.ndim != 2 or found.shape[1] != 2 or len(found) < 3:
        raise InputError(f"{label}: points have shape {found.shape}; they must be (n, 2), three nodes at least.")
    finite = (np.abs(found) < FARTHEST).all(axis=1)
    if not finite.all():
        bad = int(np.argmin(finite))
        raise InputError(f"{label}: node {bad} is at {found[bad].tolist()}; coordinates must be finite. Mesh it again.")
    return np.asarray(_read_only(found))


def checked_cells(label: str, cells: Any, kind: str, nodes: int) -> Indices:
    """Cells (m, k) as read-only whole numbers of existing nodes, none twice in a cell."""
    found, k = _whole_numbers(label, "cells", cells), KINDS[kind].nodes
    if found.ndim != 2 or found.shape[1] != k or not len(found):
        raise InputError(f"{label}: cells have shape {found.shape}; those of kind {kind!r} must be (m, {k}), m >= 1.")
    if found.min() < 0 or found.max() >= nodes:
        bad = int(np.argmax(((found < 0) | (found >= nodes)).any(axis=1)))
        text = f"{label}: cell {bad} names the nodes {found[bad].tolist()}, but the nodes are 0 ... {nodes - 1}"
        raise InputError(f"{text}. Count nodes from 0.")
    twice = (np.diff(np.sort(found, axis=1), axis=1) == 0).any(axis=1)
    if twice.any():
        bad = int(np.argmax(twice))
        text = f"{label}: cell {bad} names a node twice: {found[bad].tolist()}; {int(twice.sum())} such cells in all"
        raise InputError(f"{text}. Use triangles where quadrilaterals collapse.")
    return np.asarray(_read_only(found))


def checked_groups(label: str, field: str, groups: Any, of: str, count: int) -> dict[str, Indices]:
    """Named groups of node or cell numbers as read-only arrays."""
    found = {}
    for name, members in checks.mapping(label, field, groups).items():
        checks.identifier(f"{label}, {field}", name)
        owner = f"{label}: {field[:-1]} {name!r}"
        numbers = _whole_numbers(owner, f"{of}s", members).ravel()
        if not numbers.size:
            raise InputError(f"{owner} has no {of}s. Leave it out, or give its {of} numbers.")
        if numbers.min() < 0 or numbers.max() >= count:
            bad = int(numbers[(numbers < 0) | (numbers >= count)][0])
            raise InputError(f"{owner} names the {of} {bad}, but the {of}s are 0 ... {count - 1}. Count from 0.")
        if len(np.unique(numbers)) < len(numbers):
            raise InputError(f"{owner} names a {of} twice. Name each {of} once.")
        found[name] = _read_only(numbers)
    return found


def _require_sound_cells(label: str, points: Array, cells: Indices, kind: str) -> None:
    names = np.sort(cells[:, : KINDS[kind].corners], axis=1)
    _, first, inverse, counts = np.unique(names, axis=0, return_index=True, return_inverse=True, return_counts=True)
    if counts.max() > 1:
        bad = int(np.argmax(counts))
        second = int(np.flatnonzero(inverse.ravel() == bad)[1])
        place = _of_cell(points, cells[second])
        text = f"{label}: cells {int(first[bad])} and {second} have the same corners at {place}"
        raise InputError(f"{text}; {int((counts > 1).sum())} such pairs in all. Delete one of each.")
    corners = points[cells[:, : KINDS[kind].corners]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    least = jacobians(points, cells, kind).min(axis=1)
    wrong = least <= FLAT * longest**2
    if wrong.any():
        bad = int(np.argmin(least / longest**2))
        word = "flat" if least[bad] > -FLAT * longest[bad] ** 2 else "inverted"
        text = f"{label}: {int(wrong.sum())} of {len(cells)} cells are flat or inverted; the worst is cell {bad}, "
        text += f"{word}, at {_of_cell(points, cells[bad])}"
        raise InputError(f"{text}. {_remedy_of_cell(corners[bad], all_wrong=bool(wrong.all()))}")


def _remedy_of_cell(corners: Array, *, all_wrong: bool) -> str:
    """Remedy for a flat or inverted cell with these corners (3 or 4, 2)."""
    ahead, behind = np.roll(corners, -1, axis=0) - corners, corners - np.roll(corners, 1, axis=0)
    turns = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    if (turns < 0.0).all():
        return "Order the nodes of the cells counter-clockwise."
    if len(corners) == 4 and (turns < 0.0).sum() == 2:
        return "Its edges cross: name its corners in the order in which they follow each other around it."
    if len(corners) == 4 and (turns < 0.0).any():
        return "One of its corners points inwards: halve it into two triangles, or move its nodes."
    if all_wrong and (turns > 0.0).all():
        order = "Nodes behind its corners are the middles of its edges in the same order"
        return f"{order}, the first between corners 1 and 2."
    return "Mesh the outline with smaller cells there, or with straight edges."


def _require_one_body(label: str, points: Array, cells: Indices, edges: Edges) -> None:
    if edges.counts.max() > 2:
        bad = int(np.argmax(edges.counts))
        i, j = edges.nodes[bad, :2].tolist()
        text = f"{label}: {int(edges.counts[bad])} cells share the edge between nodes {i} and {j} at {at(points, i)}"
        raise InputError(f"{text}; two at most may. Delete cells that overlap.")
    if edges.folded.any():
        bad = int(np.argmax(edges.folded))
        (i, j), (a, b) = edges.nodes[bad, :2].tolist(), edges.cells[bad].tolist()
        text = f"{label}: cells {a} and {b} lie on the same side of the edge between nodes {i} and {j} "
        raise InputError(f"{text}at {at(points, i)}, so they overlap. Delete one of them.")
    inner, n = edges.cells[edges.counts == 2], len(cells)
    links = coo_array((np.ones(len(inner), dtype=np.int8), (inner[:, 0], inner[:, 1])), shape=(n, n))
    count, piece = connected_components(links, directed=False)
    if count > 1:
        sizes = np.bincount(piece)
        small = int(np.argmin(sizes))
        first = int(np.argmax(piece == small))
        text = f"{label}: the cells form {count} pieces that share no edge; the smallest has {int(sizes[small])} cells"
        text += f", one of them is cell {first} at {_of_cell(points, cells[first])}"
        raise InputError(f"{text}. Merge nodes at the same place, mesh the pieces as one, or make one body of each.")


def _require_conforming(label: str, points: Array, edges: Edges) -> None:
    boundary = edges.boundary
    nodes = np.unique(boundary)
    a, b = points[boundary[:, 0]], points[boundary[:, 1]]
    along = b - a
    length = np.linalg.norm(along, axis=1)
    pairs = cKDTree(points[nodes]).query_ball_point(0.5 * (a + b), 0.5 * length * (1.0 - ON_EDGE))
    for e, near in enumerate(pairs):
        others = np.setdiff1d(nodes[near], boundary[e])
        if others.size:
            offset = points[others] - a[e]
            apart = np.abs(along[e, 0] * offset[:, 1] - along[e, 1] * offset[:, 0]) / length[e]
            if apart.min() <= ON_EDGE * length[e]:
                bad, (i, j) = int(others[np.argmin(apart)]), boundary[e, :2].tolist()
                text = f"{label}: node {bad} at {at(points, bad)} lies on the edge between nodes {i} and {j}, "
                text += "whose cell does not have it, so the body would gape there"
                raise InputError(f"{text}. Mesh both sides with the same nodes.")
    counts = np.bincount(boundary[:, 0], minlength=len(points))
    if counts.max() > 1:
        bad = int(np.argmax(counts))
        text = f"{label}: the body touches itself at node {bad} at {at(points, bad)} alone, like a hinge"
        raise InputError(f"{text}. Join the cells there by an edge, or move them apart.")


def _whole_numbers(owner: str, field: str, values: Any) -> Indices:
    try:
        found = np.array(values)
        whole = np.array(found, dtype=np.int64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{owner}: {field} must be whole numbers in rows of equal length.") from None
    if found.size and (found.dtype == bool or not np.issubdtype(found.dtype, np.number) or np.any(whole != found)):
        raise InputError(f"{owner}: {field} have values of type {found.dtype}; they must be whole numbers.")
    return whole


def _read_only(values: Any) -> Any:
    values = np.ascontiguousarray(values)
    values.setflags(write=False)
    return values


def _of_cell(points: Array, nodes: Indices) -> str:
    x, y = points[nodes].mean(axis=0)
    return f"({x:g}, {y:g}) m"


ON_CIRCLE = 1e-3  # spread of distances from the centre over the radius [1] up to which nodes lie on a circle
PLACES = 13  # decimal places of centres, counted from the leading digit of the size of the mesh


@record_with(eq=False, repr=False)
class PlaneMesh:
    """A plane mesh of cells of one kind, with names for parts of its boundary and for groups of cells.

    Two meshes are equal if all their numbers and names are equal.  All arrays are read-only.

    Raises
    ------
    InputError : arrays of another shape, cells that are flat, inverted or given twice, nodes that no cell uses, nodes
        at the same place, nodes in the middle of another cell's edge, separate pieces, empty sets, unknown numbers.

    Examples
    --------
    >>> square = PlaneMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2, 3)], "quad4", {"left": [0, 3]})
    >>> square
    PlaneMesh(4 nodes, 1 quad4, sets left)
    >>> square.area
    1.0
    """

    points: Array = field("(n, 2) nodes", "m")
    cells: Indices = field(
        "(m, k) nodes of the cells, counted from 0: corners counter-clockwise, then the middles of the edges in the "
        "same order, then the centre (the order of VTK and gmsh)"
    )
    kind: str = field('"tri3", "tri6", "quad4" or "quad9"')
    sets: Mapping[str, Indices] = field("node numbers by the name of a hole or an edge", default_factory=dict)
    regions: Mapping[str, Indices] = field(
        "cell numbers by the name of a region, for bodies of several materials or thicknesses", default_factory=dict
    )
    name: str = field("name of the mesh in messages", default="mesh")

    def __post_init__(self) -> None:
        label = self.label
        checks.one_of(label, "kind", self.kind, KINDS)
        points = checked_points(label, self.points)
        cells = checked_cells(label, self.cells, self.kind, len(points))
        sets = checked_groups(label, "sets", self.sets, "node", len(points))
        regions = checked_groups(label, "regions", self.regions, "cell", len(cells))
        groups = {"sets": MappingProxyType(sets), "regions": MappingProxyType(regions)}
        for name, value in {"points": points, "cells": cells, **groups}.items():
            object.__setattr__(self, name, value)
        # the cells must be a decomposition of one connected body
        edges, used = self.edges, np.zeros(len(points), dtype=bool)
        used[cells] = True
        if not used.all():
            bad, left = int(np.argmin(used)), int((~used).sum())
            text = f"{label}: {left} nodes belong to no cell, the first is node {bad} at {at(points, bad)}"
            raise InputError(f"{text}. Delete them, or read the file with meshes.read, which leaves them out.")
        require_distinct(label, points, "cells")
        _require_sound_cells(label, points, cells, self.kind)
        _require_one_body(label, points, cells, edges)
        _require_conforming(label, points, edges)

    @property
    def label(self) -> str:
        """Class and name, as messages show it."""
        return f"PlaneMesh {self.name!r}"

    @property
    def cell_kind(self) -> CellKind:
        """Nodes, edges and shape functions of the cells."""
        return KINDS[self.kind]

    @cached_property
    def edges(self) -> Edges:
        """All edges of the cells."""
        local = np.array(KINDS[self.kind].edges)
        every = self.cells[:, local]  # (m, edges a cell, nodes an edge)
        owner, every = np.repeat(np.arange(len(self.cells)), len(local)), every.reshape(-1, local.shape[1])
        ends = np.sort(every[:, :2], axis=1)
        key = ends[:, 0] * (int(self.cells.max()) + 1) + ends[:, 1]
        order = np.argsort(key, kind="stable")
        first = np.flatnonzero(np.diff(key[order], prepend=-1))
        counts = np.diff(np.append(first, len(key)))
        second = order[np.minimum(first + 1, len(key) - 1)]
        cells_of = np.stack([owner[order[first]], np.where(counts > 1, owner[second], -1)], axis=1)
        return Edges(every[order[first]], cells_of, counts, (counts > 1) & (every[order[first], 0] == every[second, 0]))

    @cached_property
    def loops(self) -> tuple[Indices, ...]:
        """Nodes of each closed line of the boundary in order: the outline first, then the holes."""
        boundary = self.edges.boundary
        # A node at which more than two boundary edges meet ends a loop early; `PlaneMesh` refuses such meshes.
        after, loops = dict(zip(boundary[:, 0].tolist(), boundary.tolist(), strict=True)), []
        while after:
            node, nodes = next(iter(after)), []
            while node in after:
                edge = after.pop(node)
                nodes += [edge[0], *edge[2:]]
                node = edge[1]
            loops.append(np.array(nodes, dtype=np.int64))
        return tuple(sorted(loops, key=lambda loop: -planar.area(self.points[loop])))

    @cached_property
    def holes(self) -> tuple[str, ...]:
        """Names of the sets that are a whole hole; "start" and "end" stand first."""
        loops = {frozenset(loop.tolist()) for loop in self.loops[1:]}
        corners = {frozenset((loop[::2] if self.cell_kind.is_quadratic else loop).tolist()) for loop in self.loops[1:]}
        found = [name for name, nodes in self.sets.items() if frozenset(nodes.tolist()) in loops | corners]
        return tuple(sorted(found, key=lambda name: {"start": 0, "end": 1}.get(name, 2)))

    def edges_in(self, name: str) -> Indices:
        """(b, 2) or (b, 3) nodes of the boundary edges whose ends lie in the set `name`."""
        return np.asarray(self.edges.nodes[self.edge_numbers(name)])

    def edge_numbers(self, name: str) -> Indices:
        """(b,) numbers, among `edges`, of the boundary edges whose ends lie in the set `name`."""
        numbers = np.flatnonzero(self.edges.counts == 1)
        return np.asarray(numbers[np.isin(self.edges.nodes[numbers, :2], self.set_of(name)).all(axis=1)])

    def set_of(self, name: str) -> Indices:
        """Nodes of the set `name`, or `InputError` that lists the sets."""
        if not isinstance(name, str) or name not in self.sets:
            raise InputError(f"{self.label} has no set {name!r}. {checks.did_you_mean(str(name), self.sets)}")
        return self.sets[name]

    def centre_of(self, name: str) -> tuple[float, float]:
        """Centre of the set `name` [m]: of the circle on which its nodes lie, else the mean of its nodes."""
        points = self.points[self.set_of(name)]
        mean = points.mean(axis=0)
        centre = _centre_of_circle(points - mean) if len(points) > 2 else None
        if centre is not None:
            mean = mean + centre
        digits = PLACES - math.floor(math.log10(self.size))
        return round(float(mean[0]), digits) + 0.0, round(float(mean[1]), digits) + 0.0

    @cached_property
    def area(self) -> float:
        """Area [m^2]."""
        edges = self.edges.boundary
        values, slopes, weights = edge_rule(edges.shape[1])
        ends = self.points[edges] - self.points[0]
        x, dx = (np.einsum("bka,kq->aqb", ends, by) for by in (values, slopes))
        return float(0.5 * np.sum(weights[:, None] * (x[0] * dx[1] - x[1] * dx[0])))

    @property
    def size(self) -> float:
        """Largest extent along x or y [m]."""
        return float(np.ptp(self.points, axis=0).max())

    @cached_property
    def digest(self) -> str:
        """Digest of all numbers and names; equal for equal meshes."""
        state = hashlib.sha256(f"{self.kind}|{self.name}".encode())
        state.update(self.points.tobytes())
        state.update(self.cells.tobytes())
        for groups in (self.sets, self.regions):
            for name in groups:
                state.update(f"|{name}|{len(groups[name])}|".encode())
                state.update(groups[name].tobytes())
        return state.hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PlaneMesh) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        parts = [f"{len(self.points)} nodes", f"{len(self.cells)} {self.kind}"]
        groups = {"sets": self.sets, "regions": self.regions}
        parts += [f"{word} {', '.join(names)}" for word, names in groups.items() if names]
        return f"PlaneMesh({', '.join(parts)})"

    def __reduce__(self) -> tuple[Any, ...]:
        return PlaneMesh, (self.points, self.cells, self.kind, dict(self.sets), dict(self.regions), self.name)

    def skfem(self) -> Mesh2D:
        """The mesh for scikit-fem, whose numbers of nodes may differ; the cells have the same order."""
        points, cells = np.ascontiguousarray(self.points.T), np.ascontiguousarray(self.cells.T, dtype=np.int32)
        return self.cell_kind.mesh(points, cells, sort_t=False, validate=False)

    def placed(self, angle: float = 0.0, shift: tuple[float, float] = (0.0, 0.0)) -> PlaneMesh:
        """The mesh turned about its origin by `angle` [rad], then moved by `shift` [m]."""
        c, s = math.cos(angle), math.sin(angle)
        return replace(self, points=self.points @ np.array([[c, s], [-s, c]]) + np.asarray(shift, dtype=float))

    def scaled(self, factor: float) -> PlaneMesh:
        """The mesh with all lengths times `factor`, > 0: 1e-3 for a mesh in millimetres."""
        checks.positive(self.label, "factor", factor)
        return replace(self, points=self.points * factor)

    def to_quadratic(self, rounds: Sequence[str] = ()) -> PlaneMesh:
        """The mesh with a node in the middle of every edge, and in every quadrilateral: tri6 or quad9.

        Parameters
        ----------
        rounds : names of sets whose new nodes move onto the circle through the nodes of the set.

        Raises
        ------
        InputError : a set whose nodes lie on no circle.
        """
        if self.cell_kind.is_quadratic:
            return self
        edges, n = self.edges.nodes, len(self.points)
        middles = self.points[edges].mean(axis=1)
        own = {name: _pairs_in(edges, self.edges_in(name), n) for name in self.sets}
        for name in rounds:
            # Centre and radius [m] of the circle on which the nodes of a set lie, or `InputError`
            points = self.points[self.set_of(name)]
            mean = points.mean(axis=0)
            centre = _centre_of_circle(points - mean) if len(points) > 3 else None
            if centre is None:
                raise InputError(f"{self.label}: the nodes of set {name!r} lie on no circle. Leave it out of rounds.")
            centre, radius = mean + centre, float(np.linalg.norm(points - mean - centre, axis=1).mean())
            off = middles[own[name]] - centre
            middles[own[name]] = centre + off * (radius / np.linalg.norm(off, axis=1))[:, None]
        local = np.array(self.cell_kind.edges)
        rows = _pairs_in(edges, self.cells[:, local].reshape(-1, 2), n).reshape(len(self.cells), -1)
        cells, points = np.hstack([self.cells, n + rows]), np.concatenate([self.points, middles])
        if self.kind == "quad4":
            points, cells = with_centres(points, cells)
        sets = {name: np.concatenate([nodes, n + own[name]]) for name, nodes in self.sets.items()}
        return replace(self, points=points, cells=cells, kind={"tri3": "tri6", "quad4": "quad9"}[self.kind], sets=sets)

    def with_holes(self, holes: Mapping[str, tuple[float, float]]) -> PlaneMesh:
        """The mesh with names for `holes`, each found by a point inside of it [m]: {"start": (0.0, 0.0)}.

        Raises
        ------
        InputError : a point in no hole.
        """
        sets = dict(self.sets)
        for name, point in holes.items():
            x = np.array(checks.point(self.label, f"hole {name!r}", point))
            inside = [loop for loop in self.loops[1:] if planar.surrounds(self.points[loop] - x)]
            if not inside:
                middles = np.array([self.points[loop].mean(axis=0) for loop in self.loops[1:]]).reshape(-1, 2)
                digits = 3 - math.floor(math.log10(self.size))
                listed = ", ".join(f"({a:g}, {b:g})" for a, b in middles.round(digits) + 0.0)
                text = f"{self.label}: no hole at ({x[0]:g}, {x[1]:g}) m for the name {name!r}"
                raise InputError(f"{text}. Its holes are near: {listed or 'it has none'}.")
            sets[name] = inside[0]
        return replace(self, sets=sets)


def with_centres(points: Array, cells: Indices) -> tuple[Array, Indices]:
    """Nodes and cells of eight-node quadrilaterals (m, 8) with their centres, where eight shape functions have them."""
    own = points[cells]
    centres = 0.5 * own[:, 4:].sum(axis=1) - 0.25 * own[:, :4].sum(axis=1)
    return np.concatenate([points, centres]), np.hstack([cells, len(points) + np.arange(len(cells))[:, None]])


def _pairs_in(edges: Indices, wanted: Indices, nodes: int) -> Indices:
    """Numbers of the edges with the ends `wanted` (b, 2), in either direction, of a mesh with so many nodes."""
    keys, others = (np.sort(e[:, :2], axis=1) @ np.array([nodes, 1]) for e in (edges, wanted))
    order = np.argsort(keys)
    return np.asarray(order[np.searchsorted(keys, others, sorter=order)])


def _centre_of_circle(points: Array) -> Array | None:
    """Centre of the circle on which points lie [m], their mean at the origin, or None if they lie on none."""
    scale = float(np.abs(points).max())
    A = np.column_stack([2.0 * points, np.full(len(points), scale)])
    found, _, rank, _ = np.linalg.lstsq(A / scale, (points**2).sum(axis=1) / scale, rcond=1e-9)
    radii = np.linalg.norm(points - found[:2], axis=1)
    return None if rank < 3 or np.ptp(radii) > ON_CIRCLE * radii.mean() else np.asarray(found[:2])


Value = TypeVar("Value")
ByRegion: TypeAlias = Value | Mapping[str, Value] | tuple[tuple[str, Value], ...]  # all cells', or by name of a region
Materials: TypeAlias = ByRegion[Material]
Thickness: TypeAlias = ByRegion[float]  # [m]
STRESS, STRAIN = "stress", "strain"  # plane stress: thin plates, free to contract across; strain: thick bodies, held


def by_region(owner: str, field: str, value: ByRegion[Value]) -> tuple[tuple[str, Value], ...]:
    """Pairs (region, value); the region "" stands for all cells."""
    if isinstance(value, Mapping):
        return tuple(value.items())
    if isinstance(value, (tuple, list)):
        pairs = checks.sequence(owner, field, value, "pairs (region, value)")
        if any(not isinstance(pair, tuple) or len(pair) != 2 for pair in pairs):
            raise InputError(f"{owner}: {field} is {value!r}; it must be one value, or a dictionary by region.")
        return pairs
    return (("", value),)


def cell_values(mesh: PlaneMesh, field: str, value: ByRegion[Value]) -> list[tuple[Value, npt.NDArray[np.int64]]]:
    """Values with the cells (m,) that have them; every cell has exactly one, else the regions are refused."""
    pairs = by_region(mesh.label, field, value)
    if [name for name, _ in pairs] == [""]:
        return [(pairs[0][1], np.arange(len(mesh.cells)))]
    found, counts = [], np.zeros(len(mesh.cells), dtype=np.int64)
    for name, item in pairs:
        if name not in mesh.regions:
            none = "The mesh has no regions: give one value."
            known = checks.did_you_mean(name, mesh.regions) if mesh.regions else none
            raise InputError(f"{mesh.label} has no region {name!r} for {field}. {known}")
        found.append((item, mesh.regions[name]))
        counts[mesh.regions[name]] += 1
    for wrong, word in ((counts == 0, "no region"), (counts > 1, "several regions")):
        if wrong.any():
            cell = int(np.argmax(wrong))
            text = f"{mesh.label}: {int(wrong.sum())} cells are in {word} of {field}, one of them is cell {cell}"
            raise InputError(f"{text}. Give each cell one {field}: regions are {', '.join(mesh.regions)}.")
    return found


def numbers_of_cells(mesh: PlaneMesh, field: str, value: ByRegion[float], unit: str) -> Array:
    """(m,) number of each cell, > 0."""
    numbers = np.empty(len(mesh.cells))
    for item, cells in cell_values(mesh, field, value):
        numbers[cells] = checks.positive(mesh.label, field, item, unit)
    return numbers


def elasticity(mesh: PlaneMesh, material: Materials, state: str) -> Array:
    """(m, 3) stiffnesses D11, D12, D33 [Pa] of each cell, of plane stress or plane strain."""
    # sx = D11 ex + D12 ey, sy = D12 ex + D11 ey, txy = D33 gxy.
    # Equations (11.1) and (11.2) of docs/theory/plane_bodies.md.
    checks.one_of(mesh.label, "state", state, (STRESS, STRAIN))
    values = np.empty((len(mesh.cells), 3))
    for item, cells in cell_values(mesh, "material", material):
        require_material(mesh.label, item)
        E, nu = item.young, item.poisson
        if state == STRAIN:
            E, nu = E / (1.0 - nu**2), nu / (1.0 - nu)
        values[cells] = E / (1.0 - nu**2), E * nu / (1.0 - nu**2), 0.5 * E / (1.0 + nu)
    return values


def densities(mesh: PlaneMesh, material: Materials) -> Array:
    """(m,) density of each cell [kg/m^3]."""
    values = np.empty(len(mesh.cells))
    for item, cells in cell_values(mesh, "material", material):
        require_material(mesh.label, item)
        values[cells] = item.density
    return values


def require_material(label: str, item: object) -> None:
    """Refuse a value that is no `Material`."""
    if not isinstance(item, Material):
        raise InputError(f"{label}: material is {item!r}; it must be a Material(...), or a dictionary by region.")
