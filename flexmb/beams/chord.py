"""The chord of a beam element: its parameters, its deformation against the chord, and the rates of both.

Equations (2.1) to (2.5), (2.16) and (2.18) of docs/theory/beam.md.
"""

import math

from flexmb.kernels import fast

LENGTH, AXIAL, B11, B12, B22, OFFSET1, OFFSET2, ZETA, GRAVITY_X, GRAVITY_Y = range(10)
M11, M12, M22, G11, G12, G21, G22, H11, H12, H22, J, J1, J2, K11, K12, K22 = range(10, 26)
BOW11, BOW12, BOW22, FREE_LENGTH, FREE1, FREE2, PARAMETERS = range(26, 33)
"""Parameters p: L, ka, kb, offsets, zeta, g, integrals of mass, and the unstressed shape; PARAMETERS is their number.

int rho A of products: M of (1 - xi, xi) with themselves, G of these with (N2, N4), H of (N2, N4) with themselves;
int rho I of products: J of 1 with itself, J1 and J2 of 1 with (psi2, psi4), K of the latter with themselves.
BOW: the shortening of the chord is L/30 (BOW11 u1^2 - BOW12 u1 u2 + BOW22 u2^2), with 2, 1, 2 without shear.
FREE1, FREE2: rotations u1, u2 of the unstressed element; FREE_LENGTH: chord and shortening of the unstressed element.
"""

TURN, REST = 6.28125, 0.0019353071795864769
"""2 pi in two parts: the first times a number of turns below 2^40 is exact."""


@fast
def turned_back(theta, angle):
    """theta - angle in [-pi, pi]; subtracting whole turns first keeps the digits of a crank that turns often."""
    u = theta - angle
    if abs(u) > math.pi:
        turns = math.floor(u / (TURN + REST) + 0.5)
        u = (theta - turns * TURN - angle) - turns * REST
    return u


@fast
def deformation(p, q):
    """Chord (1/l, cos, sin), elongation e and rotations u1, u2 against the chord."""
    dx, dy = q[3] - q[0], q[4] - q[1]
    l = math.sqrt(dx * dx + dy * dy)
    i, alpha = 1.0 / l, math.atan2(dy, dx)
    u1, u2 = turned_back(q[2], alpha - p[OFFSET1]), turned_back(q[5], alpha - p[OFFSET2])
    bow = p[BOW11] * u1 * u1 - p[BOW12] * u1 * u2 + p[BOW22] * u2 * u2
    e = l - p[FREE_LENGTH] + p[LENGTH] / 30.0 * bow
    return i, dx * i, dy * i, e, u1, u2


@fast
def to_chord(c, s, x):
    """The two translations of a nodal vector in the axes of the chord."""
    return c * x[0] + s * x[1], c * x[1] - s * x[0], c * x[3] + s * x[4], c * x[4] - s * x[3]


@fast
def rates(i, v, chord_v):
    """rho, the rate of the chord's length, and the rates of u1 and u2."""
    rho = (chord_v[3] - chord_v[1]) * i
    return rho, chord_v[2] - chord_v[0], v[2] - rho, v[5] - rho


@fast
def second_rates(i, a, chord_a, rho, longer):
    """Rates of rho and of the rates of u1 and u2; `longer`: rate of the chord's length."""
    rho_dot = (chord_a[3] - chord_a[1]) * i - 2.0 * rho * longer * i
    return rho_dot, a[2] - rho_dot, a[5] - rho_dot


@fast
def bowing(p, x1, x2):
    """Gradient (g1, g2) of e by u1 and u2, a linear function of (u1, u2)."""
    twice1, twice2 = 2.0 * p[BOW11], 2.0 * p[BOW22]
    return p[LENGTH] / 30.0 * (twice1 * x1 - p[BOW12] * x2), p[LENGTH] / 30.0 * (twice2 * x2 - p[BOW12] * x1)
