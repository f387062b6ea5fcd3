"""Drawing of a solution at chosen instants: lines, points, symbols, meshes of plane bodies."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexmb.errors import InputError
from flexmb.fields import field, record
from flexmb.late import Late
from flexmb.model import shape as kinds
from flexmb.results.solution import Solution

if TYPE_CHECKING:
    from flexmb.elastic.beams import fem as hermite
    from flexmb.elastic.planes import stress as plane
    from flexmb.elastic.reduced import accuracy as reduced
else:  # scikit-fem takes long to import, and drawings of elastic bodies alone need it
    hermite = Late("flexmb.elastic.beams.fem")
    plane, reduced = Late("flexmb.elastic.planes.stress"), Late("flexmb.elastic.reduced.accuracy")


def carried(poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 2) in moved frames, carried along by their poses x, y, theta (..., 3); shapes are broadcast."""
    x, y, angle = np.moveaxis(poses, -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    a, b = points[..., 0], points[..., 1]
    return np.stack([x + c * a - s * b, y + s * a + c * b], axis=-1)


def turned_by(points: np.ndarray, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines and sines (n,) of the turn of points (m, 2) into others (n, m, 2) by least squares."""
    # Both have a common factor: the sum of squares of the points, times the factor by which they grow.
    return (points * moved).sum(axis=(1, 2)), (points[:, 0] * moved[..., 1] - points[:, 1] * moved[..., 0]).sum(axis=1)


def whole_turns(angle: np.ndarray) -> np.ndarray:
    """The nearest multiples of a turn [rad]."""
    return np.asarray(2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


CORNERS = {"tri3": 3, "tri6": 3, "quad4": 4, "quad9": 4}  # number of corners of a cell, by kind

PIECES = {  # triangles between the points of a cell, by kind
    "tri3": ((0, 1, 2),),
    "tri6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad4": ((0, 1, 2), (0, 2, 3)),
    "quad9": ((0, 4, 8), (0, 8, 7), (4, 1, 5), (4, 5, 8), (8, 5, 2), (8, 2, 6), (7, 8, 6), (7, 6, 3)),
}


@dataclass(frozen=True)
class Surface:
    """The mesh of a body at n instants."""

    part: str
    shape: kinds.MeshShape  # its mesh
    points: np.ndarray  # (n, m, 2) drawn places, of which a deformation may be magnified [m]
    poses: np.ndarray  # (n, nodes, 3) x, y, theta of the nodes, from which stresses are found [m, rad]

    @property
    def cells(self) -> np.ndarray:
        """(k, nodes) numbers of the points of each cell."""
        return np.array(self.shape.cells, dtype=np.int64)

    @property
    def rims(self) -> np.ndarray:
        """(k, points) numbers of the points around each cell, in order."""
        cells, corners = self.cells, CORNERS[self.shape.kind]
        if cells.shape[1] == corners:
            return cells
        around: np.ndarray = np.stack([cells[:, :corners], cells[:, corners : 2 * corners]], axis=2)
        return around.reshape(len(cells), -1)

    @property
    def triangles(self) -> np.ndarray:
        """(k, 3) numbers of the points of triangles, some of them to a cell."""
        return self.cells[:, PIECES[self.shape.kind]].reshape(-1, 3)

    @cached_property
    def stress(self) -> np.ndarray:
        """(n, m, 4) stresses sx, sy, txy at the points in world axes, and sz [Pa]; 0 where they are unknown."""
        shape = self.shape
        if shape.fibres:  # along the beams; of each element four points on the right, then four on the left
            across = np.diff(np.array(shape.points).reshape(-1, 2, 4, 2), axis=1).repeat(2, axis=1)
            ways = np.arctan2(-across[..., 0], across[..., 1]).ravel()
            own = (self._shortened @ np.array(shape.fibres).T)[..., None] * (1.0, 0.0, 0.0, 0.0)
            return turned(own, ways + reduced.deformed(shape, self.poses)[1][:, None])
        if not shape.materials:
            return np.zeros((*self.points.shape[:2], 4))
        number = shape.material_of or (0,) * len(shape.cells)
        mesh = np.array(shape.points), self.cells, shape.kind, np.array(shape.materials)[list(number)]
        if not shape.basis:
            return plane.nodal_stresses(*mesh, moved_points(shape, self.poses))
        shapes = np.array(shape.basis).T.reshape(-1, len(shape.points), 2)
        own = np.einsum("ti,ims->tms", self._shortened, plane.linear_stresses(*mesh, shapes), optimize=True)
        return turned(own, reduced.deformed(shape, self.poses)[1][:, None])

    @cached_property
    def von_mises(self) -> np.ndarray:
        """(n, m) von Mises stress at the points [Pa]; of reduced beams the normal stress in the outer fibres."""
        if self.shape.fibres:
            return np.asarray(np.abs(self._shortened @ np.array(self.shape.fibres).T))
        return plane.von_mises(self.stress)

    @property
    def has_stress(self) -> bool:
        """Whether the stress is known."""
        return bool(self.shape.materials or self.shape.fibres)

    @property
    def _shortened(self) -> np.ndarray:
        """(n, coordinates) deformation of a reduced body with its shortening by bending, e of equation (12.11)."""
        return reduced.shortened(reduced.deformed(self.shape, self.poses)[0], np.array(self.shape.shortening))

    def outlines(self) -> list[np.ndarray]:
        """Closed lines (n, points + 1, 2) of the outline and of all holes."""
        return [self.points[:, [*loop, loop[0]]] for loop in self.shape.loops]


def moved_points(shape: kinds.MeshShape, poses: np.ndarray) -> np.ndarray:
    """Places (n, m, 2) of all points of a mesh by the poses (n, nodes, 3) x, y, theta of its nodes."""
    # The frame of a reduced body carries the reference configuration and the displacements in it.
    if shape.basis:
        d, angle = reduced.deformed(shape, poses)
        own = np.array(shape.points) + (d.reshape(len(d), -1) @ np.array(shape.basis).T).reshape(len(d), -1, 2)
        return carried(angle[:, None, None] * (0.0, 0.0, 1.0), own)
    carriers = np.array(shape.carriers, dtype=float)
    return carried(poses[:, carriers[:, 0].astype(np.int64)], carriers[:, 1:])


def turned(stress: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Stresses (n, m, 4) sx, sy, txy, sz in axes from which their own ones are turned by angles (n or 1, m or 1)."""
    c, s = np.cos(angle), np.sin(angle)
    sx, sy, t, sz = np.moveaxis(stress, -1, 0)
    xx, yy = c * c * sx + s * s * sy - 2.0 * c * s * t, s * s * sx + c * c * sy + 2.0 * c * s * t
    return np.stack([xx, yy, c * s * (sx - sy) + (c * c - s * s) * t, sz], axis=-1)


def few_shapes(moved: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray]:
    """Factors (n, k) and shapes (k, m), as few as possible, of displacements (n, m), the sum within a limit [m]."""
    # Proper orthogonal decomposition, by the eigenvectors of the products of instants or of displacements, of which
    # there are fewer: a singular value decomposition takes ten times as long.
    wide = len(moved) <= moved.shape[1]
    vectors = np.linalg.eigh(moved @ moved.T if wide else moved.T @ moved)[1][:, ::-1]
    factors, shapes = (vectors, vectors.T @ moved) if wide else (moved @ vectors, vectors.T)
    count, rest = 0, moved.copy()
    while count < len(shapes) and np.abs(rest).max(initial=0.0) > limit:
        rest -= np.outer(factors[:, count], shapes[count])
        count += 1
    return factors[:, :count], shapes[:count]


GROUND = "ground"
RATES = ("vx", "vy", "omega"), ("ax", "ay", "alpha")  # signals of the velocities and accelerations of a node
RIGID, BEAM, MESH = "rigid", "beam", "mesh"  # kinds of lines of bodies


@record
class Line:
    """A polyline of a part at n instants."""

    part: str
    kind: str = field(
        'RIGID, BEAM (the axis of an element), MESH (an outline or a hole), or that of a symbol: "spring", "damper", '
        '"rod", "cable", "force", "pitch circle", "belt", "guide"'
    )
    points: np.ndarray = field("(n, m, 2)", "m")
    fields: dict[str, np.ndarray] = field("(n, m) section forces of a beam by name", default_factory=dict)
    depth: np.ndarray | None = field("(m,) depth of a beam in the plane [m], 0 where it is unknown", default=None)
    body: str = field('the body that a circle turns with; "" for other lines', default="")

    @property
    def is_beam(self) -> bool:
        """Whether the line is the axis of a beam element."""
        return self.kind == BEAM


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


def spread_instants(sol: Solution, most: int) -> np.ndarray:
    """Numbers of all saved instants; of more than `most`, of the nearest ones to `most` even times."""
    if len(sol.time) <= most:
        return np.arange(len(sol.time))
    return nearest_instants(sol, np.linspace(sol.time[0], sol.time[-1], most))


def nearest_to_each(sol: Solution, times: np.ndarray) -> np.ndarray:
    """Number of the saved instant nearest to each of `times` [s]."""
    right = np.minimum(np.maximum(np.searchsorted(sol.time, times), 1), len(sol.time) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(np.abs(times - sol.time[left]) <= np.abs(sol.time[right] - times), left, right)


def pose(sol: Solution, part: str, node: str, instants: np.ndarray) -> np.ndarray:
    """x, y, theta (n, 3) of a node at the saved `instants`; the ground stands at the origin."""
    if part == GROUND:
        return np.zeros((len(instants), 3))
    stem = f"{part}.{node}" if node else part
    return np.stack([sol.array(f"{stem}.{axis}")[instants] for axis in ("x", "y", "theta")], axis=-1)


def poses(sol: Solution, part: str, nodes: Iterable[str], instants: np.ndarray) -> np.ndarray:
    """x, y, theta (n, m, 3) of some nodes of a part at the saved `instants`."""
    return np.stack([pose(sol, part, node, instants) for node in nodes], axis=1)


def require_nodes(sol: Solution) -> None:
    """Refuse a solution whose run did not save where the nodes of its shapes are."""
    nodes: dict[str, None] = {}
    for shape in sol.shapes:
        nodes |= {f"{part}.{node}" if node else part: None for part, node in kinds.nodes_of(shape) if part != GROUND}
    missing = [f"{node}.{axis}" for node in nodes for axis in ("x", "y", "theta") if f"{node}.{axis}" not in sol]
    if missing:
        parts = list(dict.fromkeys(name.partition(".")[0] for name in missing))
        shown = ", ".join(missing[:3]) + (f" and {len(missing) - 3} more" if len(missing) > 3 else "")
        wanted = ", ".join(repr(f"{part}.*") for part in parts[:3]) + (", ..." if len(parts) > 3 else "")
        text = f"Solution of {sol.name!r}: to draw it, signals are missing that were not saved: {shown}."
        raise InputError(f"{text} Add {wanted} to simulate(..., signals=[...]), or leave it out to save all.")


def path(sol: Solution, point: kinds.Place, instants: np.ndarray) -> np.ndarray:
    """Positions (n, 2) of a point of a body at saved instants [m]."""
    body, node, offset = point
    return carried(pose(sol, body, node, instants), np.array(offset, dtype=float))


def lines(sol: Solution, instants: np.ndarray, points_per_element: int) -> list[Line]:
    """All lines of the solution: outlines of rigid bodies and meshes, axes of beams, in the order of the shapes."""
    require_nodes(sol)
    xi, found = np.linspace(0.0, 1.0, points_per_element), []
    for shape in sol.shapes:
        if isinstance(shape, kinds.RigidShape):
            at = pose(sol, shape.part, shape.node, instants)[:, None]
            found += [Line(shape.part, RIGID, carried(at, np.array(line, dtype=float))) for line in shape.lines]
        elif isinstance(shape, kinds.BeamShape):
            begin, end = (pose(sol, shape.part, node, instants) for node in (shape.start, shape.end))
            forces = hermite.section_forces(begin, end, shape, xi, beam_motion(sol, shape, instants))
            fields = {"axial_force": forces.N, "bending_moment": forces.M, "shear_force": forces.V}
            fields["curvature"] = hermite.curvature(begin, end, shape, xi)
            fields["bending_stiffness"] = np.broadcast_to(hermite.bending_stiffness(shape, xi), forces.N.shape)
            depth = shape.depth[0] + xi * (shape.depth[1] - shape.depth[0])
            found.append(Line(shape.part, BEAM, hermite.element_shape(begin, end, shape, xi), fields, depth))
        elif isinstance(shape, kinds.MeshShape):
            found += [Line(shape.part, MESH, rim) for rim in surface(sol, shape, instants).outlines()]
    return found


def surfaces(sol: Solution, instants: np.ndarray) -> list[Surface]:
    """All meshes of the solution, in the order of the shapes."""
    return [surface(sol, shape, instants) for shape in sol.shapes if isinstance(shape, kinds.MeshShape)]


def surface(sol: Solution, shape: kinds.MeshShape, instants: np.ndarray) -> Surface:
    """A mesh at the saved `instants`."""
    of_nodes = poses(sol, shape.part, shape.nodes, instants)
    return Surface(shape.part, shape, moved_points(shape, of_nodes), of_nodes)


def marks(sol: Solution, instants: np.ndarray) -> list[Mark]:
    """All joints; one with clearance gives its bearing and, where the run recorded ex and ey, its journal."""
    require_nodes(sol)
    found = []
    for shape in sol.shapes:
        if not isinstance(shape, kinds.PointShape):
            continue
        points = path(sol, (shape.body, shape.node, shape.offset), instants)
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
    marked = (s for s in sol.shapes if isinstance(s, kinds.PointShape) and s.kind == kinds.TRACE)
    return {s.part: path(sol, (s.body, s.node, s.offset), whole) for s in marked}


def parts(sol: Solution) -> tuple[str, ...]:
    """Names of the parts that are drawn, in the order of the shapes."""
    return tuple(dict.fromkeys(shape.part for shape in sol.shapes))


def bodies(sol: Solution) -> tuple[str, ...]:
    """Names of the bodies with lines, in the order of the shapes, by which bodies have their colours."""
    flexible, rigid = kinds.BeamShape | kinds.MeshShape, kinds.RigidShape
    drawn = (s for s in sol.shapes if isinstance(s, flexible) or (isinstance(s, rigid) and s.lines))
    return tuple(dict.fromkeys(shape.part for shape in drawn))


def beam_motion(sol: Solution, beam: kinds.BeamShape, instants: np.ndarray) -> list[np.ndarray] | None:
    """Velocities and accelerations (n, 6) of the ends of a beam; None where they were not saved."""
    names = [f"{beam.part}.{node}.{axis}" for axes in RATES for node in (beam.start, beam.end) for axis in axes]
    if not all(name in sol for name in names):
        return None
    return np.split(np.stack([sol.array(name)[instants] for name in names], axis=1), 2, axis=1)


# Symbols of springs, dampers, rods, cables, guides, belts, forces and pitch circles, as polylines at instants

COILS = 6  # number of teeth of the zig-zag of a spring
WIDTH = 0.02  # half width of a spring or damper, over the size of the picture
ARROW, HEAD = 0.14, 0.035  # length of an arrow and of its head, over the size of the picture
CIRCLE_POINTS = 73  # number of points of a circle
ARC_POINTS = 37  # number of points of the arc of a belt on a wheel
OVERHANG = 0.06  # length of a guide beyond the travel, over the size of the picture


def symbols(sol: Solution, instants: np.ndarray, size: float) -> list[Line]:
    """Symbols of all other shapes than bodies and points, at instants (n,), by the size of the picture [m]."""
    found = []
    for shape in sol.shapes:
        if isinstance(shape, kinds.LineShape):
            first, second = (path(sol, place, instants) for place in (shape.first, shape.second))
            found.append(Line(shape.part, shape.kind, _between(first, second, shape.kind, WIDTH * size)))
        elif isinstance(shape, kinds.ArrowShape):  # it ends in its point
            tip, angle = path(sol, shape.at, instants), np.zeros(len(instants))
            if shape.turns:
                angle = pose(sol, *shape.at[:2], instants)[:, 2]
            angle = angle + np.arctan2(shape.direction[1], shape.direction[0])
            base = tip - ARROW * size * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            found.append(Line(shape.part, "force", arrow_line(base, tip, HEAD * size)))
        elif isinstance(shape, kinds.CircleShape):
            line = carried(pose(sol, *shape.at[:2], instants)[:, None], circle_line(shape))
            found.append(Line(shape.part, "pitch circle", line, body=shape.at[0]))
        elif isinstance(shape, kinds.BeltShape):
            found.append(Line(shape.part, "belt", _belt(sol, shape, instants)))
        elif isinstance(shape, kinds.PointShape) and shape.along and shape.other:
            body, node, _ = shape.other
            if body != GROUND and (f"{body}.{node}.theta" if node else f"{body}.theta") not in sol:
                continue  # its pose was not saved
            over, every = OVERHANG * size, np.arange(len(sol.time))
            begin = path(sol, shape.other, every)
            angle = pose(sol, body, node, every)[:, 2] + np.arctan2(shape.along[1], shape.along[0])
            unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            travel = np.sum((path(sol, (shape.body, shape.node, shape.offset), every) - begin) * unit, axis=-1)
            ends = np.array([travel.min() - over, travel.max() + over])
            line = np.asarray(begin[instants, None] + ends[:, None] * unit[instants, None])
            found.append(Line(shape.part, "guide", line))
    return found


def _between(first: np.ndarray, second: np.ndarray, kind: str, width: float) -> np.ndarray:
    """Polyline (n, m, 2) from one point to another: zig-zag, dashpot, or straight."""
    if kind == kinds.SPRING:
        along = np.array([0.0, 0.15, *np.linspace(0.15, 0.85, 2 * COILS + 1)[1:-1:2], 0.85, 1.0])
        across = np.array([0.0, 0.0, *((-1.0) ** np.arange(COILS)), 0.0, 0.0])
    elif kind == kinds.DAMPER:  # rod and piston, then the cup and its rod
        along = np.array([0.0, 0.5, 0.5, 0.5, 0.5, 0.35, 0.65, 0.65, 0.35, 0.65, 0.65, 1.0])
        across = np.array([0.0, 0.0, 0.7, -0.7, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 0.0, 0.0])
    else:
        along, across = np.array([0.0, 1.0]), np.zeros(2)
    way, (_, _, normal) = second - first, directions(second - first)
    return np.asarray(first[:, None] + along[:, None] * way[:, None] + width * across[:, None] * normal[:, None])


def directions(ways: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lengths (..., 1), unit vectors and unit normals on the left (..., 2); 0 for vectors without length."""
    length = np.hypot(ways[..., :1], ways[..., 1:])
    unit = ways / np.where(length > 0.0, length, 1.0)
    return length, unit, np.stack([-unit[..., 1], unit[..., 0]], axis=-1)


def arrow_line(base: np.ndarray, tip: np.ndarray, head: float) -> np.ndarray:
    """Shaft and head (n, 5, 2) of arrows from (n, 2) to (n, 2), with heads of a length [m], shorter in short arrows."""
    length, unit, normal = directions(tip - base)
    back = np.minimum(head, 0.6 * length)
    side, foot = 0.4 * back * normal, tip - back * unit
    return np.stack([base, tip, foot + side, tip, foot - side], axis=1)


def circle_line(circle: kinds.CircleShape, points: int = CIRCLE_POINTS) -> np.ndarray:
    """Circle (m, 2) in the frame of its node: from its centre, along a spoke, and around with a number of points."""
    angles, centre = np.linspace(0.0, 2.0 * np.pi, points)[:, None], np.array([circle.at[2]])
    return np.vstack([centre, centre + circle.radius * np.hstack([np.cos(angles), np.sin(angles)])])


def _belt(sol: Solution, belt: kinds.BeltShape, instants: np.ndarray) -> np.ndarray:
    """Closed line (n, m, 2) of a belt: around the first wheel, a strand, around the second wheel, a strand."""
    first, second = (path(sol, place, instants) for place in (belt.first, belt.second))
    way = second - first
    distance = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-300)
    r1, r2 = belt.radii
    slope = np.clip((r1 + r2 if belt.crossed else r1 - r2) / distance, -1.0, 1.0)
    half = np.arccos(slope)  # between the line of centres and the radius to the upper point of contact
    angle, turn = np.arctan2(way[:, 1], way[:, 0])[:, None], np.linspace(0.0, 1.0, ARC_POINTS)
    around = angle + half[:, None] + (2.0 * np.pi - 2.0 * half)[:, None] * turn
    if belt.crossed:  # the second wheel turns against the first one
        back = angle + np.pi - half[:, None] - (2.0 * np.pi - 2.0 * half)[:, None] * turn
    else:
        back = angle - half[:, None] + 2.0 * half[:, None] * turn
    circles = (first, r1, around), (second, r2, back)
    arcs = [c[:, None] + r * np.stack([np.cos(a), np.sin(a)], axis=-1) for c, r, a in circles]
    return np.concatenate([*arcs, arcs[0][:, :1]], axis=1)
