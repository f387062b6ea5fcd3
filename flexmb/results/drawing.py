"""Drawing of a solution at chosen instants: lines and points in the plane, for files and pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.beams import hermite
from flexmb.errors import InputError
from flexmb.model.shape import TRACE, BeamShape, MeshShape, Place, PointShape, RigidShape, nodes_of
from flexmb.results.solution import Solution
from flexmb.results.surfaces import Surface, moved_points

GROUND = "ground"


@dataclass(frozen=True)
class Line:
    """A polyline of a part at n instants, with the section forces of beams.

    `fields` holds arrays (n, m) by name; it is empty for rigid lines.  `depth` (m,) is the depth of a beam in the plane
    [m], 0 where it is unknown.  `of_mesh`: whether it is the outline or a hole of a mesh.
    """

    part: str
    points: np.ndarray  # (n, m, 2) [m]
    fields: dict[str, np.ndarray]
    depth: np.ndarray | None = None
    of_mesh: bool = False

    @property
    def is_beam(self) -> bool:
        """Whether the line is the axis of a beam element."""
        return bool(self.fields)


@dataclass(frozen=True)
class Mark:
    """A joint, or the journal of a joint with clearance, at n instants."""

    part: str
    kind: str
    points: np.ndarray  # (n, 2) [m]
    force: np.ndarray  # (n,) normal force of a contact [N], else 0
    on_ground: bool
    slides: bool = False  # along a guide or a slot


def nearest_instants(sol: Solution, times: np.ndarray) -> np.ndarray:
    """Numbers of the saved instants nearest to `times` [s], increasing and each only once."""
    return np.unique(nearest_to_each(sol, times))


def nearest_to_each(sol: Solution, times: np.ndarray) -> np.ndarray:
    """Number of the saved instant nearest to each of `times` [s]."""
    right = np.clip(np.searchsorted(sol.time, times), 1, max(len(sol.time) - 1, 1))
    right = np.minimum(right, len(sol.time) - 1)
    left = np.maximum(right - 1, 0)
    nearer_left = np.abs(times - sol.time[left]) <= np.abs(sol.time[right] - times)
    return np.where(nearer_left, left, right)


def pose(sol: Solution, part: str, node: str, instants: np.ndarray) -> np.ndarray:
    """x, y, theta (n, 3) of a node at the saved `instants`; the ground stands at the origin."""
    if part == GROUND:
        return np.zeros((len(instants), 3))
    stem = f"{part}.{node}" if node else part
    return np.stack([sol.array(f"{stem}.{axis}")[instants] for axis in ("x", "y", "theta")], axis=-1)


def require_nodes(sol: Solution) -> None:
    """Refuse a solution whose run did not save where the nodes of its shapes are."""
    nodes: dict[str, None] = {}
    for shape in sol.shapes:
        nodes |= {f"{part}.{node}" if node else part: None for part, node in nodes_of(shape) if part != GROUND}
    missing = [f"{node}.{axis}" for node in nodes for axis in ("x", "y", "theta") if f"{node}.{axis}" not in sol]
    if missing:
        parts = list(dict.fromkeys(name.partition(".")[0] for name in missing))
        shown = ", ".join(missing[:3]) + (f" and {len(missing) - 3} more" if len(missing) > 3 else "")
        wanted = ", ".join(repr(f"{part}.*") for part in parts[:3]) + (", ..." if len(parts) > 3 else "")
        raise InputError(
            f"Solution of {sol.name!r}: to draw it, signals are missing that were not saved: {shown}. "
            f"Add {wanted} to simulate(..., signals=[...]), or leave it out to save all."
        )


def carried(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (m, 2) in the frame of a node, carried along by its poses (n, 3): (n, m, 2)."""
    c, s = np.cos(pose[:, 2, None]), np.sin(pose[:, 2, None])
    x, y = points[None, :, 0], points[None, :, 1]
    return np.stack([pose[:, 0, None] + c * x - s * y, pose[:, 1, None] + s * x + c * y], axis=-1)


