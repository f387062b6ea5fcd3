"""Output of gap kernels, distances along a direction, and friction of joints.

d = n . (x2 + R2 s2 - x1 - R1 s1) with n = R1 m.  With e = x2 + R2 s2 - x1, far = n . e and near = n . R2 s2 the second
derivatives stand in `add_curvature`.
"""

import math
from typing import Any

from flexmb import places
from flexmb.errors import InputError
from flexmb.fields import instance
from flexmb.kernels import compiled, joint_friction_kernel
from flexmb.model.law import FrictionLaw


@compiled
def turns_of(q):
    """Cosine and sine of the angles of both nodes."""
    return math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])


@compiled
def arms_of(s1x, s1y, s2x, s2y, q, turns=None):
    """Vectors from the nodes to the points, and from the first point to the second; turns: as of `turns_of`."""
    c1, d1, c2, d2 = turns_of(q) if turns is None else turns
    ax, ay = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    return ax, ay, bx, by, q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay


# Output of gap kernels: gap, slip and geometry of the contact point (see `flexmb.kernels.GAP_SIZE`)
@compiled
def put_point(out, q, v, gap, nx, ny, X, Y):
    """Gap, its rate, slip, normal and arms for a contact point (X, Y) of both bodies."""
    r1x, r1y, r2x, r2y = X - q[0], Y - q[1], X - q[3], Y - q[4]
    ux, uy = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    out[places.GAP], out[places.GAP_RATE], out[places.SLIP] = gap, -(nx * ux + ny * uy), nx * uy - ny * ux
    put_arms(out, nx, ny, r1x, r1y, r2x, r2y)


@compiled
def put_arms(out, nx, ny, r1x, r1y, r2x, r2y):
    """Normal, and arms from the nodes to the contact point."""
    out[places.NORMAL_X], out[places.NORMAL_Y] = nx, ny
    out[places.ARM1_X], out[places.ARM1_Y], out[places.ARM2_X], out[places.ARM2_Y] = r1x, r1y, r2x, r2y


@compiled
def put_eccentricity(out, ex, ey, vex, vey):
    """Eccentricity and its rate."""
    out[places.ECCENTRICITY_X], out[places.ECCENTRICITY_Y] = ex, ey
    out[places.ECCENTRICITY_RATE_X], out[places.ECCENTRICITY_RATE_Y] = vex, vey


@compiled
def put_column(out, j, nqx, nqy, Xq, Yq):
    """Derivatives of normal and arms by coordinate j; (Xq, Yq): derivatives of the contact point."""
    out[places.NORMAL_X_Q + j], out[places.NORMAL_Y_Q + j] = nqx, nqy
    out[places.ARM1_X_Q + j], out[places.ARM1_Y_Q + j] = Xq - (1.0 if j == 0 else 0.0), Yq - (1.0 if j == 1 else 0.0)
    out[places.ARM2_X_Q + j], out[places.ARM2_Y_Q + j] = Xq - (1.0 if j == 3 else 0.0), Yq - (1.0 if j == 4 else 0.0)


@compiled
def put_side_columns(out, nx, ny, bx, by):
    """Columns of a point of the second body, with the arm (bx, by), at a straight side of the first."""
    for j in range(6):
        put_column(out, j, 0.0, 0.0, 0.0, 0.0)
    put_column(out, 2, -ny, nx, 0.0, 0.0)
    put_column(out, 3, 0.0, 0.0, 1.0, 0.0)
    put_column(out, 4, 0.0, 0.0, 0.0, 1.0)
    put_column(out, 5, 0.0, 0.0, -by, bx)


@compiled
def difference_column(j, ax, ay, bx, by):
    """Derivatives by coordinate j of a vector between points with arms (ax, ay), (bx, by), and of its first point."""
    first = (-1.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 1.0), (ay, -ax, -ay, ax)
    second = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (-by, bx, 0.0, 0.0)
    return (first + second)[j]


@compiled
def journal_gap(p, q, v, derivatives, out, turns=None):
    """Journal in a bearing: e = journal centre - bearing centre, gap = c - |e|, normal n = e/|e|."""
    # The contact point lies at R1 + depth/2 from the bearing's centre, so both bodies are pushed at one point.
    # Equations (5.1) and (5.2) of docs/theory/contact.md.
    c, R1, s1x, s1y, s2x, s2y = p
    ax, ay, bx, by, ex, ey = arms_of(s1x, s1y, s2x, s2y, q, turns)
    vex, vey = v[3] - by * v[5] - v[0] + ay * v[2], v[4] + bx * v[5] - v[1] - ax * v[2]
    size = math.sqrt(ex * ex + ey * ey)
    if size > 0.0:
        nx, ny, inverse = ex / size, ey / size, 1.0 / size
    else:
        nx, ny, inverse = 1.0, 0.0, 0.0
    radius = R1 + 0.5 * (size - c)
    r1x, r1y = ax + radius * nx, ay + radius * ny  # from node 1 to the contact point
    r2x, r2y = r1x + q[0] - q[3], r1y + q[1] - q[4]
    out[places.GAP] = c - size
    out[places.GAP_RATE] = -(nx * vex + ny * vey)
    ux, uy = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    out[places.SLIP] = -ny * ux + nx * uy
    put_arms(out, nx, ny, r1x, r1y, r2x, r2y)
    put_eccentricity(out, ex, ey, vex, vey)
    if not derivatives:
        return
    gx, gy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # de/dq
    for j in range(6):
        along, across = nx * gx[j] + ny * gy[j], (nx * gy[j] - ny * gx[j]) * inverse
        nqx, nqy = -ny * across, nx * across
        px, py = radius * nqx + 0.5 * along * nx, radius * nqy + 0.5 * along * ny
        if j < 3:
            px, py = px - gx[j], py - gy[j]
        put_column(out, j, nqx, nqy, px, py)


