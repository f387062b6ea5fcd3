"""Frequencies of a slider-crank in several poses, the crank held by its drive.

A rod of length l is pinned to the crank, which stands still, and to a slider of mass M whose guide makes the angle
beta with the rod.  With u = s cos(beta) and w = s sin(beta) at the slider, no moment there, and s its travel,

    M omega^2 = EA a cot(a l) cos^2(beta) - EI k^3 (coth(k l) - cot(k l))/2 sin^2(beta),

a = omega sqrt(m/EA), k = (m omega^2/EI)^(1/4).  It follows from u = s cos(beta) sin(a x)/sin(a l), w = A sin(k x) +
B sinh(k x), and the forces on the slider along its guide.
Source of the wave solutions: L. Meirovitch, Analytical Methods in Vibrations, Macmillan 1967, chapter 5.
"""

import math

import numpy as np
from record import Problem, Value
from scipy.optimize import brentq

import flexmb as fm

CRANK, ROD, SLIDER, GUIDE, OFFSET = 0.15, 0.40, 0.05, 0.35, 0.2
WIDTH, HEIGHT, YOUNG, DENSITY = 0.02, 0.006, 2.1e11, 7850.0
EA, EI, M_LINE = YOUNG * WIDTH * HEIGHT, YOUNG * WIDTH * HEIGHT**3 / 12.0, DENSITY * WIDTH * HEIGHT
POSES = (0.5, 1.5, 2.6, 4.4)
PROBLEM = Problem(
    title="Slider-crank held in several poses",
    source="exact frequency equation of a beam with a mass that slides at an angle to it; waves: Meirovitch 1967, "
    "chapter 5",
    kind="exact",
    about="`fm.modes` of a mechanism: rigid crank held by its drive, flexible rod, slider in a guide that is "
    "inclined by 0.35 rad and passes the crank's pivot at 0.2 m.  The frequencies depend on the pose through the angle "
    "between rod and guide.",
)


def geometry(angle):
    """Pins and the angle between the guide and the rod."""
    along = np.array([math.cos(GUIDE), math.sin(GUIDE)])
    side = OFFSET * np.array([-along[1], along[0]])
    pin = CRANK * np.array([math.cos(angle), math.sin(angle)])
    across = (pin - side) @ side / OFFSET
    slider = side + along * (pin @ along + math.sqrt(ROD**2 - across**2))
    rod = math.atan2(*(slider - pin)[::-1])
    return tuple(map(float, pin)), tuple(map(float, slider)), GUIDE - rod


def slider_crank(angle, elements):
    pin, end, _ = geometry(angle)
    crank = fm.RigidLink("crank", (0.0, 0.0), pin, 0.5, 1e-3)
    section = fm.Rectangle(width=WIDTH, height=HEIGHT)
    rod = fm.FlexibleLink(
        "rod", pin, end, section=section, material=fm.Material(young=YOUNG, density=DENSITY), elements=elements
    )
    slider = fm.RigidBody("slider", end, mass=SLIDER, inertia=1e-3)
    joints = (
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, rod, at=pin),
        fm.Revolute("B", rod, slider, at=end),
        fm.Prismatic("guide", fm.GROUND, slider, along=(math.cos(GUIDE), math.sin(GUIDE))),
        fm.Drive("motor", "O", fm.ConstantSpeed(10.0)),
    )
    return fm.Mechanism("slider-crank", (crank, rod, slider, *joints))


def frequency_equation(omega, beta):
    """The equation times sin(a l) sin(k l), which removes its poles."""
    al, kl = omega * ROD * math.sqrt(M_LINE / EA), ROD * (M_LINE * omega**2 / EI) ** 0.25
    sa, ca, sk, ck = math.sin(al), math.cos(al), math.sin(kl), math.cos(kl)
    axial = EA * al / ROD * ca * sk * math.cos(beta) ** 2
    bending = EI * (kl / ROD) ** 3 * sa * (sk / math.tanh(kl) - ck) / 2.0 * math.sin(beta) ** 2
    return SLIDER * omega**2 * sa * sk - axial + bending


def exact(beta, count):
    """The lowest frequencies [Hz]."""
    grid = 2.0 * math.pi * np.arange(20.0, 3000.0, 1.0)
    values = [frequency_equation(w, beta) for w in grid]
    found = [
        brentq(frequency_equation, a, b, args=(beta,), xtol=1e-10, rtol=1e-13)
        for a, b, fa, fb in zip(grid, grid[1:], values, values[1:], strict=False)
        if fa * fb < 0.0
    ]
    return np.array(found[:count]) / (2.0 * math.pi)


def values(elements, count):
    for angle in POSES:
        beta = geometry(angle)[2]
        found = fm.modes(slider_crank(angle, elements), count=count).frequencies
        for n, (reference, ours) in enumerate(zip(exact(beta, count), found, strict=True), 1):
            yield Value(f"crank at {angle} rad (beta {beta:.3f}): frequency {n} [Hz]", reference, ours, 1e-4)


@PROBLEM.case("8 elements")
def eight():
    yield from values(8, 1)


@PROBLEM.case("32 elements")
def many():
    yield from values(32, 4)


test_case, _ = PROBLEM.tests()