def path(sol: Solution, point: Place, instants: np.ndarray) -> np.ndarray:
    """Positions (n, 2) of a point of a body at saved instants [m]."""
    body, node, offset = point
    return carried(pose(sol, body, node, instants), np.array([offset], dtype=float))[:, 0]


def lines(sol: Solution, instants: np.ndarray, points_per_element: int) -> list[Line]:
    """All lines of the solution: outlines of rigid bodies and meshes, axes of beams, in the order of the shapes."""
    require_nodes(sol)
    xi = np.linspace(0.0, 1.0, points_per_element)
    found = []
    for shape in sol.shapes:
        if isinstance(shape, RigidShape):
            at = pose(sol, shape.part, shape.node, instants)
            found += [Line(shape.part, carried(at, np.array(line, dtype=float)), {}) for line in shape.lines]
        elif isinstance(shape, BeamShape):
            found.append(_beam(sol, shape, instants, xi))
        elif isinstance(shape, MeshShape):
            rims = surface(sol, shape, instants).outlines()
            found += [Line(shape.part, rim, {}, of_mesh=True) for rim in rims]
    return found


def surfaces(sol: Solution, instants: np.ndarray) -> list[Surface]:
    """All meshes of the solution, in the order of the shapes."""
    return [surface(sol, shape, instants) for shape in sol.shapes if isinstance(shape, MeshShape)]


def surface(sol: Solution, shape: MeshShape, instants: np.ndarray) -> Surface:
    """A mesh at the saved `instants`."""
    poses = np.stack([pose(sol, shape.part, node, instants) for node in shape.nodes], axis=1)
    return Surface(shape.part, shape, moved_points(shape, poses), poses)


def marks(sol: Solution, instants: np.ndarray) -> list[Mark]:
    """All joints; one with clearance gives its bearing and, where the run recorded ex and ey, its journal."""
    require_nodes(sol)
    found = []
    for shape in sol.shapes:
        if not isinstance(shape, PointShape):
            continue
        at = pose(sol, shape.body, shape.node, instants)
        points = carried(at, np.array([shape.offset], dtype=float))[:, 0]
        name = f"{shape.part}.normal_force"
        force = sol.array(name)[instants] if name in sol else np.zeros(len(instants))
        slides = shape.along is not None
        ground = not slides and GROUND in (shape.body, shape.other[0] if shape.other is not None else "")
        found.append(Mark(shape.part, shape.kind, points, force, ground, slides))
        if f"{shape.part}.ex" in sol and not slides:
            play = np.stack([sol.array(f"{shape.part}.{axis}")[instants] for axis in ("ex", "ey")], axis=-1)
            found.append(Mark(shape.part, "journal", points + play, force, on_ground=False))
    return found


def traces(sol: Solution) -> dict[str, np.ndarray]:
    """Paths (n, 2) of the markers with a trace over all saved instants, by the name of the marker [m]."""
    whole = np.arange(len(sol.time))
    found = {}
    for shape in sol.shapes:
        if isinstance(shape, PointShape) and shape.kind == TRACE:
            found[shape.part] = path(sol, (shape.body, shape.node, shape.offset), whole)
    return found


def parts(sol: Solution) -> tuple[str, ...]:
    """Names of the parts that are drawn, in the order of the shapes."""
    return tuple(dict.fromkeys(shape.part for shape in sol.shapes))


def _beam(sol: Solution, beam: BeamShape, instants: np.ndarray, xi: np.ndarray) -> Line:
    begin, end = (pose(sol, beam.part, node, instants) for node in (beam.start, beam.end))
    forces = hermite.section_forces(begin, end, beam, xi)
    shape = (len(instants), len(xi))
    fields = {
        "axial_force": forces.N,
        "bending_moment": forces.M,
        "shear_force": forces.V,
        "curvature": hermite.curvature(begin, end, beam, xi),
        "bending_stiffness": np.broadcast_to(hermite.bending_stiffness(beam, xi), shape),
    }
    depth = beam.depth[0] + xi * (beam.depth[1] - beam.depth[0])
    return Line(beam.part, hermite.element_shape(begin, end, beam, xi), fields, depth)
