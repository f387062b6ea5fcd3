"""A solution as VTK files, one a frame, for ParaView and other readers of VTK."""

from __future__ import annotations

import json
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.files import unwritable
from flexmb.errors import InputError

if TYPE_CHECKING:
    import meshio

    from flexmb.results.drawing import Line, Mark, Surface, SymbolLine
    from flexmb.results.solution import Solution

MOST_FRAMES = 200
FIELDS = ("axial_force", "bending_moment", "shear_force", "curvature", "bending_stiffness")
UNITS = {
    "displacement": "m",
    "deformation": "m",
    "axial_force": "N",
    "bending_moment": "N m",
    "shear_force": "N",
    "curvature": "1/m",
    "bending_stiffness": "N m2",
    "normal_force": "N",
    "stress_x": "Pa",
    "stress_y": "Pa",
    "stress_xy": "Pa",
    "von_mises": "Pa",
}
TRACES = "traces.vtu"
"""File of the paths of markers, beside the frames."""

CELLS = {"tri3": "triangle", "tri6": "triangle6", "quad4": "quad", "quad9": "quad9"}
"""Kinds of cells of meshes as meshio names them."""

KINDS = ("rigid", "beam", "joint", "revolute", "prismatic", "fixed", "clearance", "journal", "mesh")
"""Kinds of cells by number; kinds that a user's own parts bring follow after these."""


@dataclass(frozen=True)
class Frames:
    """Cells of all frames, and data of each frame."""

    points: np.ndarray  # (n, n_p, 3) [m]
    deformation: np.ndarray  # (n, n_p, 3) points less those of undeformed bodies [m]
    data: dict[str, np.ndarray]  # by name, (n, n_p)
    segments: np.ndarray  # (n_l, 2)
    vertices: np.ndarray  # (n_v, 1)
    part: tuple[np.ndarray, np.ndarray]  # number of the part, of segments and vertices
    kind: tuple[np.ndarray, np.ndarray]  # number of the kind, of segments and vertices
    kinds: tuple[str, ...]  # names of the kinds
    meshes: tuple[tuple[str, np.ndarray, int], ...]  # of each mesh: kind of meshio, points of cells, number of the part


@arguments.checked
def write_vtk(sol: Solution, path: str | Path, frames: int | None = None, *, points_per_element: int = 8) -> Path:
    """Write the motion as a ParaView collection: `path` (.pvd), and beside it a folder with one .vtu file a frame.

    Beams are drawn with their deformed shape; springs, dampers, rods, cables, belts, guides, pitch circles and forces
    are lines as in pictures; joints are vertices; plane bodies are their deformed meshes.  Point data: displacement
    (since the first frame, with the rigid motion), deformation (against the unstressed body laid through its joints, as
    `magnify` has it in pictures: a mechanism warped by it stays together), axial_force, bending_moment, shear_force,
    curvature and bending_stiffness of beams (signs as in `elastic.beams.shapes`), normal_force of contacts,
    and stress_x, stress_y, stress_xy in world axes and von_mises of plane bodies; 0 where it does not apply.  Cell
    data: part and kind, numbers whose names stand in names.json in the folder of the frames.  Paths of markers with
    `trace` are part 1 of each frame, in one file with the time as point data.  Older frames of the name are
    replaced.

    Parameters
    ----------
    sol : the solution.
    path : the .pvd file; missing folders are made.
    frames : number of frames, >= 2, evenly over the time; the nearest saved instants are taken, each once, the first
        and the last always.  None: all saved instants, at most 200.
    points_per_element : points along each beam element, its two nodes included, >= 2.

    Returns
    -------
    Path
        The .pvd file.

    Raises
    ------
    InputError : a path that cannot be written, fewer than 2 frames, a solution without instants or shapes.
    """
    target = _checked_target(path)
    per_element = checks.count("write_vtk", "points_per_element", points_per_element, 2)
    instants = _chosen(sol, frames)
    content = _content(sol, instants, per_element)
    try:
        return _write(sol, content, instants, target)
    except (OSError, ValueError) as error:
        raise unwritable(target, error, "write_vtk") from error


def _checked_target(path: str | Path) -> Path:
    target = Path(path)
    if target.suffix not in {"", ".pvd"} or not target.name:
        raise InputError(f"write_vtk: path is {str(path)!r}; it must end in .pvd, the format of a series of frames.")
    return target.with_suffix(".pvd")


