"""Kernels of a journal in an oil film: forces, exact tangents, power, signals; x, y, theta of both bodies.

Forces follow from the power F.u - T w, with the rates u = B v of the journal's centre beside the mean spin, and w of
the journal against the bearing: r = -B^T F + T dw/dv.  So action equals reaction, moments included.

Equations (15.5) and (15.7) of docs/theory/films.md.
"""

import math

from flexmb import kernels
from flexmb.model.massless import massless
from flexmb.parts.bearings import film
from flexmb.parts.joints.contact_point import arms_of

# Parameters p: kind and extent of the film, clearance, height of the roughness; scales of force [N s], moment [N m s],
# pressure [Pa s] and flow [m^3]; points in the frames of their nodes; number of the signal.
KIND, EXTENT, CLEARANCE, HEIGHT, FORCE, DRAG, PRESSURE, FLOW = range(8)
OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, CHOSEN = range(8, 13)

# Least film between surfaces pressed into each other, over the height of the roughness: oil left in its valleys.
KEPT = 0.5


@kernels.compiled
def relative(p, q, v):
    """Arms of both points, eccentricity, rates u beside the mean spin, the spin; size and direction n of the former."""
    ax, ay, bx, by, ex, ey = arms_of(p[OFFSET1_X], p[OFFSET1_Y], p[OFFSET2_X], p[OFFSET2_Y], q)
    spin = 0.5 * (v[2] + v[5])
    ux, uy = v[3] - by * v[5] - v[0] + ay * v[2] + spin * ey, v[4] + bx * v[5] - v[1] - ax * v[2] - spin * ex
    size = math.sqrt(ex * ex + ey * ey)
    nx, ny = (ex / size, ey / size) if size > 0.0 else (1.0, 0.0)  # along x without an eccentricity
    return ax, ay, bx, by, ex, ey, ux, uy, spin, size, nx, ny


@kernels.compiled
def thickness(h, height):
    """Thickness of the film at a gap h and its derivative; below the roughness `height` it nears `KEPT` of it."""
    if h >= height:
        return h, 1.0
    least = KEPT * height
    fall = math.exp((h - height) / (height - least))
    return least + (height - least) * fall, fall


@kernels.compiled
def eccentricity(p, size):
    """Eccentricity over the clearance and its derivative; a film thinner than the roughness nears `KEPT` of it."""
    c = p[CLEARANCE]
    h, fall = thickness(c - size, p[HEIGHT])
    return size / c if c - size >= p[HEIGHT] else 1.0 - h / c, fall / c


@kernels.compiled
def force(p, turn, size, nx, ny, ux, uy):
    """Force on the journal along n and t, derivatives by the eccentricity, a and b; a and b; derivatives by `turn`."""
    # `turn`: angle of the bearing, which counts where the oil comes from grooves.
    c, S = p[CLEARANCE], p[FORCE]
    eps, eps_e = eccentricity(p, size)
    a, b = (nx * ux + ny * uy) / c, (ny * ux - nx * uy) / c
    Fr_w, Ft_w = 0.0, 0.0
    if p[KIND] == film.PADS:
        widest = math.atan2(-ny, -nx) - turn
        Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b, Fr_w, Ft_w = film.pads_force(p, eps, a, b, widest)
    elif p[KIND] == film.TABLE:
        Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b = film.table_force(p, eps, a, b)
    else:
        Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b = film.film_force(p[KIND], p[EXTENT], eps, a, b)
    Fr_e, Ft_e = eps_e * Fr_e, eps_e * Ft_e
    return S * Fr, S * Ft, S * Fr_e, S * Ft_e, S * Fr_a, S * Fr_b, S * Ft_a, S * Ft_b, a, b, -S * Fr_w, -S * Ft_w


@kernels.compiled
def mean_force(p, turn, size, nx, ny, x, y):
    """Mean of the force at the rates (x, y) and of minus that at the opposite ones, for a journal at rest."""
    Fx, Fy = 0.0, 0.0
    for sign in (0.5, -0.5):
        Fr, Ft, _, _, _, _, _, _, _, _, _, _ = force(p, turn, size, nx, ny, 2.0 * sign * x, 2.0 * sign * y)
        Fx, Fy = Fx + sign * (Fr * nx - Ft * ny), Fy + sign * (Fr * ny + Ft * nx)
    return Fx, Fy


