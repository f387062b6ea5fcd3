"""A solution as VTK files, one a frame, for ParaView and other readers of VTK."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Mapping
from html import escape
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.files import unwritable
from flexmb.errors import InputError
from flexmb.late import meshio
from flexmb.results import drawing
from flexmb.results.positions import magnified, with_values
from flexmb.results.solution import Solution, require_rows

MOST_FRAMES = 200
FIELDS = ("axial_force", "bending_moment", "shear_force", "curvature", "bending_stiffness")
UNITS = {
    "displacement": "m", "deformation": "m", "axial_force": "N", "bending_moment": "N m", "shear_force": "N",
    "curvature": "1/m", "bending_stiffness": "N m2", "normal_force": "N",
    "stress_x": "Pa", "stress_y": "Pa", "stress_xy": "Pa", "von_mises": "Pa",
}  # fmt: skip
TRACES = "traces.vtu"  # file of the paths of markers, beside the frames
CELLS = {"tri3": "triangle", "tri6": "triangle6", "quad4": "quad", "quad9": "quad9"}  # kinds of cells, as in meshio
# Kinds of cells by number; kinds that a user's own parts bring follow after these.
KINDS = ("rigid", "beam", "joint", "revolute", "prismatic", "fixed", "clearance", "journal", "mesh")
STRESSES = ("stress_x", "stress_y", "stress_xy")  # stresses of meshes in world axes


class Piece(NamedTuple):
    """A drawn thing at n instants."""

    points: np.ndarray  # (n, m, 2) its points [m]
    cell: str  # kind of its cells as meshio names it
    cells: np.ndarray  # (k, j) numbers of the points of each cell
    part: str  # name of its part
    kind: str  # and of its own kind
    data: Mapping[str, np.ndarray]  # (n, m) fields at its points, by name


@arguments.checked
def write_vtk(sol: Solution, path: str | Path, frames: int | None = None, *, points_per_element: int = 8) -> Path:
    """Write the motion as a ParaView collection: `path` (.pvd), which is returned, and a folder with one .vtu a frame.

    Beams are drawn with their deformed shape; springs, dampers, rods, cables, belts, guides, pitch circles and forces
    are lines as in pictures; joints are vertices; plane bodies are their deformed meshes.  Point data: displacement
    (since the first frame, with the rigid motion), deformation (against the unstressed body laid through its joints, as
    `magnify` has it in pictures: a mechanism warped by it stays together), axial_force, bending_moment, shear_force,
    curvature and bending_stiffness of beams (signs as in `elastic.beams.fem`), normal_force of contacts, and stress_x,
    stress_y, stress_xy in world axes and von_mises of plane bodies; 0 where it does not apply.  Cell data: part and
    kind, numbers whose names stand in names.json in the folder of the frames.  Paths of markers with `trace` are part 1
    of each frame, in one file with the time as point data.  Older frames of the name are replaced.

    Parameters
    ----------
    sol : the solution.
    path : the .pvd file; missing folders are made.
    frames : number of frames, >= 2, evenly over the time; the nearest saved instants are taken, each once, the first
        and the last always.  None: all saved instants, at most 200.
    points_per_element : points along each beam element, its two nodes included, >= 2.

    Raises
    ------
    InputError : a path that cannot be written, fewer than 2 frames, a solution without instants or shapes.
    """
    target = checks.path("write_vtk", path)
    if target.suffix not in {"", ".pvd"} or not target.name:
        raise InputError(f"write_vtk: path is {str(path)!r}; it must end in .pvd, the format of a series of frames.")
    target = target.with_suffix(".pvd")
    per_element = checks.count("write_vtk", "points_per_element", points_per_element, 2)
    # Numbers of the saved instants that become frames
    require_rows("write_vtk", sol)
    if frames is None:
        instants = drawing.spread_instants(sol, MOST_FRAMES)
    else:
        n = checks.count("write_vtk", "frames", frames, 2)
        instants = drawing.nearest_instants(sol, np.linspace(sol.time[0], sol.time[-1], n))
    kinds, meshes = _frames(sol, instants, per_element)
    try:
        return _write(sol, meshes, kinds, sol.time[instants], target)
    except (OSError, ValueError) as error:
        raise unwritable(target, error, "write_vtk") from error


def _frames(sol: Solution, instants: np.ndarray, points_per_element: int) -> tuple[tuple[str, ...], list[meshio.Mesh]]:
    """Names of the kinds by their numbers, and the meshes of all frames."""
    shown = with_values(sol, sol.time[instants], sol.values[instants])
    pieces = _pieces(shown, points_per_element)
    kinds = tuple(dict.fromkeys([*KINDS, *(piece.kind for piece in pieces)]))
    number = {name: k for k, name in enumerate(drawing.parts(sol))}
    first = np.cumsum([0, *(piece.points.shape[1] for piece in pieces)])
    cells: list[tuple[str, np.ndarray]] = []
    labels: dict[str, list[np.ndarray]] = {"part": [], "kind": []}
    for cell, group in groupby(zip(pieces, first, strict=False), lambda pair: pair[0].cell):
        own = list(group)
        counts = [len(piece.cells) for piece, _ in own]
        cells.append((cell, np.concatenate([piece.cells + at for piece, at in own])))
        labels["part"].append(np.repeat([number[piece.part] for piece, _ in own], counts))
        labels["kind"].append(np.repeat([kinds.index(piece.kind) for piece, _ in own], counts))
    names = [*FIELDS, "normal_force", *((*STRESSES, "von_mises") if any(p.kind == "mesh" for p in pieces) else ())]
    zeros, points = [np.zeros(piece.points.shape[:2]) for piece in pieces], _places(pieces)
    data = {"displacement": points - points[0]}
    data["deformation"] = points - _places(_pieces(magnified(shown, 0.0), points_per_element))
    for name in names:
        columns = (piece.data.get(name, none) for piece, none in zip(pieces, zeros, strict=True))
        data[name] = np.concatenate([*columns], axis=1)
    frames = ({name: values[k] for name, values in data.items()} for k in range(len(points)))
    return kinds, [meshio.Mesh(now, cells, now_data, labels) for now, now_data in zip(points, frames, strict=True)]


def _pieces(sol: Solution, points_per_element: int) -> list[Piece]:
    """Lines of bodies, symbols, joints and meshes at all saved instants."""
    instants = np.arange(len(sol.time))
    bodies, marks = drawing.lines(sol, instants, points_per_element), drawing.marks(sol, instants)
    places = [line.points.reshape(-1, 2) for line in bodies] + [mark.points for mark in marks]
    signs = drawing.symbols(sol, instants, float(np.ptp(np.concatenate(places), axis=0).max()) if places else 1.0)
    lines = [line for line in bodies if line.kind != drawing.MESH] + signs
    found = [Piece(x.points, "line", _steps(x.points.shape[1]), x.part, x.kind, x.fields) for x in lines]
    for mark in marks:
        force = {"normal_force": mark.force[:, None]}
        found.append(Piece(mark.points[:, None], "vertex", np.zeros((1, 1), dtype=int), mark.part, mark.kind, force))
    for mesh in drawing.surfaces(sol, instants):
        data = {name: mesh.stress[..., k] for k, name in enumerate(STRESSES)} | {"von_mises": mesh.von_mises}
        found.append(Piece(mesh.points, CELLS[mesh.shape.kind], mesh.cells, mesh.part, "mesh", data))
    return found


def _steps(count: int) -> np.ndarray:
    """Cells (count - 1, 2) along a line of some points."""
    return np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)


def _places(pieces: list[Piece]) -> np.ndarray:
    """Places (n, n_p, 3) of all points [m]."""
    return np.pad(np.concatenate([piece.points for piece in pieces], axis=1), ((0, 0), (0, 0), (0, 1)))


def _write(sol: Solution, meshes: list[meshio.Mesh], kinds: tuple[str, ...], times: np.ndarray, target: Path) -> Path:
    """Write all files into a folder of their own first, so that a full disk leaves the old frames whole."""
    folder = target.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    digits = max(4, len(str(len(times) - 1)))
    names = [f"{target.stem}_{k:0{digits}d}.vtu" for k in range(len(times))]
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.stem}.") as scratch:
        for name, mesh in zip(names, meshes, strict=True):
            meshio.write(Path(scratch) / name, mesh)
        words = ("parts", drawing.parts(sol)), ("kinds", kinds)
        legend: dict[str, Any] = {word: {str(k): one for k, one in enumerate(own)} for word, own in words}
        legend["units"] = UNITS
        (Path(scratch) / "names.json").write_text(json.dumps(legend, indent=2), encoding="utf-8")
        paths, n = list(drawing.traces(sol).values()), len(sol.time)  # of markers over the saved instants
        traced = [TRACES] if paths else []
        if paths:
            points = np.concatenate([np.column_stack([path, np.zeros(n)]) for path in paths])
            steps = np.concatenate([k * n + _steps(n) for k in range(len(paths))])
            whole = meshio.Mesh(points, [("line", steps)], point_data={"time": np.tile(sol.time, len(paths))})
            meshio.write(Path(scratch) / TRACES, whole)
        rows = [  # the frame of each time, and the file of the paths, if there are some
            f'    <DataSet timestep="{float(t)!r}" group="" part="{part}" file="{escape(f"{folder.name}/{name}")}"/>'
            for t, frame in zip(times, names, strict=True)
            for part, name in enumerate([frame, *traced])
        ]
        head = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "  <Collection>"]
        collection = Path(scratch) / target.name
        text = "\n".join([*head, *rows, "  </Collection>", "</VTKFile>", ""])
        collection.write_text(text, encoding="utf-8", errors="surrogateescape")  # names of files as the system has them
        pattern = re.compile(re.escape(target.stem) + r"_\d{4,}\.vtu")
        for stale in [file for file in folder.iterdir() if pattern.fullmatch(file.name) or file.name == TRACES]:
            stale.unlink()
        for name in [*names, "names.json", *traced]:
            (Path(scratch) / name).replace(folder / name)
        collection.replace(target)
    return target