def _chosen(sol: Solution, frames: int | None) -> np.ndarray:
    """Numbers of the saved instants that become frames."""
    from flexmb.results.drawing import nearest_instants
    from flexmb.results.solution import require_rows

    require_rows("write_vtk", sol)
    if frames is None:
        if len(sol.time) <= MOST_FRAMES:
            return np.arange(len(sol.time))
        frames = MOST_FRAMES
    n = checks.count("write_vtk", "frames", frames, 2)
    return nearest_instants(sol, np.linspace(sol.time[0], sol.time[-1], n))


def _content(sol: Solution, instants: np.ndarray, points_per_element: int) -> Frames:
    """Points, cells and data of all frames."""
    from flexmb.results import drawing
    from flexmb.results.positions import magnified, with_values

    shown = with_values(sol, sol.time[instants], sol.values[instants])
    bodies, signs, marks, meshes = _drawn(shown, points_per_element)
    lines = [*bodies, *(drawing.Line(sign.part, sign.points, {}) for sign in signs)]
    number = {name: k for k, name in enumerate(drawing.parts(sol))}
    kinds = tuple(dict.fromkeys([*KINDS, *(sign.kind for sign in signs), *(m.kind for m in marks)]))
    points = _places(bodies, signs, marks, meshes)
    counts = [mesh.points.shape[1] for mesh in meshes]
    first = points.shape[1] - sum(counts) + np.cumsum([0, *counts])
    segments, owner = _segments(lines)
    vertices = np.arange(len(marks))[:, None] + sum(line.points.shape[1] for line in lines)
    kind_of = [int(line.is_beam) for line in bodies] + [kinds.index(sign.kind) for sign in signs]
    of_lines = np.array([(number[x.part], k) for x, k in zip(lines, kind_of, strict=True)], dtype=np.int64).reshape(
        -1, 2
    )
    of_marks = np.array([(number[m.part], kinds.index(m.kind)) for m in marks], dtype=np.int64).reshape(-1, 2)
    return Frames(
        points=points,
        deformation=points - _places(*_drawn(magnified(shown, 0.0), points_per_element)),
        data=_point_data(lines, marks, meshes, len(instants)),
        segments=segments,
        vertices=vertices,
        part=(of_lines[owner, 0], of_marks[:, 0]),
        kind=(of_lines[owner, 1], of_marks[:, 1]),
        kinds=kinds,
        meshes=tuple((CELLS[m.shape.kind], m.cells + k, number[m.part]) for m, k in zip(meshes, first, strict=False)),
    )


def _drawn(sol: Solution, points_per_element: int) -> tuple[list[Line], list[SymbolLine], list[Mark], list[Surface]]:
    """Lines of bodies, symbols, joints and meshes at all saved instants."""
    from flexmb.results import drawing
    from flexmb.results.drawing import symbols

    instants = np.arange(len(sol.time))
    bodies, marks = drawing.lines(sol, instants, points_per_element), drawing.marks(sol, instants)
    places = [line.points.reshape(-1, 2) for line in bodies] + [mark.points for mark in marks]
    signs = symbols(sol, instants, float(np.ptp(np.concatenate(places), axis=0).max()) if places else 1.0)
    return [line for line in bodies if not line.of_mesh], signs, marks, drawing.surfaces(sol, instants)


def _places(bodies: list[Line], signs: list[SymbolLine], marks: list[Mark], meshes: list[Surface]) -> np.ndarray:
    """Places (n, n_p, 3) of all points: lines, joints, meshes [m]."""
    flat = [*(x.points for x in bodies), *(x.points for x in signs), *(m.points[:, None] for m in marks)]
    flat += [mesh.points for mesh in meshes]
    return np.pad(np.concatenate(flat, axis=1), ((0, 0), (0, 0), (0, 1)))


def _segments(lines: list[Line]) -> tuple[np.ndarray, np.ndarray]:
    """Two-point cells along all lines, and the number of the line of each cell."""
    cells, owner, first = [np.zeros((0, 2), dtype=np.int64)], [np.zeros(0, dtype=np.int64)], 0
    for k, line in enumerate(lines):
        m = line.points.shape[1]
        start = first + np.arange(m - 1)
        cells.append(np.stack([start, start + 1], axis=1))
        owner.append(np.full(m - 1, k))
        first += m
    return np.concatenate(cells), np.concatenate(owner)


