"""The elastica with stretch: a clamped beam of finite axial stiffness under a dead force on its tip.

With s along the unstretched beam, theta the direction of the axis and e its strain:
    x' = (1 + e) cos(theta),  y' = (1 + e) sin(theta),  theta' = M/EI
    N = EA e = Fx cos(theta) + Fy sin(theta),  M' = (1 + e) (Fx sin(theta) - Fy cos(theta)),  M(L) = 0
This is the planar beam theory of Reissner without shear: N = EA (|r'| - 1), M = EI theta'.
Source: E. Reissner, On one-dimensional finite-strain beam theory: the plane problem, Zeitschrift fuer angewandte
Mathematik und Physik 23 (1972) 795-804.  The reference is an integration of these equations here, from the tip to the
clamp, with the angle of the tip found by bisection: it shares nothing with the element.
"""

import math
from itertools import product

import numpy as np
from record import Curve, Problem, Value
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fm
from flexmb.mechanisms.cantilever import cantilever

LENGTH, EI = 1.0, 10.0
SLENDERNESS = (100.0, 300.0, 1000.0)  # EA L^2/EI
DIRECTIONS = {"across": (0.0, 1.0), "oblique": (0.8, 0.6)}

PROBLEM = Problem(
    title="Extensible elastica",
    source="Equations: E. Reissner, Zeitschrift fuer angewandte Mathematik und Physik 23 (1972) 795-804.",
    kind="computed here by shooting with tolerances of 1e-12",
    about="""A clamped beam that bends and stretches: EA L^2/EI = 100 to 1000, with a dead force of 4 EI/L^2 on its tip,
    across the beam or oblique. At 100 the axial strain reaches 4 %, far more than a slender beam of steel could bear;
    that is where a wrong measure of strain would show. The element agrees with N = EA (|r'| - 1) in the limit of many
    elements, with an error of second order that grows with the strain, because the shortening of its chord by bending
    is counted on the unstretched length; without strain the fourth order of the elastica is left. A force along the
    beam alone stretches it by F L/(EA) exactly, whatever the size.""",
)


def section_of(ratio: float) -> tuple[fm.Section, fm.Material]:
    """Section and material with EI and EA L^2/EI = ratio."""
    young = 1e9
    area = ratio * EI / LENGTH**2 / young
    return fm.GeneralSection(area=area, second_moment=EI / young), fm.Material(young=young, density=1000.0)


def loaded(force: tuple[float, float], ratio: float, elements: int) -> tuple[float, float, float]:
    """Place [m] and rotation [rad] of the tip, as flexmb finds them."""
    section, material = section_of(ratio)
    mech = cantilever(LENGTH, section, material, elements=elements, force=force)
    found = fm.static_equilibrium(mech)
    return found["beam.end.x"], found["beam.end.y"], found["beam.end.theta"]


def exact(force: tuple[float, float], ratio: float) -> tuple[float, float, float]:
    """The same by integrating the equations from the tip to the clamp."""
    fx, fy = force
    ea = ratio * EI / LENGTH**2

    def slope(_, state):
        _, _, theta, moment = state
        c, s = math.cos(theta), math.sin(theta)
        stretch = 1.0 + (fx * c + fy * s) / ea
        return stretch * c, stretch * s, moment / EI, stretch * (fx * s - fy * c)

    def at_clamp(angle: float) -> np.ndarray:
        run = solve_ivp(slope, (LENGTH, 0.0), (0.0, 0.0, angle, 0.0), method="DOP853", rtol=1e-12, atol=1e-13)
        return run.y[:, -1]

    direction = math.atan2(fy, fx)  # the tip turns towards the force, and not beyond
    angle = brentq(lambda a: at_clamp(a)[2], 1e-9, direction - 1e-9, xtol=1e-14, rtol=1e-14)
    x, y, _, _ = at_clamp(angle)
    return -x, -y, angle


def force_of(name: str) -> tuple[float, float]:
    """4 EI/L^2 in the direction of that name."""
    c, s = DIRECTIONS[name]
    return 4.0 * EI / LENGTH**2 * c, 4.0 * EI / LENGTH**2 * s


@PROBLEM.case("16 elements")
def sixteen():
    for name, ratio in product(DIRECTIONS, SLENDERNESS):
        force = force_of(name)
        quantities = ("x of the tip / L", "y of the tip / L", "angle of the tip [rad]")
        for quantity, ref, ours in zip(quantities, exact(force, ratio), loaded(force, ratio, 16), strict=True):
            yield Value(f"{name}, EA L^2/EI = {ratio:g}: {quantity}", ref, ours, band=1e-4, scale=1.0)


@PROBLEM.case("along the beam, 4 elements")
def along():
    for strain in (-0.01, 0.1, 0.5):
        x, y, theta = loaded((strain * 100.0 * EI / LENGTH**2, 0.0), 100.0, 4)
        yield Value(f"strain {strain:g}: x of the tip / L", 1.0 + strain, x / LENGTH, band=1e-12)
        yield Value(f"strain {strain:g}: y and angle of the tip", 0.0, abs(y) + abs(theta), band=1e-12, scale=1.0)


@PROBLEM.convergence(
    "extensible",
    "Extensible elastica: distance of the tip from its exact place.",
    "element length / L",
    "distance / L",
    slow=True,
)
def elements():
    # Coarser, the error of fourth order that bending has is as large, and of the other sign in oblique loading.
    counts = (16, 32, 64, 128)
    for name, ratio in product(DIRECTIONS, (100.0, 1000.0)):
        x, y, _ = exact(force_of(name), ratio)
        tips = [loaded(force_of(name), ratio, n) for n in counts]
        errors = [math.hypot(tip[0] - x, tip[1] - y) / LENGTH for tip in tips]
        yield Curve(f"{name}, EA L$^2$/EI = {ratio:g}", [1.0 / n for n in counts], errors, order=2.0)


test_case, test_curves = PROBLEM.tests()