@kernels.compiled
def turned(nx, ny, nn, nt, tn, tt):
    """Components xx, xy, yx, yy of a matrix given along n and t."""
    return (
        nx * nx * nn - nx * ny * (nt + tn) + ny * ny * tt,
        nx * ny * (nn - tt) + nx * nx * nt - ny * ny * tn,
        nx * ny * (nn - tt) + nx * nx * tn - ny * ny * nt,
        ny * ny * nn + nx * ny * (nt + tn) + nx * nx * tt,
    )


@kernels.compiled
def drag(p, size):
    """Moment of the film over the spin of the journal against the bearing, and its derivative by the eccentricity."""
    eps, eps_e = eccentricity(p, size)
    f = 1.0 / math.sqrt(1.0 - eps * eps)
    return p[DRAG] * f, p[DRAG] * eps * f * f * f * eps_e


@kernels.compiled
def put_residual(ax, ay, bx, by, ex, ey, Fx, Fy, T, r):
    """r (6,) for the force on the journal and the viscous moment T against its spin."""
    half = 0.5 * (ex * Fy - ey * Fx)
    r[0], r[1], r[2] = Fx, Fy, ax * Fy - ay * Fx + half - T
    r[3], r[4], r[5] = -Fx, -Fy, by * Fx - bx * Fy + half + T


@kernels.compiled
def put_force(p, q, v, r):
    """r (6,) alone; energies, of which the film has the power that it takes."""
    ax, ay, bx, by, ex, ey, ux, uy, _, size, nx, ny = relative(p, q, v)
    Fr, Ft, _, _, _, _, _, _, a, b, _, _ = force(p, q[2], size, nx, ny, ux, uy)
    viscous, _ = drag(p, size)
    w = v[5] - v[2]
    put_residual(ax, ay, bx, by, ex, ey, Fr * nx - Ft * ny, Fr * ny + Ft * nx, viscous * w, r)
    return 0.0, 0.0, viscous * w * w + p[CLEARANCE] * (Ft * b - Fr * a)


@kernels.compiled
def put_tangent(p, q, v, kq, kv, r, A):
    """r (6,), and A += kq dr/dq + kv dr/dv."""
    ax, ay, bx, by, ex, ey, ux, uy, spin, size, nx, ny = relative(p, q, v)
    Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b, a, b, Fr_w, Ft_w = force(p, q[2], size, nx, ny, ux, uy)
    Fx, Fy, c, w = Fr * nx - Ft * ny, Fr * ny + Ft * nx, p[CLEARANCE], v[5] - v[2]
    viscous, viscous_e = drag(p, size)
    put_residual(ax, ay, bx, by, ex, ey, Fx, Fy, viscous * w, r)
    if size > 0.0:
        Fr_t, Ft_t = (a * Fr_b - b * Fr_a - Ft - Fr_w) / size, (a * Ft_b - b * Ft_a + Fr - Ft_w) / size
    else:  # the force is a linear function of the eccentricity there: its derivative along y, turned into n and t
        _, _, Ft_t, Fr_t, _, _, _, _, _, _, _, _ = force(p, q[2], size, 0.0, 1.0, ux, uy)
        Fr_t = -Fr_t
    Exx, Exy, Eyx, Eyy = turned(nx, ny, Fr_e, Fr_t, Ft_e, Ft_t)
    Dxx, Dxy, Dyx, Dyy = turned(nx, ny, Fr_a / c, -Fr_b / c, Ft_a / c, -Ft_b / c)
    gx, gy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # de/dq
    mean, own = (0.0, 0.0, 0.5, 0.0, 0.0, 0.5), (0.0, 0.0, -1.0, 0.0, 0.0, 1.0)  # mean spin and w by v
    for k in range(6):
        x, y = spin * gy[k], -spin * gx[k]  # du/dq, then rates u by both
        if k == 2:
            x, y = x + ax * v[2], y + ay * v[2]
        elif k == 5:
            x, y = x - bx * v[5], y - by * v[5]
        x, y = kq * x + kv * (gx[k] + ey * mean[k]), kq * y + kv * (gy[k] - ex * mean[k])
        if ux == 0.0 and uy == 0.0:  # at rest, where a film presses on the side to which the journal goes
            Fx_k, Fy_k = mean_force(p, q[2], size, nx, ny, x, y)
        else:
            Fx_k = kq * (Exx * gx[k] + Exy * gy[k]) + Dxx * x + Dxy * y
            Fy_k = kq * (Eyx * gx[k] + Eyy * gy[k]) + Dyx * x + Dyy * y
        if k == 2:
            Fx_k, Fy_k = Fx_k + kq * (Fr_w * nx - Ft_w * ny), Fy_k + kq * (Fr_w * ny + Ft_w * nx)
        T_k = kq * viscous_e * w * (nx * gx[k] + ny * gy[k]) + kv * viscous * own[k]
        for j in range(6):
            A[j, k] -= (gx[j] + ey * mean[j]) * Fx_k + (gy[j] - ex * mean[j]) * Fy_k - own[j] * T_k
        across = 0.5 * kq * (gy[k] * Fx - gx[k] * Fy)
        A[2, k] -= across
        A[5, k] -= across
    A[2, 2] -= kq * (ax * Fx + ay * Fy)
    A[5, 5] += kq * (bx * Fx + by * Fy)


