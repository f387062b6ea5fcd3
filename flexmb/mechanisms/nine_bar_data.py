"""Data and pose of the nine-bar mechanism."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.elastic.beams.section import Rectangle
from flexmb.errors import InputError
from flexmb.fields import Input, field, not_negative, one_of, point, positive, record
from flexmb.mechanisms.geometry import LEFT, RIGHT, Point, at_angle, corner, on_line
from flexmb.model.law import Material
from flexmb.parts.contact.friction import ModifiedCoulomb
from flexmb.parts.contact.hysteresis_laws import LankaraniNikravesh
from flexmb.parts.contact.onset import LARGEST, LEAST_APPROACH, ONSET


@record
class NineBarData(Input):
    """Data of the nine-bar mechanism; the digit in a name is the number of the link.

    From table 1 of the paper: distances of hinges, pivots 1 and 4, masses, moments of inertia, `centre7`.  Eq. (11) has
    no m v^2/2 of links 1, 4 and 6, so their J is about the axis in the frame.  For the panel the table prints 3.802e-3,
    too small for a triangle of that size; the default has the exponent -2.  Gravity: eq. (13), U = sum m g x.

    The paper leaves the others out or prints them wrong, see docs/nine_bar.md.  `length8` is twice its centre of mass
    .168, since the printed length repeats another row.  Fitted: sides of the panel, where the table repeats other rows;
    pivot 6 and the line of the slider, which are only drawn; the beams, to the table's masses.  Reconstructed: contact,
    friction and damping.  Eq. (6) takes the speed at the onset, however small.

    Raises
    ------
    InputError : values out of range, a panel whose sides form no triangle.

    Notes
    -----
    Source: X. Chen, S. Jiang, Y. Deng, Q. Wang, Dynamics analysis of 2-DOF complex planar mechanical system with joint
    clearance and flexible links, Nonlinear Dynamics (2018), tables 1 and 3, equations (1)-(30).

    Examples
    --------
    >>> NineBarData(mass9=1.0).mass9
    1.0
    """

    LIGHT_DAMPING: ClassVar[float] = 1e-6
    """zeta2 [s] of light steel structures: .07 % of critical damping in the first bending mode of link 3."""

    INFERRED_DAMPING: ClassVar[float] = 2e-5
    """zeta2 [s] under which most of the paper's statements hold together; see docs/nine_bar.md, "Damping"."""

    _: KW_ONLY
    length1: float = field("distance of the hinges", "m", positive, default=0.045)
    length2: float = field("distance of the hinges", "m", positive, default=0.326)
    length3: float = field("distance of the hinges", "m", positive, default=0.497)
    length4: float = field("distance of the hinges", "m", positive, default=0.095)
    length6: float = field("distance of the hinges", "m", positive, default=0.230)
    length8: float = field("distance of the hinges", "m", positive, default=0.336)
    side_ab: float = field("side of panel 7 between its hinges", "m", positive, default=0.229)
    side_ac: float = field("side of panel 7 between its hinges", "m", positive, default=0.304)
    side_bc: float = field("side of panel 7 between its hinges", "m", positive, default=0.315)
    pivot1: Point = field("axis of the crank in the frame", "m", point, default=(0.0, 0.0))
    pivot4: Point = field("axis of the crank in the frame", "m", point, default=(0.0, 0.430))
    pivot6: Point = field("axis of the rocker in the frame", "m", point, default=(-0.580, 0.190))
    slider_line: float = field("Y of the line on which the slider's hinge moves", "m", default=0.090)
    mass1: float = field("mass", "kg", positive, default=0.148)
    mass2: float = field("mass", "kg", positive, default=0.805)
    mass3: float = field("mass", "kg", positive, default=0.603)
    mass4: float = field("mass", "kg", positive, default=0.265)
    mass6: float = field("mass", "kg", positive, default=0.581)
    mass7: float = field("mass", "kg", positive, default=4.334)
    mass8: float = field("mass", "kg", positive, default=0.827)
    mass9: float = field("mass", "kg", positive, default=0.801)
    inertia1: float = field("moment of inertia about the axis in the frame", "kg m^2", positive, default=2.382e-4)
    inertia2: float = field("moment of inertia about the centre of mass", "kg m^2", positive, default=8.001e-3)
    inertia3: float = field("moment of inertia about the centre of mass", "kg m^2", positive, default=1.337e-2)
    inertia4: float = field("moment of inertia about the axis in the frame", "kg m^2", positive, default=1.210e-3)
    inertia6: float = field("moment of inertia about the axis in the frame", "kg m^2", positive, default=1.212e-2)
    inertia7: float = field("moment of inertia about the centre of mass", "kg m^2", positive, default=3.802e-2)
    inertia8: float = field("moment of inertia about the centre of mass", "kg m^2", positive, default=8.663e-3)
    inertia9: float = field("without influence, as the slider does not turn", "kg m^2", positive, default=1e-3)
    centre7: float = field("of mass of the panel, from A towards the centroid of A, B, C", "m", positive, default=0.147)
    bearing_radius: float = field("R1 at P1", "m", positive, default=0.010)
    restitution: float = field("coefficient of restitution of the contact", rule=positive, default=0.9)
    contact_young: float = field("E of journal and bearing", "Pa", positive, default=207e9)
    contact_poisson: float = field("nu of journal and bearing", default=0.29)
    least_approach: float = field("as of `LankaraniNikravesh`", "m/s", not_negative, default=LEAST_APPROACH)
    reference_speed: str = field("as of `LankaraniNikravesh`", rule=one_of(ONSET, LARGEST), default=ONSET)
    friction_coefficient: float = field("cf of eq. (8)", rule=not_negative, default=0.01)
    v0: float = field("first slip speed of eq. (8)", "m/s", not_negative, default=1e-4)
    v1: float = field("second slip speed of eq. (8)", "m/s", positive, default=1e-3)
    young: float = field("E of the beams", "Pa", positive, default=207e9)
    density: float = field("rho of the beams", "kg/m^3", positive, default=7801.0)
    depth: float = field("depth of all bars in the plane of motion", "m", positive, default=0.025)
    thickness: float = field("thickness of all bars but that of link 3", "m", positive, default=0.012)
    thickness3: float = field("thickness of the bar of link 3", "m", positive, default=0.006)
    damping: float = field("zeta2, damping of the beams; inferred", "s", not_negative, default=INFERRED_DAMPING)
    mass_damping: float = field("zeta1, mass-proportional damping of the beams", "1/s", not_negative, default=0.0)
    gravity: float = field("acceleration of gravity along X", "m/s^2", default=-9.81)

    def __post_init__(self) -> None:
        super().__post_init__()
        sides = sorted((self.side_ab, self.side_ac, self.side_bc))
        if sides[2] >= sides[0] + sides[1]:
            text = f"NineBarData: sides of {sides[0]:g}, {sides[1]:g} and {sides[2]:g} m form no triangle;"
            raise InputError(f"{text} the longest must be shorter than the other two together.")

    def own_inertia(self, number: int) -> float:
        """Moment of inertia of the link of a `number`, 1 to 4, 6 or 8, about its centre of mass midway [kg m^2]."""
        inertia = float(getattr(self, f"inertia{number}"))
        if number not in (1, 4, 6):
            return inertia
        steiner = getattr(self, f"mass{number}") * (0.5 * getattr(self, f"length{number}")) ** 2
        if inertia <= steiner:
            text = f"NineBarData: inertia{number} is {inertia:g} kg m^2 about the axis in the frame;"
            text += f" it must be > {steiner:.4g}, the mass times the square of half the length."
            raise InputError(f"{text} If it is meant about the centre of mass, add this.")
        return float(inertia - steiner)

    def section(self, number: int) -> Rectangle:
        """Cross section of the beams of the link of a `number`."""
        return Rectangle(width=self.thickness3 if number == 3 else self.thickness, height=self.depth)

    @property
    def material(self) -> Material:
        """Material of the beams."""
        return Material(self.young, self.density, self.contact_poisson)

    @property
    def normal(self) -> LankaraniNikravesh:
        """Normal law of the contact at P1, its stiffness by eq. (4) with both radii."""
        partner = Material(self.contact_young, self.density, self.contact_poisson)
        return LankaraniNikravesh.from_materials(
            partner,
            partner,
            restitution=self.restitution,
            least_approach=self.least_approach,
            reference_speed=self.reference_speed,
        )

    @property
    def coulomb(self) -> ModifiedCoulomb:
        """Friction of the contact at P1, eqs. (7)-(8)."""
        return ModifiedCoulomb(self.friction_coefficient, self.v0, self.v1)


