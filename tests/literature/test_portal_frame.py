"""Frequencies of a clamped portal frame against the exact dynamic stiffness.

Every bar obeys EI w'''' = m omega^2 w and EA u'' = -m omega^2 u; its end forces by its end displacements are Kolousek's
functions of lambda = l (m omega^2/EI)^(1/4) and mu = omega l sqrt(m/EA).  The frame vibrates freely where the
determinant of the assembled 6 x 6 matrix of both upper corners vanishes.
Source: V. Kolousek, Dynamics in Engineering Structures, Butterworths 1973, chapter 3.
"""

import math

import numpy as np
from record import Curve, Problem, Value
from scipy.optimize import brentq

import flexmb as fm

YOUNG, DENSITY, WIDTH = 2.1e11, 7850.0, 0.05
HEIGHTS = (0.02, 0.03, 0.02)
POINTS = ((0.0, 0.0), (0.0, 1.0), (1.4, 1.0), (1.4, -0.2))
PROBLEM = Problem(
    title="Portal frame",
    source="V. Kolousek, Dynamics in Engineering Structures, Butterworths 1973, chapter 3 (dynamic stiffness)",
    kind="exact",
    about="A frame of three steel bars with legs of different length, clamped at both feet; the references are roots "
    "of the determinant of the dynamic stiffness, computed in the test.",
)


def portal(elements):
    frame = fm.FlexibleFrame(
        "portal",
        POINTS,
        ((0, 1), (1, 2), (2, 3)),
        section=tuple(fm.Rectangle(width=WIDTH, height=h) for h in HEIGHTS),
        material=fm.Material(young=YOUNG, density=DENSITY),
        elements=elements,
    )
    return fm.Mechanism("portal", [frame, *(fm.Fixed(f"foot{k}", fm.GROUND, frame, at=POINTS[k]) for k in (0, 3))])


def bar(omega, start, end, height):
    """Dynamic stiffness (6, 6) of a bar in the axes of the plane, and the factor that its poles are roots of."""
    d = np.subtract(end, start)
    l = float(np.hypot(*d))
    c, s = d / l
    EI, EA, m = YOUNG * WIDTH * height**3 / 12.0, YOUNG * WIDTH * height, DENSITY * WIDTH * height
    x, mu = l * (m * omega**2 / EI) ** 0.25, omega * l * math.sqrt(m / EA)
    sn, cs, sh, ch = math.sin(x), math.cos(x), math.sinh(x), math.cosh(x)
    pole = 1.0 - cs * ch
    b = EI / l**3 / pole
    k = np.zeros((6, 6))
    k[np.ix_([0, 3], [0, 3])] = EA / l * mu / math.sin(mu) * np.array([[math.cos(mu), -1.0], [-1.0, math.cos(mu)]])
    f1, f2, f3 = b * x**3 * (sn * ch + cs * sh), b * l * x**2 * sn * sh, -b * x**3 * (sn + sh)
    f4, f5, f6 = b * l * x**2 * (ch - cs), b * l**2 * x * (sn * ch - cs * sh), b * l**2 * x * (sh - sn)
    k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = [[f1, f2, f3, f4], [f2, f5, -f4, f6], [f3, -f4, f1, -f2], [f4, f6, -f2, f5]]
    T = np.kron(np.eye(2), [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return T.T @ k @ T, pole / ch * math.sin(mu)


def determinant(omega):
    """Determinant without its poles, scaled."""
    K, factor = np.zeros((12, 12)), 1.0
    for k, height in enumerate(HEIGHTS):
        part, pole = bar(omega, POINTS[k], POINTS[k + 1], height)
        K[3 * k : 3 * k + 6, 3 * k : 3 * k + 6] += part
        factor *= pole
    sign, size = np.linalg.slogdet(K[3:9, 3:9])
    return sign * factor * math.exp(size - 90.0)


def exact(count):
    """The lowest frequencies [Hz]."""
    grid = 2.0 * math.pi * np.arange(3.0, 600.0, 0.5)
    values = [determinant(w) for w in grid]
    found = [
        brentq(determinant, a, b, xtol=1e-12, rtol=1e-14)
        for a, b, fa, fb in zip(grid, grid[1:], values, values[1:], strict=False)
        if fa * fb < 0.0
    ]
    return np.array(found[:count]) / (2.0 * math.pi)


def ours(elements, count):
    return fm.modes(portal(elements), count=count).frequencies


@PROBLEM.case("8 elements a bar")
def eight():
    for n, (reference, found) in enumerate(zip(exact(2), ours(8, 2), strict=True), 1):
        yield Value(f"frequency {n} [Hz]", reference, found, 1e-4)


@PROBLEM.case("24 elements a bar")
def many():
    for n, (reference, found) in enumerate(zip(exact(6), ours(24, 6), strict=True), 1):
        yield Value(f"frequency {n} [Hz]", reference, found, 1e-4)


@PROBLEM.convergence("portal-frame", "Frequencies of a clamped portal", "element length / bar", "relative error")
def convergence():
    counts, references = (2, 4, 8), exact(2)
    errors = np.array([np.abs(ours(n, 2) / references - 1.0) for n in counts])
    for n in range(2):
        yield Curve(
            f"frequency {n + 1}", [1.0 / c for c in counts], list(errors[:, n]), 4.0, 0.3
        )  # the axial part, of second order, begins to show


test_case, test_curves = PROBLEM.tests()
