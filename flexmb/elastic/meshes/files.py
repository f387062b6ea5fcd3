"""Plane meshes from files of gmsh and other generators, through meshio."""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.elastic.beams.mesh import plane_points, read_file
from flexmb.elastic.meshes.mesh import PlaneMesh, with_centres
from flexmb.elastic.meshes.outlines import halved
from flexmb.errors import FileFormatError
from flexmb.planar import Array, Indices

Groups = dict[str, list[Indices]]
# Kind of the cells of meshio.
CELLS = {"triangle": "tri3", "triangle6": "tri6", "quad": "quad4", "quad8": "quad9", "quad9": "quad9"}
TRIANGLES = {"quad4": "tri3", "quad9": "tri6"}  # kind of the triangles into which quadrilaterals are halved

TURNED = {  # nodes of a cell in the other sense of rotation, by kind
    "tri3": (0, 2, 1),
    "tri6": (0, 2, 1, 5, 4, 3),
    "quad4": (0, 3, 2, 1),
    "quad9": (0, 3, 2, 1, 7, 6, 5, 4, 8),
}

TAG = "gmsh:physical"  # cell data that hold the numbers of physical groups


def read(path: str | PathLike[str], unit: float = 1.0) -> PlaneMesh:
    """A plane mesh from a file in any format of meshio: gmsh, Abaqus, VTK, ...

    Names of physical curves, of sets of lines and of sets of nodes become sets; names of physical surfaces and of sets
    of cells become regions; groups without a name are called by their number.  Nodes that no cell uses are left out,
    clockwise cells are turned, eight-node quadrilaterals get a centre, and quadrilaterals beside triangles are halved.

    Parameters
    ----------
    path : the file; in 3-D all z must be equal.
    unit : metres in a unit of length of the file: 1e-3 for millimetres.

    Raises
    ------
    FileFormatError : no such file, not a mesh, no plane cells, linear beside quadratic cells, not plane.
    InputError : cells that are no body, see `PlaneMesh`.
    """
    file = checks.path("mesh", path)
    checks.positive(str(file), "unit", unit, "m")
    mesh = read_file(file)
    points = plane_points(file, mesh.points) * unit
    points, cells, kind, owners = _plane_cells(file, mesh, points)
    # Nodes by the name of a set, and cells by the name of a region
    sets: Groups = {_name(name): [np.asarray(nodes)] for name, nodes in mesh.point_sets.items()}
    regions: Groups = {}
    for name, members in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            given = [np.asarray(c if c is not None else [], dtype=np.int64) for c in members]
            _add(mesh, _name(name), given, sets, regions)
    names = {(int(dimension), int(tag)): name for name, (tag, dimension) in mesh.field_data.items()}
    for tag in np.unique(np.concatenate([*mesh.cell_data.get(TAG, []), np.zeros(0, dtype=int)])):
        for dimension in (1, 2):
            name = _name(names.get((dimension, int(tag)), str(int(tag))))
            if tag > 0 and name not in (sets if dimension == 1 else regions):
                of = [data == tag if _dimension(b) == dimension else np.zeros(len(data), dtype=bool)
                      for b, data in zip(mesh.cells, mesh.cell_data[TAG], strict=True)]  # fmt: skip
                _add(mesh, name, [np.flatnonzero(one) for one in of], sets, regions)
    numbers, used = np.full(len(points), -1), np.unique(cells)
    numbers[used] = np.arange(len(used))
    chosen = {name: numbers[np.unique(np.concatenate(nodes))] for name, nodes in sets.items()}  # -1: without a cell
    places = {name: np.flatnonzero(np.isin(owners, np.concatenate(own))) for name, own in regions.items()}
    own = {name: nodes[nodes >= 0] for name, nodes in chosen.items() if (nodes >= 0).any()}
    regions_found = {name: cells_of for name, cells_of in places.items() if cells_of.size}
    corners = points[cells[:, : 4 if kind.startswith("quad") else 3]]
    x, y = np.moveaxis(corners - corners[:, :1], 2, 0)
    area = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    upright = np.where(area[:, None] < 0.0, cells[:, TURNED[kind]], cells)  # corners counter-clockwise
    return PlaneMesh(points[used], numbers[upright], kind, own, regions_found, file.name)


def _plane_cells(file: Path, mesh: Any, points: Array) -> tuple[Array, Indices, str, Indices]:
    """Nodes, cells, their kind, and the number of the file's cell (blocks one after the other) of each cell."""
    given = [(b.type, b.data, n) for b, n in _blocks(mesh) if b.type in CELLS]
    blocks = [(CELLS[kind], kind, np.asarray(data, dtype=np.int64), n) for kind, data, n in given]
    kinds = {kind for kind, *_ in blocks}
    if not blocks:
        found = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        text = f"{file}: no plane cells; the cells are: {found}"
        raise FileFormatError(f"{text}. Mesh the surface with triangles or quadrilaterals and export these.")
    if len(kinds & {"tri3", "quad4"}) and len(kinds & {"tri6", "quad9"}):
        text = f"{file}: linear and quadratic cells in one mesh ({', '.join(sorted(kinds))})"
        raise FileFormatError(f"{text}. Export all cells with the same order.")
    cells, owners = [], []
    for kind, name, data, first in blocks:
        nodes = data
        if name == "quad8":
            points, nodes = with_centres(points, data)
        owner = first + np.arange(len(data))
        if len(kinds) > 1 and kind in TRIANGLES:
            nodes, owner = halved(points, nodes, TRIANGLES[kind]), np.tile(owner, 2)
        cells.append(nodes)
        owners.append(owner)
    kind = min(kinds, key=lambda k: k not in TRIANGLES.values())
    return points, np.concatenate(cells), kind, np.concatenate(owners)


def _blocks(mesh: Any) -> Iterator[tuple[Any, int]]:
    """Blocks of cells of a file, with the number of their first cell."""
    first = 0
    for block in mesh.cells:
        yield block, first
        first += len(block.data)


def _add(mesh: Any, name: str, members: list[Indices], sets: Groups, regions: Groups) -> None:
    """Add cells, given by block, to the nodes of a set (lines) or to the cells of a region."""
    for (block, first), own in zip(_blocks(mesh), members, strict=True):
        if own.size and _dimension(block) == 1:
            sets.setdefault(name, []).append(np.asarray(block.data)[own].ravel())
        elif own.size and block.type in CELLS:
            regions.setdefault(name, []).append(first + own)


def _dimension(block: Any) -> int:
    return 1 if block.type.startswith("line") else 2 if block.type in CELLS else 0


def _name(name: str) -> str:
    """A name as flexmb allows it: without dots, slashes and outer blanks."""
    return name.strip().replace(".", "_").replace("/", "_")
