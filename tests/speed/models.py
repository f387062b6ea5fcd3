"""The models that are timed, built with flexmb; peer.py builds the same ones for Exudyn from the same numbers.

Slider-crank: crank 0.05 m at a constant 5000 rpm, rod 0.12 m and 0.21 kg, slider 0.14 kg, two turns, no gravity.  With
play the rod carries the bearing (10 mm) and the slider the journal (9.5 mm), steel on steel, restitution 0.9.
Rod: the same with a rod of beams of steel (2.1e11 Pa, 7850 kg/m^3) and a slider without extent.
Link: the same with a rod that is a plane link with eyes, 10 mm thick, with holes of 10 mm radius, E as above,
nu = 0.3, damped by 5e-6 s times its stiffness.
Chain: hinged links of 0.4 m, 20 x 4 mm, of the same steel; straight along +x and at rest, falls for 0.5 s.
Nine-bar: `NineBarData` with friction that rises from slip zero on, as the peer's does.
"""

import math
from dataclasses import dataclass

import numpy as np

import flexmb as fm
from flexmb.elastic.meshes.mesh import PlaneMesh
from flexmb.parts.contact.onset import HISTORY, approach_speed

CRANK, CRANK_MASS, CRANK_INERTIA = 0.05, 0.30, 1.0e-5  # m, kg, kg m^2 about the centre of mass
ROD, ROD_MASS, ROD_INERTIA = 0.12, 0.21, 2.5e-4
SLIDER_MASS = 0.14
OMEGA = 5000.0 * 2.0 * math.pi / 60.0  # rad/s
TURN = 2.0 * math.pi / OMEGA

BEARING, CLEARANCE, RESTITUTION, SLIDING_ZONE = 0.010, 5e-4, 0.9, 1e-3
CONTACT_STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)
LEAST_APPROACH = 1e-3  # m/s

BEAM_STEEL = fm.Material(young=2.1e11, density=7850.0)
HEAVY = math.sqrt(ROD_MASS / (BEAM_STEEL.density * ROD))  # side of a square that weighs what the rigid rod weighs
SECTIONS = {"heavy": (HEAVY, HEAVY), "slender": (0.010, 0.005)}  # width, height in the plane of bending [m]
LINK, LINK_SECTION, GRAVITY = 0.4, (0.020, 0.004), 9.81

PLANE_STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
LINK_EYE, LINK_HOLE, LINK_WIDTH, LINK_THICKNESS, LINK_CELL = 0.020, 0.010, 0.020, 0.010, 0.005  # m
LINK_DAMPING = 5e-6  # s, stiffness-proportional

NINE_BAR_SPEED, NINE_BAR_PLAY = 2.0 * math.pi, 5e-4
NINE_BAR_TURN = 2.0 * math.pi / NINE_BAR_SPEED


def hertz(clearance: float = CLEARANCE) -> float:
    """Stiffness of the contact between rod and slider [N/m^1.5]."""
    law = fm.LankaraniNikravesh.from_materials(CONTACT_STEEL, CONTACT_STEEL, restitution=RESTITUTION)
    return law.for_radii(BEARING, BEARING - clearance).stiffness


def _slider_crank(rod, slider, last, *, driven: bool = True) -> fm.Mechanism:
    """Crank, the given rod and slider, joined by `last`; not driven, the crank only starts with its speed."""
    start = None if driven else (0.0, 0.5 * CRANK * OMEGA, OMEGA)
    crank = fm.RigidLink("crank", (0.0, 0.0), (CRANK, 0.0), CRANK_MASS, CRANK_INERTIA, velocity=start)
    joints = (
        fm.Revolute("A", fm.GROUND, crank, (0.0, 0.0)),
        fm.Revolute("B", crank, rod, (CRANK, 0.0)),
        last,
        fm.Prismatic("guide", fm.GROUND, slider),
    )
    drive = (fm.Drive("motor", "A", fm.ConstantSpeed(OMEGA)),) if driven else ()
    return fm.Mechanism("slider-crank", (crank, rod, slider, *joints, *drive))


def _rigid_rod_and_slider() -> tuple[fm.RigidLink, fm.RigidBody]:
    end = (CRANK + ROD, 0.0)
    return fm.RigidLink("rod", (CRANK, 0.0), end, ROD_MASS, ROD_INERTIA), fm.RigidBody("slider", end, SLIDER_MASS, 1e-4)


def ideal(*, driven: bool = True) -> fm.Mechanism:
    """The slider-crank with ideal joints, driven or turning freely."""
    rod, slider = _rigid_rod_and_slider()
    return _slider_crank(rod, slider, fm.Revolute("C", rod, slider, (CRANK + ROD, 0.0)), driven=driven)


def worn(mu: float = 0.03, clearance: float = CLEARANCE, normal: fm.NormalLaw | None = None) -> fm.Mechanism:
    """The slider-crank with play between rod and slider; `normal` instead of the library's law."""
    rod, slider = _rigid_rod_and_slider()
    law = normal or fm.LankaraniNikravesh(hertz(), restitution=RESTITUTION, least_approach=LEAST_APPROACH)
    options = {"clearance": clearance, "bearing_radius": BEARING, "normal": law}
    if mu:
        options["friction"] = fm.ModifiedCoulomb(mu, v0=0.0, v1=SLIDING_ZONE)
    return _slider_crank(rod, slider, fm.RevoluteClearance("C", rod, slider, (CRANK + ROD, 0.0), **options))


