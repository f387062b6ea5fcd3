"""Plane meshes: nodes, cells of one kind, named sets and groups, regions."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
from skfem import Mesh2D

from flexmb import checks
from flexmb.elastic.meshes.cell_kinds import KINDS, CellKind, Edges, area_inside, edge_rule, edges_of, loops_of
from flexmb.elastic.meshes.checks import checked_cells, checked_groups, checked_points, require_sound
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.model.law import Material
from flexmb.planar import Array, Indices

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
        require_sound(label, points, cells, self.kind, self.edges)

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
        return edges_of(self.cells, self.kind)

    @cached_property
    def loops(self) -> tuple[Indices, ...]:
        """Nodes of each closed line of the boundary in order: the outline first, then the holes."""
        loops = loops_of(self.edges.boundary)
        return tuple(sorted(loops, key=lambda loop: -area_inside(self.points[loop])))

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
        inside = np.isin(self.edges.nodes[numbers, :2], self.set_of(name)).all(axis=1)
        return np.asarray(numbers[inside])

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
        parts += [f"{word} {', '.join(groups)}" for word, groups in self._groups().items() if groups]
        return f"PlaneMesh({', '.join(parts)})"

    def __reduce__(self) -> tuple[Any, ...]:
        return PlaneMesh, (self.points, self.cells, self.kind, dict(self.sets), dict(self.regions), self.name)

    def _groups(self) -> dict[str, Mapping[str, Indices]]:
        return {"sets": self.sets, "regions": self.regions}

    def skfem(self) -> Mesh2D:
        """The mesh for scikit-fem, whose numbers of nodes may differ; the cells have the same order."""
        kind = self.cell_kind.mesh
        points, cells = np.ascontiguousarray(self.points.T), np.ascontiguousarray(self.cells.T, dtype=np.int32)
        return kind(points, cells, sort_t=False, validate=False)

    def placed(self, angle: float = 0.0, shift: tuple[float, float] = (0.0, 0.0)) -> PlaneMesh:
        """The mesh turned about its origin by `angle` [rad], then moved by `shift` [m]."""
        c, s = math.cos(angle), math.sin(angle)
        points = self.points @ np.array([[c, s], [-s, c]]) + np.asarray(shift, dtype=float)
        return self._with(points, self.cells, self.kind, self.sets)

    def scaled(self, factor: float) -> PlaneMesh:
        """The mesh with all lengths times `factor`, > 0: 1e-3 for a mesh in millimetres."""
        checks.positive(self.label, "factor", factor)
        return self._with(self.points * factor, self.cells, self.kind, self.sets)

    def to_quadratic(self, rounds: Sequence[str] = ()) -> PlaneMesh:
        """The mesh with a node in the middle of every edge, and in every quadrilateral: tri6 or quad9.

        Parameters
        ----------
        rounds : names of sets whose new nodes move onto the circle through the nodes of the set.

        Raises
        ------
        InputError : a set whose nodes lie on no circle.
        """
        return self if self.cell_kind.is_quadratic else quadratic(self, rounds)

    def with_holes(self, holes: Mapping[str, tuple[float, float]]) -> PlaneMesh:
        """The mesh with names for `holes`, each found by a point inside of it [m]: {"start": (0.0, 0.0)}.

        Raises
        ------
        InputError : a point in no hole.
        """
        sets = dict(self.sets)
        for name, point in holes.items():
            x = np.array(checks.point(self.label, f"hole {name!r}", point))
            inside = [loop for loop in self.loops[1:] if _surrounds(self.points[loop] - x)]
            if not inside:
                middles = np.array([self.points[loop].mean(axis=0) for loop in self.loops[1:]]).reshape(-1, 2)
                digits = 3 - math.floor(math.log10(self.size))
                listed = ", ".join(f"({a:g}, {b:g})" for a, b in middles.round(digits) + 0.0)
                text = f"{self.label}: no hole at ({x[0]:g}, {x[1]:g}) m for the name {name!r}"
                raise InputError(f"{text}. Its holes are near: {listed or 'it has none'}.")
            sets[name] = inside[0]
        return self._with(self.points, self.cells, self.kind, sets)

    def _with(self, points: Array, cells: Indices, kind: str, sets: Mapping[str, Indices]) -> PlaneMesh:
        """The mesh with other nodes and cells."""
        return PlaneMesh(points, cells, kind, sets, self.regions, self.name)


def _surrounds(points: Array) -> bool:
    """Whether a polygon goes round the origin."""
    ahead = np.roll(points, -1, axis=0)
    cross = points[:, 0] * ahead[:, 1] - points[:, 1] * ahead[:, 0]
    return abs(float(np.arctan2(cross, np.sum(points * ahead, axis=1)).sum())) > math.pi


def quadratic(mesh: PlaneMesh, rounds: Sequence[str]) -> PlaneMesh:
    """The mesh `mesh` of tri3 or quad4 as tri6 or quad9; new nodes of the sets `rounds` lie on circles."""
    edges, n = mesh.edges.nodes, len(mesh.points)
    middles = mesh.points[edges].mean(axis=1)
    own = {name: _pairs_in(edges, mesh.edges_in(name), n) for name in mesh.sets}
    for name in rounds:
        mesh.set_of(name)
        centre, radius = circle_of(mesh, name)
        off = middles[own[name]] - centre
        middles[own[name]] = centre + off * (radius / np.linalg.norm(off, axis=1))[:, None]
    local = np.array(mesh.cell_kind.edges)
    rows = _pairs_in(edges, mesh.cells[:, local].reshape(-1, 2), n).reshape(len(mesh.cells), -1)
    cells, points = np.hstack([mesh.cells, n + rows]), np.concatenate([mesh.points, middles])
    if mesh.kind == "quad4":
        points, cells = with_centres(points, cells)
    sets = {name: np.concatenate([nodes, n + own[name]]) for name, nodes in mesh.sets.items()}
    kind = {"tri3": "tri6", "quad4": "quad9"}[mesh.kind]
    return PlaneMesh(points, cells, kind, sets, mesh.regions, mesh.name)


def with_centres(points: Array, cells: Indices) -> tuple[Array, Indices]:
    """Nodes and cells of eight-node quadrilaterals (m, 8) with their centres, where eight shape functions have them."""
    own = points[cells]
    centres = 0.5 * own[:, 4:].sum(axis=1) - 0.25 * own[:, :4].sum(axis=1)
    numbers = len(points) + np.arange(len(cells))[:, None]
    return np.concatenate([points, centres]), np.hstack([cells, numbers])


def _pairs_in(edges: Indices, wanted: Indices, nodes: int) -> Indices:
    """Numbers of the edges with the ends `wanted` (b, 2), in either direction, of a mesh with so many nodes."""
    keys, others = (np.sort(e[:, :2], axis=1) @ np.array([nodes, 1]) for e in (edges, wanted))
    order = np.argsort(keys)
    return np.asarray(order[np.searchsorted(keys, others, sorter=order)])


def circle_of(mesh: PlaneMesh, name: str) -> tuple[Array, float]:
    """Centre and radius [m] of the circle on which the nodes of a set lie, or `InputError`."""
    points = mesh.points[mesh.set_of(name)]
    mean = points.mean(axis=0)
    centre = _centre_of_circle(points - mean) if len(points) > 3 else None
    if centre is None:
        raise InputError(f"{mesh.label}: the nodes of set {name!r} lie on no circle. Leave it out of rounds.")
    return mean + centre, float(np.linalg.norm(points - mean - centre, axis=1).mean())


def _centre_of_circle(points: Array) -> Array | None:
    """Centre of the circle on which points lie [m], their mean at the origin, or None if they lie on none."""
    scale = float(np.abs(points).max())
    A = np.column_stack([2.0 * points, np.full(len(points), scale)])
    found, _, rank, _ = np.linalg.lstsq(A / scale, (points**2).sum(axis=1) / scale, rcond=1e-9)
    radii = np.linalg.norm(points - found[:2], axis=1)
    if rank < 3 or np.ptp(radii) > ON_CIRCLE * radii.mean():
        return None
    return np.asarray(found[:2])


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
