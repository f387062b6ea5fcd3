"""Constraint of an averaged pin: it moves with the mean of nodes that stay free to deform (RBE3).

With weights w (sum 1), arms r_k of the nodes from the pin in the mesh, their mean c = sum w r_k and s_k = r_k - c:

    x_pin = sum w x_k - R c,     sum w (R s_k) x x_k = 0

R = R(theta) is the rotation that fits the nodes best in the sense of least squares.  No stiffness is added.
Source: R. D. Cook et al., Concepts and Applications of Finite Element Analysis, 4th ed., Wiley 2002, section 13.2
(constraint equations); the rotation by least squares is Horn's, J. Opt. Soc. Am. A 4 (1987) 629-642, in the plane.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.kernels import constraint_kernel
from flexmb.model.contributions import ConstraintContribution, Coordinate

MEAN_X, MEAN_Y, MOMENT, WEIGHTS = range(4)
"""Parameters p: c, sum w |s|^2 [m^2], then three numbers of every node."""

WEIGHT, ARM_X, ARM_Y, PER_NODE = range(4)
"""Numbers of a node: its weight and s; PER_NODE is their count."""


@constraint_kernel
def averaged_pin_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Pin (x, y, theta) and nodes (x, y) each: two equations of the place [m], one of the rotation [rad]."""
    c, s, spin = math.cos(q[2]), math.sin(q[2]), v[2]
    mx, my = c * p[MEAN_X] - s * p[MEAN_Y], s * p[MEAN_X] + c * p[MEAN_Y]
    g[0], g[1] = q[0] + mx, q[1] + my
    G[0, 0], G[1, 1], G[0, 2], G[1, 2] = 1.0, 1.0, -my, mx
    gamma[0], gamma[1] = spin * spin * mx, spin * spin * my
    cross, dot, dot_rate, unit = 0.0, 0.0, 0.0, 1.0 / p[MOMENT]
    for k in range((q.shape[0] - 3) // 2):
        i, at = 3 + 2 * k, WEIGHTS + PER_NODE * k
        w, x, y = p[at + WEIGHT], p[at + ARM_X], p[at + ARM_Y]
        ax, ay = unit * w * (c * x - s * y), unit * w * (s * x + c * y)
        g[0] -= w * q[i]
        g[1] -= w * q[i + 1]
        cross += ax * q[i + 1] - ay * q[i]
        dot += ax * q[i] + ay * q[i + 1]
        dot_rate += ax * v[i] + ay * v[i + 1]
        G[0, i], G[1, i + 1] = -w, -w
        G[2, i], G[2, i + 1] = -ay, ax
        H[2, i], H[2, i + 1] = -lam[2] * ax, -lam[2] * ay
        H[i, 2], H[i + 1, 2] = -lam[2] * ax, -lam[2] * ay
    g[2], G[2, 2] = cross, -dot
    gamma[2] = spin * (2.0 * dot_rate + spin * cross)
    H[2, 2] = -(lam[0] * mx + lam[1] * my) - lam[2] * cross


def averaged_pin(
    part: str, coordinates: tuple[Coordinate, ...], arms: np.ndarray, weights: np.ndarray
) -> ConstraintContribution:
    """Constraint of a pin, by the coordinates x, y, theta of the pin, then x, y of every node.

    `arms` (n, 2) lead from the pin to its nodes in the mesh [m]; `weights` (n,) of the nodes sum up to 1.
    """
    mean = weights @ arms
    own = arms - mean
    moment = float(weights @ (own**2).sum(axis=1))
    p = [*mean, moment, *np.column_stack([weights, own]).ravel()]
    numbers = tuple(map(float, p))
    return ConstraintContribution(part, averaged_pin_kernel, coordinates, numbers, 3, is_drive=True)
