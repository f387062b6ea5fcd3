"""Two curves of two bodies on their common normal: distance, rows of constraints, output of gap kernels.

c1 and c2 = c1 + distance n are the points of both curves, n the outward normal of the first one, t = k x n.  A curve
has the curvature b/a there (1/0: a point, 0/1: a line).  With tau = t . (u2 - u1) of the velocities u of the material
points, the normal turns by dphi and the points travel by ds1, ds2 along their curves, each counter-clockwise:
    dphi (a1 b2 + a2 b1 + b1 b2 distance) = b1 b2 tau + a1 b2 dtheta1 + a2 b1 dtheta2
    ds1  (...) = a1 (b2 tau + a2 (dtheta2 - dtheta1) - b2 distance dtheta1),   ds2 = tau - ds1 - distance dphi
Source: to second order a curve is its circle of curvature; the equations are those of its rolling and sliding (J. J.
Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., 2011, on Euler-Savary and cams).
"""

from flexmb.joints.contact_point import put_column, put_eccentricity, put_point
from flexmb.kernels import compiled
from flexmb.places import LOAD, LOAD_BY_LAM, SLIDING


@compiled
def unit_motion(j, r1x, r1y, r2x, r2y):
    """Velocities u1, u2 of the material points at c1, c2 and of both angles, for a unit velocity of coordinate j."""
    if j == 0:
        return 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if j == 1:
        return 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    if j == 2:
        return -r1y, r1x, 0.0, 0.0, 1.0, 0.0
    if j == 3:
        return 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    if j == 4:
        return 0.0, 0.0, 0.0, 1.0, 0.0, 0.0
    return 0.0, 0.0, -r2y, r2x, 0.0, 1.0


@compiled
def travel(tau, w1, w2, distance, a1, b1, a2, b2):
    """Turn of the normal, and travel of both points along their curves; no turn where any normal would do."""
    scale = a1 * b2 + a2 * b1 + b1 * b2 * distance
    over = 1.0 / scale if scale != 0.0 else 0.0
    turn = over * (b1 * b2 * tau + a1 * b2 * w1 + a2 * b1 * w2)
    first = over * a1 * (b2 * tau + a2 * (w2 - w1) - b2 * distance * w1)
    return turn, first, tau - first - distance * turn


@compiled
def row(x, y, r1x, r1y, r2x, r2y):
    """Velocity of c2 less that of c1 along (x, y), by the six coordinates."""
    return -x, -y, x * r1y - y * r1x, x, y, y * r2x - x * r2y


@compiled
def row_change(x, y, px, py, r1x, r1y, r2x, r2y, x1, y1, x2, y2):
    """Derivative of `row`, for derivatives (px, py) of the direction, (x1, y1) and (x2, y2) of the arms."""
    return (
        -px,
        -py,
        px * r1y - py * r1x + x * y1 - y * x1,
        px,
        py,
        py * r2x - px * r2y + y * x2 - x * y2,
    )


@compiled
def with_arms(q, X, Y, nx, ny, distance, a1, b1, a2, b2):
    """All numbers of a pair: c1, normal, distance, curvatures, arms from both nodes to c1 and c2."""
    r2x, r2y = X + distance * nx - q[3], Y + distance * ny - q[4]
    return X, Y, nx, ny, distance, a1, b1, a2, b2, X - q[0], Y - q[1], r2x, r2y


@compiled
def second_speed(pair, v):
    """Velocity of the second body along the normal at c2."""
    _, _, nx, ny, _, _, _, _, _, _, _, r2x, r2y = pair
    return nx * (v[3] - v[5] * r2y) + ny * (v[4] + v[5] * r2x)


@compiled
def put_equation(pair, v, lam, g, G, gamma, H):
    """Equation distance = 0 of a constraint kernel."""
    _, _, nx, ny, distance, a1, b1, a2, b2, r1x, r1y, r2x, r2y = pair
    g[0] = distance
    J = row(nx, ny, r1x, r1y, r2x, r2y)
    total = 0.0
    for j in range(6):
        G[0, j] = J[j]
        u1x, u1y, u2x, u2y, w1, w2 = unit_motion(j, r1x, r1y, r2x, r2y)
        tau = -ny * (u2x - u1x) + nx * (u2y - u1y)
        turn, first, second = travel(tau, w1, w2, distance, a1, b1, a2, b2)
        x1, y1 = -first * ny - w1 * r1y, first * nx + w1 * r1x
        x2, y2 = second * ny - w2 * r2y, -second * nx + w2 * r2x
        change = row_change(nx, ny, -turn * ny, turn * nx, r1x, r1y, r2x, r2y, x1, y1, x2, y2)
        for i in range(6):
            H[i, j] = lam[0] * change[i]
            total += v[i] * change[i] * v[j]
    gamma[0] = -total


@compiled
def middle_change(j, pair):
    """Derivatives of the middle between c1 and c2 by coordinate j, and turn of the normal."""
    _, _, nx, ny, distance, a1, b1, a2, b2, r1x, r1y, r2x, r2y = pair
    u1x, u1y, u2x, u2y, w1, w2 = unit_motion(j, r1x, r1y, r2x, r2y)
    tau = -ny * (u2x - u1x) + nx * (u2y - u1y)
    turn, first, _ = travel(tau, w1, w2, distance, a1, b1, a2, b2)
    along, across = 0.5 * (nx * (u2x - u1x) + ny * (u2y - u1y)), first + 0.5 * distance * turn
    return u1x + along * nx - across * ny, u1y + along * ny + across * nx, turn


@compiled
def put_sliding(pair, lam, out, H):
    """Output of a joint-friction kernel: load |lam|, and sliding at the middle between c1 and c2."""
    _, _, nx, ny, distance, _, _, _, _, r1x, r1y, r2x, r2y = pair
    half = 0.5 * distance
    r1x, r1y, r2x, r2y = r1x + half * nx, r1y + half * ny, r2x - half * nx, r2y - half * ny
    out[LOAD] = abs(lam[0])
    out[LOAD_BY_LAM] = 1.0 if lam[0] > 0.0 else (-1.0 if lam[0] < 0.0 else 0.0)
    J = row(-ny, nx, r1x, r1y, r2x, r2y)
    for j in range(6):
        out[SLIDING + j] = J[j]
        X, Y, turn = middle_change(j, pair)
        x1, y1 = X - (1.0 if j == 0 else 0.0), Y - (1.0 if j == 1 else 0.0)
        x2, y2 = X - (1.0 if j == 3 else 0.0), Y - (1.0 if j == 4 else 0.0)
        change = row_change(-ny, nx, -turn * nx, -turn * ny, r1x, r1y, r2x, r2y, x1, y1, x2, y2)
        for i in range(6):
            H[i, j] = change[i]


@compiled
def put_gap(pair, q, v, out):
    """Output of a gap kernel; the contact point lies in the middle between c1 and c2."""
    X, Y, nx, ny, distance, _, _, _, _, r1x, r1y, r2x, r2y = pair
    half = 0.5 * distance
    put_point(out, q, v, distance, -nx, -ny, X + half * nx, Y + half * ny)
    J = row(nx, ny, r1x, r1y, r2x, r2y)
    rate, spin = 0.0, 0.0
    for j in range(6):
        Xq, Yq, turn = middle_change(j, pair)
        put_column(out, j, turn * ny, -turn * nx, Xq, Yq)
        rate += J[j] * v[j]
        spin += turn * v[j]
    put_eccentricity(
        out,
        distance * nx,
        distance * ny,
        rate * nx - distance * spin * ny,
        rate * ny + distance * spin * nx,
    )
