"""A double pendulum of rigid rods as a mechanism and by Lagrange's equations in its two angles."""

import math

import numpy as np
from scipy.integrate import solve_ivp

import flexmb as fm

G = 9.81
UPPER, LOWER = (1.0, 0.8, 0.12), (0.7, 0.5, 0.03)  # length [m], mass [kg], inertia about the middle [kg m^2]
START = (0.3, -0.7)  # directions of the rods against +X [rad]


def pendulum():
    """Two rigid rods, hinged at the origin and to each other."""
    (L1, m1, J1), (L2, m2, J2) = UPPER, LOWER
    knee = (L1 * math.cos(START[0]), L1 * math.sin(START[0]))
    tip = (knee[0] + L2 * math.cos(START[1]), knee[1] + L2 * math.sin(START[1]))
    upper, lower = fm.RigidLink("upper", (0.0, 0.0), knee, m1, J1), fm.RigidLink("lower", knee, tip, m2, J2)
    joints = (fm.Revolute("O", fm.GROUND, upper, (0.0, 0.0)), fm.Revolute("P", upper, lower, knee))
    return fm.Mechanism("pendulum", (upper, lower, *joints), gravity=(0.0, -G))


def rates(t, y):
    """Rates of (a, b, a', b') by Lagrange's equations; directions against +X."""
    a, b, p, q = y
    (L1, m1, J1), (L2, m2, J2) = UPPER, LOWER
    c, s = math.cos(a - b), math.sin(a - b)
    k = m2 * L1 * L2 / 2
    M = np.array([[J1 + m1 * L1**2 / 4 + m2 * L1**2, k * c], [k * c, J2 + m2 * L2**2 / 4]])
    right = [
        -k * s * q * q - (m1 / 2 + m2) * G * L1 * math.cos(a),
        k * s * p * p - m2 * G * L2 / 2 * math.cos(b),
    ]
    return [p, q, *np.linalg.solve(M, right)]


def knee_force(y, alpha):
    """m2 (acceleration of the lower rod's middle + g)."""
    a, b, p, q = y
    (L1, _, _), (L2, m2, _) = UPPER, LOWER
    ax = L1 * (-alpha[0] * math.sin(a) - p * p * math.cos(a)) + L2 / 2 * (-alpha[1] * math.sin(b) - q * q * math.cos(b))
    ay = L1 * (alpha[0] * math.cos(a) - p * p * math.sin(a)) + L2 / 2 * (alpha[1] * math.cos(b) - q * q * math.sin(b))
    return m2 * ax, m2 * (ay + G)


def motion(times):
    """Angles, speeds and force of the knee on the lower rod, each (n, 2), by an explicit method of order 8 at 1e-13."""
    span = (0.0, float(times[-1]))
    y = solve_ivp(rates, span, (*START, 0.0, 0.0), "DOP853", times, rtol=1e-13, atol=1e-13).y.T
    force = np.array([knee_force(state, rates(0.0, state)[2:]) for state in y])
    return y[:, :2], y[:, 2:], force
