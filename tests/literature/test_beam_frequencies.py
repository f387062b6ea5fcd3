"""Natural frequencies of straight beams: five end conditions, axial prestress, a wedge.

omega = z^2 sqrt(EI/(m L^4)), z the roots of: sin z = 0 (pinned-pinned), cos z cosh z = -1 (clamped-free), cos z cosh
z = 1 (clamped-clamped, free-free), tan z = tanh z (clamped-pinned).
With an axial force P (tension > 0) in a pinned beam: omega_n = (n pi/L)^2 sqrt(EI/m) sqrt(1 + P L^2/(n^2 pi^2 EI)).
Source: R. D. Blevins, Formulas for Natural Frequency and Mode Shape, Van Nostrand Reinhold 1979, tables 8-1 and 8-8.
Wedge (height linear, width constant, clamped at the thick end): omega = 5.315 sqrt(EI/(m L^4)), EI and m at the root:
G. Kirchhoff, Monatsberichte Berlin 1879, 815-828; the equation of the roots is J1(x) I2(x) + I1(x) J2(x) = 0 with
omega = (x/2)^2 sqrt(EI/(m L^4)), x = 2 sqrt(5.315).
"""

import math

import numpy as np
from record import Curve, Problem, Value
from scipy.optimize import brentq
from scipy.special import iv, jv

import flexmb as fm

LENGTH, EI, RHO_A, EA = 2.0, 3.0, 0.5, 3e6
UNIT = math.sqrt(EI / (RHO_A * LENGTH**4))
MATERIAL = fm.Material(young=1e9, density=1000.0)
ERROR_OF_ELEMENT = (
    "a cubic element of length h overrates a frequency whose waves have the number k by (k h)^4/1440 (Taylor series "
    "of the difference equation of the assembled elements)"
)

PROBLEM = Problem(
    title="Bending frequencies of beams",
    source="Blevins, Formulas for Natural Frequency and Mode Shape, 1979, tables 8-1, 8-8; Kirchhoff 1879 (wedge)",
    kind="exact",
    about="Frequencies from `fm.modes` over sqrt(EI/(m L^4)).  The free beam must return three rigid motions by their "
    "names.  With prestress the modes are those about the equilibrium under the force.",
)


def roots(f, n, first):
    """n roots of f, one in each interval of length pi from `first` on."""
    return np.array([brentq(f, first + k * math.pi, first + (k + 1) * math.pi) for k in range(n)])


# the equations divided by cosh z, so that nothing overflows
EQUATIONS = {
    "pinned-pinned": lambda n: np.pi * np.arange(1, n + 1),
    "clamped-free": lambda n: roots(lambda z: math.cos(z) + 1.0 / math.cosh(z), n, 0.0),
    "clamped-clamped": lambda n: roots(lambda z: math.cos(z) - 1.0 / math.cosh(z), n, math.pi),
    "clamped-pinned": lambda n: roots(lambda z: math.sin(z) - math.cos(z) * math.tanh(z), n, math.pi),
    "free-free": lambda n: roots(lambda z: math.cos(z) - 1.0 / math.cosh(z), n, math.pi),
}


def beam(ends, elements, tension=0.0):
    """A beam along x with the ends wanted; the right one is free to move along x."""
    foot, head = (0.0, 0.0), (LENGTH, 0.0)
    section = fm.GeneralSection(area=EA / 1e9, second_moment=EI / 1e9)
    material = fm.Material(young=1e9, density=RHO_A * 1e9 / EA)
    link = fm.FlexibleLink("beam", foot, head, section=section, material=material, elements=elements)
    parts = [link]
    if ends.startswith(("pinned", "clamped")):
        parts.append((fm.Revolute if ends.startswith("pinned") else fm.Fixed)("left", fm.GROUND, link, at=foot))
    if ends.endswith(("pinned", "clamped")):
        slider = fm.RigidBody("slider", head, mass=1e-9, inertia=1e-9)
        joint = fm.Revolute if ends.endswith("pinned") else fm.Fixed
        parts += [slider, joint("right", link, slider, at=head), fm.Prismatic("guide", fm.GROUND, slider)]
        if tension:
            parts.append(fm.Force("P", slider, at=head, force=(tension, 0.0)))
    return fm.Mechanism("beam", parts)


def ours(mechanism, count, at=None):
    """The lowest bending frequencies omega/UNIT without rigid motions; EA is too large for axial ones among them."""
    found = fm.modes(mechanism, count=count + 3, at=at)
    return 2.0 * math.pi * found.frequencies[found.rigid :][:count] / UNIT


