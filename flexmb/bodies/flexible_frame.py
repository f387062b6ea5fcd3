"""A flexible frame: straight beams welded at corners."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks, planar
from flexmb.beams.section import Section
from flexmb.bodies.bosses import Bosses, RigidProperties, fit_bosses
from flexmb.bodies.fields import Field, Triple, start_displacement, start_velocity
from flexmb.bodies.flexible import (
    Beam,
    Elements,
    assemble,
    beam_pieces,
    beam_shapes,
    boss_pieces,
    checked_elements,
    fractions,
    mass_damping_pieces,
    mass_parts,
    nearest_node,
    rotary_inertia_of,
)
from flexmb.bodies.flexible_link import check_beam
from flexmb.errors import InputError
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.material import Material
from flexmb.model.part import Body
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

Point = tuple[float, float]
Edge = tuple[int, int]


@dataclass(frozen=True)
class FlexibleFrame(Body):
    """Straight beams between corners, welded there; theta of every node is 0 in the drawn pose.

    Nodes are called node0, node1, ...: first the corners in the order of `points`, then the inner nodes edge by edge.
    The body's own signals are those of node0.

    Parameters
    ----------
    name : the frame's name.
    points : corners in the drawn pose [m], unstressed.
    edges : pairs of corner numbers, one a beam.
    section : cross section of all beams, or one a beam.
    material : material.
    elements : elements a beam (number, or fractions of the length where inner nodes stand), or one entry a beam.
    mass : total mass [kg]; what the beams lack is put on the corners and on their mean.  None: the beams' own.
    inertia : moment of inertia about the centre of mass [kg m^2].  None: the beams' own.
    centre : centre of mass in the drawn pose [m], when mass or inertia is given.  None: the beams' own.
    damping : stiffness-proportional damping time zeta2 [s] (Rayleigh), >= 0.
    mass_damping : mass-proportional damping rate zeta1 [1/s] (Rayleigh), >= 0; see the notes.
    rotary_inertia : whether the turning of sections has inertia (Rayleigh beam): False, True for rho I, or a number
        [kg m] >= 0.
    velocity : (vx, vy, omega) of node0 at the start, the frame moving as a rigid body, or one (vx, vy, omega) per node;
        None: as driven.
    displacement : (dx, dy, dtheta) per node at the start [m, rad], added to the drawn pose; None: drawn as it starts.

    Raises
    ------
    InputError : values out of range, corners that no edge reaches, an edge twice, mass properties out of reach, fields
        with another number of entries than nodes.

    Notes
    -----
    A mass at the mean of the corners has the velocity that is the mean of theirs, as if held by light spokes.
    Slender beams with small strains and any rotation.

    `mass_damping` acts on the velocity against a frame that has its origin at the first corner of the first edge and
    points to the second one, on the mass of the beams and of the bosses on corners, not on a mass at the mean of the
    corners; no rigid motion is damped.  A mode of angular frequency omega that leaves those two corners in place has
    the damping ratio xi = zeta1/(2 omega) + zeta2 omega/2, when nothing lies at the mean of the corners.
    Source of the ratio: R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, section 12-5.

    Fields of velocity and displacement: see `FlexibleLink`.  The frame is unstressed without its displacement.
    """

    points: tuple[Point, ...]
    edges: tuple[Edge, ...]
    _: KW_ONLY
    section: Section | tuple[Section, ...]
    material: Material
    elements: Elements | tuple[Elements, ...] = 4
    mass: float | None = None
    inertia: float | None = None
    centre: Point | None = None
    damping: float = 0.0
    mass_damping: float = 0.0
    rotary_inertia: bool | float = False
    velocity: Triple | Field | None = None
    displacement: Field | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        corners = checks.sequence(self.label, "points", self.points, "corners (x, y)")
        points = tuple(checks.point(self.label, f"points[{i}]", p) for i, p in enumerate(corners))
        object.__setattr__(self, "points", points)
        edges = checks.sequence(self.label, "edges", self.edges, "pairs of corner numbers")
        object.__setattr__(self, "edges", tuple(self._checked_edge(i, e) for i, e in enumerate(edges)))
        pairs = [frozenset(edge) for edge in self.edges]
        for i, pair in enumerate(pairs):
            if pair in pairs[:i]:
                raise InputError(
                    f"{self.label}: edges[{i}] is {self.edges[i]}, which joins two corners once more; remove it."
                )
        lonely = set(range(len(points))) - {i for edge in self.edges for i in edge}
        if lonely or not self.edges:
            raise InputError(f"{self.label}: corners {sorted(lonely)} belong to no edge. Remove them or add edges.")
        if isinstance(self.section, list):
            object.__setattr__(self, "section", tuple(self.section))
        check_beam(self)
        if isinstance(self.section, tuple) and len(self.section) != len(self.edges):
            raise InputError(f"{self.label}: {len(self.section)} sections for {len(self.edges)} edges; give one each.")
        object.__setattr__(self, "elements", self._checked_elements())
        if self.centre is not None:
            object.__setattr__(self, "centre", checks.point(self.label, "centre", self.centre))
        count = len(self.nodes())
        object.__setattr__(self, "velocity", start_velocity(self.label, self.velocity, count, None))
        object.__setattr__(self, "displacement", start_displacement(self.label, self.displacement, count, None))
        self._bosses()

    def _checked_edge(self, i: int, edge: object) -> Edge:
        try:
            a, b = (checks.count(self.label, f"edges[{i}]", k, 0) for k in edge)  # type: ignore[attr-defined]
        except (TypeError, ValueError) as error:
            raise InputError(f"{self.label}: edges[{i}] is {edge!r}; it must be a pair of corner numbers.") from error
        if max(a, b) >= len(self.points) or planar.distance(self.points[a], self.points[b]) <= 0.0:
            raise InputError(
                f"{self.label}: edges[{i}] is {edge!r}; it must join two different corners of {len(self.points)}."
            )
        return a, b

    def _checked_elements(self) -> tuple[Elements, ...]:
        given = self.elements
        if isinstance(given, (tuple, list)) and len(given) == len(self.edges):
            return tuple(checked_elements(self.label, e) for e in given)
        return (checked_elements(self.label, given),) * len(self.edges)

    @classmethod
    def from_mesh(
        cls,
        name: str,
        path: str,
        at: Point = (0.0, 0.0),
        *,
        angle: float = 0.0,
        sections: Mapping[int, Section],
        material: Material,
        mass: float | None = None,
        inertia: float | None = None,
        centre: Point | None = None,
        damping: float = 0.0,
        mass_damping: float = 0.0,
        rotary_inertia: bool | float = False,
        velocity: Triple | Field | None = None,
        displacement: Field | None = None,
    ) -> FlexibleFrame:
        """A frame from a mesh of line cells (any format of meshio); corners are where beams meet, end or bend.

        Parameters
        ----------
        name : the frame's name.
        path : mesh file.
        at : where the mesh's origin is put in the drawn pose [m].
        angle : by how much the mesh is turned about its origin [rad].
        sections : cross section by cell tag.
        material, mass, inertia, centre, damping, mass_damping, rotary_inertia, velocity, displacement : see the class.

        Raises
        ------
        InputError : a mesh that is no frame of straight beams, tags without a section.
        FileFormatError : a file that is no mesh.
        """
        from flexmb.beams.mesh import members, read_lines  # noqa: PLC0415 - meshio is needed only here

        mesh = read_lines(path)
        corners: dict[int, int] = {}
        edges, elements, chosen = [], [], []
        for nodes in members(mesh):
            tag = mesh.tag_of(nodes)
            if tag not in sections:
                raise InputError(
                    f"FlexibleFrame {name!r}: {path} has cells with tag {tag}, for which sections has no entry. "
                    "Add one."
                )
            edges.append(tuple(corners.setdefault(int(n), len(corners)) for n in (nodes[0], nodes[-1])))
            stations = mesh.stations(nodes)
            inner = tuple(float(s) for s in stations[1:-1] / stations[-1])
            elements.append(inner or 1)
            chosen.append(sections[tag])
        points = tuple(planar.from_frame(at, angle, tuple(map(float, mesh.points[n]))) for n in corners)
        return cls(
            name,
            points,
            tuple(edges),
            section=tuple(chosen),
            material=material,
            elements=tuple(elements),
            mass=mass,
            inertia=inertia,
            centre=centre,
            damping=damping,
            mass_damping=mass_damping,
            rotary_inertia=rotary_inertia,
            velocity=velocity,
            displacement=displacement,
        )

    @property
    def corners(self) -> tuple[str, ...]:
        """Names of the corner nodes."""
        return tuple(f"node{i}" for i in range(len(self.points)))

    def nodes(self) -> tuple[Node, ...]:
        """Corners, then inner nodes edge by edge."""
        found = {f"node{i}": p for i, p in enumerate(self.points)}
        for beam in self._beams():
            inner = zip(beam.nodes, beam.stations, strict=True)
            for name, station in inner:
                s = station / beam.stations[-1]
                x = beam.start[0] + s * (beam.end[0] - beam.start[0])
                y = beam.start[1] + s * (beam.end[1] - beam.start[1])
                found.setdefault(name, (x, y))
        return tuple(Node(name, *point, 0.0) for name, point in found.items())

    def attach(self, owner: str, point: Point) -> Attachment:
        """The node at that point."""
        size = max(planar.distance(self.points[0], p) for p in self.points)
        return Attachment(self.name, nearest_node(self.label, owner, self.nodes(), point, size).name, (0.0, 0.0))

    def start_velocity(self) -> Triple | Field | None:
        """The declared start velocity."""
        return self.velocity

    def start_displacement(self) -> Field | None:
        """The declared start displacement."""
        return self.displacement

    def properties(self) -> RigidProperties:
        """Mass, centre of mass and moment of inertia of the frame as a rigid body in the drawn pose."""
        bosses = self._bosses()
        parts = [part for beam in self._beams() for part in mass_parts(beam)]
        parts += [(m, p, bosses.inertia) for m, p in zip(bosses.masses, self.points, strict=True)]
        mean = np.array(self.points).mean(axis=0)
        parts.append((bosses.mean_mass, (float(mean[0]), float(mean[1])), 0.0))
        return RigidProperties.of(parts)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Elements, bosses and damping."""
        nodes = {n.name: n for n in self.nodes()}
        beams, bosses = self._beams(), self._bosses()
        lumps = {corner: (mass, bosses.inertia) for corner, mass in zip(self.corners, bosses.masses, strict=True)}
        return [
            *beam_pieces(self.name, beams, nodes, self.damping, mechanism.gravity),
            *boss_pieces(self.name, self.corners, bosses, mechanism.gravity),
            *mass_damping_pieces(self.name, beams, beams[0], self.mass_damping, lumps),
        ]

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the beams alone
        """The elements."""
        return beam_shapes(self.name, self._beams(), {n.name: n for n in self.nodes()})

    @classmethod
    def prepare(cls, parts: Sequence[FlexibleFrame]) -> None:
        """Matrices of all beams in one assembly."""
        assemble(beam for part in parts for beam in part._beams())

    def _beams(self) -> list[Beam]:
        sections = self.section if isinstance(self.section, tuple) else (self.section,) * len(self.edges)
        beams, count = [], len(self.points)
        rotary = rotary_inertia_of(self.label, self.rotary_inertia)
        for (a, b), section, elements in zip(self.edges, sections, self.elements, strict=True):  # type: ignore[arg-type]
            share = fractions(elements)
            inner = tuple(f"node{count + i}" for i in range(len(share) - 2))
            count += len(inner)
            length = planar.distance(self.points[a], self.points[b])
            stations = tuple(s * length for s in share)
            names = (f"node{a}", *inner, f"node{b}")
            beams.append(Beam(names, self.points[a], self.points[b], stations, section, self.material, rotary))
        return beams

    def _bosses(self) -> Bosses:
        if self.mass is None and self.inertia is None:
            return Bosses((0.0,) * len(self.points), 0.0, 0.0)
        beam = RigidProperties.of([part for b in self._beams() for part in mass_parts(b)])
        mass = beam.mass if self.mass is None else self.mass
        inertia = beam.inertia if self.inertia is None else self.inertia
        wanted = RigidProperties(mass, self.centre or beam.centre, inertia)
        return fit_bosses(self.label, beam, wanted, list(self.points))