@dataclass(frozen=True)
class NineBarPose:
    """Hinges of the nine-bar mechanism at given crank angles [m]."""

    P1: Point  # P1, P4, B, A, C, S: ends of the cranks; end of links 2 and 3; end of rocker 6; end of link 8; slider
    P4: Point
    B: Point
    A: Point
    C: Point
    S: Point
    centre7: Point  # centre of mass of the panel

    @classmethod
    def at(cls, data: NineBarData, theta1: float, theta4: float) -> NineBarPose:
        """The pose at angles of the cranks from +X [rad], in closed form, in the branch of each loop of the paper."""
        loop = f"nine_bar at start = ({theta1:g}, {theta4:g}) rad: loop"
        P1 = at_angle(data.pivot1, data.length1, theta1)
        P4 = at_angle(data.pivot4, data.length4, theta4)
        B = corner(f"{loop} O1-P1-B-P4-O4", P1, data.length2, P4, data.length3, LEFT)
        A = corner(f"{loop} O6-A-B", data.pivot6, data.length6, B, data.side_ab, LEFT)
        C = corner("nine_bar: panel A-B-C", A, data.side_ac, B, data.side_bc, RIGHT)
        S = on_line(f"{loop} C-S-guide", C, data.length8, data.slider_line, -1.0)
        to_centroid = (A[0] + B[0] + C[0]) / 3.0 - A[0], (A[1] + B[1] + C[1]) / 3.0 - A[1]
        fraction = data.centre7 / math.hypot(*to_centroid)
        return cls(P1, P4, B, A, C, S, (A[0] + fraction * to_centroid[0], A[1] + fraction * to_centroid[1]))
