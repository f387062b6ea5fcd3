"""A flexible bar between two points: a chain of corotational beam elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, cast

from flexmb import checks, planar
from flexmb.beams.section import Section
from flexmb.bodies.bar import Bar
from flexmb.bodies.bosses import Bosses, RigidProperties, fit_bosses
from flexmb.bodies.fields import Field, FieldLike, Triple, start_displacement, start_velocity
from flexmb.bodies.flexible import (
    Beam,
    Elements,
    assemble,
    beam_pieces,
    beam_shapes,
    boss_pieces,
    checked_elements,
    deflection_kernel,
    fractions,
    mass_damping_pieces,
    mass_parts,
    nearest_node,
    rotary_inertia_of,
)
from flexmb.errors import InputError
from flexmb.model.contributions import Attachment, Contribution, Node, SignalContribution
from flexmb.model.material import Material
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

Point = tuple[float, float]


@dataclass(frozen=True)
class FlexibleLink(Bar):
    """A straight beam between two points; theta of a node is the direction of its axis, counted from +X.

    Nodes are called node0 .. nodeN from `start` to `end`; "start" and "end" are other names of the outer ones, and the
    body's own signals are those of the node in the middle.

    Parameters
    ----------
    name : the link's name.
    start, end : its ends in the drawn pose [m], unstressed.
    section : cross section.
    material : material.
    elements : number of equal elements, or increasing fractions of the length where inner nodes stand.
    mass : total mass [kg]; what the beam lacks is put into bosses at the ends.  None: the beam's own.
    inertia : moment of inertia about the centre of mass [kg m^2], reached through the bosses.  None: what results.
    centre : where the centre of mass lies between start (0) and end (1), when `mass` is given.
    damping : stiffness-proportional damping time zeta2 [s] (Rayleigh), >= 0.
    mass_damping : mass-proportional damping rate zeta1 [1/s] (Rayleigh), >= 0; see the notes.
    pivot_inertia : further moment of inertia at the start node [kg m^2], not counted in `inertia`.
    rotary_inertia : whether the turning of sections has inertia (Rayleigh beam): False, True for rho I, or a number
        [kg m] >= 0.
    velocity : (vx, vy, omega) of the middle node at the start, the link moving as a rigid body; or one (vx, vy, omega)
        per node, or a function of s that returns it, s being 0 at the start and 1 at the end; None: as driven.
    displacement : (dx, dy, dtheta) per node at the start [m, rad], or a function of s that returns it, added to the
        drawn pose; None: drawn as it starts.

    Raises
    ------
    InputError : values out of range; a mass or inertia that bosses cannot make; fields with another number of entries
        than nodes, or of another shape.

    Notes
    -----
    Slender beams with small strains and any rotation.  Not for deep beams: there is no shear.
    Source of the element: see `flexmb.beams.corotational`.

    `mass_damping` acts on the velocity against a frame that has its origin at the start and points to the end, on the
    mass of beam and bosses; no rigid motion is damped.  A bending mode of angular frequency omega that leaves both ends
    in place, as with a pin at each, has the damping ratio xi = zeta1/(2 omega) + zeta2 omega/2.  In other modes the
    first part is multiplied by the kinetic energy of the motion seen from that frame over that of the motion itself:
    5 with two free ends, 0.058 with a clamp at one end, in the first mode.
    Source of the ratio: R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, section 12-5.

    Fields are absolute, in world axes, given for the drawn pose; functions are evaluated once, when the link is made.
    A velocity field holds exactly.  The link is unstressed without its displacement: with it, it starts bent or
    stretched, and is not in equilibrium unless loads or accelerations hold it so.  Joints take their points and angles
    from the link without displacement; open loops are closed by moving bodies in their bent shape, unturned fields
    of velocity included, so draw a link that has one where it starts.
    """

    _: KW_ONLY
    section: Section
    material: Material
    elements: Elements = 4
    mass: float | None = None
    inertia: float | None = None
    centre: float = 0.5
    damping: float = 0.0
    mass_damping: float = 0.0
    pivot_inertia: float = 0.0
    rotary_inertia: bool | float = False
    velocity: Triple | FieldLike | None = None
    displacement: FieldLike | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_beam(self)
        object.__setattr__(self, "elements", checked_elements(self.label, self.elements))
        checks.between(self.label, "centre", self.centre, 0.0, 1.0)
        checks.not_negative(self.label, "pivot_inertia", self.pivot_inertia, "kg m^2")
        places = fractions(self.elements)
        for name, checked in (("velocity", start_velocity), ("displacement", start_displacement)):
            object.__setattr__(self, name, checked(self.label, getattr(self, name), len(places), places))
        _ = self._bosses  # refuses what bosses cannot make

    @classmethod
    def from_mesh(
        cls,
        name: str,
        path: str,
        start: Point,
        end: Point,
        *,
        sections: Mapping[int, Section],
        material: Material,
        mass: float | None = None,
        inertia: float | None = None,
        centre: float = 0.5,
        damping: float = 0.0,
        mass_damping: float = 0.0,
        pivot_inertia: float = 0.0,
        rotary_inertia: bool | float = False,
        velocity: Triple | FieldLike | None = None,
        displacement: FieldLike | None = None,
    ) -> FlexibleLink:
        """A link with the nodes of a line mesh (any format of meshio), laid between two points of the drawn pose.

        Parameters
        ----------
        name : the link's name.
        path : mesh file with one straight chain of line cells.
        start, end : where the ends of the mesh are put [m]; their distance must be the length of the mesh.
        sections : cross section by cell tag.
        material, mass, inertia, centre, damping, mass_damping, pivot_inertia, rotary_inertia, velocity, displacement :
            see the class.

        Raises
        ------
        InputError : a mesh that is no straight chain, of another length, or with tags that have no section.
        FileFormatError : a file that is no mesh.
        """
        from flexmb.beams.mesh import chain, read_lines  # noqa: PLC0415 - meshio is needed only here

        mesh = read_lines(path)
        order = chain(mesh)
        station = mesh.stations(order)
        length = planar.distance(start, end)
        if abs(station[-1] - length) > 1e-6 * length:
            raise InputError(
                f"FlexibleLink {name!r}: {path} is {station[-1]:g} m long, but start and end are {length:g} m apart. "
                "Move the ends, or take the mesh of the right link."
            )
        inner = tuple(float(s) for s in station[1:-1] / station[-1])
        return cls(
            name,
            start,
            end,
            section=section_of(f"FlexibleLink {name!r}", str(path), set(mesh.tags.tolist()), sections),
            material=material,
            elements=inner or 1,
            mass=mass,
            inertia=inertia,
            centre=centre,
            damping=damping,
            mass_damping=mass_damping,
            pivot_inertia=pivot_inertia,
            rotary_inertia=rotary_inertia,
            velocity=velocity,
            displacement=displacement,
        )

    def nodes(self) -> tuple[Node, ...]:
        """Nodes from start to end."""
        return self._nodes

    @cached_property
    def _nodes(self) -> tuple[Node, ...]:
        angle = self.angle
        (x0, y0), (x1, y1) = self.start, self.end
        places = enumerate(fractions(self.elements))
        return tuple([Node(f"node{i}", x0 + s * (x1 - x0), y0 + s * (y1 - y0), angle) for i, s in places])

    @property
    def main(self) -> str:
        """The node in the middle of the chain."""
        return f"node{len(self._nodes) // 2}"

    @property
    def aliases(self) -> dict[str, str]:
        """start and end."""
        return {"start": "node0", "end": f"node{len(self._nodes) - 1}"}

    def attach(self, owner: str, point: Point) -> Attachment:
        """The node at that point."""
        return Attachment(self.name, nearest_node(self.label, owner, self.nodes(), point, self.length).name, (0.0, 0.0))

    def start_velocity(self) -> Triple | Field | None:
        """The declared start velocity."""
        return cast("Triple | Field | None", self.velocity)

    def start_displacement(self) -> Field | None:
        """The declared start displacement."""
        return cast("Field | None", self.displacement)

    def properties(self) -> RigidProperties:
        """Mass, centre of mass and moment of inertia of the link as a rigid body in the drawn pose."""
        bosses, parts = self._bosses, mass_parts(self._beam)
        ends = zip(bosses.masses, (self.start, self.end), strict=True)
        parts += [(mass, point, bosses.inertia) for mass, point in ends]
        parts.append((0.0, self.start, self.pivot_inertia))
        return RigidProperties.of(parts)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Elements, bosses, damping and the signal `deflection`."""
        nodes, zeta = {n.name: n for n in self._nodes}, self.mass_damping
        ends = (self._nodes[0].name, self._nodes[-1].name)
        bosses = self._bosses
        if self.pivot_inertia:
            extra = Bosses((0.0,), self.pivot_inertia, 0.0)
            pivot = boss_pieces(self.name, ends[:1], extra, mechanism.gravity)
        else:
            pivot = []
        three = (ends[0], self.main, ends[1])
        coordinates = tuple([(self.name, node, axis) for node in three for axis in (0, 1)])
        return [
            *beam_pieces(self.name, [self._beam], nodes, self.damping, mechanism.gravity),
            *boss_pieces(self.name, ends, bosses, mechanism.gravity),
            *pivot,
            *(mass_damping_pieces(self.name, [self._beam], self._beam, zeta, self._lumps()) if zeta else ()),
            SignalContribution(self.name, "deflection", "m", deflection_kernel, coordinates),
        ]

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the beam alone
        """The elements."""
        return beam_shapes(self.name, [self._beam], {n.name: n for n in self.nodes()})

    @classmethod
    def prepare(cls, parts: Sequence[FlexibleLink]) -> None:
        """Matrices of all beams in one assembly."""
        assemble(part._beam for part in parts)

    @cached_property
    def _beam(self) -> Beam:
        length = self.length
        names = tuple([node.name for node in self._nodes])
        stations = tuple([s * length for s in fractions(self.elements)])
        rotary = rotary_inertia_of(self.label, self.rotary_inertia)
        return Beam(names, self.start, self.end, stations, self.section, self.material, rotary)

    def _lumps(self) -> dict[str, tuple[float, float]]:
        """Mass and moment of inertia put on the end nodes."""
        bosses = self._bosses
        (first, last), J = bosses.masses, bosses.inertia
        return {self.aliases["start"]: (first, J + self.pivot_inertia), self.aliases["end"]: (last, J)}

    @cached_property
    def _bosses(self) -> Bosses:
        if self.mass is None and self.inertia is None:
            return Bosses((0.0, 0.0), 0.0, 0.0)
        beam = RigidProperties.of(mass_parts(self._beam))
        mass = beam.mass if self.mass is None else self.mass
        along = (self.centre * self.length, 0.0)
        centre = beam.centre if self.mass is None else planar.from_frame(self.start, self.angle, along)
        if self.inertia is None:
            own = planar.to_frame(self.start, self.angle, beam.centre)[0] * beam.mass
            target = own + (mass - beam.mass) * self.length / 2.0 if self.mass is None else mass * along[0]
            return point_bosses(self.label, beam.mass, mass, (target - own) / self.length)
        wanted = RigidProperties(mass, centre, self.inertia)
        return fit_bosses(self.label, beam, wanted, [self.start, self.end])


