"""Data and pose of the nine-bar mechanism."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import ClassVar

from flexmb import checks
from flexmb.elastic.beams.section import Rectangle
from flexmb.errors import InputError
from flexmb.mechanisms.geometry import LEFT, RIGHT, Point, at_angle, corner, on_line
from flexmb.model.law import Material
from flexmb.parts.contact.friction import ModifiedCoulomb
from flexmb.parts.contact.hysteresis_laws import LankaraniNikravesh
from flexmb.parts.contact.onset import LARGEST, LEAST_APPROACH, ONSET

POINTS = ("pivot1", "pivot4", "pivot6")
MAY_BE_ANYTHING = ("slider_line", "gravity")
MAY_BE_ZERO = ("friction_coefficient", "v0", "damping", "mass_damping", "least_approach")


@dataclass(frozen=True, kw_only=True)
class NineBarData:
    """Data of the nine-bar mechanism; the digit in a name is the number of the link.

    "Table": the value is printed in the paper.  "Fitted" or "reconstructed": the paper leaves it out or prints it
    wrong; see docs/nine_bar.md.

    Parameters
    ----------
    length1, length2, length3, length4, length6 : distance of the hinges [m].  Table 1.
    length8 : length of link 8 [m].  Twice its centre of mass .168; the printed length repeats another row.
    side_ab, side_ac, side_bc : sides of panel 7 between its hinges [m].  Fitted; the table repeats other rows.
    pivot1, pivot4 : axes of the cranks in the frame [m].  Table 1: .430 m apart.
    pivot6 : axis of rocker 6 [m].  Fitted; only drawn in the paper.
    slider_line : Y of the line on which the slider's hinge moves [m].  Fitted; only drawn in the paper.
    mass1, mass2, mass3, mass4, mass6, mass7, mass8, mass9 : masses [kg].  Table 1.
    inertia1, inertia4, inertia6 : moments of inertia about the axis in the frame [kg m^2].  Table 1; eq. (11) has no
        m v^2/2 of these links, so their J contains it.
    inertia2, inertia3, inertia8 : moments of inertia about the centre of mass [kg m^2].  Table 1.
    inertia7 : moment of inertia of panel 7 about the centre of mass [kg m^2].  Table 1 prints 3.802e-3, which is too
        small for a triangle of that size; the default has the exponent -2.
    inertia9 : moment of inertia of the slider [kg m^2], > 0.  The slider does not turn, so it has no influence.
    centre7 : distance of the panel's centre of mass from hinge A, towards the centroid of A, B, C [m].  Table 1.
    bearing_radius : R1 at P1 [m].  Reconstructed; the paper's table 3 is missing.
    restitution : coefficient of restitution of the contact.  Reconstructed.
    contact_young, contact_poisson : E [Pa] and nu of journal and bearing.  Reconstructed.
    least_approach, reference_speed : arguments of the normal law, see `LankaraniNikravesh`.  Eq. (6) of the paper takes
        the speed at the onset, however small.
    friction_coefficient, v0, v1 : cf and the slip speeds of eq. (8) [1, m/s, m/s].  Reconstructed.
    young, density : E [Pa] and rho [kg/m^3] of the beams.  Fitted to the table's masses.
    depth, thickness, thickness3 : depth of all bars in the plane of motion, thickness of all but link 3, thickness of
        link 3 [m].  Fitted to the table's masses.
    damping : zeta2, stiffness-proportional damping of the beams [s].  The paper gives no value; default:
        `LIGHT_DAMPING`, and `NineBarData.INFERRED_DAMPING` is fitted to what the paper says of chaos.
    mass_damping : zeta1, mass-proportional damping of the beams [1/s].  Reconstructed.
    gravity : acceleration of gravity along X [m/s^2].  Eq. (13), U = sum m g x, means the direction -X.

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

    length1: float = 0.045
    length2: float = 0.326
    length3: float = 0.497
    length4: float = 0.095
    length6: float = 0.230
    length8: float = 0.336
    side_ab: float = 0.229
    side_ac: float = 0.304
    side_bc: float = 0.315
    pivot1: Point = (0.0, 0.0)
    pivot4: Point = (0.0, 0.430)
    pivot6: Point = (-0.580, 0.190)
    slider_line: float = 0.090
    mass1: float = 0.148
    mass2: float = 0.805
    mass3: float = 0.603
    mass4: float = 0.265
    mass6: float = 0.581
    mass7: float = 4.334
    mass8: float = 0.827
    mass9: float = 0.801
    inertia1: float = 2.382e-4
    inertia2: float = 8.001e-3
    inertia3: float = 1.337e-2
    inertia4: float = 1.210e-3
    inertia6: float = 1.212e-2
    inertia7: float = 3.802e-2
    inertia8: float = 8.663e-3
    inertia9: float = 1e-3
    centre7: float = 0.147
    bearing_radius: float = 0.010
    restitution: float = 0.9
    contact_young: float = 207e9
    contact_poisson: float = 0.29
    least_approach: float = LEAST_APPROACH
    reference_speed: str = ONSET
    friction_coefficient: float = 0.01
    v0: float = 1e-4
    v1: float = 1e-3
    young: float = 207e9
    density: float = 7801.0
    depth: float = 0.025
    thickness: float = 0.012
    thickness3: float = 0.006
    damping: float = LIGHT_DAMPING
    mass_damping: float = 0.0
    gravity: float = -9.81

    def __post_init__(self) -> None:
        owner = "NineBarData"
        for name in (f.name for f in fields(self)):
            value = getattr(self, name)
            if name in POINTS:
                object.__setattr__(self, name, checks.point(owner, name, value))
            elif name == "reference_speed":
                checks.one_of(owner, name, value, (ONSET, LARGEST))
            elif name in MAY_BE_ANYTHING:
                checks.number(owner, name, value)
            elif name in MAY_BE_ZERO:
                checks.not_negative(owner, name, value)
            elif name == "contact_poisson":
                checks.number(owner, name, value)
            else:
                checks.positive(owner, name, value)
        sides = sorted((self.side_ab, self.side_ac, self.side_bc))
        if sides[2] >= sides[0] + sides[1]:
            raise InputError(
                f"{owner}: sides of {sides[0]:g}, {sides[1]:g} and {sides[2]:g} m form no triangle; the longest must "
                "be shorter than the other two together."
            )

    def own_inertia(self, number: int) -> float:
        """Moment of inertia of link 1, 2, 3, 4, 6 or 8 about its centre of mass, midway between its hinges [kg m^2].

        Parameters
        ----------
        number : number of the link.

        Raises
        ------
        InputError : a crank or rocker whose moment of inertia is less than that of its mass at its centre.
        """
        inertia = float(getattr(self, f"inertia{number}"))
        if number not in (1, 4, 6):
            return inertia
        steiner = getattr(self, f"mass{number}") * (0.5 * getattr(self, f"length{number}")) ** 2
        if inertia <= steiner:
            raise InputError(
                f"NineBarData: inertia{number} is {inertia:g} kg m^2 about the axis in the frame; it must be > "
                f"{steiner:.4g}, the mass times the square of half the length. "
                "If it is meant about the centre of mass, add this."
            )
        return float(inertia - steiner)

    def section(self, number: int) -> Rectangle:
        """Cross section of the beams of a link.

        Parameters
        ----------
        number : number of the link.
        """
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
    """Hinges of the nine-bar mechanism at given crank angles [m].

    Parameters
    ----------
    P1, P4, B, A, C, S : ends of the cranks; end of links 2 and 3; end of rocker 6; end of link 8; slider.
    centre7 : centre of mass of the panel.
    """

    P1: Point
    P4: Point
    B: Point
    A: Point
    C: Point
    S: Point
    centre7: Point

    @classmethod
    def at(cls, data: NineBarData, theta1: float, theta4: float) -> NineBarPose:
        """The pose in closed form, in the branch of each loop that the paper draws.

        Parameters
        ----------
        data : lengths and axes.
        theta1, theta4 : angles of the cranks, counted from +X [rad].

        Raises
        ------
        AssemblyError : a loop that cannot close; the message names the loop and the missing length.
        """
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
