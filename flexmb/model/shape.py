"""Shapes of parts for drawings: records of plain numbers, stored with a solution, written as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from flexmb.errors import InputError

Point = tuple[float, float]
Place = tuple[str, str, Point]
"""Body, its node, and a point in the frame of the node [m]."""


@dataclass(frozen=True, slots=True)
class RigidShape:
    """Polylines that move with one node of a part.

    Parameters
    ----------
    node : name of its node; empty for the one node of a rigid body.
    lines : polylines, each a tuple of points (x, y) in the frame of the node [m].
    """

    part: str
    node: str
    lines: tuple[tuple[Point, ...], ...]


@dataclass(frozen=True, slots=True)
class BeamShape:
    """One beam element between two nodes of a part.

    The rotation of an end against the chord is theta + start_angle - (direction of the chord).

    Parameters
    ----------
    start, end : names of the nodes.
    length : length of the unstressed element [m].
    start_angle, end_angle : direction of the axis less theta of the node, in the unstressed element [rad].
    axial : axial force per elongation [N/m].
    bending : (b11, b12, b22), end moments per end rotation against the chord [N m/rad].
    ei : bending stiffness of the section at the start and at the end [N m2].
    depth : depth of the section in the plane at the start and at the end [m]; 0 where it is unknown.
    shear : (c1, c2), shear angle over the end rotations against the chord, sign changed [1].
    bow : shortening of the chord over length/30: bow1 u1^2 - bow2 u1 u2 + bow3 u2^2, with the end rotations u1 and u2.
    unstressed : (l0, u10, u20), end rotations of the unstressed element against its chord [rad], and the sum of its
        chord and the shortening of its chord [m]; None: straight.
    """

    part: str
    start: str
    end: str
    length: float
    start_angle: float
    end_angle: float
    axial: float
    bending: tuple[float, float, float]
    ei: tuple[float, float]
    depth: tuple[float, float] = (0.0, 0.0)
    shear: tuple[float, float] = (0.0, 0.0)
    bow: tuple[float, float, float] = (2.0, 1.0, 2.0)
    unstressed: tuple[float, float, float] | None = None

    @property
    def chord(self) -> float:
        """Distance of the ends of the unstressed element [m]."""
        free, u1, u2 = self.free
        return free - self.length / 30.0 * (self.bow[0] * u1 * u1 - self.bow[1] * u1 * u2 + self.bow[2] * u2 * u2)

    @property
    def free(self) -> tuple[float, float, float]:
        """(l0, u10, u20), also of a straight element."""
        return (self.length, 0.0, 0.0) if self.unstressed is None else self.unstressed


@dataclass(frozen=True, slots=True)
class MeshShape:
    """The mesh of a plane body.

    Each point is carried by a node, at an offset in the frame of this node.  Of a reduced body, `basis` gives the
    displacements of all points by the poses of all nodes against the frame of the body, and there are no carriers.

    Parameters
    ----------
    kind : kind of the cells: "tri3", "tri6", "quad4" or "quad9".
    points : (n) places in the reference configuration [m].
    cells : (m) numbers of the points of each cell, corners first.
    loops : numbers of the points along the outline and along each hole, in order, the first one not repeated.
    nodes : names of the nodes that move the points.
    carriers : (n) number of a node in `nodes`, and the point in its frame [m].
    materials : stresses sx = d11 ex + d12 ey, txy = d33 gxy, sz = nu (sx + sy): (d11, d12, d33 [Pa], nu; 0 in a plate).
    material_of : (m) number of the material of each cell; empty: the only one.
    poses : (nodes) x, y, theta of the nodes in the reference configuration [m, rad], of a reduced body in its axes.
    weights : (nodes) x, y by which the nodes turn the frame; empty: it turns with the first node.
    basis : (2 n) displacements x0, y0, x1, ... by x, y, theta of every node.
    shortening : directions (n,) in which bending shortens the body, each above its matrix (n, n) [1/m]; in older
        files matrices of the coordinates from the fourth one on.
    fibres : (n) of reduced beams: normal stress in the outer fibre, by x, y, theta of every node [Pa/m, Pa/rad].
    """

    part: str
    kind: str
    points: tuple[Point, ...]
    cells: tuple[tuple[int, ...], ...]
    loops: tuple[tuple[int, ...], ...]
    nodes: tuple[str, ...]
    carriers: tuple[tuple[int, float, float], ...] = ()
    materials: tuple[tuple[float, float, float, float], ...] = ()
    material_of: tuple[int, ...] = ()
    poses: tuple[tuple[float, float, float], ...] = ()
    weights: tuple[Point, ...] = ()
    basis: tuple[tuple[float, ...], ...] = ()
    shortening: tuple[tuple[tuple[float, ...], ...], ...] = ()
    fibres: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class PointShape:
    """A joint, or another thing drawn as one point.

    Parameters
    ----------
    kind : what it is: "revolute", "prismatic", "fixed", "clearance", ...
    body, node : the node that carries the point; the body "ground" stands still at the origin.
    offset : the point in the frame of the node [m].
    other : point of the other body of a joint; None for a point of one body.
    along : direction of the guide or slot in which the point slides, in the frame of `other`; None: it does not slide.
    """

    part: str
    kind: str
    body: str
    node: str
    offset: Point
    other: Place | None = None
    along: Point | None = None


@dataclass(frozen=True, slots=True)
class LineShape:
    """A thing between two points: spring, damper, rod or cable.

    Parameters
    ----------
    kind : "spring", "damper", "rod" or "cable".
    first, second : both points.
    """

    part: str
    kind: str
    first: Place
    second: Place


@dataclass(frozen=True, slots=True)
class ArrowShape:
    """An arrow that ends in a point: a force.

    Parameters
    ----------
    at : the point.
    direction : direction of the arrow, in the frame of the node or in world axes.
    turns : whether the direction turns with the node.
    """

    part: str
    at: Place
    direction: Point
    turns: bool


@dataclass(frozen=True, slots=True)
class CircleShape:
    """A circle about a point, with a spoke that shows its rotation: a pitch circle.

    Parameters
    ----------
    at : the centre.
    radius : radius [m].
    """

    part: str
    at: Place
    radius: float


@dataclass(frozen=True, slots=True)
class BeltShape:
    """A belt around two wheels.

    Parameters
    ----------
    first, second : centres of the wheels.
    radii : radii of the belt's middle line on both wheels [m].
    crossed : whether the strands cross.
    """

    part: str
    first: Place
    second: Place
    radii: tuple[float, float]
    crossed: bool


Symbol = LineShape | ArrowShape | CircleShape | BeltShape
Shape = RigidShape | BeamShape | MeshShape | PointShape | Symbol
Shapes = Sequence[Shape]


class LateShapes(Sequence[Shape]):
    """Shapes computed at first use; equal to the tuple of the shapes, and pickled as that tuple."""

    def __init__(self, find: Callable[[], Shapes]) -> None:
        self._find: Callable[[], Shapes] | None = find
        self._found: tuple[Shape, ...] = ()

    def all(self) -> tuple[Shape, ...]:
        """The shapes."""
        if self._find is not None:
            self._found, self._find = tuple(self._find()), None
        return self._found

    def __len__(self) -> int:
        return len(self.all())

    def __getitem__(self, place: Any) -> Any:
        return self.all()[place]

    def __iter__(self) -> Iterator[Shape]:
        return iter(self.all())

    def __eq__(self, other: object) -> bool:
        return self.all() == (other.all() if isinstance(other, LateShapes) else other)

    def __hash__(self) -> int:
        return hash(self.all())

    def __repr__(self) -> str:
        return repr(self.all())

    def __reduce__(self) -> tuple[Any, ...]:
        return tuple, (self.all(),)


SPRING, DAMPER, ROD, CABLE = "spring", "damper", "rod", "cable"
"""Kinds of lines between two points."""

MARKER, TRACE = "marker", "trace"
"""Kinds of points that are no joints: a marker, and a marker whose path is drawn."""

KINDS: dict[str, type[Shape]] = {
    "rigid": RigidShape,
    "beam": BeamShape,
    "mesh": MeshShape,
    "point": PointShape,
    "line": LineShape,
    "arrow": ArrowShape,
    "circle": CircleShape,
    "belt": BeltShape,
}


def nodes_of(shape: Shape) -> list[tuple[str, str]]:
    """Bodies and nodes with which a shape moves."""
    if isinstance(shape, BeamShape):
        return [(shape.part, shape.start), (shape.part, shape.end)]
    if isinstance(shape, MeshShape):
        return [(shape.part, node) for node in shape.nodes]
    if isinstance(shape, PointShape):
        return [(shape.body, shape.node)]
    if isinstance(shape, RigidShape):
        return [(shape.part, shape.node)]
    places = [shape.first, shape.second] if isinstance(shape, LineShape | BeltShape) else [shape.at]
    return [(body, node) for body, node, _ in places]


def to_json(shapes: Shapes) -> str:
    """`shapes` as JSON; floats are written so that they read back to the same bits."""
    words = {kind: word for word, kind in KINDS.items()}
    return json.dumps([{"shape": words[type(s)], **asdict(s)} for s in shapes])


def from_json(text: str) -> Shapes:
    """The shapes in `text` as `to_json` wrote them, or `InputError`."""
    try:
        items = [dict(item) for item in json.loads(text)]
        return tuple(KINDS[item.pop("shape")](**{k: _tuples(value) for k, value in item.items()}) for item in items)
    except (ValueError, TypeError, KeyError) as error:
        message = f"shapes: {text[:60]!r} is no list of drawing records ({error}). Write it with to_json."
        raise InputError(message) from None


def _tuples(value: Any) -> Any:
    return tuple(_tuples(v) for v in value) if isinstance(value, list) else value
