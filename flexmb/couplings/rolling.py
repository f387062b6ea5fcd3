"""Wheels that roll on one another or are tied by a belt: kernels on the line of their centres.

With the length D and direction phi of the line from the first centre to the second, and R = r1 + r2 (r2 < 0: a ring
with inner teeth, or an open belt):
    g = r1 theta1 + r2 theta2 - R phi - value
The ratio is exact for any D.  The multiplier is the force F at the radii r1 and r2.  Its gradient is the couple r1 F
and r2 F, and F R/D across the line of centres on the first wheel and against it on the second: balanced for any D.
Teeth and strands push or pull along the line as well, by |F| w(D) in either direction of F.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb.couplings.distance import FIRST_ANGLE, SECOND_ANGLE, add_bending, line_between
from flexmb.couplings.tooth_contact import STEEPEST
from flexmb.joints.direction import add_curvature, direction, dot
from flexmb.kernels import compiled, constraint_kernel, friction_law, joint_friction_kernel
from flexmb.model.law import FrictionLaw
from flexmb.places import LOAD, LOAD_BY_LAM, SLIDING

STANDARD_PRESSURE_ANGLE = math.radians(20.0)
"""Pressure angle of standard gears [rad] (ISO 53)."""

ARM = 6
"""Place of the arm's angle among the coordinates, where it is the last one; it says which turn phi is in."""


@constraint_kernel
def rolling_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = r1 theta1 + r2 theta2 - R phi - value; phi within half a turn of the arm's angle plus `drawn`.

    Equations (13.1) and (13.2) of docs/theory/wheels.md.
    """
    r1, r2, s1x, s1y, s2x, s2y, drawn, value = p
    D, ex, ey, along, across = line_between(s1x, s1y, s2x, s2y, q)
    R, expected = r1 + r2, drawn
    if q.shape[0] > ARM:
        expected += q[ARM]
    beyond = math.atan2(ey, ex) - expected
    phi = expected + beyond - 2.0 * math.pi * math.floor(beyond / (2.0 * math.pi) + 0.5)
    g[0] = r1 * q[2] + r2 * q[5] - R * phi - value
    for i in range(6):
        G[0, i] = -R * across[i] / D
    G[0, 2] += r1
    G[0, 5] += r2
    swing = along[FIRST_ANGLE] * v[2] * v[2] + along[SECOND_ANGLE] * v[5] * v[5]
    gamma[0] = R * (swing - 2.0 * dot(along, v) * dot(across, v) / D) / D
    k = lam[0] * R / D
    for i in range(6):
        for j in range(6):
            H[i, j] = k * (along[i] * across[j] + across[i] * along[j]) / D
    H[2, 2] -= k * along[FIRST_ANGLE]
    H[5, 5] -= k * along[SECOND_ANGLE]


@compiled
def put_along(w, slope, D, along, across, out, H):
    """Direction w dD/dq of a force along the line of centres, and its derivatives; slope = dw/dD.

    Equation (13.3) of docs/theory/wheels.md.
    """
    for i in range(6):
        out[SLIDING + i] = w * along[i]
        for j in range(6):
            H[i, j] = slope * along[i] * along[j]
    add_bending(w, D, across, H)


@compiled
def put_size(force, share, least, out):
    """Load: share of |force|, at least `least`."""
    out[LOAD] = max(share * abs(force), least)
    if out[LOAD] > least:
        out[LOAD_BY_LAM] = math.copysign(share, force)


@joint_friction_kernel
def tooth_pressure(p, q, lam, out, H):
    """Teeth part the wheels by |F| w, w = R tan(alpha)/D, cos alpha = base/D; R < 0: a ring draws its wheel inwards."""
    s1x, s1y, s2x, s2y, R, base = p
    D, _, _, along, across = line_between(s1x, s1y, s2x, s2y, q)
    cos_a = min(base / D, STEEPEST)
    square = 1.0 / (cos_a * cos_a) - 1.0  # of tan alpha
    w = R * math.sqrt(square) / D
    put_size(lam[0], 1.0, 0.0, out)
    put_along(w, w / (D * square) if base < STEEPEST * D else -w / D, D, along, across, out, H)


@joint_friction_kernel
def strand_pull(p, q, lam, out, H):
    """Both strands pull with the mean tension, |F|/2 or the pretension: w = -dL/dD = -2 sqrt(1 - (R/D)^2)."""
    s1x, s1y, s2x, s2y, R, pretension = p
    D, _, _, along, across = line_between(s1x, s1y, s2x, s2y, q)
    root = math.sqrt(max(1.0 - R * R / (D * D), 0.0))
    put_size(lam[0], 0.5, pretension, out)
    put_along(-2.0 * root, -2.0 * R * R / (D * D * D * root) if root > 0.0 else 0.0, D, along, across, out, H)


@joint_friction_kernel
def rack_pressure(p, q, lam, out, H):
    """Teeth push the pinion off its rack by |F| tan(alpha), along n of the rack."""
    nx, ny, s1x, s1y, s2x, s2y, tan_a = p
    _, J, mx, my, far, near = direction(nx, ny, s1x, s1y, s2x, s2y, q)
    put_size(lam[0], 1.0, 0.0, out)
    for i in range(6):
        out[SLIDING + i] = tan_a * J[i]
    add_curvature(tan_a, mx, my, far, near, H)


@friction_law
def push_kernel(p, h, slip, N, z, z_new):
    """T = N in the given direction, whatever slides."""
    return N, 0.0, 1.0


@dataclass(frozen=True)
class Push(FrictionLaw):
    """Force in the direction of "sliding" as large as the load: a reaction that depends on a multiplier."""

    kernel = push_kernel
