"""Euler columns: the four classical end conditions.

A straight column of length L and bending stiffness EI under an axial force P at its upper end buckles at
P = c EI/L^2, with c = pi^2 (pinned-pinned), pi^2/4 (fixed-free), 4 pi^2 (fixed-fixed) and z^2 with z the first root of
tan z = z (fixed-pinned; 20.1907).  Source: S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 2nd ed.,
McGraw-Hill 1961, sections 2.1 to 2.3.
"""

import math

from record import Curve, Problem, Value
from scipy.optimize import brentq

import flexmb as fm

LENGTH, EI = 2.0, 3.0
FACTORS = {
    "pinned-pinned": math.pi**2,
    "fixed-free": math.pi**2 / 4.0,
    "fixed-fixed": 4.0 * math.pi**2,
    "fixed-pinned": brentq(lambda z: math.sin(z) - z * math.cos(z), 4.0, 4.7) ** 2,
}
ERROR_OF_ELEMENT = (
    "a cubic element of length h overrates the load of a shape with waves of number k by (k h)^4/720 (Taylor series of "
    "the difference equation of the assembled elements)"
)

PROBLEM = Problem(
    title="Euler columns",
    source="Timoshenko, Gere, Theory of Elastic Stability, 2nd ed., McGraw-Hill 1961, sections 2.1 to 2.3",
    kind="exact",
    about="Critical loads of a straight column from the linear buckling analysis `fm.buckling`; the column stands "
    "inclined by 0.3 rad, so that no entry of a matrix vanishes by chance.  It tests the geometric stiffness of the "
    "beam element, and joints under load.",
)


# EA is so large (3e7 EI/L^2) that the column does not shorten before it buckles, as in the source
def column(ends, elements, angle=0.3):
    """A column under the unit load EI/L^2 along its axis."""
    c, s = math.cos(angle), math.sin(angle)
    foot, head = (0.0, 0.0), (LENGTH * c, LENGTH * s)
    material = fm.Material(young=1e9, density=1000.0)
    section = fm.GeneralSection(area=0.1, second_moment=EI / 1e9)
    beam = fm.FlexibleLink("column", foot, head, section=section, material=material, elements=elements)
    lower = fm.Revolute if ends.startswith("pinned") else fm.Fixed
    parts = [beam, lower("foot", fm.GROUND, beam, at=foot)]
    unit = EI / LENGTH**2
    parts.append(fm.Force("P", beam, at=head, force=(-unit * c, -unit * s)))
    if not ends.endswith("free"):
        cap = fm.RigidBody("cap", head, mass=1.0, inertia=1.0)
        upper = fm.Revolute if ends.endswith("pinned") else fm.Fixed
        parts += [cap, upper("head", beam, cap, at=head), fm.Prismatic("guide", fm.GROUND, cap, along=(c, s))]
    return fm.Mechanism("column", parts)


def critical(ends, elements):
    """Ours, in EI/L^2."""
    return float(fm.buckling(column(ends, elements), count=1).factors[0])


@PROBLEM.case("8 elements")
def eight():
    for ends, exact in FACTORS.items():
        ours = critical(ends, 8)
        waves = math.sqrt(exact) / 8
        # the two stiffest shapes have waves that 8 cubic elements cannot follow to 1e-4: the error known beforehand
        known = waves**4 / 720
        missed = {} if known < 1e-4 else {"missed": ERROR_OF_ELEMENT, "limit": 1.1 * known}
        yield Value(f"{ends}: P L^2/EI", exact, ours, 1e-4, **missed)


@PROBLEM.case("16 elements")
def sixteen():
    for ends, exact in FACTORS.items():
        yield Value(f"{ends}: P L^2/EI", exact, critical(ends, 16), 1e-4)


@PROBLEM.convergence("euler-columns", "Critical loads of Euler columns", "elements length / L", "relative error")
def convergence():
    for ends, exact in FACTORS.items():
        # Two elements give fixed-fixed a shape of another symmetry. Fixed-free is half of pinned-pinned, so half as
        # many do for it; with 16 its error is 1.3e-7, and EA = 3e7 EI/L^2 leaves 1e-7 of round-off in the eigenvalue.
        counts = (2, 4, 8) if ends == "fixed-free" else (4, 8, 16)
        errors = [abs(critical(ends, n) / exact - 1.0) for n in counts]
        yield Curve(ends, [1.0 / n for n in counts], errors, 4.0, 0.2)


test_case, test_curves = PROBLEM.tests()
