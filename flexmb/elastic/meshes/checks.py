"""Checks of plane meshes: each message names the mesh, the cells or nodes, and the remedy."""

from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from flexmb import checks
from flexmb.elastic.beams.mesh import FARTHEST, at, require_distinct
from flexmb.elastic.meshes.cell_kinds import KINDS, Edges, jacobians
from flexmb.errors import InputError
from flexmb.planar import Array, Indices

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
    found = _whole_numbers(label, "cells", cells)
    k = KINDS[kind].nodes
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


def require_sound(label: str, points: Array, cells: Indices, kind: str, edges: Edges) -> None:
    """Refuse meshes whose cells are no decomposition of one connected body."""
    _require_used(label, points, cells)
    require_distinct(label, points, "cells")
    _require_once(label, points, cells, kind)
    _require_upright(label, points, cells, kind)
    _require_two_cells(label, points, edges)
    _require_one_piece(label, points, cells, edges)
    _require_no_hanging_nodes(label, points, edges)
    _require_simple_boundary(label, points, edges)


def _require_used(label: str, points: Array, cells: Indices) -> None:
    used = np.zeros(len(points), dtype=bool)
    used[cells] = True
    if not used.all():
        bad = int(np.argmin(used))
        text = f"{label}: {int((~used).sum())} nodes belong to no cell, the first is node {bad} at {at(points, bad)}"
        raise InputError(f"{text}. Delete them, or read the file with meshes.read, which leaves them out.")


def _require_once(label: str, points: Array, cells: Indices, kind: str) -> None:
    corners = np.sort(cells[:, : KINDS[kind].corners], axis=1)
    _, first, inverse, counts = np.unique(corners, axis=0, return_index=True, return_inverse=True, return_counts=True)
    if counts.max() > 1:
        bad = int(np.argmax(counts))
        second = int(np.flatnonzero(inverse.ravel() == bad)[1])
        place = _of_cell(points, cells[second])
        text = f"{label}: cells {int(first[bad])} and {second} have the same corners at {place}"
        raise InputError(f"{text}; {int((counts > 1).sum())} such pairs in all. Delete one of each.")


def _require_upright(label: str, points: Array, cells: Indices, kind: str) -> None:
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


def _require_two_cells(label: str, points: Array, edges: Edges) -> None:
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


def _require_one_piece(label: str, points: Array, cells: Indices, edges: Edges) -> None:
    inner = edges.cells[edges.counts == 2]
    n = len(cells)
    links = coo_array((np.ones(len(inner), dtype=np.int8), (inner[:, 0], inner[:, 1])), shape=(n, n))
    count, piece = connected_components(links, directed=False)
    if count > 1:
        sizes = np.bincount(piece)
        small = int(np.argmin(sizes))
        first = int(np.argmax(piece == small))
        text = f"{label}: the cells form {count} pieces that share no edge; the smallest has {int(sizes[small])} cells"
        text += f", one of them is cell {first} at {_of_cell(points, cells[first])}"
        raise InputError(f"{text}. Merge nodes at the same place, mesh the pieces as one, or make one body of each.")


def _require_no_hanging_nodes(label: str, points: Array, edges: Edges) -> None:
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


def _require_simple_boundary(label: str, points: Array, edges: Edges) -> None:
    counts = np.bincount(edges.boundary[:, 0], minlength=len(points))
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
