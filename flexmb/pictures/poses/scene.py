"""Everything that is drawn of a run at some instants: lines, joints, symbols, paths, forces, limits of the axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexmb.errors import InputError
from flexmb.results import drawing
from flexmb.results.drawing import Line, Mark
from flexmb.results.solution import Solution
from flexmb.results.surfaces import Surface
from flexmb.results.symbols import ARROW, HEAD, SymbolLine, symbols

Box = tuple[tuple[float, float], tuple[float, float]]
"""Limits of x and of y [m]."""

PER_ELEMENT = 9
"""Number of points on a beam element."""

SHARE = 98.0
"""Percentile of absolute values at which colours and lengths of arrows end; impacts would make all else too small."""

BOX_POSES = 400
"""Number of poses of a run, at most, that the limits of the axes are taken from."""


@dataclass(frozen=True)
class Scene:
    """Drawing of a run at n instants.

    Parameters
    ----------
    name : name of the mechanism.
    time : (n,) instants [s].
    lines : outlines of rigid bodies and meshes, axes of beams.
    marks : joints and markers.
    signs : symbols of springs, loads, couplings.
    forces : arrows of joint forces, at most as long as the arrow of a load.
    paths : paths (m, 2) of points by name [m], and their instants (m,) [s].
    box : limits of x and y.
    surfaces : meshes of plane bodies.
    """

    name: str
    time: np.ndarray
    lines: list[Line]
    marks: list[Mark]
    signs: list[SymbolLine]
    box: Box
    forces: list[SymbolLine] = field(default_factory=list)
    paths: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    surfaces: list[Surface] = field(default_factory=list)

    @property
    def size(self) -> float:
        """Width of the picture [m]."""
        return self.box[0][1] - self.box[0][0]

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the bodies with lines, in their order."""
        return tuple(dict.fromkeys(line.part for line in self.lines))


def scene_of(
    sol: Solution,
    rows: np.ndarray,
    *,
    box: Box | None = None,
    paths: dict[str, tuple[np.ndarray, np.ndarray]] | None = None,
    forces: Sequence[str] = (),
    true: Solution | None = None,
) -> Scene:
    """Scene of saved rows with numbers (n,) of a solution; `box`: limits of the axes, None: room for all poses.

    `paths` are paths of points by name, with their instants; None: those of the markers with a trace.  Section forces
    and stresses are those of `true` where the deformation of `sol` is magnified.
    """
    traced = {name: (path, sol.time) for name, path in drawing.traces(sol).items()} if paths is None else paths
    limits = box_of_run(sol, list(traced.values())) if box is None else box
    size = limits[0][1] - limits[0][0]
    lines, marks = drawing.lines(sol, rows, PER_ELEMENT), drawing.marks(sol, rows)
    arrows = joint_forces(sol, rows, marks, forces, size)
    signs, meshes = symbols(sol, rows, size), drawing.surfaces(sol, rows)
    if true is not None:
        for line, own in zip(lines, drawing.lines(true, rows, PER_ELEMENT), strict=True):
            line.fields.update(own.fields)
        own_poses = (mesh.poses for mesh in drawing.surfaces(true, rows))
        meshes = [replace(mesh, poses=poses) for mesh, poses in zip(meshes, own_poses, strict=True)]
    return Scene(sol.name, sol.time[rows], lines, marks, signs, limits, arrows, traced, meshes)


LEAST_SIZE, LONE_POINT = 1e-9, 0.1
"""Extent of a mechanism [m] below which it is a point, and the width of a picture of a point [m]."""


def box_of_run(sol: Solution, paths: Sequence[tuple[np.ndarray, np.ndarray]] = ()) -> Box:
    """Limits of x and y that hold all poses of a run, some hundred of them in long runs."""
    every = np.unique(np.linspace(0, len(sol.time) - 1, min(len(sol.time), BOX_POSES)).round().astype(int))
    lines, marks = drawing.lines(sol, every, PER_ELEMENT), drawing.marks(sol, every)
    points = [line.points for line in lines] + [m.points for m in marks] + [path for path, _ in paths]
    whole = np.concatenate([p.reshape(-1, 2) for p in points])
    size = float(max(*np.ptp(whole, axis=0), 1e-9))
    return box_around([whole, *(sign.points for sign in symbols(sol, every, size))])


def box_around(points: list[np.ndarray]) -> Box:
    """Limits of x and y around all points (..., 2) [m], with a margin."""
    flat = np.concatenate([p.reshape(-1, 2) for p in points])
    low, high = flat.min(axis=0), flat.max(axis=0)
    size = float(max(*(high - low)))
    if size < LEAST_SIZE:  # a single point
        size = LONE_POINT
    margin, least = 0.12 * size, 0.35 * size
    widen = np.maximum(least - (high - low), 0.0) / 2.0 + margin
    (x0, y0), (x1, y1) = (low - widen).tolist(), (high + widen).tolist()
    return (x0, x1), (y0, y1)


def box_about(sol: Solution, row: int, centre: np.ndarray) -> Box:
    """Limits of x and y around a point (2,) [m], as wide as the bodies need in any direction at one instant."""
    points = np.concatenate([line.points[0] for line in drawing.lines(sol, np.array([row]), PER_ELEMENT)])
    reach = float(np.hypot(*(points - centre).T).max())
    return box_around([centre + reach * np.array([[-1.0, -1.0], [1.0, 1.0]])])


def joint_forces(
    sol: Solution, rows: np.ndarray, marks: Sequence[Mark], joints: Sequence[str], size: float
) -> list[SymbolLine]:
    """Arrows of the forces of joints on their second bodies, at saved instants with numbers (n,).

    Their lengths are proportional to the forces up to the 98th percentile of all of them, which has the length of a
    load's arrow; larger forces, those of impacts, have the same length.  The size of the picture is in m.
    """
    places = {mark.part: mark.points for mark in marks if mark.kind != "journal"}
    vectors = {name: np.stack([sol.array(f"{name}.fx"), sol.array(f"{name}.fy")], axis=-1)[rows] for name in joints}
    sizes = np.concatenate([np.zeros(1), *(np.hypot(*v.T) for v in vectors.values())])
    top = float(np.percentile(sizes, SHARE)) or float(sizes.max()) or 1.0
    found = []
    for name, vector in vectors.items():
        if name not in places:
            raise InputError(f"forces: {name!r} is no joint that is drawn. Known: {', '.join(places)}.")
        arrow = ARROW * size * vector / np.maximum(np.hypot(*vector.T), top)[:, None]
        length = np.hypot(*arrow.T)[:, None]
        unit = arrow / np.where(length > 0.0, length, 1.0)
        normal = np.stack([-unit[:, 1], unit[:, 0]], axis=-1)
        head = np.minimum(HEAD * size, 0.6 * length)
        base, tip = places[name], places[name] + arrow
        back, side = tip - head * unit, 0.4 * head * normal
        points = np.stack([base, tip, back + side, tip, back - side], axis=1)
        found.append(SymbolLine(name, "force", points))
    return found
