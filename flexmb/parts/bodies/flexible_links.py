"""Flexible bodies of beams: their base, bars between two points, and frames."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmb import checks, planar
from flexmb.elastic.beams.corotational import checked_turn, chord_share, points, tangents
from flexmb.elastic.beams.section import Section, checked_factor
from flexmb.errors import InputError
from flexmb.fields import between, field, instance, not_negative, point, positive, record, several, variant
from flexmb.findings.finding import Finding, found
from flexmb.late import scipy
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.law import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, ElasticBody, Pose, WatchedMotion
from flexmb.model.shape import Shapes
from flexmb.parts.bodies import flexible
from flexmb.parts.bodies.flexible import Beam, Elements, Field, FieldLike, RigidProperties, Triple
from flexmb.parts.bodies.rigid import Bar

Point = tuple[float, float]
THICK_ARC = 0.1  # height of a section over the radius of an arc, above which the stress is not that of a straight beam
LEAST_SLENDERNESS = 5.0  # length of a beam over its height, below which shear cannot be left out


@record
class FlexibleBody(ElasticBody):
    """Base of bodies made of beams; a subclass lays them out and fits bosses to the nodes at its corners."""

    # - elements: a number of equal elements, or increasing fractions of the length where inner nodes stand.
    # - mass, inertia: bosses at the corners add to the beams what is missing.
    # - rotary_inertia (Rayleigh beam): False for none, True for rho I, or a number >= 0; None: rho I with shear, none
    #   without.
    # - shear (Timoshenko beam): False for none, True for the shear factor of the section (Cowper's, for Poisson's ratio
    #   of the material), or the shear factor, such as 5/6.
    # - stress: the largest normal stress in the outer fibres, signals `von_mises` [Pa] and `von_mises_node`, the number
    #   of its node, or of the middle of an element behind all nodes.  None: where the material has a yield stress and
    #   all sections know their outer fibres.
    # - velocity: of a rigid motion, or one (vx, vy, omega) per node; displacement: per node [m, rad], added to the
    #   reference configuration.
    stress_name: ClassVar[str] = "normal stress in the outer fibres"
    theory: ClassVar[str] = "beams"
    _: KW_ONLY
    section: Section | tuple[Section, ...] = field("cross section of all beams, or one a beam")
    material: Material = field("material", rule=instance(Material, "a Material(...)"))
    elements: flexible.Elements | tuple[flexible.Elements, ...] = field(
        "elements a beam, or fractions of its length, or such a beam", default=4
    )
    mass: float | None = field("total mass; None: the beams' own", "kg", positive, default=None)
    inertia: float | None = field("about the centre of mass; None: the beams' own", "kg m^2", positive, default=None)
    centre: float | Point | None = field("of mass, when mass or inertia is given; None: the beams' own", default=None)
    damping: float = field("stiffness-proportional damping time zeta2 (Rayleigh)", "s", not_negative, default=0.0)
    mass_damping: float = field("mass-proportional damping rate zeta1 (Rayleigh)", "1/s", not_negative, default=0.0)
    rotary_inertia: bool | float | None = field("of the sections, see above", "kg m", default=None)
    shear: bool | float = field("whether beams have shear, see above", default=False)
    stress: bool | None = field(
        "whether every accepted step looks for the largest stress, see above",
        rule=instance(bool, "True, False or None"), default=None,
    )  # fmt: skip
    velocity: flexible.Triple | flexible.FieldLike | None = field(
        "(vx, vy, omega) at the start; None: as driven", default=None
    )
    displacement: flexible.FieldLike | None = field("(dx, dy, dtheta) at the start, as above; None: none", default=None)

    @property
    @abstractmethod
    def corners(self) -> tuple[str, ...]:
        """Names of the nodes at the corners."""

    @property
    @abstractmethod
    def corner_points(self) -> tuple[Point, ...]:
        """Points of the corners in the reference configuration [m]."""

    @property
    @abstractmethod
    def beams(self) -> tuple[flexible.Beam, ...]:
        """The beams; the frame of mass-proportional damping lies on the first one."""

    @abstractmethod
    def _fit(self, own: flexible.RigidProperties, mass: float) -> flexible.Bosses:
        """Bosses that turn the beams' `own` properties into the declared ones, with the total `mass` [kg]."""

    @abstractmethod
    def _further_mass(self) -> tuple[float, Point, float]:
        """Mass [kg], point [m] and moment of inertia [kg m^2] beside beams and bosses at corners."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.section, list):
            object.__setattr__(self, "section", tuple(self.section))
        for section in self._sections:
            checks.instance(self.label, "section", section, Section, "a cross section such as Rectangle(...)")
        if self.stress and not self.knows_stress:
            text = f"{self.label}: stress is True, and a section does not know its outer fibre"
            raise InputError(f"{text}. Give outer_fibre=... [m] to the section.")
        _ = self._options

    def _check_fields(self, count: int, places: Sequence[float] | None) -> None:
        """Check the start fields of `count` nodes; functions are evaluated at `places`, or refused without them."""
        for name, checked in (("velocity", flexible.start_velocity), ("displacement", flexible.start_displacement)):
            object.__setattr__(self, name, checked(self.label, getattr(self, name), count, places))

    @cached_property
    def _bosses(self) -> flexible.Bosses:
        """Masses and moments of inertia at the corners, which give the body its declared mass properties."""
        if self.mass is None and self.inertia is None:
            return flexible.Bosses((0.0,) * len(self.corners), 0.0, 0.0)
        own = flexible.RigidProperties.of(self._mass_parts())
        return self._fit(own, own.mass if self.mass is None else self.mass)

    def properties(self) -> flexible.RigidProperties:
        """Mass, centre of mass and moment of inertia as a rigid body in the reference configuration."""
        bosses = self._bosses
        corners = [(mass, point, bosses.inertia) for mass, point in zip(bosses.masses, self.corner_points, strict=True)]
        return flexible.RigidProperties.of([*self._mass_parts(), *corners, self._further_mass()])

    @property
    def seeks_stress(self) -> bool:
        return (self.material.yield_stress is not None and self.knows_stress) if self.stress is None else self.stress

    @property
    def knows_stress(self) -> bool:
        return all(map(flexible.knows_stress, self._sections))

    def reference_points(self) -> np.ndarray:
        """Places (n, 2) of the nodes, then of the middles of the elements, in the reference configuration [m]."""
        return np.array([(node.x, node.y) for node in self.nodes()] + [p for beam in self.beams for p in beam.middles])

    def place_name(self, number: int) -> str:
        count = len(self.nodes())
        return super().place_name(number) if number < count else f"the middle of element {number - count}"

    def strain_at_rest(self, mechanism: Mechanism, pose: Pose) -> tuple[float, float]:
        strain = float(self._strains(lambda names: np.array([[pose[name] for name in names]])).max())
        return strain, max(strain * self.material.young, super().strain_at_rest(mechanism, pose)[1])

    def strain_in(self, motion: WatchedMotion) -> tuple[float, float, float]:
        strains = self._strains(lambda names: motion.rows(*names))
        k = int(np.argmax(strains))
        return float(strains[k]), float(strains[k]) * self.material.young, float(motion.times[k])

    def _strains(self, rows: Callable[[list[str]], np.ndarray]) -> np.ndarray:
        """Largest strains (n,) of n poses, by a function that gives `rows` (n, k) of coordinates by full names."""
        nodes, found_here = {node.name: node for node in self.nodes()}, []
        for beam in self.beams:
            names = [f"{self.name}.{node}.{axis}" for axis in ("x", "y", "theta") for node in beam.nodes]
            found_here.append(flexible.beam_strains(beam, nodes, np.split(rows(names), 3, axis=1)).max(axis=1))
        return np.asarray(np.max(found_here, axis=0))

    def odd_sizes(self) -> Iterator[Finding]:
        """Findings on thick arcs of unknown outlines, and on beams without shear that are short for their height."""
        arcs = [beam for beam in self.beams if beam.turn and self.seeks_stress]
        heights = [2.0 * _outer_fibre(beam.section) * abs(beam.turn) / beam.length for beam in arcs]
        unknown = [h for h, beam in zip(heights, arcs, strict=True) if np.isnan(flexible.arc_factors(beam)).any()]
        if unknown and max(unknown) > THICK_ARC:
            text = f"{self.label}: the radius of an arc is {1.0 / max(unknown):.3g} times the height of its section,"
            text += " whose outline is unknown: its stress is that of a straight beam, too small at the inner fibre."
            remedy = "Take a Rectangle, Circle or Tube, or a section of your own with over_radius_at."
            yield found("thick-arc", (self.name,), text, remedy, radius_over_height=1.0 / max(unknown))
        if self.shear is not False:
            return
        height = max(2.0 * _outer_fibre(beam.section) for beam in self.beams)
        length = float(np.hypot(*np.ptp(self.reference_points(), axis=0)))
        if length < LEAST_SLENDERNESS * height:
            text = f"{self.label} is {length:.4g} m long and {height:.4g} m high: no slender beam."
            remedy = "Take a rigid body, or shear=True; the bending of this one would lack its shear."
            yield found("stubby-beam", (self.name,), text, remedy, length=length, height=height)

    def total_mass(self) -> float:
        return self.properties().mass

    def attach(self, owner: str, point: Point) -> Attachment:
        points = self.corner_points
        size = max([planar.distance(points[0], corner) for corner in points[1:]])
        node = flexible.nearest_node(self.label, owner, self.nodes(), point, size)
        return Attachment(self.name, node.name, (0.0, 0.0))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        nodes, gravity = {n.name: n for n in self.nodes()}, mechanism.gravity
        every = flexible.beam_pieces(self.name, self.beams, nodes, self.damping, gravity) + self._boss_pieces(gravity)
        every += flexible.mass_damping_pieces(self.name, self.beams, self.beams[0], self.mass_damping, self._lumps())
        every += [flexible.beam_stress_signal(self.name, self.beams, nodes, gravity)] if self.seeks_stress else []
        return every

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return flexible.beam_shapes(self.name, self.beams, {n.name: n for n in self.nodes()}, mechanism.gravity)

    @classmethod
    def prepare(cls, parts: Sequence[FlexibleBody]) -> None:
        flexible.assemble(beam for part in parts for beam in part.beams)

    def _boss_pieces(self, gravity: Point) -> list[Contribution]:
        """Contributions of the masses at the corners and at their mean."""
        return flexible.boss_pieces(self.name, self.corners, self._bosses, gravity)

    def _lumps(self) -> dict[str, tuple[float, float]]:
        """Mass [kg] and moment of inertia [kg m^2] at the corners, by node."""
        return {name: (m, self._bosses.inertia) for name, m in zip(self.corners, self._bosses.masses, strict=True)}

    def _mass_parts(self) -> list[tuple[float, Point, float]]:
        """Mass, centre of mass and moment of inertia of every element."""
        return [part for beam in self.beams for part in flexible.mass_parts(beam)]

    @property
    def _sections(self) -> tuple[Section, ...]:
        """The sections, one of all beams or one of each."""
        return self.section if isinstance(self.section, tuple) else (self.section,)

    @cached_property
    def _options(self) -> tuple[float | None, float | None]:
        """Rotary inertia [kg m] (None: rho I) and shear of a `Beam` (None: that of its sections, if they know it)."""
        shear: float | None = None if self.shear is True else 0.0
        if not isinstance(self.shear, bool):
            shear = checked_factor(self.label, "shear", self.shear)
        for section in self._sections if shear is None else ():
            try:
                section.shear_factor_at(0.5, self.material.poisson)
            except InputError as error:
                raise InputError(f"{self.label}: shear is True, and {error}") from None
        rotary = shear != 0.0 if self.rotary_inertia is None else self.rotary_inertia
        if isinstance(rotary, bool):
            return None if rotary else 0.0, shear
        return checks.not_negative(self.label, "rotary_inertia", rotary, "kg m"), shear

    def _beam(
        self, names: Sequence[str], ends: tuple[Point, Point], places: Sequence[float], section: Section, turn: float
    ) -> flexible.Beam:
        """A beam between two points with nodes of these names at fractions of its length."""
        length = planar.distance(*ends) / chord_share(turn)
        stations = tuple([s * length for s in places])
        return flexible.Beam(tuple(names), *ends, stations, section, self.material, *self._options, turn)


def _outer_fibre(section: Section) -> float:
    """Largest distance of the outer fibre [m]; where it is unknown that of a rectangle of the same A and I."""
    places = np.array([0.0, 0.5, 1.0])
    if flexible.knows_stress(section):
        return float(np.max(section.outer_fibre_at(places)))
    return float(np.max(np.sqrt(3.0 * section.second_moment_at(places) / section.area_at(places))))


def beam_of_mesh(
    label: str, path: str, tags: set[int], stations: np.ndarray, sections: Mapping[int, Section]
) -> tuple[flexible.Elements, Section]:
    """Inner nodes as fractions of the length, and the one section of a straight beam, by stations (n,) and `tags`."""
    missing = sorted(tags - set(sections))
    if missing:
        raise InputError(f"{label}: {path} has cells with tag {missing[0]}, for which sections has no entry. Add one.")
    if len({sections[t] for t in tags}) != 1:
        raise InputError(f"{label}: {path} has cells of several sections {sorted(tags)}; use FlexibleFrame.from_mesh.")
    return tuple(float(s) for s in stations[1:-1] / stations[-1]) or 1, sections[min(tags)]


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
