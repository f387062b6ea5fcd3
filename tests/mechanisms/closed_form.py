"""The ideal nine-bar mechanism by hand: complex loop equations, eq. (12), eq. (13), torques by virtual power.

Nothing here comes from the package: the links are directions exp(i theta), the angles follow from the law of cosines,
and their rates from the differentiated loop equations.  Angles: theta2 from P1 to B, theta3 from P4 to B, theta6 from
O6 to A, theta7 from A to B, theta8 from C to S; beta12 and beta lead from AB to AC and to the panel's centre of mass.
Numbers: tables 1-3 of the paper as docs/nine_bar.md reconstructs them.
"""

from typing import NamedTuple

import numpy as np

L1, L2, L3, L4, L6, L8 = 0.045, 0.326, 0.497, 0.095, 0.230, 0.336
L71, L72, L73 = 0.229, 0.304, 0.315
O4, O6, LINE = 0.430j, -0.580 + 0.190j, 0.090
M1, M2, M3, M4, M6, M7, M8, M9 = 0.148, 0.805, 0.603, 0.265, 0.581, 4.334, 0.827, 0.801
J1, J2, J3, J4, J6, J7, J8 = 2.382e-4, 8.001e-3, 1.337e-2, 1.210e-3, 1.212e-2, 3.802e-2, 8.663e-3
LS71, GRAVITY = 0.147, 9.81

BETA12 = -np.arccos((L71**2 + L72**2 - L73**2) / (2 * L71 * L72))  # C lies to the right of AB
BETA = np.angle(L71 + L72 * np.exp(1j * BETA12))


class Angles(NamedTuple):
    """(n,) each: angles of the links, or their first or second derivatives, and X of the slider or its derivatives."""

    t1: np.ndarray
    t2: np.ndarray
    t3: np.ndarray
    t4: np.ndarray
    t6: np.ndarray
    t7: np.ndarray
    t8: np.ndarray
    s9: np.ndarray


def e(angle):
    return np.exp(1j * angle)


def triangle(base, a, b):
    """Angle at the first end of `base` between it and the side a, when b is the third side."""
    c = np.abs(base)
    return np.arccos((a * a + c * c - b * b) / (2 * a * c))


def positions(t1, t4) -> Angles:
    P1, P4 = L1 * e(t1), O4 + L4 * e(t4)
    t2 = np.angle(P4 - P1) + triangle(P4 - P1, L2, L3)
    B = P1 + L2 * e(t2)
    t3 = np.angle(B - P4)
    t6 = np.angle(B - O6) + triangle(B - O6, L6, L71)
    A = O6 + L6 * e(t6)
    t7 = np.angle(B - A)
    C = A + L72 * e(t7 + BETA12)
    t8 = np.pi - np.arcsin((LINE - C.imag) / L8)
    return Angles(t1, t2, t3, t4, t6, t7, t8, (C + L8 * e(t8)).real)


def two(u, w, z):
    """Real x, y with x u + y w = z."""
    down = (np.conj(w) * u).imag
    return (np.conj(w) * z).imag / down, (np.conj(u) * z).imag / -down


def _chain(q, w1, w4, extra):
    """Rates of all angles from those of the cranks; `extra` are the known terms of each loop (0 for rates)."""
    u = [1j * length * e(t) for length, t in ((L1, q.t1), (L2, q.t2), (L3, q.t3), (L4, q.t4), (L6, q.t6), (L71, q.t7))]
    w2, w3 = two(u[1], -u[2], w4 * u[3] - w1 * u[0] + extra[0])
    w6, w7 = two(u[4], u[5], w1 * u[0] + w2 * u[1] + extra[1])
    c = w6 * u[4] + w7 * 1j * L72 * e(q.t7 + BETA12) + extra[2]
    w8 = -(c.imag + extra[3].imag) / (L8 * np.cos(q.t8))
    s9 = (c + w8 * 1j * L8 * e(q.t8) + extra[3]).real
    return Angles(w1, w2, w3, w4, w6, w7, w8, s9)


def rates(q, w1, w4) -> Angles:
    return _chain(q, w1, w4, [0j * q.t1] * 4)