JOURNAL_FILM = massless("JOURNAL_FILM", globals())

THICKNESS, PEAK_PRESSURE, POWER, SIDE_FLOW, ATTITUDE, FILM_FX, FILM_FY, TORQUE = range(8)
# Signals with their units, in the order of `film_signal`.
SIGNALS = (
    ("film_thickness", "m"), ("pressure", "Pa"), ("power", "W"), ("flow", "m3/s"), ("attitude", "rad"),
    ("film_fx", "N"), ("film_fy", "N"), ("film_torque", "N m"),
)  # fmt: skip


@kernels.signal_kernel
def film_signal(p, t, q, v, a):
    """`CHOSEN`: place in `SIGNALS`; forces act on the second body."""
    which = int(p[CHOSEN])
    _, _, _, _, ex, ey, ux, uy, _, size, nx, ny = relative(p, q, v)
    c = p[CLEARANCE]
    if which == THICKNESS:
        return c - size
    squeeze, wedge = (nx * ux + ny * uy) / c, (ny * ux - nx * uy) / c
    eps, _ = eccentricity(p, size)
    if which in (SIDE_FLOW, PEAK_PRESSURE):
        field, scale = (film.SIDE, p[FLOW]) if which == SIDE_FLOW else (film.PEAK, p[PRESSURE])
        if p[KIND] == film.PADS:
            return scale * film.pads_scalar(p, field, eps, squeeze, wedge, math.atan2(-ny, -nx) - q[2])
        if p[KIND] == film.TABLE:
            return scale * film.table_scalar(p, field, eps, squeeze, wedge)
        if which == SIDE_FLOW:
            size = math.sqrt(squeeze * squeeze + wedge * wedge)
            return scale * (0.5 * (size + abs(wedge)) if p[EXTENT] == film.HALF else size)
        return scale * film.film_pressure(p[KIND], eps, squeeze, wedge)
    return of_force(p, which, q[2], ex, ey, ux, uy, size, nx, ny, v[5] - v[2])


@kernels.compiled
def of_force(p, which, turn, ex, ey, ux, uy, size, nx, ny, w):
    """Signal that follows from the force of the film."""
    Fr, Ft, _, _, _, _, _, _, a, b, _, _ = force(p, turn, size, nx, ny, ux, uy)
    viscous, _ = drag(p, size)
    Fx, Fy = Fr * nx - Ft * ny, Fr * ny + Ft * nx
    if which == POWER:
        return viscous * w * w + p[CLEARANCE] * (Ft * b - Fr * a)
    if which == ATTITUDE:
        return math.atan2(Ft, -Fr) if Ft != 0.0 or Fr != 0.0 else 0.0
    if which == TORQUE:
        return -viscous * w - 0.5 * (ex * Fy - ey * Fx)
    return Fx if which == FILM_FX else Fy
