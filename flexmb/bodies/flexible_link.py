"""A flexible bar between two points: a chain of corotational beam elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from typing import TYPE_CHECKING

from flexmb import checks, planar
from flexmb.beams.arc import checked_turn, points, tangents
from flexmb.beams.section import Section
from flexmb.bodies.bar import Bar
from flexmb.bodies.bosses import Bosses, RigidProperties, fit_bosses
from flexmb.bodies.fields import FieldLike, Triple
from flexmb.bodies.flexible import Beam, Elements, boss_pieces, checked_elements, deflection_kernel, fractions
from flexmb.bodies.flexible_body import FlexibleBody, beam_of_mesh
from flexmb.docstrings import documented
from flexmb.errors import InputError
from flexmb.model.contributions import Contribution, Node, SignalContribution
from flexmb.model.material import Material

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

Point = tuple[float, float]


@documented
class FlexibleLink(FlexibleBody, Bar):
    """A beam between two points, straight or an arc; theta of a node is the direction of its axis, counted from +X.

    Nodes are called node0 .. nodeN from `start` to `end`; "start" and "end" are other names of the outer ones, and the
    body's own signals are the signals of the node in the middle.

    Parameters
    ----------
    name : the link's name.
    start, end : its ends in the reference configuration [m], unstressed.
    section : cross section.
    elements : number of equal elements, or increasing fractions of the length where inner nodes stand.
    mass : total mass [kg]; bosses at the ends add the difference to the beam.  None: the beam's own.
    inertia : moment of inertia about the centre of mass [kg m^2], reached by the bosses.  None: that of beam and
        bosses.
    centre : place of the centre of mass between start (0) and end (1), when `mass` is given.
    pivot_inertia : further moment of inertia at the start node [kg m^2], not counted in `inertia`.
    turn : by which the unstressed link turns from start to end along a circular arc [rad], counter-clockwise > 0,
        between -2 pi and 2 pi; 0: straight.
    velocity : (vx, vy, omega) of the middle node at the start, the link moving as a rigid body; or one (vx, vy, omega)
        per node, or a function of s that returns it, s being 0 at the start and 1 at the end; None: as driven.
    displacement : (dx, dy, dtheta) per node at the start [m, rad], or a function of s that returns it, added to the
        reference configuration; None: no displacement.

    Raises
    ------
    InputError : values out of range; a mass or inertia that bosses cannot make, or of an arc; fields with another
        number of entries than nodes, or of another shape; shear of a section that does not know its shear factor.

    Notes
    -----
    Beams with small strains and any rotation; without `shear` not for deep beams (length over height below 10).
    Elements of an arc are arcs; they should turn by less than 0.5 rad each.  The signal `deflection` of an arc holds
    its rise.
    Source of the element: see `flexmb.beams.corotational`.

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
    section: Section
    elements: Elements = 4
    centre: float = 0.5
    pivot_inertia: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "turn", checked_turn(self.label, "turn", self.turn))
        if self.turn and (self.mass is not None or self.inertia is not None):
            text = f"{self.label}: mass and inertia are for straight links, since they fix a centre on the line between"
            raise InputError(f"{text} the ends. For an arc use FlexibleFrame with one edge, whose centre is a point.")
        object.__setattr__(self, "elements", checked_elements(self.label, self.elements))
        checks.between(self.label, "centre", self.centre, 0.0, 1.0)
        checks.not_negative(self.label, "pivot_inertia", self.pivot_inertia, "kg m^2")
        places = fractions(self.elements)
        self._check_fields(len(places), places)
        _ = self._bosses  # refuses mass properties out of reach

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
        rotary_inertia: bool | float | None = None,
        shear: bool | float = False,
        stress: bool | None = None,
        velocity: Triple | FieldLike | None = None,
        displacement: FieldLike | None = None,
    ) -> FlexibleLink:
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
        label, tags = f"FlexibleLink {name!r}", set(mesh.tags.tolist())
        elements, section = beam_of_mesh(label, path, tags, station, sections)
        return cls(
            name, start, end, section=section, material=material, elements=elements, mass=mass, inertia=inertia,
            centre=centre, damping=damping, mass_damping=mass_damping, pivot_inertia=pivot_inertia,
            rotary_inertia=rotary_inertia, shear=shear, stress=stress, velocity=velocity, displacement=displacement,
        )  # fmt: skip

    def nodes(self) -> tuple[Node, ...]:
        """Nodes from start to end."""
        return self._nodes

    @cached_property
    def _nodes(self) -> tuple[Node, ...]:
        arc = self.start, self.end, self.turn, fractions(self.elements)
        poses = zip(points(*arc), tangents(*arc), strict=True)
        return tuple([Node(f"node{i}", *point, angle) for i, (point, angle) in enumerate(poses)])

    @property
    def main(self) -> str:
        """The node in the middle of the chain."""
        return f"node{len(self._nodes) // 2}"

    @property
    def aliases(self) -> dict[str, str]:
        """start and end."""
        return {"start": "node0", "end": f"node{len(self._nodes) - 1}"}

    @property
    def corners(self) -> tuple[str, ...]:
        """Names of the end nodes."""
        return self._nodes[0].name, self._nodes[-1].name

    @property
    def corner_points(self) -> tuple[Point, ...]:
        """The ends [m]."""
        return self.start, self.end

    @cached_property
    def beams(self) -> tuple[Beam, ...]:
        """The one beam."""
        names, ends = [n.name for n in self._nodes], (self.start, self.end)
        return (self._beam(names, ends, fractions(self.elements), self.section, self.turn),)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Elements, bosses, damping and the signal `deflection`."""
        three = (self.corners[0], self.main, self.corners[1])
        coordinates = tuple([(self.name, node, axis) for node in three for axis in (0, 1)])
        deflection = SignalContribution(self.name, "deflection", "m", deflection_kernel, coordinates)
        return [*super().contributions(mechanism), deflection]

    def _boss_pieces(self, gravity: Point) -> list[Contribution]:
        """Contributions of the bosses and of the pivot."""
        ends = super()._boss_pieces(gravity)
        if self.pivot_inertia == 0.0:
            return ends
        return [*ends, *boss_pieces(self.name, self.corners[:1], Bosses((0.0,), self.pivot_inertia, 0.0), gravity)]

    def _lumps(self) -> dict[str, tuple[float, float]]:
        """Mass [kg] and moment of inertia [kg m^2] at the ends, by node."""
        (start, (mass, inertia)), end = super()._lumps().items()
        return dict([(start, (mass, inertia + self.pivot_inertia)), end])

    def _further_mass(self) -> tuple[float, Point, float]:
        """The pivot: no mass, at the start, its moment of inertia [kg m^2]."""
        return 0.0, self.start, self.pivot_inertia

    def _fit(self, own: RigidProperties, mass: float) -> Bosses:
        """Bosses at the ends; without a declared moment of inertia they are point masses."""
        along = (self.centre * self.length, 0.0)
        if self.inertia is None:
            moment = planar.to_frame(self.start, self.angle, own.centre)[0] * own.mass
            return point_bosses(self.label, own.mass, mass, (mass * along[0] - moment) / self.length)
        centre = own.centre if self.mass is None else planar.from_frame(self.start, self.angle, along)
        return fit_bosses(self.label, own, RigidProperties(mass, centre, self.inertia), [self.start, self.end])


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