def _point_data(lines: list[Line], marks: list[Mark], meshes: list[Surface], n: int) -> dict[str, np.ndarray]:
    """Fields (n, points) of lines, joints and meshes, in this order."""
    on_lines = sum(line.points.shape[1] for line in lines)
    on_meshes = np.zeros((n, sum(mesh.points.shape[1] for mesh in meshes)))
    data = {}
    for field in FIELDS:
        columns = [line.fields.get(field, np.zeros(line.points.shape[:2])) for line in lines]
        data[field] = np.concatenate([np.zeros((n, 0)), *columns, np.zeros((n, len(marks))), on_meshes], axis=1)
    forces = [m.force[:, None] for m in marks]
    data["normal_force"] = np.concatenate([np.zeros((n, on_lines)), *forces, on_meshes], axis=1)
    if meshes:
        before = np.zeros((n, on_lines + len(marks)))
        for k, field in enumerate(("stress_x", "stress_y", "stress_xy")):
            data[field] = np.concatenate([before, *(mesh.stress[..., k] for mesh in meshes)], axis=1)
        data["von_mises"] = np.concatenate([before, *(mesh.von_mises for mesh in meshes)], axis=1)
    return data


def _write(sol: Solution, content: Frames, instants: np.ndarray, target: Path) -> Path:
    """Write all files into a folder of their own first, so that a full disk leaves the old frames whole."""
    import meshio

    folder = target.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    digits = max(4, len(str(len(instants) - 1)))
    names = [f"{target.stem}_{k:0{digits}d}.vtu" for k in range(len(instants))]
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.stem}.") as scratch:
        for k, name in enumerate(names):
            meshio.write(Path(scratch) / name, _mesh(content, k))
        legend = {"parts": _numbered(_part_names(sol)), "kinds": _numbered(content.kinds), "units": UNITS}
        (Path(scratch) / "names.json").write_text(json.dumps(legend, indent=2), encoding="utf-8")
        traced = _trace_mesh(sol)
        if traced is not None:
            meshio.write(Path(scratch) / TRACES, traced)
        collection = Path(scratch) / target.name
        text = _collection(folder.name, names, sol.time[instants], TRACES if traced is not None else None)
        collection.write_text(text, encoding="utf-8", errors="surrogateescape")  # names of files as the system has them
        for stale in _frames_in(folder, target.stem):
            stale.unlink()
        for name in [*names, "names.json", *([TRACES] if traced is not None else [])]:
            (Path(scratch) / name).replace(folder / name)
        collection.replace(target)
    return target


def _mesh(content: Frames, k: int) -> meshio.Mesh:
    """Frame k as a mesh of meshio."""
    import meshio

    cells = [("line", content.segments), ("vertex", content.vertices), *(mesh[:2] for mesh in content.meshes)]
    part = [*content.part, *(np.full(len(own), number) for _, own, number in content.meshes)]
    kind = [*content.kind, *(np.full(len(own), content.kinds.index("mesh")) for _, own, _ in content.meshes)]
    used = [i for i, (_, cell) in enumerate(cells) if len(cell)]
    data = {name: values[k] for name, values in content.data.items()}
    return meshio.Mesh(
        content.points[k],
        [cells[i] for i in used],
        point_data={
            "displacement": content.points[k] - content.points[0],
            "deformation": content.deformation[k],
            **data,
        },
        cell_data={"part": [part[i] for i in used], "kind": [kind[i] for i in used]},
    )


def _trace_mesh(sol: Solution) -> meshio.Mesh | None:
    """Paths of all markers with a trace over the saved instants; None without such markers."""
    import meshio

    from flexmb.results.drawing import traces

    paths = list(traces(sol).values())
    if not paths:
        return None
    n = len(sol.time)
    points = np.concatenate([np.column_stack([path, np.zeros(n)]) for path in paths])
    steps = np.concatenate([k * n + np.arange(n - 1) for k in range(len(paths))])
    data = {"time": np.tile(sol.time, len(paths))}
    return meshio.Mesh(points, [("line", np.column_stack([steps, steps + 1]))], point_data=data)


def _frames_in(folder: Path, stem: str) -> list[Path]:
    """Frames that an earlier call left in the folder."""
    pattern = re.compile(re.escape(stem) + r"_\d{4,}\.vtu")
    return [file for file in folder.iterdir() if pattern.fullmatch(file.name) or file.name == TRACES]


def _part_names(sol: Solution) -> tuple[str, ...]:
    from flexmb.results.drawing import parts

    return parts(sol)


def _numbered(names: tuple[str, ...]) -> dict[str, str]:
    return {str(k): name for k, name in enumerate(names)}


def _collection(folder: str, names: list[str], times: np.ndarray, traced: str | None) -> str:
    """Text of the collection: the frame of each time, and the file of the paths (None: no paths)."""
    rows = [
        f'    <DataSet timestep="{float(t)!r}" group="" part="{part}" file={quoteattr(f"{folder}/{name}")}/>'
        for t, frame in zip(times, names, strict=True)
        for part, name in enumerate([frame, *([traced] if traced else [])])
    ]
    head = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "  <Collection>"]
    return "\n".join([*head, *rows, "  </Collection>", "</VTKFile>", ""])