def of_beams(elements, count, wanted):
    for ends, equation in EQUATIONS.items():
        exact = equation(count)
        for n, (z, omega) in enumerate(zip(exact, ours(beam(ends, elements), count), strict=True), 1):
            known = (z / elements) ** 4 / 1440.0
            # beyond 1e-4 the element's own error, known beforehand, is the limit; clamped ends cost a little more
            missed = {} if known < 0.9e-4 else {"missed": ERROR_OF_ELEMENT, "limit": wanted * known}
            yield Value(f"{ends}, omega {n}", z**2, omega, 1e-4, **missed)


@PROBLEM.case("8 elements")
def eight():
    yield from of_beams(8, 3, 1.3)


@PROBLEM.case("32 elements")
def thirty_two():
    yield from of_beams(32, 5, 1.3)


@PROBLEM.case("rigid motions of the free beam")
def rigid():
    found = fm.modes(beam("free-free", 8), count=4)
    names = ("translation in x", "translation in y", "rotation")
    told = sum(f"rigid: {n} of 'beam'" == kind for n, kind in zip(names, found.kinds, strict=False))
    yield Value("rigid motions, by name", 3, told, 0.0, scale=1.0)
    yield Value("frequency of the third [Hz]", 0.0, found.frequencies[2], 0.0, scale=1.0)
    # about the centre of mass: the rotation moves the middle node along neither axis
    yield Value("middle node in the rotation", 0.0, found.shape(2, "beam.node4.y"), 1e-9, scale=1.0)


@PROBLEM.case("prestress, 8 elements")
def prestress():
    for share in (-0.9, -0.5, 1.0, 10.0):
        mechanism = beam("pinned-pinned", 8, share * math.pi**2 * EI / LENGTH**2)
        exact = math.pi**2 * math.sqrt(1.0 + share)
        omega = ours(mechanism, 1, fm.static_equilibrium(mechanism, load_steps=2))[0]
        # near the critical load the frequency is the root of a difference: its relative error grows by 1/(1 + share)
        known = (math.pi / 8) ** 4 / 1440.0 / (1.0 + share)
        missed = {"missed": ERROR_OF_ELEMENT, "limit": 1.1 * known} if known > 1e-4 else {}
        yield Value(f"omega 1 at P = {share:g} critical", exact, omega, 1e-4, **missed)


@PROBLEM.case("prestress, 16 elements")
def prestress_fine():
    for share in (-0.9, -0.5, 1.0, 10.0):
        mechanism = beam("pinned-pinned", 16, share * math.pi**2 * EI / LENGTH**2)
        omega = ours(mechanism, 2, fm.static_equilibrium(mechanism, load_steps=2))
        for n in (1, 2):
            exact = (n * math.pi) ** 2 * math.sqrt(1.0 + share / n**2)
            yield Value(f"omega {n} at P = {share:g} critical", exact, omega[n - 1], 1e-4)


@PROBLEM.case("wedge, 32 elements")
def wedge():
    root = brentq(lambda x: jv(1, x) * iv(2, x) + iv(1, x) * jv(2, x), 4.0, 5.0)
    yield Value("root of Kirchhoff's equation, (x/2)^2", 5.315, (root / 2.0) ** 2, 5e-4, scale=1.0)
    width, height = 0.02, 0.01
    section = fm.Tapered(fm.Rectangle(width=width, height=height), fm.Rectangle(width=width, height=1e-6 * height))
    link = fm.FlexibleLink("wedge", (0.0, 0.0), (1.0, 0.0), section=section, material=MATERIAL, elements=32)
    mechanism = fm.Mechanism("wedge", [link, fm.Fixed("clamp", fm.GROUND, link, at=(0.0, 0.0))])
    unit = math.sqrt(1e9 * height**2 / 12.0 / 1000.0)
    omega = 2.0 * math.pi * fm.modes(mechanism, count=1).frequencies[0] / unit
    yield Value("omega of the wedge", (root / 2.0) ** 2, omega, 1e-4)


@PROBLEM.convergence("beam-frequencies", "First frequency of beams", "element length / L", "relative error")
def convergence():
    for ends, equation in EQUATIONS.items():
        exact, counts = equation(1)[0] ** 2, (8, 16, 32)
        errors = [abs(ours(beam(ends, n), 1)[0] / exact - 1.0) for n in counts]
        yield Curve(ends, [1.0 / n for n in counts], errors, 4.0, 0.1)


test_case, test_curves = PROBLEM.tests()