def point_bosses(label: str, beam_mass: float, mass: float, second: float) -> Bosses:
    """Point masses at both ends, `second` at the end, that make mass and centre right, whatever the inertia."""
    first = mass - beam_mass - second
    if min(first, second) < -1e-9 * mass:
        raise InputError(
            f"{label}: mass {mass:g} kg cannot be reached by bosses at the ends: they would need {first:.4g} and "
            f"{second:.4g} kg, since the beam alone weighs {beam_mass:g} kg. "
            "Give a larger mass, a smaller section, or another centre."
        )
    return Bosses((max(first, 0.0), max(second, 0.0)), 0.0, 0.0)


def check_beam(body) -> None:
    """Checks of section, material, mass, inertia and damping that links and frames share."""
    sections = body.section if isinstance(body.section, tuple) else (body.section,)
    for section in sections:
        if not isinstance(section, Section):
            raise InputError(
                f"{body.label}: section is {section!r}; it must be a cross section such as Rectangle(...)."
            )
    if not isinstance(body.material, Material):
        raise InputError(f"{body.label}: material is {body.material!r}; it must be a Material(...).")
    for name, unit in (("mass", "kg"), ("inertia", "kg m^2")):
        if getattr(body, name) is not None:
            checks.positive(body.label, name, getattr(body, name), unit)
    checks.not_negative(body.label, "damping", body.damping, "s")
    checks.not_negative(body.label, "mass_damping", body.mass_damping, "1/s")
    rotary_inertia_of(body.label, body.rotary_inertia)


def section_of(label: str, path: str, tags: set[int], sections: Mapping[int, Section]) -> Section:
    """The one section of a mesh whose cells all carry the same tag."""
    missing = sorted(tags - set(sections))
    if missing:
        raise InputError(f"{label}: {path} has cells with tag {missing[0]}, for which sections has no entry. Add one.")
    if len({sections[t] for t in tags}) != 1:
        raise InputError(f"{label}: {path} has cells of several sections {sorted(tags)}; use FlexibleFrame.from_mesh.")
    return sections[min(tags)]
