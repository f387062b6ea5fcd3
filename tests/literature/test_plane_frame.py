"""Logan's portal: a plane frame with clamped feet under a force and a moment.

Nodes (0, 0) clamped, (0, 10 ft), (10 ft, 10 ft), (10 ft, 0) clamped; E = 30e6 psi, A = 10 in^2, I = 200 in^4 (columns),
100 in^4 (beam); 10 000 lb in +x on node 2, 5000 in lb counter-clockwise on node 3.
Source: D. L. Logan, A First Course in the Finite Element Method, 4th ed., Thomson 2007, example 5.1: d2x = 0.211 in,
d2y = 0.00148 in, phi2 = -0.00153 rad, d3x = 0.209 in, d3y = -0.00148 in, phi3 = -0.00149 rad.
"""

import numpy as np
from record import Problem, Value

import flexmb as fm

INCH, POUND = 0.0254, 4.4482216152605
E = 30e6 * POUND / INCH**2
SPAN, AREA = 120.0 * INCH, 10.0 * INCH**2
POINTS = ((0.0, 0.0), (0.0, SPAN), (SPAN, SPAN), (SPAN, 0.0))
SECOND = (200.0 * INCH**4, 100.0 * INCH**4, 200.0 * INCH**4)
PRINTED = {
    "d2x [in]": (0.211, 0.5e-3), "d2y [in]": (0.00148, 0.5e-5), "phi2 [rad]": (-0.00153, 0.5e-5),
    "d3x [in]": (0.209, 0.5e-3), "d3y [in]": (-0.00148, 0.5e-5), "phi3 [rad]": (-0.00149, 0.5e-5),
}  # fmt: skip

PROBLEM = Problem(
    title="Plane frame (Logan, example 5.1)",
    source="D. L. Logan, A First Course in the Finite Element Method, 4th ed., 2007, example 5.1",
    kind="published and exact",
    about="A flexible frame of three beams, one element each, both feet clamped.  The printed digits are checked to "
    "half a unit of the last one; small loads beside them against a linear stiffness solution made in the test.",
)


def portal(share):
    """The portal under a share of its loads."""
    sections = tuple(fm.GeneralSection(area=AREA, second_moment=second) for second in SECOND)
    frame = fm.FlexibleFrame(
        "portal",
        POINTS,
        ((0, 1), (1, 2), (2, 3)),
        section=sections,
        material=fm.Material(young=E, density=7850.0),
        elements=1,
    )
    feet = [fm.Fixed(f"foot{k}", fm.GROUND, frame, at=POINTS[k]) for k in (0, 3)]
    force = fm.Force("P", frame, at=POINTS[1], force=(share * 10e3 * POUND, 0.0))
    moment = fm.Torque("M", frame, share * 5e3 * POUND * INCH, at=POINTS[2])
    return fm.Mechanism("portal", [frame, *feet, force, moment])


def answer(share):
    """Displacements (dx, dy [m], phi [rad]) of nodes 2 and 3: half the difference of both signs of the loads.

    The columns turn, so that nodes 2 and 3 sink by a square of the load that a linear analysis leaves out.
    """
    up, down = (fm.static_equilibrium(portal(sign * share), load_steps=1) for sign in (1.0, -1.0))
    places = [f"portal.node{k}.{axis}" for k in (1, 2) for axis in ("x", "y", "theta")]
    return np.array([(up[place] - down[place]) / 2.0 for place in places])


def bar(start, end, second):
    """Textbook stiffness (6, 6) of a beam in the axes of the plane."""
    d = np.subtract(end, start)
    length = np.hypot(*d)
    c, s = d / length
    T = np.kron(np.eye(2), [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    a, b = E * AREA / length, E * second / length**3
    k = np.zeros((6, 6))
    k[np.ix_([0, 3], [0, 3])] = a * np.array([[1, -1], [-1, 1]])
    L = length
    k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = b * np.array(
        [[12, 6 * L, -12, 6 * L], [6 * L, 4 * L * L, -6 * L, 2 * L * L],
         [-12, -6 * L, 12, -6 * L], [6 * L, 2 * L * L, -6 * L, 4 * L * L]]
    )  # fmt: skip
    return T.T @ k @ T


def linear(share):
    """The same by direct stiffness."""
    K = np.zeros((12, 12))
    for k, second in enumerate(SECOND):
        K[3 * k : 3 * k + 6, 3 * k : 3 * k + 6] += bar(POINTS[k], POINTS[k + 1], second)
    return np.linalg.solve(K[3:9, 3:9], [share * 10e3 * POUND, 0.0, 0.0, 0.0, 0.0, share * 5e3 * POUND * INCH])


@PROBLEM.case("as printed")
def printed():
    units = (INCH, INCH, 1.0, INCH, INCH, 1.0)
    # the print is of a linear analysis: a hundredth of the loads, times a hundred
    for (name, (reference, band)), x, unit in zip(PRINTED.items(), 100.0 * answer(0.01), units, strict=True):
        yield Value(name, reference, x / unit, band, scale=1.0)


@PROBLEM.case("small loads, against linear stiffness")
def small():
    share = 1e-4
    for name, exact, ours in zip(PRINTED, linear(share), answer(share), strict=True):
        yield Value(name.split()[0], exact, ours, 1e-6)


test_case, _ = PROBLEM.tests()
