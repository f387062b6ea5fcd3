"""Simeon's slider-crank with a flexible connecting rod."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

from flexmb import arguments, checks
from flexmb.beams.section import Rectangle
from flexmb.bodies.flexible_link import FlexibleLink
from flexmb.bodies.rigid_body import RigidBody
from flexmb.bodies.rigid_link import RigidLink
from flexmb.drives.constant_speed import ConstantSpeed
from flexmb.drives.drive import Drive
from flexmb.errors import InputError
from flexmb.joints.prismatic import Prismatic
from flexmb.joints.revolute import Revolute
from flexmb.mechanisms.choices import check_flag
from flexmb.model.material import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND

NAME = "Simeon's slider-crank"
Triple = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class SimeonData:
    """Data of the slider-crank of the IVP test set (problem "crank").

    Parameters
    ----------
    crank, rod : lengths l1, l2 [m].
    crank_mass, slider_mass : m1, m3 [kg]; the mass of the rod follows from section and density.
    crank_inertia : J1, moment of inertia of the crank about its pivot [kg m^2].
    side : side of the square section of the rod [m].
    young, density : Young's modulus and density of the rod [Pa, kg/m^3].
    speed : speed of the crank [rad/s].
    stretch : axial displacements q3, q4 of the rod's middle and end at the start [m].
    stretch_rate : rates of the axial displacements at the start [m/s].
    waves : rates of the amplitudes q1, q2 of the first and second lateral sine wave at the start [m/s].

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    The source has J2 = 0.0045339259 kg m^2 for the rod about its pin, m l^2/3 + m h^2/12 with the thickness h of the
    section.  The beam here has m l^2/3 = 0.00453312 kg m^2, 0.02 % less: with a driven crank J2 enters the torque of
    the drive but no motion.
    Source: B. Simeon, Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs, Mathematical
    Modelling of Systems 2 (1996) 1-18; start values: W. Lioen, J. de Swart, Test Set for Initial Value Problem Solvers.
    """

    crank: float = 0.15
    rod: float = 0.30
    crank_mass: float = 0.36
    slider_mass: float = 0.075552
    crank_inertia: float = 0.002727
    side: float = 0.008
    young: float = 2e11
    density: float = 7870.0
    speed: float = 150.0
    stretch: tuple[float, float] = (0.103339863e-4, 0.169327969e-4)
    stretch_rate: tuple[float, float] = (-0.178591076e-5, -0.268938672e-5)
    waves: tuple[float, float] = (0.444896105, 0.463434311e-2)

    def __post_init__(self) -> None:
        for name in (f.name for f in fields(self)):
            value = getattr(self, name)
            if name in ("stretch", "stretch_rate", "waves"):
                unit = "m" if name == "stretch" else "m/s"
                object.__setattr__(self, name, checks.point("SimeonData", name, value, unit))
            else:
                checks.positive("SimeonData", name, value)

    @property
    def rod_mass(self) -> float:
        """Mass m2 of the uniform rod [kg]."""
        return self.density * self.side**2 * self.rod


@arguments.checked
def simeon(
    data: SimeonData | None = None, *, elements: int = 8, stretched: bool = True, waving: bool = True
) -> Mechanism:
    """A rigid crank driven at constant speed, a flexible rod and a slider, all on a line at the start; no gravity.

    Bodies: crank rod slider.  Joints: O (frame and crank), A (crank and rod), B (rod and slider), guide.  Drive: motor.

    Parameters
    ----------
    data : data of the mechanism; None: `SimeonData()`.
    elements : number of beam elements of the rod, even.
    stretched : whether the rod starts with the axial displacements and rates of the data; otherwise unstressed.
    waving : whether the rod starts with the lateral waves of the data; otherwise with a rigid motion.

    Raises
    ------
    InputError : values out of range or of the wrong kind, an odd number of elements.

    Examples
    --------
    >>> simeon().names
    ('crank', 'rod', 'slider', 'O', 'A', 'B', 'guide', 'motor')
    """
    data = SimeonData() if data is None else data
    if not isinstance(data, SimeonData):
        raise InputError(f"simeon: data is {data!r}; it must be a SimeonData, e.g. SimeonData(rod=0.4).")
    check_flag("simeon", "stretched", stretched)
    check_flag("simeon", "waving", waving)
    if checks.count("simeon", "elements", elements) % 2:
        raise InputError(f"simeon: elements is {elements}; it must be even, so that a node stands in the middle.")
    O, A, B = (0.0, 0.0), (data.crank, 0.0), (data.crank + data.rod, 0.0)
    crank = RigidLink("crank", O, A, data.crank_mass, data.crank_inertia - data.crank_mass * (data.crank / 2.0) ** 2)
    rod = FlexibleLink(
        "rod", A, B, section=Rectangle(width=data.side, height=data.side), material=Material(data.young, data.density),
        elements=elements, displacement=stretch(data) if stretched else None,
        velocity=start_velocity(data, stretched=stretched, waving=waving),
    )  # fmt: skip
    slider = RigidBody("slider", B, data.slider_mass, data.slider_mass * 1e-4)
    joints = (
        Revolute("O", GROUND, crank, at=O),
        Revolute("A", crank, rod, at=A),
        Revolute("B", rod, slider, at=B),
        Prismatic("guide", GROUND, slider, at=B, along=(1.0, 0.0)),
    )
    return Mechanism(NAME, (crank, rod, slider, *joints, Drive("motor", "O", ConstantSpeed(data.speed))))


def stretch(data: SimeonData) -> Callable[[float], Triple]:
    """Start displacement of the rod: along the rod, a parabola through 0, q3 in the middle and q4 at the end.

    Parameters
    ----------
    data : data of the mechanism.
    """
    return lambda s: (parabola(data.stretch, s), 0.0, 0.0)


def start_velocity(data: SimeonData, *, stretched: bool, waving: bool) -> Callable[[float], Triple]:
    """Start velocity of the rod: rigid motion of the chord, lateral waves, rates of the axial displacements.

    Parameters
    ----------
    data : data of the mechanism.
    stretched, waving : see `simeon`.
    """
    tip = data.speed * data.crank
    end = data.rod + (data.stretch[1] if stretched else 0.0)
    turn = -tip / end
    a, b = data.waves if waving else (0.0, 0.0)
    rate = data.stretch_rate if stretched else (0.0, 0.0)
    k = math.pi / data.rod

    def velocity(s: float) -> Triple:
        x = data.rod * s + (parabola(data.stretch, s) if stretched else 0.0)
        wave = a * math.sin(math.pi * s) + b * math.sin(2.0 * math.pi * s)
        slope = k * (a * math.cos(math.pi * s) + 2.0 * b * math.cos(2.0 * math.pi * s))
        return parabola(rate, s), tip + turn * x + wave, turn + slope

    return velocity


def parabola(values: tuple[float, float], s: float) -> float:
    """Parabola through 0 at s = 0, values[0] at 1/2, values[1] at 1.

    Parameters
    ----------
    values : the two values.
    s : position, 0 ... 1.
    """
    return 4.0 * values[0] * s * (1.0 - s) + values[1] * s * (2.0 * s - 1.0)
