"""Three bars from one joint: Logan's plane truss.

Bars from node 1 at the origin to (0, 10 ft), (10 ft, 10 ft), (10 ft, 0), pinned at all ends, E = 30e6 psi, A = 2
in^2, and 10 000 lb downwards on node 1.
Source: D. L. Logan, A First Course in the Finite Element Method, 4th ed., Thomson 2007, example 3.5: d1x = 0.414e-2 in,
d1y = -1.59e-2 in, stresses 3965, 1471, 1035 psi (the third bar is pressed).  The first two stresses are
computed from rounded displacements there: the linear equations give 3964.5 and 1464.5 psi.
"""

import math

import numpy as np
from record import Problem, Value

import flexmb as fm

INCH, POUND = 0.0254, 4.4482216152605
PSI = POUND / INCH**2
E, AREA, LOAD, SPAN = 30e6 * PSI, 2.0 * INCH**2, 10e3 * POUND, 120.0 * INCH
FAR = ((0.0, SPAN), (SPAN, SPAN), (SPAN, 0.0))

PROBLEM = Problem(
    title="Plane truss (Logan, example 3.5)",
    source="D. L. Logan, A First Course in the Finite Element Method, 4th ed., 2007, example 3.5",
    kind="published and exact",
    about="Three flexible links of one element each between ideal pins.  The printed digits are checked to half a "
    "unit of the last one; a small load beside them against a linear stiffness solution made in the test.",
)


def truss(load):
    """Three pinned bars and a force downwards on their common pin."""
    section = fm.GeneralSection(area=AREA, second_moment=1.0 * INCH**4)
    material = fm.Material(young=E, density=7850.0)
    options = {"section": section, "material": material, "elements": 1}
    bars = [fm.FlexibleLink(f"bar{k}", (0.0, 0.0), end, **options) for k, end in enumerate(FAR, 1)]
    pins = [
        fm.Revolute(f"far{k}", fm.GROUND, bar, at=end) for k, (bar, end) in enumerate(zip(bars, FAR, strict=True), 1)
    ]
    pins += [fm.Revolute(f"near{k}", bars[0], bar, at=(0.0, 0.0)) for k, bar in enumerate(bars[1:], 2)]
    return fm.Mechanism("truss", [*bars, *pins, fm.Force("P", bars[0], at=(0.0, 0.0), force=(0.0, -load))])


def answer(load):
    """(displacement of node 1 [m], axial stresses [Pa], tension > 0)."""
    found = fm.static_equilibrium(truss(load), load_steps=1)
    moved = np.array([found["bar1.start.x"], found["bar1.start.y"]])
    stresses = []
    for k, far in enumerate(FAR, 1):
        along = (np.array(far) - moved) / math.dist(far, moved)
        stresses.append(float(np.dot(found.force(f"far{k}")[:2], along)) / AREA)
    return moved, stresses


def linear(load):
    """The same by direct stiffness: sum of E A/l n n^T over the bars."""
    n = [np.array(far) / math.hypot(*far) for far in FAR]
    K = sum(E * AREA / math.hypot(*far) * np.outer(d, d) for far, d in zip(FAR, n, strict=True))
    u = np.linalg.solve(K, [0.0, -load])
    return u, [float(-E / math.hypot(*far) * d @ u) for far, d in zip(FAR, n, strict=True)]


@PROBLEM.case("as printed")
def printed():
    u, stress = answer(LOAD)
    yield Value("d1x [in]", 0.414e-2, u[0] / INCH, 0.5e-5, scale=1.0)
    yield Value("d1y [in]", -1.59e-2, u[1] / INCH, 0.5e-4, scale=1.0)
    rounded = "the source computes stresses from rounded displacements; its linear equations give {:.1f} psi"
    exact = linear(LOAD)[1]
    for k, (reference, limit) in enumerate(((3965.0, 0.6), (1471.0, 7.0), (-1035.0, None))):
        word = {} if limit is None else {"missed": rounded.format(exact[k] / PSI), "limit": limit}
        yield Value(f"stress {k + 1} [psi]", reference, stress[k] / PSI, 0.5, scale=1.0, **word)


@PROBLEM.case("small load, against linear stiffness")
def small():
    load = 1e-3 * LOAD  # strains of 1e-7: what is nonlinear is of that size
    u, stress = answer(load)
    u_linear, stress_linear = linear(load)
    for axis in range(2):
        yield Value(f"d1{'xy'[axis]} [m]", u_linear[axis], u[axis], 1e-6)
    for k in range(3):
        yield Value(f"stress {k + 1} [Pa]", stress_linear[k], stress[k], 1e-6)


test_case, _ = PROBLEM.tests()
