"""Nine-bar mechanism with two cranks, a joint with clearance and flexible links."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar

from flexmb import arguments, checks, planar
from flexmb.elastic.beams.section import Rectangle
from flexmb.errors import InputError
from flexmb.fields import Input, field, not_negative, one_of, point, positive, record
from flexmb.mechanisms import choices
from flexmb.mechanisms.choices import Point
from flexmb.model.law import FrictionLaw, Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body
from flexmb.parts.bodies.flexible_links import FlexibleFrame, FlexibleLink
from flexmb.parts.bodies.rigid import RigidBody, RigidLink
from flexmb.parts.contact.friction import ModifiedCoulomb
from flexmb.parts.contact.hysteresis import LankaraniNikravesh
from flexmb.parts.contact.onset import LARGEST, LEAST_APPROACH, ONSET
from flexmb.parts.drives.motions import Drive
from flexmb.parts.joints.prismatic import Prismatic
from flexmb.parts.joints.revolute import Revolute


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
            partner, partner, restitution=self.restitution, least_approach=self.least_approach,
            reference_speed=self.reference_speed,
        )  # fmt: skip

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
        P1 = choices.at_angle(data.pivot1, data.length1, theta1)
        P4 = choices.at_angle(data.pivot4, data.length4, theta4)
        B = choices.corner(f"{loop} O1-P1-B-P4-O4", P1, data.length2, P4, data.length3, choices.LEFT)
        A = choices.corner(f"{loop} O6-A-B", data.pivot6, data.length6, B, data.side_ab, choices.LEFT)
        C = choices.corner("nine_bar: panel A-B-C", A, data.side_ac, B, data.side_bc, choices.RIGHT)
        S = choices.on_line(f"{loop} C-S-guide", C, data.length8, data.slider_line, -1.0)
        to_centroid = (A[0] + B[0] + C[0]) / 3.0 - A[0], (A[1] + B[1] + C[1]) / 3.0 - A[1]
        fraction = data.centre7 / math.hypot(*to_centroid)
        return cls(P1, P4, B, A, C, S, (A[0] + fraction * to_centroid[0], A[1] + fraction * to_centroid[1]))


NAME = "nine-bar"
LINKS = {1: "crank1", 2: "link2", 3: "link3", 4: "crank4", 6: "rocker6", 8: "link8"}
ON_THE_FRAME = (1, 4, 6)
SLIDER_SIZE = (0.060, 0.036)  # width and height of the slider in pictures [m]


@arguments.checked
def nine_bar(
    speed: Annotated[float, "rad/s"] = 2.0 * math.pi, *, clearance: Annotated[float | None, "m"] = None,
    flexible: bool = False, friction: str | FrictionLaw | None = "coulomb", elements: int = 4,
    start: Annotated[tuple[float, float], "rad"] = (0.0, 0.0), ramp: Annotated[float | None, "s"] = None,
    mesh: str | None = None, data: NineBarData | None = None,
) -> Mechanism:  # fmt: skip
    """The nine-bar mechanism with two driven cranks, eight moving bodies and one joint with clearance.

        O1 - crank1 - P1 - link2 - B        P1: ideal joint or joint with clearance
        O4 - crank4 - P4 - link3 - B        B: links 2 and 3 and panel 7 (joints B2 and B3)
        O6 - rocker6 - A                    A: rocker 6 and panel 7
        panel7 = triangle A, B, C
        C - link8 - S - slider              the slider moves along X, and so does gravity

    Bodies: crank1 link2 link3 crank4 rocker6 panel7 link8 slider.  Joints: O1 O4 O6 P1 P4 B2 B3 A C S, guide.
    Drives: motor1, motor4.

    Parameters
    ----------
    speed : speed w; crank 1 turns with -w, crank 4 with +w.
    clearance : radius of the bearing on crank 1 less radius of the journal on link 2; None: ideal joint.
    flexible : whether the links are beams; the slider is always rigid.
    friction : friction at P1: "coulomb" for the modified Coulomb law with the data, a friction law, or None.
    elements : number of beam elements of each link, and of each side of the panel.
    start : angles of cranks 1 and 4 at the start, from +X.
    ramp : time in which the cranks reach their speed from rest; None: they start at full speed.
    mesh : folder of the line meshes crank1.msh, link2.msh, ..., panel7.msh of beams, as in `meshes/` of the repository
        (tag 1: section of the bars, tag 2: of link 3); with it, links are beams and `elements` is not used.
    data : data of the mechanism; None: `NineBarData()`.

    Raises
    ------
    InputError : values out of range or of the wrong kind.
    AssemblyError : a loop that cannot close at `start`; the message names the loop and the missing length.

    Notes
    -----
    Rigid and flexible mechanism have the same mass, centre of mass and moment of inertia body by body.  Bosses at the
    ends of a beam, and for the cranks and rocker 6 an inertia on the axis in the frame, make up the difference.
    Source: Chen, Jiang, Deng, Wang, Nonlinear Dynamics (2018); each field of `NineBarData` says whether its number is
    printed there or reconstructed.

    Examples
    --------
    >>> mech = nine_bar(speed=6.28, clearance=0.5e-3, flexible=True)
    >>> mech.find("P1").clearance
    0.0005
    """
    data = NineBarData() if data is None else data
    checks.instance("nine_bar", "data", data, NineBarData, "a NineBarData, e.g. NineBarData(mass7=4.0)")
    checks.flag("nine_bar", "flexible", flexible)
    checks.count("nine_bar", "elements", elements)
    speed = checks.number("nine_bar", "speed", speed, "rad/s")
    pose = NineBarPose.at(data, *choices.angles("nine_bar", "start", start))
    is_rigid = not flexible and mesh is None
    body = _rigid_bodies(data, pose) if is_rigid else _flexible_bodies(data, pose, elements, mesh)
    body["slider"] = RigidBody("slider", pose.S, data.mass9, data.inertia9, outline=choices.box(pose.S, *SLIDER_SIZE))
    law = choices.friction_law("nine_bar", friction, data.coulomb)
    play = choices.pin("P1", body["crank1"], body["link2"], pose.P1, clearance, data.bearing_radius, data.normal, law)
    cranks = ("motor1", "O1", -speed), ("motor4", "O4", speed)
    drives = [Drive(name, joint, choices.crank_motion("nine_bar", w, ramp)) for name, joint, w in cranks]
    ideal = [
        Revolute("O1", GROUND, body["crank1"], at=data.pivot1),
        Revolute("O4", GROUND, body["crank4"], at=data.pivot4),
        Revolute("O6", GROUND, body["rocker6"], at=data.pivot6),
        Revolute("P4", body["crank4"], body["link3"], at=pose.P4),
        Revolute("B2", body["link2"], body["panel7"], at=pose.B),
        Revolute("B3", body["link3"], body["panel7"], at=pose.B),
        Revolute("A", body["rocker6"], body["panel7"], at=pose.A),
        Revolute("C", body["panel7"], body["link8"], at=pose.C),
        Revolute("S", body["link8"], body["slider"], at=pose.S),
        Prismatic("guide", GROUND, body["slider"], at=pose.S, along=(1.0, 0.0)),
    ]
    return Mechanism(NAME, (*body.values(), *ideal, play, *drives), (data.gravity, 0.0))


def _ends(data: NineBarData, pose: NineBarPose) -> dict[int, tuple[Point, Point]]:
    return {
        1: (data.pivot1, pose.P1), 2: (pose.P1, pose.B), 3: (pose.P4, pose.B),
        4: (data.pivot4, pose.P4), 6: (data.pivot6, pose.A), 8: (pose.C, pose.S),
    }  # fmt: skip


def _rigid_bodies(data: NineBarData, pose: NineBarPose) -> dict[str, Body]:
    ends = _ends(data, pose)
    masses = {k: (getattr(data, f"mass{k}"), data.own_inertia(k)) for k in LINKS}
    bodies: dict[str, Body] = {name: RigidLink(name, *ends[k], *masses[k]) for k, name in LINKS.items()}
    corners = (pose.A, pose.B, pose.C, pose.A)
    bodies["panel7"] = RigidBody("panel7", pose.centre7, data.mass7, data.inertia7, outline=corners)
    return bodies


def _flexible_bodies(data: NineBarData, pose: NineBarPose, elements: int, mesh: str | None) -> dict[str, Body]:
    """Links and panel as beams, with the nodes of the meshes of a folder where one is given."""
    common: dict[str, Any] = {"material": data.material, "damping": data.damping, "mass_damping": data.mass_damping}
    sections = {1: data.section(1), 2: data.section(3)}
    bodies: dict[str, Body] = {}
    for k, name in LINKS.items():
        if mesh is None:
            make = partial(FlexibleLink, name, *_ends(data, pose)[k], section=data.section(k), elements=elements)
        else:
            file = str(Path(mesh) / f"{name}.msh")
            make = partial(FlexibleLink.from_mesh, name, file, *_ends(data, pose)[k], sections=sections)
        bodies[name] = _beam(data, k, partial(make, **common))
    corners = (pose.A, pose.B, pose.C)
    if mesh is None:
        edges = ((0, 1), (1, 2), (2, 0))
        panel = partial(FlexibleFrame, "panel7", corners, edges, section=data.section(7), elements=elements, **common)
    else:
        file, angle = str(Path(mesh) / "panel7.msh"), planar.direction(pose.A, pose.B)
        panel = partial(FlexibleFrame.from_mesh, "panel7", file, pose.A, angle=angle, sections=sections, **common)
        found = panel().corner_points
        for name, hinge in zip("ABC", corners, strict=True):
            off = min(planar.distance(hinge, corner) for corner in found)
            if off > 1e-6 * planar.distance(*corners[:2]):
                text = f"nine_bar: {file} has no corner at hinge {name} of the panel, the nearest is {off:.4g} m away."
                text += " Its sides and their order must be those of the data,"
                raise InputError(f"{text} A at (0, 0), B along +x, C below (y < 0).")
    bodies["panel7"] = panel(mass=data.mass7, inertia=data.inertia7, centre=pose.centre7)
    return bodies


def _beam(data: NineBarData, number: int, make: Callable[..., FlexibleLink]) -> FlexibleLink:
    """A link as a beam with the mass and the moment of inertia of the rigid link."""
    mass, inertia = getattr(data, f"mass{number}"), data.own_inertia(number)
    if number not in ON_THE_FRAME:
        return make(mass=mass, inertia=inertia)
    # The inertia that the bar and point masses at its ends lack lies on the axis in the frame, like a shaft or a hub;
    # bosses at the outer end would need a radius of gyration larger than the depth of the link.
    lacking = inertia - make(mass=mass).properties().inertia
    if lacking < 0.0:
        text = f"NineBarData: inertia{number} is too small for {LINKS[number]!r} as a beam with masses at its ends,"
        text += f" by {-lacking:.4g} kg m^2."
        raise InputError(f"{text} Give a larger inertia{number}, a smaller mass{number}, or a lighter section.")
    return make(mass=mass, pivot_inertia=lacking)
