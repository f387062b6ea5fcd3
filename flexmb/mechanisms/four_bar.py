"""Crank-rocker four-bar mechanism with thin, elastic coupler and rocker."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY
from functools import partial
from typing import Annotated, Any

from flexmb import arguments, checks
from flexmb.elastic.beams.section import Rectangle
from flexmb.errors import InputError
from flexmb.fields import Input, field, not_negative, positive, record
from flexmb.mechanisms.choices import LEFT, at_angle, corner, crank_motion, friction_law, pin
from flexmb.model.law import FrictionLaw, Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body
from flexmb.parts.bodies.flexible_links import FlexibleLink
from flexmb.parts.bodies.rigid import RigidLink
from flexmb.parts.contact.friction import ModifiedCoulomb
from flexmb.parts.contact.hysteresis import LankaraniNikravesh
from flexmb.parts.drives.motions import Drive
from flexmb.parts.joints.revolute import Revolute

NAME = "four-bar"


@record
class FourBarData(Input):
    """Data of the four-bar mechanism.

    Raises
    ------
    InputError : values out of range, lengths with which the crank cannot turn round (Grashof).

    Notes
    -----
    Lengths, sections, bearing mass and speed are those of the aluminium laboratory mechanism of D. A. Turcic, A. Midha,
    J. R. Bosnik, Dynamic analysis of elastic mechanism systems, part II: experimental results, J. Dynamic Systems,
    Measurement, and Control 106 (1984) 255-260, as later papers repeat them (in inches: lengths 10, 4.25, 11, 10.65,
    sections 1 by 0.167 and 1 by 0.063; 340 rpm); not compared with the original.  Damping and contact are chosen here.
    """

    _: KW_ONLY
    ground: float = field("distance of the pivots in the frame", "m", positive, default=0.2540)
    crank: float = field("length of the crank", "m", positive, default=0.1080)
    coupler: float = field("length of the coupler", "m", positive, default=0.2794)
    rocker: float = field("length of the rocker", "m", positive, default=0.2705)
    width: float = field("width of all links, normal to the plane of motion", "m", positive, default=0.0254)
    crank_depth: float = field("depth of the crank in the plane of motion", "m", positive, default=0.00424)
    coupler_depth: float = field("depth of the coupler", "m", positive, default=0.0016)
    rocker_depth: float = field("depth of the rocker", "m", positive, default=0.0016)
    bearing_mass: float = field("mass of the bearing at the end of the coupler", "kg", not_negative, default=0.042)
    young: float = field("E of the links", "Pa", positive, default=71e9)
    poisson: float = field("nu of the links", rule=positive, default=0.33)
    density: float = field("rho of the links", "kg/m^3", positive, default=2710.0)
    damping: float = field("zeta2, stiffness-proportional damping of flexible links", "s", not_negative, default=1e-5)
    bearing_radius: float = field("radius of the bearing on the coupler", "m", positive, default=0.005)
    restitution: float = field("coefficient of restitution of the contact", rule=positive, default=0.9)
    contact_young: float = field("E of journal and bearing, steel on steel", "Pa", positive, default=207e9)
    contact_poisson: float = field("nu of journal and bearing", rule=positive, default=0.29)
    friction_coefficient: float = field("coefficient of the modified Coulomb friction", rule=not_negative, default=0.03)
    v0: float = field("first slip speed of the friction", "m/s", not_negative, default=1e-4)
    v1: float = field("second slip speed of the friction", "m/s", positive, default=1e-3)

    def __post_init__(self) -> None:
        super().__post_init__()
        shortest, *_, longest = lengths = sorted((self.ground, self.crank, self.coupler, self.rocker))
        if self.crank > shortest or shortest + longest >= lengths[1] + lengths[2]:
            text = f"FourBarData: with ground {self.ground:g}, crank {self.crank:g}, coupler {self.coupler:g}"
            text += f" and rocker {self.rocker:g} m the crank cannot turn round. It must be the shortest,"
            raise InputError(f"{text} and together with the longest link shorter than the other two (Grashof).")


@arguments.checked
def four_bar(
    speed: Annotated[float, "rad/s"] = 340.0 * 2.0 * math.pi / 60.0, *, clearance: Annotated[float | None, "m"] = None,
    flexible: bool = False, friction: str | FrictionLaw | None = None, elements: int = 4,
    start: Annotated[float, "rad"] = 0.0, ramp: Annotated[float | None, "s"] = None, data: FourBarData | None = None,
) -> Mechanism:  # fmt: skip
    """A crank-rocker mechanism with rigid or flexible links, and with or without clearance at B; no gravity.

    Bodies: crank coupler rocker.  Joints: O, D (frame), A (crank and coupler), B (coupler and rocker).  Drive: motor.

    Parameters
    ----------
    speed : speed of the crank.
    clearance : radius of the bearing on the coupler less that of the journal on the rocker, at B; None: ideal joint.
    flexible : whether the links are beams.
    friction : friction at B: "coulomb" for the modified Coulomb law with the data, a friction law, or None.
    elements : number of beam elements of each link.
    start : angle of the crank at the start, from +X.
    ramp : time in which the crank reaches its speed from rest; None: it starts at full speed.
    data : data of the mechanism; None: `FourBarData()`.

    Raises
    ------
    InputError : values out of range or of the wrong kind.

    Notes
    -----
    The rigid links have the mass, centre of mass and moment of inertia of the beams.  Source: see `FourBarData`.

    Examples
    --------
    >>> four_bar(flexible=True).names
    ('crank', 'coupler', 'rocker', 'O', 'D', 'A', 'B', 'motor')
    """
    data = FourBarData() if data is None else data
    checks.instance("four_bar", "data", data, FourBarData, "a FourBarData, e.g. FourBarData(crank=0.1)")
    checks.flag("four_bar", "flexible", flexible)
    checks.count("four_bar", "elements", elements)
    O, D = (0.0, 0.0), (data.ground, 0.0)
    A = at_angle(O, data.crank, checks.number("four_bar", "start", start, "rad"))
    B = corner("four_bar: loop O-A-B-D", A, data.coupler, D, data.rocker, LEFT)
    aluminium = Material(data.young, data.density, data.poisson)
    make = partial(FlexibleLink, material=aluminium, elements=elements, damping=data.damping)
    bar = data.density * data.width * data.coupler_depth * data.coupler
    total = bar + data.bearing_mass  # with the bearing at the end of the coupler
    more: Any = {"mass": total, "centre": (0.5 * bar + data.bearing_mass) / total}
    beams = [
        make("crank", O, A, section=Rectangle(width=data.width, height=data.crank_depth)),
        make("coupler", A, B, section=Rectangle(width=data.width, height=data.coupler_depth), **more),
        make("rocker", D, B, section=Rectangle(width=data.width, height=data.rocker_depth)),
    ]
    crank, coupler, rocker = beams if flexible else [_rigid(beam) for beam in beams]
    steel = Material(data.contact_young, data.density, data.contact_poisson)
    normal = LankaraniNikravesh.from_materials(steel, steel, restitution=data.restitution)
    law = friction_law("four_bar", friction, ModifiedCoulomb(data.friction_coefficient, data.v0, data.v1))
    worn = pin("B", coupler, rocker, B, clearance, data.bearing_radius, normal, law)
    ends = Revolute("O", GROUND, crank, at=O), Revolute("D", GROUND, rocker, at=D)
    joints = [*ends, Revolute("A", crank, coupler, at=A), worn]
    motor = Drive("motor", "O", crank_motion("four_bar", speed, ramp))
    return Mechanism(NAME, (crank, coupler, rocker, *joints, motor))


def _rigid(beam: FlexibleLink) -> Body:
    """A rigid link with the mass properties of a beam."""
    own = beam.properties()
    centre = math.dist(beam.start, own.centre) / beam.length
    return RigidLink(beam.name, beam.start, beam.end, own.mass, own.inertia, centre)
