"""Shapes of parts for drawings: records of plain numbers, stored with a solution, written as JSON."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from flexmb.errors import InputError

Point = tuple[float, float]
Place = tuple[str, str, Point]  # body, its node, and a point in the frame of the node [m]


@dataclass(frozen=True, slots=True)
class RigidShape:
    """Polylines that move with one node of a part."""

    part: str
    node: str  # name of its node; empty for the one node of a rigid body
    lines: tuple[tuple[Point, ...], ...]  # polylines, each a tuple of points (x, y) in the frame of the node [m]


@dataclass(frozen=True, slots=True)
class BeamShape:
    """Beam element of a part; an end's rotation against the chord is theta + start_angle - chord's direction."""

    part: str
    start: str  # name of its node; `end` that of the other one
    end: str
    length: float  # length of the unstressed element [m]
    start_angle: float  # direction of the axis less theta of the node, in the unstressed element [rad]
    end_angle: float
    axial: float  # axial force per elongation [N/m]
    bending: tuple[float, float, float]  # (b11, b12, b22), end moments per end rotation against the chord [N m/rad]
    ei: tuple[float, float]  # bending stiffness of the section at the start and at the end [N m2]
    # depth of the section in the plane at the start and at the end [m]; 0 where it is unknown
    depth: tuple[float, float] = (0.0, 0.0)
    # (c1, c2), shear angle over the end rotations against the chord, sign changed [1]
    shear: tuple[float, float] = (0.0, 0.0)
    # shortening of the chord over length/30: bow1 u1^2 - bow2 u1 u2 + bow3 u2^2, with the end rotations u1 and u2
    bow: tuple[float, float, float] = (2.0, 1.0, 2.0)
    # (l0, u10, u20), end rotations of the unstressed element against its chord [rad], and the sum of its chord
    # and the shortening of its chord [m]; None: straight
    unstressed: tuple[float, float, float] | None = None
    # gravity [m/s^2] and integrals of mass of the element, as in `elastic.beams.corotational`; (): unknown, older files
    mass: tuple[float, ...] = ()

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
    """The mesh of a plane body."""

    # Each point is carried by a node, at an offset in the frame of this node. Of a reduced body, `basis` gives the
    # displacements of all points by the poses of all nodes against the frame of the body, and there are no carriers.
    part: str
    kind: str  # kind of the cells: "tri3", "tri6", "quad4" or "quad9"
    points: tuple[Point, ...]  # (n) places in the reference configuration [m]
    cells: tuple[tuple[int, ...], ...]  # (m) numbers of the points of each cell, corners first
    # numbers of the points along the outline and along each hole, in order, the first one not repeated
    loops: tuple[tuple[int, ...], ...]
    nodes: tuple[str, ...]  # names of the nodes that move the points
    # (n) number of a node in `nodes`, and the point in its frame [m]
    carriers: tuple[tuple[int, float, float], ...] = ()
    # stresses sx = d11 ex + d12 ey, txy = d33 gxy, sz = nu (sx + sy): (d11, d12, d33 [Pa], nu; 0 in a plate)
    materials: tuple[tuple[float, float, float, float], ...] = ()
    material_of: tuple[int, ...] = ()  # (m) number of the material of each cell; empty: the only one
    # (nodes) x, y, theta of the nodes in the reference configuration [m, rad], of a reduced body in its axes
    poses: tuple[tuple[float, float, float], ...] = ()
    # (nodes) x, y by which the nodes turn the frame; empty: it turns with the first node
    weights: tuple[Point, ...] = ()
    basis: tuple[tuple[float, ...], ...] = ()  # (2 n) displacements x0, y0, x1, ... by x, y, theta of every node
    # directions (n,) in which bending shortens the body, each above its matrix (n, n) [1/m]; in older files
    # matrices of the coordinates from the fourth one on
    shortening: tuple[tuple[tuple[float, ...], ...], ...] = ()
    # (n) of reduced beams: normal stress in the outer fibre, by x, y, theta of every node [Pa/m, Pa/rad]
    fibres: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class PointShape:
    """A joint, or another thing drawn as one point."""

    part: str
    kind: str  # what it is: "revolute", "prismatic", "fixed", "clearance", ...
    body: str  # body and node that carry the point; the body "ground" stands still at the origin
    node: str
    offset: Point  # the point in the frame of the node [m]
    other: Place | None = None  # point of the other body of a joint; None for a point of one body
    # direction of the guide or slot in which the point slides, in the frame of `other`; None: it does not slide
    along: Point | None = None


@dataclass(frozen=True, slots=True)
class LineShape:
    """A thing between two points: spring, damper, rod or cable."""

    part: str
    kind: str  # "spring", "damper", "rod" or "cable"
    first: Place
    second: Place


@dataclass(frozen=True, slots=True)
class ArrowShape:
    """An arrow that ends in a point: a force."""

    part: str
    at: Place
    direction: Point  # direction of the arrow, in the frame of the node or in world axes
    turns: bool  # whether the direction turns with the node


@dataclass(frozen=True, slots=True)
class CircleShape:
    """A circle about a point, with a spoke that shows its rotation: a pitch circle."""

    part: str
    at: Place
    radius: float  # radius [m]


@dataclass(frozen=True, slots=True)
class BeltShape:
    """A belt around two wheels."""

    part: str
    first: Place  # centres of the wheels
    second: Place
    radii: tuple[float, float]  # radii of the belt's middle line on both wheels [m]
    crossed: bool  # whether the strands cross


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


SPRING, DAMPER, ROD, CABLE = "spring", "damper", "rod", "cable"  # kinds of lines between two points
MARKER, TRACE = "marker", "trace"  # kinds of points that are no joints: a marker, and a marker whose path is drawn
KINDS: dict[str, type[Shape]] = {
    "rigid": RigidShape, "beam": BeamShape, "mesh": MeshShape, "point": PointShape, "line": LineShape,
    "arrow": ArrowShape, "circle": CircleShape, "belt": BeltShape,
}  # fmt: skip


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
