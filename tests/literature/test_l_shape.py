"""A frame of two legs at a right angle, clamped at one end, under a dead force on the other: shear, large rotations.

Legs of 1 m, the first along x from the clamp, the second along y; section 0.1 m wide and 0.05 m high, E = 210 GPa,
nu = 0.3, ks = 10 (1 + nu)/(12 + 11 nu), a force of 1 MN along x on the tip.  With theta the direction of the normals:
    x' = (1 + e) cos(theta) - g sin(theta),  y' = (1 + e) sin(theta) + g cos(theta),  theta' = M/EI
    EA e = F cos(theta),  ks G A g = -F sin(theta),  M' = y' F,  M = 0 at the tip
Source of the equations: E. Reissner, On one-dimensional finite-strain beam theory: the plane problem, Zeitschrift fuer
angewandte Mathematik und Physik 23 (1972) 795-804.  The exact digits are from shooting on them, by an independent
script.  Published value: J. Gerstmayr, Exudyn, example of geometrically exact beams, u_y = -0.91814745 m with four and
four elements of linear interpolation.
"""

import math

import numpy as np
from record import Curve, Problem, Value

import flexmb as fm

EXACT = {True: (0.8592284754, -0.9140520497, -1.3785942908), False: (0.8586543901, -0.9141793562, -1.3791810591)}
NAMES = ("u_x of the tip [m]", "u_y of the tip [m]", "rotation of the tip [rad]")
WORDS = {True: "with shear", False: "without shear"}
STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
TIP = (1.0, 1.0)

PROBLEM = Problem(
    title="L-shaped frame with shear",
    source="Equations: E. Reissner, ZAMP 23 (1972) 795-804; u_y of four and four elements: J. Gerstmayr, Exudyn",
    kind="exact, by shooting with an independent script; one published value",
    about="""The tip turns by 79 degrees. Bending converges with the fourth power of the element length, shear and
    stretching with the second. That the limit is Reissner's, to nine digits, shows that his axial strain, measured
    along the normal of a section, is met: a strain measured along the axis would move u_x by 8e-7 m.""",
)


def tip(shear: bool, elements: int) -> np.ndarray:
    """Displacements [m] and rotation [rad] of the tip."""
    frame = fm.FlexibleFrame(
        "L", ((0.0, 0.0), (1.0, 0.0), TIP), ((0, 1), (1, 2)), section=fm.Rectangle(width=0.1, height=0.05),
        material=STEEL, elements=elements, shear=shear,
    )  # fmt: skip
    clamp = fm.Fixed("clamp", fm.GROUND, frame, at=(0.0, 0.0))
    mechanism = fm.Mechanism("L", [frame, clamp, fm.Force("F", frame, at=TIP, force=(1e6, 0.0))])
    found = fm.static_equilibrium(mechanism)
    return np.array([found["L.node2.x"] - 1.0, found["L.node2.y"] - 1.0, found["L.node2.theta"]])


@PROBLEM.case("128 + 128 elements")
def refined():
    for shear, exact in EXACT.items():
        for name, reference, ours in zip(NAMES, exact, tip(shear, 128), strict=True):
            yield Value(f"{WORDS[shear]}: {name}", reference, ours, 2e-8)


@PROBLEM.case("64 + 64 and 128 + 128 elements, extrapolated")
def extrapolated():
    for shear, exact in EXACT.items():
        ours = (4.0 * tip(shear, 128) - tip(shear, 64)) / 3.0
        for name, reference, value in zip(NAMES, exact, ours, strict=True):
            yield Value(f"{WORDS[shear]}: {name}", reference, value, 2e-9)


@PROBLEM.case("4 + 4 elements")
def coarse():
    for name, reference, ours in zip(NAMES, EXACT[True], tip(True, 4), strict=True):
        yield Value(f"with shear: {name}", reference, ours, 1e-4)
    yield Value(
        "with shear: u_y of the tip, beside four and four linear elements [m]", -0.91814745, tip(True, 4)[1], 5e-3
    )


@PROBLEM.convergence(
    "l_shape", "L-shaped frame: distance of the tip from its exact place.", "element length [m]", "[m]"
)
def elements():
    counts = (32, 64, 128)
    for shear, exact in EXACT.items():
        errors = [math.hypot(*(tip(shear, n) - exact)[:2]) for n in counts]
        yield Curve(WORDS[shear], [1.0 / n for n in counts], errors, order=2.0 if shear else 1.5)


test_case, test_curves = PROBLEM.tests()
