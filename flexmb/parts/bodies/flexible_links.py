"""Flexible bars between two points, and frames: chains of corotational beam elements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY
from functools import cached_property

import numpy as np

from flexmb import checks, planar
from flexmb.elastic.beams.corotational import checked_turn, points, tangents
from flexmb.elastic.beams.section import Section
from flexmb.errors import InputError
from flexmb.fields import between, field, not_negative, point, record, several, variant
from flexmb.late import scipy
from flexmb.model.contributions import Contribution, Node
from flexmb.model.law import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body
from flexmb.parts.bodies import flexible
from flexmb.parts.bodies.flexible import Beam, Elements, Field, FieldLike, RigidProperties, Triple
from flexmb.parts.bodies.flexible_body import FlexibleBody, beam_of_mesh
from flexmb.parts.bodies.rigid import Bar

Point = tuple[float, float]
Edge = tuple[int, int]


@record
class Edges(Body):
    """Base of bodies of edges between corners of the reference configuration.

    Raises
    ------
    InputError : a pair that joins no two different corners, an edge twice, corners that no edge reaches.
    """

    points: Sequence[Point] = field("corners, unstressed", "m", several(point, "corners (x, y)"))
    edges: Sequence[Edge] = field("pairs of corner numbers, one for each beam")

    def __post_init__(self) -> None:
        super().__post_init__()
        edges = checks.sequence(self.label, "edges", self.edges, "pairs of corner numbers")
        checked: list[Edge] = []
        for i, edge in enumerate(edges):
            try:
                a, b = (checks.count(self.label, f"edges[{i}]", k, 0) for k in edge)
            except (TypeError, ValueError) as error:
                text = f"{self.label}: edges[{i}] is {edge!r}; it must be a pair of corner numbers."
                raise InputError(text) from error
            if max(a, b) >= len(self.points) or planar.distance(self.points[a], self.points[b]) <= 0.0:
                text = f"{self.label}: edges[{i}] is {edge!r};"
                raise InputError(f"{text} it must join two different corners of {len(self.points)}.")
            checked.append((a, b))
        object.__setattr__(self, "edges", tuple(checked))
        pairs = [frozenset(edge) for edge in self.edges]
        for i, pair in enumerate(pairs):
            if pair in pairs[:i]:
                text = f"{self.label}: edges[{i}] is {self.edges[i]}, which joins two corners once more;"
                raise InputError(f"{text} remove it.")
        lonely = set(range(len(self.points))) - {i for edge in self.edges for i in edge}
        if lonely or not self.edges:
            raise InputError(f"{self.label}: corners {sorted(lonely)} belong to no edge. Remove them or add edges.")


def smooth_turns(points: Iterable[Point], closed: bool = False) -> tuple[float, ...]:
    """Turns of arcs from point to point along the cubic spline through points: `turns` of a `FlexibleFrame`.

    The spline has the distances of the points as its parameter and ends that are bent like their neighbours
    ("not-a-knot"; with three points a parabola, with two a line).  Turns have an error of third order of the distances
    of the points at the ends of an open curve, of fourth order and less elsewhere; where the curvature varies, the
    directions of neighbouring arcs differ at a point by an angle of second order.  Frames have no forces from either.

    Parameters
    ----------
    points : the points in order [m], at least two; neighbours apart.
    closed : whether the curve goes on from the last point to the first, which is not repeated.

    Returns
    -------
    tuple of float : one turn [rad] for each pair of neighbours, counter-clockwise > 0.

    Raises
    ------
    InputError : too few points, neighbours at one place, points too far apart for their turn.

    Examples
    --------
    >>> corner = (0.0, 0.0), (0.1, 0.0), (0.15, 0.05), (0.15, 0.15)
    >>> [round(turn, 3) for turn in smooth_turns(corner)]
    [1.0, 0.587, 1.0]
    """
    owner = "smooth_turns"
    given = checks.sequence(owner, "points", points, "points (x, y)")
    path = np.array([checks.point(owner, f"points[{i}]", p) for i, p in enumerate(given)])
    if len(path) < (3 if closed else 2):
        raise InputError(f"{owner}: {len(path)} points make no curve; give at least {3 if closed else 2}.")
    if closed:
        path = np.concatenate([path, path[:1]])
    steps = np.hypot(*np.diff(path, axis=0).T)
    if not np.all(steps > 0.0):
        k = int(np.argmin(steps > 0.0))
        raise InputError(f"{owner}: points[{k}] and the next one are both {tuple(path[k].tolist())}; remove one.")
    ends = "periodic" if closed else "not-a-knot"
    spline = scipy.interpolate.CubicSpline(np.cumsum([0.0, *steps]), path, bc_type=ends)
    slopes = spline(spline.x, 1)
    turns = np.diff(np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0])))
    if np.abs(turns).max() >= 0.5 * math.pi:
        k = int(np.abs(turns).argmax())
        text = f"{owner}: from points[{k}] to the next one the curve turns by {turns[k]:.3g} rad"
        raise InputError(f"{text}; give points between them, at most pi/2 apart.")
    return tuple(turns.tolist())


@variant
class FlexibleFrame(FlexibleBody, Edges):
    """Beams between corners, straight or arcs, welded there; theta of every node is 0 in the reference configuration.

    Nodes are called node0, node1, ...: first the corners in the order of `points`, then the inner nodes edge by edge.
    The body's own signals are the signals of node0.  A rigid `velocity` is that of node0.  `turns` are those by which
    an unstressed beam turns from its first corner to its second along a circular arc, counter-clockwise > 0, between -2
    pi and 2 pi; turns of a smooth curve through the corners:  `flexmb.bodies.smooth_turns`.

    Raises
    ------
    InputError : values out of range, corners that no edge reaches, an edge twice, mass properties out of reach, fields
        with another number of entries than nodes.

    Notes
    -----
    A mass at the mean of the corners moves with the mean of their velocities, as if held by light spokes.
    Beams with small strains and any rotation; without `shear` not for deep beams (length over height below 10).
    Elements of an arc are arcs; they should turn by less than 0.5 rad each.

    `mass_damping` acts on the velocity against a frame that has its origin at the first corner of the first edge and
    points to the second one, on the mass of the beams and of the bosses on corners, not on a mass at the mean of the
    corners; no rigid motion is damped.  A mode of angular frequency omega that leaves those two corners in place has
    the damping ratio xi = zeta1/(2 omega) + zeta2 omega/2, when nothing lies at the mean of the corners.
    Source of the ratio: R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, section 12-5.

    Fields of velocity and displacement: see `FlexibleLink`.  The frame is unstressed without its displacement.
    """

    _: KW_ONLY
    centre: Point | None = field("of mass, with mass or inertia; None: the beams' own", "m", point, default=None)
    turns: float | tuple[float, ...] = field("turns of all arcs, or one an edge; 0: straight", "rad", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.section, tuple) and len(self.section) != len(self.edges):
            raise InputError(f"{self.label}: {len(self.section)} sections for {len(self.edges)} edges; give one each.")
        count, given, turns = len(self.edges), self.elements, self.turns
        each = given if isinstance(given, (tuple, list)) and len(given) == count else (given,) * count
        object.__setattr__(self, "elements", tuple(flexible.checked_elements(self.label, e) for e in each))
        if isinstance(turns, Iterable) and not isinstance(turns, str):
            turns = checks.sequence(self.label, "turns", turns, "angles in rad, one an edge")
            if len(turns) != count:
                raise InputError(f"{self.label}: {len(turns)} turns for {count} edges; give one each.")
            turns = tuple(checked_turn(self.label, f"turns[{i}]", turn) for i, turn in enumerate(turns))
        else:
            turns = checked_turn(self.label, "turns", turns)
        object.__setattr__(self, "turns", turns)
        self._check_fields(len(self.nodes()), None)
        _ = self._bosses  # refuses mass properties out of reach

    @classmethod
    def from_mesh(
        cls, name: str, path: str, at: Point = (0.0, 0.0), *, angle: float = 0.0, sections: Mapping[int, Section],
        material: Material, mass: float | None = None, inertia: float | None = None, centre: Point | None = None,
        damping: float = 0.0, mass_damping: float = 0.0, rotary_inertia: bool | float | None = None,
        shear: bool | float = False, stress: bool | None = None, velocity: Triple | Field | None = None,
        displacement: Field | None = None,
    ) -> FlexibleFrame:  # fmt: skip
        """A frame from a mesh of line cells (any format of meshio); corners: beams meet, end or bend there.

        Parameters
        ----------
        name : the frame's name.
        path : mesh file.
        at : point of the mesh's origin in the reference configuration [m].
        angle : rotation of the mesh about its origin [rad].
        sections : cross section by cell tag.
        material, mass, inertia, centre, damping, mass_damping, rotary_inertia, shear, stress, velocity, displacement :
            see the class.

        Raises
        ------
        InputError : a mesh that is no frame of straight beams, tags without a section.
        FileFormatError : a file that is no mesh.
        """
        from flexmb.elastic.beams.mesh import members, read_lines  # noqa: PLC0415 - meshio is needed only here

        mesh = read_lines(path)
        corners: dict[int, int] = {}
        edges, beams = list[Edge](), []
        for nodes in members(mesh):
            first = corners.setdefault(int(nodes[0]), len(corners))
            edges.append((first, corners.setdefault(int(nodes[-1]), len(corners))))
            own = {mesh.tag_of(nodes)}, mesh.stations(nodes)
            beams.append(beam_of_mesh(f"FlexibleFrame {name!r}", path, *own, sections))
        elements, chosen = zip(*beams, strict=True)
        points = tuple(planar.from_frame(at, angle, (x, y)) for x, y, *_ in (mesh.points[n].tolist() for n in corners))
        return cls(
            name, points, tuple(edges), section=chosen, material=material, elements=elements, mass=mass,
            inertia=inertia, centre=centre, damping=damping, mass_damping=mass_damping, rotary_inertia=rotary_inertia,
            shear=shear, stress=stress, velocity=velocity, displacement=displacement,
        )  # fmt: skip

    @property
    def corners(self) -> tuple[str, ...]:
        return tuple(f"node{i}" for i in range(len(self.points)))

    @property
    def corner_points(self) -> tuple[Point, ...]:
        return tuple(self.points)

    def nodes(self) -> tuple[Node, ...]:
        corners = {f"node{i}": p for i, p in enumerate(self.points)}
        every = {name: p for beam in self.beams for name, p in zip(beam.nodes, beam.points, strict=True)}
        return tuple(Node(name, *point, 0.0) for name, point in (corners | every | corners).items())

    @cached_property
    def beams(self) -> tuple[Beam, ...]:
        """One beam an edge."""
        sections = self.section if isinstance(self.section, tuple) else (self.section,) * len(self.edges)
        turns = self.turns if isinstance(self.turns, tuple) else (self.turns,) * len(self.edges)
        beams, count = [], len(self.points)
        for (a, b), section, elements, turn in zip(self.edges, sections, self.elements, turns, strict=True):  # type: ignore[arg-type]
            places = flexible.fractions(elements)
            inner = [f"node{count + i}" for i in range(len(places) - 2)]
            count += len(inner)
            ends = (self.points[a], self.points[b])
            beams.append(self._beam((f"node{a}", *inner, f"node{b}"), ends, places, section, turn))
        return tuple(beams)

    def _further_mass(self) -> tuple[float, Point, float]:
        """The mass at the mean of the corners, as a point."""
        mean = np.array(self.points).mean(axis=0)
        return self._bosses.mean_mass, (float(mean[0]), float(mean[1])), 0.0

    def _fit(self, own: RigidProperties, mass: float) -> flexible.Bosses:
        wanted = RigidProperties(mass, self.centre or own.centre, own.inertia if self.inertia is None else self.inertia)
        return flexible.fit_bosses(self.label, own, wanted, list(self.points))


@variant
class FlexibleLink(FlexibleBody, Bar):
    """A beam between two points, straight or an arc; theta of a node is the direction of its axis, counted from +X.

    Nodes are called node0 .. nodeN from `start` to `end`; "start" and "end" are other names of the outer ones, and the
    body's own signals are the signals of the node in the middle.  A rigid `velocity` is that of the middle node; fields
    of velocity and displacement may be functions of s, 0 at the start and 1 at the end.  An unstressed link with a
    `turn` turns from start to end along a circular arc, counter-clockwise > 0, between -2 pi and 2 pi.

    Raises
    ------
    InputError : values out of range; a mass or inertia that bosses cannot make, or of an arc; fields with another
        number of entries than nodes, or of another shape; shear of a section that does not know its shear factor.

    Notes
    -----
    Beams with small strains and any rotation; without `shear` not for deep beams (length over height below 10).
    Elements of an arc are arcs; they should turn by less than 0.5 rad each.  The signal `deflection` of an arc holds
    its rise.
    Source of the element: see `flexmb.elastic.beams.corotational`.

    `mass_damping` acts on the velocity against a frame that has its origin at the start and points to the end, on the
    mass of beam and bosses; no rigid motion is damped.  A bending mode of angular frequency omega that leaves both ends
    in place, as with a pin at each, has the damping ratio xi = zeta1/(2 omega) + zeta2 omega/2.  In other modes the
    first part is multiplied by the kinetic energy of the motion seen from that frame over that of the motion itself:
    5 with two free ends, 0.058 with a clamp at one end, in the first mode.
    Source of the ratio: R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, section 12-5.

    Fields are absolute, in world axes, given for the reference configuration; functions are evaluated once, when the
    link is made. A velocity field holds exactly. The link is unstressed without its displacement. With a displacement
    the link starts bent or stretched, and is in equilibrium only if loads or accelerations hold it so. Joints take
    their points and angles from the link without displacement. Open loops are closed by moving the bodies in their bent
    shape; velocity fields are not turned with them. So declare a link with a velocity field in the pose in which it
    starts.
    """

    _: KW_ONLY
    section: Section = field("cross section")
    elements: Elements = field("number of elements, or fractions of the length where inner nodes stand", default=4)
    centre: float = field("of mass, from start (0) to end (1), with `mass`", rule=between(0.0, 1.0), default=0.5)
    pivot_inertia: float = field("at the start node, not counted in `inertia`", "kg m^2", not_negative, default=0.0)
    turn: float = field("turn of an arc from start to end, see above; 0: straight", "rad", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "turn", checked_turn(self.label, "turn", self.turn))
        if self.turn and (self.mass is not None or self.inertia is not None):
            text = f"{self.label}: mass and inertia are for straight links, since they fix a centre on the line between"
            raise InputError(f"{text} the ends. For an arc use FlexibleFrame with one edge, whose centre is a point.")
        object.__setattr__(self, "elements", flexible.checked_elements(self.label, self.elements))
        places = flexible.fractions(self.elements)
        self._check_fields(len(places), places)
        _ = self._bosses  # refuses mass properties out of reach

    @classmethod
    def from_mesh(
        cls, name: str, path: str, start: Point, end: Point, *, sections: Mapping[int, Section], material: Material,
        mass: float | None = None, inertia: float | None = None, centre: float = 0.5, damping: float = 0.0,
        mass_damping: float = 0.0, pivot_inertia: float = 0.0, rotary_inertia: bool | float | None = None,
        shear: bool | float = False, stress: bool | None = None, velocity: Triple | FieldLike | None = None,
        displacement: FieldLike | None = None,
    ) -> FlexibleLink:  # fmt: skip
        """A link with the nodes of a line mesh (any format of meshio), laid between two points.

        Parameters
        ----------
        name : the link's name.
        path : mesh file with one straight chain of line cells.
        start, end : points of the ends of the mesh [m]; their distance must be the length of the mesh.
        sections : cross section by cell tag.
        material, mass, inertia, centre, damping, mass_damping, pivot_inertia, rotary_inertia, shear, stress, velocity,
            displacement : see the class.

        Raises
        ------
        InputError : a mesh that is no straight chain, of another length, or with tags that have no section.
        FileFormatError : a file that is no mesh.
        """
        from flexmb.elastic.beams.mesh import chain, read_lines  # noqa: PLC0415 - meshio is needed only here

        mesh = read_lines(path)
        station, length = mesh.stations(chain(mesh)), planar.distance(start, end)
        if abs(station[-1] - length) > 1e-6 * length:
            text = f"FlexibleLink {name!r}: {path} is {station[-1]:g} m long, but start and end are {length:g} m apart."
            raise InputError(f"{text} Move the ends, or take the mesh of the right link.")
        label, tags = f"FlexibleLink {name!r}", set(mesh.tags.tolist())
        elements, section = beam_of_mesh(label, path, tags, station, sections)
        return cls(
            name, start, end, section=section, material=material, elements=elements, mass=mass, inertia=inertia,
            centre=centre, damping=damping, mass_damping=mass_damping, pivot_inertia=pivot_inertia,
            rotary_inertia=rotary_inertia, shear=shear, stress=stress, velocity=velocity, displacement=displacement,
        )  # fmt: skip

    def nodes(self) -> tuple[Node, ...]:
        return self._nodes

    @cached_property
    def _nodes(self) -> tuple[Node, ...]:
        arc = self.start, self.end, self.turn, flexible.fractions(self.elements)
        poses = zip(points(*arc), tangents(*arc), strict=True)
        return tuple([Node(f"node{i}", *point, angle) for i, (point, angle) in enumerate(poses)])

    @property
    def main(self) -> str:
        return f"node{len(self._nodes) // 2}"

    @property
    def aliases(self) -> dict[str, str]:
        return {"start": "node0", "end": f"node{len(self._nodes) - 1}"}

    @property
    def corners(self) -> tuple[str, ...]:
        return self._nodes[0].name, self._nodes[-1].name

    @property
    def corner_points(self) -> tuple[Point, ...]:
        return self.start, self.end

    @cached_property
    def beams(self) -> tuple[Beam, ...]:
        """The one beam."""
        names, ends = [n.name for n in self._nodes], (self.start, self.end)
        return (self._beam(names, ends, flexible.fractions(self.elements), self.section, self.turn),)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        deflection = flexible.deflection_signal(self.name, self.beams[0], {n.name: n for n in self.nodes()})
        return [*super().contributions(mechanism), deflection]

    def _boss_pieces(self, gravity: Point) -> list[Contribution]:
        ends = super()._boss_pieces(gravity)
        if self.pivot_inertia == 0.0:
            return ends
        pivot = flexible.Bosses((0.0,), self.pivot_inertia, 0.0)
        return [*ends, *flexible.boss_pieces(self.name, self.corners[:1], pivot, gravity)]

    def _lumps(self) -> dict[str, tuple[float, float]]:
        (start, (mass, inertia)), end = super()._lumps().items()
        return dict([(start, (mass, inertia + self.pivot_inertia)), end])

    def _further_mass(self) -> tuple[float, Point, float]:
        """The pivot: no mass, at the start, its moment of inertia [kg m^2]."""
        return 0.0, self.start, self.pivot_inertia

    def _fit(self, own: RigidProperties, mass: float) -> flexible.Bosses:
        """Bosses at the ends; without a declared moment of inertia they are point masses."""
        along = (self.centre * self.length, 0.0)
        if self.inertia is None:
            moment = planar.to_frame(self.start, self.angle, own.centre)[0] * own.mass
            second = (mass * along[0] - moment) / self.length
            first = mass - own.mass - second
            if min(first, second) < -1e-9 * mass:
                text = f"{self.label}: mass {mass:g} kg cannot be reached by bosses at the ends: they would need"
                text += f" {first:.4g} and {second:.4g} kg, since the beam alone weighs {own.mass:g} kg."
                raise InputError(f"{text} Give a larger mass, a smaller section, or another centre.")
            return flexible.Bosses((max(first, 0.0), max(second, 0.0)), 0.0, 0.0)
        centre = own.centre if self.mass is None else planar.from_frame(self.start, self.angle, along)
        return flexible.fit_bosses(self.label, own, RigidProperties(mass, centre, self.inertia), [self.start, self.end])
