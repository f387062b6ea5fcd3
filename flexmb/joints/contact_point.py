"""Output of gap kernels: gap, slip and geometry of the contact point (see `flexmb.kernels.GAP_SIZE`)."""

from flexmb.kernels import compiled
from flexmb.places import (
    ARM1_X,
    ARM1_X_Q,
    ARM1_Y,
    ARM1_Y_Q,
    ARM2_X,
    ARM2_X_Q,
    ARM2_Y,
    ARM2_Y_Q,
    ECCENTRICITY_RATE_X,
    ECCENTRICITY_RATE_Y,
    ECCENTRICITY_X,
    ECCENTRICITY_Y,
    GAP,
    GAP_RATE,
    NORMAL_X,
    NORMAL_X_Q,
    NORMAL_Y,
    NORMAL_Y_Q,
    SLIP,
)


@compiled
def put_point(out, q, v, gap, nx, ny, X, Y):
    """Gap, its rate, slip, normal and arms for a contact point (X, Y) of both bodies."""
    r1x, r1y, r2x, r2y = X - q[0], Y - q[1], X - q[3], Y - q[4]
    ux, uy = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    out[GAP], out[GAP_RATE], out[SLIP] = gap, -(nx * ux + ny * uy), nx * uy - ny * ux
    put_arms(out, nx, ny, r1x, r1y, r2x, r2y)


@compiled
def put_arms(out, nx, ny, r1x, r1y, r2x, r2y):
    """Normal, and arms from the nodes to the contact point."""
    out[NORMAL_X], out[NORMAL_Y] = nx, ny
    out[ARM1_X], out[ARM1_Y], out[ARM2_X], out[ARM2_Y] = r1x, r1y, r2x, r2y


@compiled
def put_eccentricity(out, ex, ey, vex, vey):
    """Eccentricity and its rate."""
    out[ECCENTRICITY_X], out[ECCENTRICITY_Y] = ex, ey
    out[ECCENTRICITY_RATE_X], out[ECCENTRICITY_RATE_Y] = vex, vey


@compiled
def put_column(out, j, nqx, nqy, Xq, Yq):
    """Derivatives of normal and arms by coordinate j; (Xq, Yq): derivatives of the contact point."""
    out[NORMAL_X_Q + j], out[NORMAL_Y_Q + j] = nqx, nqy
    out[ARM1_X_Q + j], out[ARM1_Y_Q + j] = Xq - (1.0 if j == 0 else 0.0), Yq - (1.0 if j == 1 else 0.0)
    out[ARM2_X_Q + j], out[ARM2_Y_Q + j] = Xq - (1.0 if j == 3 else 0.0), Yq - (1.0 if j == 4 else 0.0)


@compiled
def difference_column(j, ax, ay, bx, by):
    """Derivatives by coordinate j of the vector from a point of the first node to one of the second, and of the first.

    (ax, ay), (bx, by) : arms of both points.
    """
    if j == 0:
        return -1.0, 0.0, 1.0, 0.0
    if j == 1:
        return 0.0, -1.0, 0.0, 1.0
    if j == 2:
        return ay, -ax, -ay, ax
    if j == 3:
        return 1.0, 0.0, 0.0, 0.0
    if j == 4:
        return 0.0, 1.0, 0.0, 0.0
    return -by, bx, 0.0, 0.0
