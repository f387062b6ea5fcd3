"""Slider-crank with clearance in the piston pin."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY
from typing import Annotated

from flexmb import arguments, checks
from flexmb.elastic.beams.section import Rectangle
from flexmb.errors import InputError
from flexmb.fields import Input, field, not_negative, positive, record
from flexmb.mechanisms.choices import at_angle, box, crank_motion, friction_law, on_line, pin
from flexmb.model.law import FrictionLaw, Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body
from flexmb.parts.bodies.flexible_links import FlexibleLink
from flexmb.parts.bodies.rigid import RigidBody, RigidLink
from flexmb.parts.contact.friction import ModifiedCoulomb
from flexmb.parts.contact.hysteresis import LankaraniNikravesh
from flexmb.parts.drives.motions import Drive
from flexmb.parts.joints.prismatic import Prismatic
from flexmb.parts.joints.revolute import Revolute

NAME = "slider-crank"
SLIDER_SIZE = (0.030, 0.020)  # width and height of the slider in pictures [m]


@record
class SliderCrankData(Input):
    """Data of the slider-crank with a worn piston pin.

    Raises
    ------
    InputError : values out of range, a rod that is not longer than the crank.

    Notes
    -----
    Lengths, masses and contact: the slider-crank with clearance in the piston pin of P. Flores, J. Ambrosio, J. C. P.
    Claro, H. M. Lankarani, Kinematics and Dynamics of Multibody Systems with Imperfect Joints, Springer 2008.
    """

    _: KW_ONLY
    crank: float = field("length of the crank", "m", positive, default=0.05)
    rod: float = field("length of the rod", "m", positive, default=0.12)
    crank_mass: float = field("mass of the crank, its centre at mid-length", "kg", positive, default=0.30)
    rod_mass: float = field("mass of the rod, its centre at mid-length", "kg", positive, default=0.21)
    slider_mass: float = field("mass of the slider", "kg", positive, default=0.14)
    crank_inertia: float = field("J of the crank about its centre of mass", "kg m^2", positive, default=1.0e-5)
    rod_inertia: float | None = field("J of the rod; None: uniform, m l^2/12", "kg m^2", positive, default=2.5e-4)
    slider_inertia: float = field("without influence, as the slider does not turn", "kg m^2", positive, default=1.0e-4)
    bearing_radius: float = field("radius of the bearing in the rod", "m", positive, default=0.010)
    restitution: float = field("coefficient of restitution of the contact", rule=positive, default=0.9)
    young: float = field("E of journal and bearing, and of a flexible rod", "Pa", positive, default=207e9)
    poisson: float = field("nu of journal and bearing, and of a flexible rod", rule=positive, default=0.3)
    density: float = field("rho of a flexible rod, for its square section", "kg/m^3", positive, default=7801.0)
    friction_coefficient: float = field("coefficient of the modified Coulomb friction", rule=not_negative, default=0.03)
    v0: float = field("first slip speed of the friction", "m/s", not_negative, default=1e-4)
    v1: float = field("second slip speed of the friction", "m/s", positive, default=1e-3)
    damping: float = field("zeta2, stiffness-proportional damping of a flexible rod", "s", not_negative, default=1e-6)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rod <= self.crank:
            text = f"SliderCrankData: rod is {self.rod:g} m; it must be longer than the crank,"
            raise InputError(f"{text} {self.crank:g} m, or the crank cannot turn round.")

    @property
    def rod_side(self) -> float:
        """Side of the square section of a flexible rod, from its mass [m]."""
        return math.sqrt(self.rod_mass / (self.density * self.rod))


@arguments.checked
def slider_crank(
    speed: Annotated[float, "rad/s"] = 5000.0 * 2.0 * math.pi / 60.0, *, clearance: Annotated[float | None, "m"] = None,
    flexible: bool = False, friction: str | FrictionLaw | None = None, elements: int = 8,
    start: Annotated[float, "rad"] = 0.0, ramp: Annotated[float | None, "s"] = None,
    data: SliderCrankData | None = None,
) -> Mechanism:  # fmt: skip
    """The slider-crank with or without clearance in the piston pin, and with a rigid or flexible rod; no gravity.

    Bodies: crank rod slider.  Joints: O (frame and crank), A (crank and rod), B (rod and slider), guide.  Drive: motor.

    Parameters
    ----------
    speed : speed of the crank.
    clearance : radius of the bearing in the rod less radius of the pin on the slider; None: ideal joint.
    flexible : whether the rod is a beam.
    friction : friction in the piston pin: "coulomb" for the modified Coulomb law with the data, a law, or None.
    elements : number of beam elements of a flexible rod.
    start : angle of the crank at the start, from +X.
    ramp : time in which the crank reaches its speed from rest; None: it starts at full speed.
    data : data of the mechanism; None: `SliderCrankData()`.

    Raises
    ------
    InputError : values out of range or of the wrong kind.

    Notes
    -----
    A flexible rod is a uniform bar with the moment of inertia m l^2/12 = 2.52e-4 kg m^2, 0.8 % above the 2.5e-4 of the
    rigid rod; masses at the ends of a bar can only increase it.  For a comparison give the rigid rod
    `SliderCrankData(rod_inertia=None)`.

    Examples
    --------
    >>> slider_crank(clearance=0.5e-3).names
    ('crank', 'rod', 'slider', 'O', 'A', 'B', 'guide', 'motor')
    """
    data = SliderCrankData() if data is None else data
    checks.instance("slider_crank", "data", data, SliderCrankData, "a SliderCrankData, e.g. SliderCrankData(rod=0.2)")
    checks.flag("slider_crank", "flexible", flexible)
    checks.count("slider_crank", "elements", elements)
    angle = checks.number("slider_crank", "start", start, "rad")
    O = (0.0, 0.0)
    A = at_angle(O, data.crank, angle)
    B = on_line("slider_crank: loop O-A-B-guide", A, data.rod, 0.0, 1.0)
    crank = RigidLink("crank", O, A, data.crank_mass, data.crank_inertia)
    steel = Material(data.young, data.density, data.poisson)
    inertia = (data.rod_mass * data.rod**2 / 12.0) if data.rod_inertia is None else data.rod_inertia
    rod: Body = RigidLink("rod", A, B, data.rod_mass, inertia)
    if flexible:
        section = Rectangle(width=data.rod_side, height=data.rod_side)
        rod = FlexibleLink("rod", A, B, section=section, material=steel, elements=elements, damping=data.damping)
    slider = RigidBody("slider", B, data.slider_mass, data.slider_inertia, outline=box(B, *SLIDER_SIZE))
    normal = LankaraniNikravesh.from_materials(steel, steel, restitution=data.restitution)
    law = friction_law("slider_crank", friction, ModifiedCoulomb(data.friction_coefficient, data.v0, data.v1))
    worn = pin("B", rod, slider, B, clearance, data.bearing_radius, normal, law)
    guide = Prismatic("guide", GROUND, slider, at=B, along=(1.0, 0.0))
    joints = [Revolute("O", GROUND, crank, at=O), Revolute("A", crank, rod, at=A), worn, guide]
    motor = Drive("motor", "O", crank_motion("slider_crank", speed, ramp))
    return Mechanism(NAME, (crank, rod, slider, *joints, motor))