@fm.normal_law
def lankarani_nikravesh_alone(p, h, gap, gap_rate, z, z_new):
    """The library's law as a user would write it: the force without its derivatives."""
    k, n, e, least = p
    approach, _, _ = approach_speed(h, gap, gap_rate, least, z, z_new)
    if gap >= 0.0:
        return 0.0
    return max(k * (-gap) ** n * (1.0 - 0.75 * (1.0 - e * e) * gap_rate / approach), 0.0)


@dataclass(frozen=True)
class ForceAlone(fm.NormalLaw):
    """Stiffness [N/m^n], exponent, restitution, least approach speed [m/s]."""

    k: float
    n: float = 1.5
    e: float = RESTITUTION
    least: float = LEAST_APPROACH
    kernel = lankarani_nikravesh_alone

    def history(self):
        return HISTORY


def user_law(mu: float = 0.03) -> fm.Mechanism:
    """The slider-crank with play whose law is a user's Python function."""
    return worn(mu, normal=ForceAlone(hertz()))


def flexible_rod(section: str = "heavy", elements: int = 8) -> fm.Mechanism:
    """The slider-crank with a rod of beams and ideal joints."""
    width, height = SECTIONS[section]
    end = (CRANK + ROD, 0.0)
    rod = fm.FlexibleLink(
        "rod",
        (CRANK, 0.0),
        end,
        section=fm.Rectangle(width=width, height=height),
        material=BEAM_STEEL,
        elements=elements,
    )
    slider = fm.RigidBody("slider", end, SLIDER_MASS, 1e-4)
    return _slider_crank(rod, slider, fm.Revolute("C", rod, slider, end))


def link_mesh() -> PlaneMesh:
    """Mesh of the link with eyes, as long as the rod."""
    return fm.meshes.link_with_eyes(ROD, eye=LINK_EYE, hole=LINK_HOLE, width=LINK_WIDTH, size=LINK_CELL)


def link_rod(modes: int | None) -> fm.Mechanism:
    """The slider-crank whose rod is a plane link with eyes, reduced to so many modes; None: all nodes."""
    end = (CRANK + ROD, 0.0)
    own = {"thickness": LINK_THICKNESS, "material": PLANE_STEEL, "damping": LINK_DAMPING}
    plate = fm.PlaneBody("rod", link_mesh(), start=(CRANK, 0.0), end=end, **own)
    rod = plate if modes is None else fm.Reduced(plate, modes=modes)
    slider = fm.RigidBody("slider", end, SLIDER_MASS, 1e-4)
    return _slider_crank(rod, slider, fm.Revolute("C", rod, slider, end))


def chain(links: int, elements: int) -> fm.Mechanism:
    """Hinged flexible links, straight along +x, falling from rest under gravity."""
    width, height = LINK_SECTION
    options = {
        "section": fm.Rectangle(width=width, height=height),
        "material": BEAM_STEEL,
        "elements": elements,
    }
    parts, last = [], fm.GROUND
    for k in range(links):
        link = fm.FlexibleLink(f"L{k}", (LINK * k, 0.0), (LINK * (k + 1), 0.0), **options)
        parts += [link, fm.Revolute(f"J{k}", last, link, (LINK * k, 0.0))]
        last = link
    return fm.Mechanism("chain", tuple(parts), gravity=(0.0, -GRAVITY))


def nine_bar(*, flexible: bool = False, elements: int = 4) -> fm.Mechanism:
    """The nine-bar mechanism with 0.5 mm of play at 2 pi rad/s."""
    data = fm.mechanisms.NineBarData(v0=0.0, damping=fm.mechanisms.NineBarData.LIGHT_DAMPING)
    return fm.mechanisms.nine_bar(
        NINE_BAR_SPEED, clearance=NINE_BAR_PLAY, flexible=flexible, elements=elements, data=data
    )


# Exact and converged values.


def ideal_position(theta):
    """Position of the slider of the ideal slider-crank [m]."""
    return CRANK * np.cos(theta) + np.sqrt(ROD**2 - (CRANK * np.sin(theta)) ** 2)


def ideal_energy(theta):
    """Kinetic energy of rod and slider of the ideal slider-crank at OMEGA [J]; the crank's does not change."""
    r, l, w = CRANK, ROD, OMEGA
    sine = r * np.sin(theta) / l  # of the rod's angle below the line of the slider
    cosine = np.sqrt(1.0 - sine * sine)
    turning = r * w * np.cos(theta) / (l * cosine)
    across = 0.5 * r * w * np.cos(theta)  # of the rod's centre, midway between crank pin and slider
    slider = -r * w * np.sin(theta) - l * turning * sine
    along = 0.5 * (-r * w * np.sin(theta) + slider)
    return 0.5 * (ROD_MASS * (along**2 + across**2) + ROD_INERTIA * turning**2 + SLIDER_MASS * slider**2)


def ideal_torque(theta):
    """Torque of the drive of the ideal slider-crank, dE/dtheta by a complex step [N m]."""
    return np.imag(ideal_energy(np.asarray(theta) + 1e-30j)) / 1e-30