def accelerations(q, w) -> Angles:
    """Second derivatives for cranks at constant speed."""
    d1, d2, d3, d4, d6, d7 = (
        -(rate**2) * length * e(t)
        for length, t, rate in (
            (L1, q.t1, w.t1), (L2, q.t2, w.t2), (L3, q.t3, w.t3), (L4, q.t4, w.t4), (L6, q.t6, w.t6), (L71, q.t7, w.t7)
        )
    )  # fmt: skip
    to_c = d6 - w.t7**2 * L72 * e(q.t7 + BETA12)
    zero = 0.0 * q.t1
    return _chain(q, zero, zero, [d4 + d3 - d1 - d2, d1 + d2 - d6 - d7, to_c, -(w.t8**2) * L8 * e(q.t8)])


def kinetic_energy(q, w):
    """Eq. (12) for x = y = 0, with Ls2^2 in J22 (the paper prints L3^2)."""
    ls2, ls3, ls8 = L2 / 2, L3 / 2, L8 / 2
    J11, J22, J33, J44 = J1 + M2 * L1**2, J2 + M2 * ls2**2, J3 + M3 * ls3**2, J4 + M3 * L4**2
    J55, J66, J77 = J6 + (M7 + M8) * L6**2, J7 + M7 * LS71**2 + M8 * L72**2, J8 + M8 * ls8**2
    squares = J11 * w.t1**2 + J22 * w.t2**2 + J33 * w.t3**2 + J44 * w.t4**2
    squares = squares + J55 * w.t6**2 + J66 * w.t7**2 + J77 * w.t8**2 + M9 * w.s9**2
    return (
        0.5 * squares
        + M2 * L1 * ls2 * np.cos(q.t1 - q.t2) * w.t1 * w.t2
        + M3 * L4 * ls3 * np.cos(q.t3 - q.t4) * w.t3 * w.t4
        + M7 * L6 * LS71 * np.cos(q.t6 - q.t7 - BETA) * w.t6 * w.t7
        + M8 * L6 * L72 * np.cos(q.t6 - q.t7 - BETA12) * w.t6 * w.t7
        + M8 * L6 * ls8 * np.cos(q.t6 - q.t8) * w.t6 * w.t8
        + M8 * L72 * ls8 * np.cos(q.t7 + BETA12 - q.t8) * w.t7 * w.t8
    )


MASSES = (M1, M2, M3, M4, M6, M7, M8, M9)
CENTRAL_INERTIAS = (J1 - M1 * (L1 / 2) ** 2, J2, J3, J4 - M4 * (L4 / 2) ** 2, J6 - M6 * (L6 / 2) ** 2, J7, J8, 0.0)


def terms(q):
    """Each centre of mass as a sum of arms: constant, then (length, angle, name of the angle)."""
    to_a, to_c = (L6, q.t6, "t6"), (L72, q.t7 + BETA12, "t7")
    return [
        (0.0, [(L1 / 2, q.t1, "t1")]),
        (0.0, [(L1, q.t1, "t1"), (L2 / 2, q.t2, "t2")]),
        (O4, [(L4, q.t4, "t4"), (L3 / 2, q.t3, "t3")]),
        (O4, [(L4 / 2, q.t4, "t4")]),
        (O6, [(L6 / 2, q.t6, "t6")]),
        (O6, [to_a, (LS71, q.t7 + BETA, "t7")]),
        (O6, [to_a, to_c, (L8 / 2, q.t8, "t8")]),
        (O6, [to_a, to_c, (L8, q.t8, "t8")]),
    ]


def potential_energy(q):
    """Eq. (13)."""
    centres = [origin + sum(length * e(angle) for length, angle, _ in arms) for origin, arms in terms(q)]
    return GRAVITY * sum(m * c.real for m, c in zip(MASSES, centres, strict=True))


def torques(q, w, a):
    """(M1, M4) by virtual power: inertia and weight on the velocities of unit rates of one crank each."""
    found = []
    zero, one = 0.0 * q.t1, 0.0 * q.t1 + 1.0
    names = ("t1", "t2", "t3", "t4", "t6", "t7", "t8", None)
    for unit in (rates(q, one, zero), rates(q, zero, one)):
        power = 0.0
        for m, J, name, (_, arms) in zip(MASSES, CENTRAL_INERTIAS, names, terms(q), strict=True):
            partial = sum(1j * length * e(angle) * getattr(unit, n) for length, angle, n in arms)
            acceleration = sum(
                (1j * getattr(a, n) - getattr(w, n) ** 2) * length * e(angle) for length, angle, n in arms
            )
            power = power + m * (np.conj(partial) * (acceleration + GRAVITY)).real
            if name is not None:
                power = power + J * getattr(a, name) * getattr(unit, name)
        found.append(power)
    return found
