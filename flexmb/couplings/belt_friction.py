"""Friction of a belt on its wheels: Eytelwein's limit, approached smoothly with the speed of slip.

D is the vector from the centre of the first wheel to that of the second, R = r1 + r2 (r2 < 0: an open belt) and psi the
direction of D.  Both strands are tangents of both wheels, with the tensions T0 +- F/2:
    slip s = r1 omega1 + r2 omega2 - R psi_dot,   F = largest tanh(s/creep)
    V = T0 (length of the belt) = 2 T0 (sqrt(D^2 - R^2) + R asin(R/D)) + constant,   r = dV/dq + F ds/dv
"""

from __future__ import annotations

import math

from flexmb.kernels import compiled, element_kernel, energy_kernel, signal_kernel
from flexmb.model.contributions import Contribution, Coordinate, ElementContribution, signal_contributions

SIGNALS = (
    ("force", "N"),
    ("first_torque", "N m"),
    ("second_torque", "N m"),
    ("power", "W"),
    ("slip", "m/s"),
    ("tight_tension", "N"),
    ("slack_tension", "N"),
    ("tension_ratio", "1"),
)
"""Signals with their units, in the order of their numbers."""

FORCE, FIRST_TORQUE, SECOND_TORQUE, POWER, SLIP, TIGHT, SLACK, RATIO = range(len(SIGNALS))


@compiled
def belt_row(r1, r2, q):
    """Derivatives of the slip by the six velocities."""
    dx, dy = q[3] - q[0], q[4] - q[1]
    share = (r1 + r2) / (dx * dx + dy * dy)
    return -share * dy, share * dx, r1, share * dy, -share * dx, r2


@compiled
def slip_of_belt(r1, r2, q, v):
    """Speed of the surface of the first wheel over that of the second one, seen from the line of centres."""
    row, slip = belt_row(r1, r2, q), 0.0
    for i in range(6):
        slip += row[i] * v[i]
    return slip


@compiled
def put_curvature(r1, r2, tension, force, by_slip, q, v, K):
    """Stiffness: change of the strands' directions with the centres, and of the slip."""
    dx, dy = q[3] - q[0], q[4] - q[1]
    vx, vy = v[3] - v[0], v[4] - v[1]
    R, square = r1 + r2, dx * dx + dy * dy
    w = math.sqrt(square - R * R)
    pull = 2.0 * tension * w / square
    steeper = 2.0 * tension * (2.0 * R * R - square) / (w * square * square)
    xx, xy = 2.0 * dx * dy / (square * square), (dy * dy - dx * dx) / (square * square)  # of (-dy, dx)/D^2
    row = belt_row(r1, r2, q)
    by_x, by_y = -R * (xx * vx + xy * vy), -R * (xy * vx - xx * vy)
    for i in range(2):
        for j in range(2):
            own = (dx if i == 0 else dy) * (dx if j == 0 else dy) * steeper + (pull if i == j else 0.0)
            turn = xy if i != j else (xx if i == 0 else -xx)
            own -= force * R * turn
            K[i, j] += own
            K[i + 3, j + 3] += own
            K[i, j + 3] -= own
            K[i + 3, j] -= own
    for i in range(6):
        K[i, 0] -= by_slip * row[i] * by_x
        K[i, 1] -= by_slip * row[i] * by_y
        K[i, 3] += by_slip * row[i] * by_x
        K[i, 4] += by_slip * row[i] * by_y


@element_kernel
def belt_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Forces of both strands on both wheels."""
    largest, creep, tension, r1, r2 = p
    dx, dy = q[3] - q[0], q[4] - q[1]
    R, square = r1 + r2, dx * dx + dy * dy
    share = math.tanh(slip_of_belt(r1, r2, q, v) / creep)
    force, by_slip = largest * share, largest * (1.0 - share * share) / creep
    pull, row = 2.0 * tension * math.sqrt(square - R * R) / square, belt_row(r1, r2, q)
    for i in range(6):
        r[i] = force * row[i]
        for j in range(6):
            C[i, j] = by_slip * row[i] * row[j]
    r[0] -= pull * dx
    r[1] -= pull * dy
    r[3] += pull * dx
    r[4] += pull * dy
    put_curvature(r1, r2, tension, force, by_slip, q, v, K)


@energy_kernel
def belt_energy(p, t, q, v):
    """Tension times length of the belt without its arcs of constant length, and power that slip turns into heat."""
    largest, creep, tension, r1, r2 = p
    dx, dy = q[3] - q[0], q[4] - q[1]
    R, square = r1 + r2, dx * dx + dy * dy
    slip = slip_of_belt(r1, r2, q, v)
    length = 2.0 * (math.sqrt(square - R * R) + R * math.asin(R / math.sqrt(square)))
    return tension * length, 0.0, largest * math.tanh(slip / creep) * slip


@signal_kernel
def belt_signal(p, t, q, v, a):
    """Signals of a belt by their numbers."""
    largest, creep, tension, r1, r2, number = p
    which = int(number)
    slip = slip_of_belt(r1, r2, q, v)
    force = -largest * math.tanh(slip / creep)
    tight, slack = tension + 0.5 * abs(force), tension - 0.5 * abs(force)
    if which >= TIGHT:
        return tight if which == TIGHT else (slack if which == SLACK else tight / slack)
    if which == SLIP:
        return slip
    if which == POWER:
        return r2 * force * v[5]
    return force if which == FORCE else (r1 * force if which == FIRST_TORQUE else r2 * force)


def belt_contributions(
    part: str, coordinates: tuple[Coordinate, ...], radii: tuple[float, float], limits: tuple[float, float, float]
) -> list[Contribution]:
    """Element and signals of a belt with friction."""
    p = (*limits, *radii)
    return [
        ElementContribution(part, belt_kernel, coordinates, p, energy=belt_energy),
        *signal_contributions(part, belt_signal, SIGNALS, coordinates, p),
    ]