# Distance of a point of the second node along a direction of the first: value, gradient, second derivatives
@compiled
def direction(mx, my, s1x, s1y, s2x, s2y, q, turns=None):
    """d, its gradient, and n, far, near; turns: as of `turns_of`."""
    c1, d1, c2, d2 = turns_of(q) if turns is None else turns
    nx, ny = c1 * mx - d1 * my, d1 * mx + c1 * my
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    ex, ey = q[3] + bx - q[0], q[4] + by - q[1]
    far = nx * ex + ny * ey
    gradient = (-nx, -ny, nx * ey - ny * ex, nx, ny, ny * bx - nx * by)
    # the part along R1 s1 is constant: n . R1 s1 = m . s1
    return far - mx * s1x - my * s1y, gradient, nx, ny, far, nx * bx + ny * by


@compiled
def put_turn(row, angle, q, g, G):
    """Equation theta2 - theta1 - angle = 0 of a constraint kernel."""
    g[row], G[row, 2] = q[5] - q[2] - angle, -1.0
    G[row, 5] = 1.0


@compiled
def add_curvature(k, nx, ny, far, near, H):
    """H += k d2d/dq2."""
    H[2, 2] -= k * far
    H[5, 5] -= k * near
    H[2, 5] += k * near
    H[5, 2] += k * near
    for i, x in ((0, k * ny), (1, -k * nx), (3, -k * ny), (4, k * nx)):
        H[i, 2] += x
        H[2, i] += x


@compiled
def curvature_times(nx, ny, far, near, v):
    """d2d/dq2 v."""
    w1, w2 = v[2], v[5]
    swing = nx * (v[4] - v[1]) - ny * (v[3] - v[0]) - far * w1 + near * w2
    return ny * w1, -nx * w1, swing, -ny * w1, nx * w1, near * (w1 - w2)


@compiled
def dot(x, y):
    """Scalar product of six numbers."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3] + x[4] * y[4] + x[5] * y[5]


@compiled
def difference(p, q, g, G):
    """Relative rotation of two nodes: g = theta2 - theta1 - angle; q = (theta1, theta2)."""
    (angle,) = p
    g[0], G[0, 0] = q[1] - q[0] - angle, -1.0
    G[0, 1] = 1.0


@compiled
def direction_row(dx, dy, s1x, s1y, s2x, s2y, q, v, lam, row, g, G, gamma, H, turns=None):
    """g = n . (x2 + R2 s2 - x1 - R1 s1), where n = R1 (dx, dy) turns with the first node."""
    g[row], J, nx, ny, far, near = direction(dx, dy, s1x, s1y, s2x, s2y, q, turns)
    for j in range(6):
        G[row, j] = J[j]
    add_curvature(lam[row], nx, ny, far, near, H)
    gamma[row] = -dot(curvature_times(nx, ny, far, near, v), v)


@compiled
def slide(p, q, v, lam, g, G, gamma, H, turns=None):
    """Slider in a guide on the first body: no offset across the guide, no relative rotation."""
    ux, uy, s1x, s1y, s2x, s2y, angle = p
    direction_row(-uy, ux, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H, turns)
    put_turn(1, angle, q, g, G)


@joint_friction_kernel
def journal_friction(p, q, lam, out, H):
    """Pin of radius R: N = |force| + preload, slip = R (omega2 - omega1)."""
    # Equation (1.8) of docs/theory/equations_of_motion.md.
    R, preload = p
    F = math.sqrt(lam[0] * lam[0] + lam[1] * lam[1])
    out[places.LOAD] = F + preload
    if F > 0.0:
        for i in range(2):
            out[places.LOAD_BY_LAM + i] = lam[i] / F
    for theta, arm in ((2, -R), (5, R)):
        out[places.SLIDING + theta] = arm


@joint_friction_kernel
def guide_friction(p, q, lam, out, H):
    """Slider of length l: N = |F/2 + M/l| + |F/2 - M/l| + preload, slip = rate of its travel."""
    # Equation (1.9) of docs/theory/equations_of_motion.md.
    ux, uy, s1x, s1y, s2x, s2y, length, preload = p
    across, couple = abs(lam[0]), 2.0 * abs(lam[1]) / length
    if across >= couple:
        row, load, by_lam = 0, across, 1.0 if lam[0] > 0.0 else (-1.0 if lam[0] < 0.0 else 0.0)
    else:
        row, load, by_lam = 1, couple, math.copysign(2.0 / length, lam[1])
    out[places.LOAD] = load + preload
    out[places.LOAD_BY_LAM + row] = by_lam
    _, J, nx, ny, far, near = direction(ux, uy, s1x, s1y, s2x, s2y, q)
    for j in range(6):
        out[places.SLIDING + j] = J[j]
    add_curvature(1.0, nx, ny, far, near, H)


# Rule of the friction of an ideal joint.
JOINT_FRICTION = instance(FrictionLaw, "a friction law, e.g. ModifiedCoulomb, or None")


def check_friction(joint: Any, size: str) -> None:
    """Check friction law, `size` of the surfaces and preload: all given, or none."""
    value = getattr(joint, size)
    if joint.friction is None and (value is not None or joint.preload):
        raise InputError(f"{joint.label}: {size} and preload belong to friction; give friction=..., or leave them.")
    if joint.friction is not None and value is None:
        raise InputError(f"{joint.label}: {size} is missing, which friction needs; give {size}=... in m.")
