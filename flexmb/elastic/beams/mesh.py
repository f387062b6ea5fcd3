"""Line meshes from files: reading through meshio, straight chains, and the straight members of frames."""

import io
import math
import struct
import zlib
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from flexmb import checks
from flexmb.dynamics.jobs.files import READ_ERRORS
from flexmb.errors import FileFormatError, InputError
from flexmb.late import meshio
from flexmb.planar import Array, Indices

Walk = tuple[list[int], list[int]]  # nodes in order, and the lines between them
TAG_NAMES = ("gmsh:physical", "cell_tags", "section")  # names of cell data with tags; the first that a file has counts
SAME_PLACE = 1e-9  # distance over the size of the mesh [1] below which two points are one
FARTHEST = 1e100  # largest coordinate [m], whose square is still a float
STRAIGHT = 1e-4  # angle up to which a beam counts as straight [rad]; above the rounding of files in single precision
# Errors that readers of meshio raise on files that are no mesh; some readers even exit.
BROKEN = (*READ_ERRORS, AssertionError, EOFError, SyntaxError, struct.error, zlib.error, SystemExit)


@dataclass(frozen=True, eq=False)
class LineMesh:
    """A plane mesh of two-node lines."""

    points: Array  # (n, 2) nodes [m]
    edges: Indices  # (m, 2) indices of the first and last node of each line
    tags: Indices  # (m,) tag of each line; 0 where the file has none
    name: str = "mesh"  # name of the mesh in messages

    def __post_init__(self) -> None:
        points, edges, name = self.points, self.edges, self.name
        unused = np.setdiff1d(np.arange(len(points)), edges)
        if unused.size:
            first, count = unused[0], unused.size
            text = f"{name}: {count} nodes belong to no line, the first is node {first} at {at(points, first)}"
            raise InputError(f"{text}. Delete them, or connect them.")
        lengths = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
        k = int(np.argmin(lengths))
        if lengths[k] <= SAME_PLACE * extent(points):
            text = f"{name}: line {k} between nodes {edges[k, 0]} and {edges[k, 1]} has zero length"
            raise InputError(f"{text}. Delete it and merge its nodes.")
        first_of: dict[frozenset[int], int] = {}
        for k, edge in enumerate(edges.tolist()):
            first = first_of.setdefault(frozenset(edge), k)
            if first != k:
                text = f"{name}: lines {first} and {k} join the same nodes {edge[0]} and {edge[1]}"
                raise InputError(f"{text}. Delete one of them.")
        require_distinct(name, points, "lines")

    def stations(self, nodes: Sequence[int] | Indices) -> Array:
        """Arc lengths [m] of a sequence of nodes, from 0 at its first."""
        steps = np.linalg.norm(np.diff(self.points[np.asarray(nodes)], axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def tag_of(self, nodes: Sequence[int] | Indices) -> int:
        """Tag of the lines along nodes of a member, which is that of the first of these lines."""
        return int(self.tags[(np.sort(self.edges, axis=1) == np.sort(nodes[:2])).all(axis=1)].item())


def read_lines(path: str | PathLike[str]) -> LineMesh:
    """The lines of a mesh file [m] in any format of meshio, with points, edges and tags in the order of the file."""
    # Cells of other kinds are left out; every node must belong to a line or be a single point (vertex cell). In 3-D all
    # z must be equal. Loose nodes, lines of zero length or given twice, and nodes at the same place are refused.
    file = checks.path("mesh", path)
    mesh = read_file(file)
    edges = np.asarray(mesh.get_cells_type("line"), dtype=np.int64).reshape(-1, 2)
    if not len(edges):
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        text = f"{file}: no two-node line cells; the cells are: {kinds}"
        raise FileFormatError(f"{text}. Mesh the curves with elements of first order and export them.")
    # nodes that only vertex cells use, such as the centre of an arc in gmsh, are left out
    points = plane_points(file, mesh.points)
    on_line, single = np.zeros(len(points), dtype=bool), np.zeros(len(points), dtype=bool)
    on_line[edges] = True
    vertices = [block.data.ravel() for block in mesh.cells if block.type == "vertex"]
    single[np.concatenate([*vertices, np.zeros(0, dtype=np.int64)])] = True
    keep, tags = on_line | ~single, np.zeros(len(edges), dtype=np.int64)
    name = next((name for name in TAG_NAMES if name in mesh.cell_data), None)
    if name is not None:
        values = np.asarray(mesh.get_cell_data(name, "line"))
        # a file may hold several numbers a cell, or fractions, under any name
        numbers = values.shape == tags.shape and np.issubdtype(values.dtype, np.number)
        if not numbers or np.any(values != np.round(values)):
            text = f"{file}: cell data {name!r} are not one whole number for each line"
            raise FileFormatError(f"{text}. Give one number a line under this name, or export the mesh without it.")
        tags = values.astype(np.int64)
    return LineMesh(points[keep], (np.cumsum(keep) - 1)[edges], tags, name=str(file))


def chain(mesh: LineMesh) -> Indices:
    """Node indices of a mesh that must be one straight open chain, in the direction of its first line."""
    lines = _lines_at(mesh)
    branches = [node for node, at in enumerate(lines) if len(at) > 2]
    if branches:
        text = f"{mesh.name}: {len(lines[branches[0]])} lines meet at node {branches[0]}; a chain has no branches"
        raise InputError(f"{text}. Use members(mesh) for a frame.")
    stops = {node for node, at in enumerate(lines) if len(at) == 1}
    nodes = _walk(mesh, 0, lines, stops)[0]
    if not stops or nodes[0] == nodes[-1]:
        raise InputError(f"{mesh.name}: the lines close a loop; a chain has two ends. Use members(mesh) for a frame.")
    if len(nodes) < len(mesh.points):
        text = f"{mesh.name}: the chain from node {nodes[0]} to {nodes[-1]} has {len(nodes)} nodes"
        raise InputError(f"{text}, the mesh {len(mesh.points)}. Join the pieces, or use members(mesh).")
    _require_straight(mesh, nodes)
    return np.array(nodes, dtype=np.int64)


def members(mesh: LineMesh) -> list[Indices]:
    """The straight beams of a frame: node indices from corner, end, branch or change of tag to the next one."""
    # The first line of a beam in the file gives its direction, and the order of the beams. A gently curved line is no
    # straight beam and is refused.
    lines, stops = _lines_at(mesh), set[int]()  # beams end at an end, a branch, a change of tag, or a corner
    for node, at in enumerate(lines):
        bend = math.pi
        if len(at) == 2 and mesh.tags[at[0]] == mesh.tags[at[1]]:
            before, after = (mesh.points[_other(mesh, line, node)] for line in at)
            bend = _angle(mesh.points[node] - before, after - mesh.points[node])
        if bend > STRAIGHT:
            stops.add(node)
    done, result = set[int](), []
    for first in range(len(mesh.edges)):
        if first not in done:
            nodes, used = _walk(mesh, first, lines, stops)
            done.update(used)
            _require_straight(mesh, nodes)
            result.append(np.array(nodes, dtype=np.int64))
    return result


def read_file(file: Path) -> Any:
    """The mesh of meshio in a file, or `FileFormatError`."""
    if not file.is_file():
        raise FileFormatError(f"{file}: no such file. The current folder is {Path.cwd()}.")
    said = io.StringIO()
    try:
        # meshio prints, and leaves the program when no reader fits; readers raise whatever broken text leads to
        with redirect_stdout(said), redirect_stderr(said):
            mesh = meshio.read(file)
        # ValueError for cells with nodes that are not there, or with another number of nodes than their kind has
        from meshio._common import num_nodes_per_cell

        for block in mesh.cells:
            nodes = np.asarray(block.data)
            if block.type in num_nodes_per_cell and nodes.shape[1:] != (num_nodes_per_cell[block.type],):
                raise ValueError(f"cells {block.type} of shape {nodes.shape}")
            if nodes.size and nodes.dtype.kind in "iu" and not (nodes.min() >= 0 and nodes.max() < len(mesh.points)):
                raise ValueError(f"cells {block.type} with nodes beyond the {len(mesh.points)} points")
    except (meshio.ReadError, *BROKEN) as error:
        reason = str(error) if isinstance(error, Exception) else said.getvalue().strip().split("\n")[0]
        text = f"{file}: not a mesh that meshio can read ({type(error).__name__}: {reason})"
        raise FileFormatError(f"{text}. Export it as gmsh 2.2 (.msh) or VTK (.vtu).") from error
    return mesh


def plane_points(file: Path, points: Any) -> Array:
    """Nodes (n, 2) of a file, whose z must be equal [m]."""
    xyz = np.asarray(points, dtype=float)
    if xyz.ndim != 2 or xyz.shape[1] not in (2, 3):
        text = f"{file}: points have shape {xyz.shape}; flexmb needs plane points (n, 2) or (n, 3)"
        raise FileFormatError(f"{text}. Export the mesh with x and y coordinates.")
    sound = (np.abs(xyz) < FARTHEST).all(axis=1)
    if not sound.all():
        bad = int(np.argmin(sound))
        text = f"{file}: node {bad} is at {xyz[bad].tolist()}; coordinates must be finite, and below {FARTHEST:g} m"
        raise FileFormatError(f"{text}. Mesh the shape again.")
    if xyz.shape[1] == 3 and np.ptp(xyz[:, 2]) > SAME_PLACE * extent(xyz):
        text = f"{file}: z spreads over {np.ptp(xyz[:, 2]):g} m; flexmb is plane, all z must be equal"
        raise FileFormatError(f"{text}. Turn the mesh into the x-y plane.")
    return np.ascontiguousarray(xyz[:, :2])


def extent(points: Array) -> float:
    """Largest extent of points (n, 2) along an axis [m]."""
    return float(np.max(np.ptp(points, axis=0)))


def require_distinct(name: str, points: Array, joined: str) -> None:
    """Refusal of nodes (n, 2) at the same place; `joined`: the kind of cells that they should join."""
    same = cKDTree(points).query_pairs(SAME_PLACE * extent(points), output_type="ndarray")
    if len(same):
        i, j = min(same.tolist())
        text = f"{name}: nodes {i} and {j} lie at the same place {at(points, i)}, so the {joined} there are not joined"
        raise InputError(f"{text}; {len(same)} such pairs in all. Merge the nodes (in gmsh: Coherence Mesh).")


def at(points: Array, node: int) -> str:
    """Place of a node, for messages."""
    x, y = points[node]
    return f"({x:g}, {y:g}) m"


def _lines_at(mesh: LineMesh) -> list[list[int]]:
    """For each node, the lines that meet there."""
    lines: list[list[int]] = [[] for _ in mesh.points]
    for k, (i, j) in enumerate(mesh.edges.tolist()):
        lines[i].append(k)
        lines[j].append(k)
    return lines


def _other(mesh: LineMesh, line: int, node: int) -> int:
    i, j = mesh.edges[line]
    return int(j if node == i else i)


def _angle(a: Array, b: Array) -> float:
    """Angle between two directions, 0 to pi [rad]."""
    return float(abs(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)))


def _walk(mesh: LineMesh, first: int, lines: list[list[int]], stops: set[int]) -> Walk:
    """Nodes and lines through line `first`, on both sides to the next stop, or round a loop without one."""
    tail, head = mesh.edges[first].tolist()
    ahead, used = _follow(mesh, first, head, lines, stops)
    if ahead[-1] == tail:
        return [tail, *ahead], used
    behind, used_behind = _follow(mesh, first, tail, lines, stops)
    return [*reversed(behind), *ahead], [*used, *used_behind]


def _follow(mesh: LineMesh, line: int, node: int, lines: list[list[int]], stops: set[int]) -> Walk:
    """Nodes from `node` on, away from `line`, to the next stop, and the lines walked, `line` included."""
    nodes, used, start = [node], [line], line
    while node not in stops:
        line = next(k for k in lines[node] if k != line)
        if line == start:
            break
        node = _other(mesh, line, node)
        nodes.append(node)
        used.append(line)
    return nodes, used


def _require_straight(mesh: LineMesh, nodes: list[int]) -> None:
    path = mesh.points[nodes]
    chord = path[-1] - path[0]
    for k, step in enumerate(np.diff(path, axis=0)):
        angle = math.pi if nodes[0] == nodes[-1] else _angle(chord, step)  # a loop has no chord
        if angle > STRAIGHT:
            text = f"{mesh.name}: the lines from node {nodes[0]} to {nodes[-1]} are not straight: the one from node "
            text += f"{nodes[k]} to {nodes[k + 1]} is turned by {angle:.3g} rad against the chord"
            raise InputError(f"{text}. Use members(mesh) for a frame; replace an arc by straight pieces with corners.")
