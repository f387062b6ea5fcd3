"""Force of an oil film between a journal and its bearing: closed forms, tables of the Reynolds equation, pads.

Angles theta count from the widest gap in the direction of positive spin; H = 1 + eps cos(theta) is the thickness over
the clearance c.  With the eccentricity e = c eps n, the mean spin W of both bodies and u = e_dot - W k x e, the rates
are a = u.n/c (squeeze) and b = -u.t/c (wedge).  The pressure of the short and of the long film is f(theta) (k b sin - a
cos) with a positive weight f, so the film is positive between alpha = atan2(a, k b) and alpha + pi, for any squeeze.

Equations (15.1) to (15.6) of docs/theory/films.md.
"""

import math
from functools import lru_cache
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from flexmb.errors import SolveError
from flexmb.kernels import compiled

SHORT, LONG, TABLE, PADS = 0.0, 1.0, 2.0, 3.0  # kinds of films, as parameters of the kernels hold them
TABLE_BEGIN = 13  # number of parameters before those of a table
# Extents of a film: where its pressure is positive; from the widest to the narrowest gap in the sense of the spin
# beside the line of centres, whatever the squeeze; all round.
POSITIVE, HALF, WHOLE = 0.0, 1.0, 2.0


@compiled
def ends_of_sector(eps, alpha):
    """Sommerfeld's angle g at both ends of the positive film: its sine and cosine, and the difference of the angles."""
    s, x, y = math.sqrt(1.0 - eps * eps), math.cos(alpha), math.sin(alpha)
    near, far = 1.0 + eps * x, 1.0 - eps * x
    sin1, cos1, sin2, cos2 = s * y / near, (x + eps) / near, -s * y / far, (eps - x) / far
    turn = math.atan2(sin2, cos2) - math.atan2(sin1, cos1)
    return sin1, cos1, sin2, cos2, turn if turn > 0.0 else turn + 2.0 * math.pi


@compiled
def moments(eps, alpha, whole):
    """Integrals over g of 1, cos, sin, cos^2, sin cos, sin^2, then their derivatives by eps; `whole`: all round."""
    # The ends are fixed in theta: dg/deps = -sin g/(1 - eps^2).
    if whole:
        return 2.0 * math.pi, 0.0, 0.0, math.pi, 0.0, math.pi, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sin1, cos1, sin2, cos2, turn = ends_of_sector(eps, alpha)
    both, r = 0.5 * (sin2 * cos2 - sin1 * cos1), -1.0 / (1.0 - eps * eps)
    return (
        turn, sin2 - sin1, cos1 - cos2, 0.5 * turn + both, 0.5 * (sin2 * sin2 - sin1 * sin1), 0.5 * turn - both,
        r * (sin2 - sin1), r * (sin2 * cos2 - sin1 * cos1), r * (sin2 * sin2 - sin1 * sin1),
        r * (sin2 * cos2 * cos2 - sin1 * cos1 * cos1), r * (sin2 * sin2 * cos2 - sin1 * sin1 * cos1),
        r * (sin2 * sin2 * sin2 - sin1 * sin1 * sin1),
    )  # fmt: skip


@compiled
def film_force(kind, extent, eps, a, b):
    """Force over its scale, outwards and along +theta, and derivatives of both by eps, a and b: eight numbers."""
    # The pressure is zero at the ends of a positive film, so their motion adds nothing to first order.
    k, k_e = 1.0, 0.0
    if kind == LONG:
        k = 2.0 / (2.0 + eps * eps)
        k_e = -eps * k * k
    whole, alpha = extent == WHOLE, math.atan2(a if extent == POSITIVE else 0.0, k * b)
    # Integrals of cos^2, sin cos, sin^2 over H^3, and their derivatives by eps
    I, Ic, Is, Icc, Isc, Iss, J, Jc, Js, Jcc, Jsc, Jss = moments(eps, alpha, whole)
    s2 = 1.0 - eps * eps
    s, r = math.sqrt(s2), eps / s2
    f3 = 1.0 / (s2 * s)
    f4, f5 = f3 / s, f3 / s2
    cc, sc, ss = f5 * (Icc - 2.0 * eps * Ic + eps * eps * I), f4 * (Isc - eps * Is), f3 * Iss
    cc_e = 5.0 * r * cc + f5 * (Jcc - 2.0 * eps * Jc + eps * eps * J - 2.0 * Ic + 2.0 * eps * I)
    sc_e, ss_e = 4.0 * r * sc + f4 * (Jsc - eps * Js - Is), 3.0 * r * ss + f3 * Jss
    if kind == LONG:  # of the same times 6 (2 + eps cos) H
        m, n, n_e = 2.0 + eps * eps, 3.0 * eps, 3.0
        plain = f5 * ((1.0 + eps * eps) * Ic - eps * (Icc + I))  # of cos over H^3
        plain_e = 5.0 * r * plain + f5 * ((1.0 + eps * eps) * Jc - eps * (Jcc + J) + 2.0 * eps * Ic - Icc - I)
        # What an integration by parts leaves: (2 + eps cos)/H^2 at both ends times sin cos, cos^2, differences, and
        # their derivatives by eps. Sine and cosine change their signs from one end to the other, so their products are
        # the same.
        e_xy, e_xx, e_xy_e, e_xx_e = 0.0, 0.0, 0.0, 0.0
        if not whole:
            x, y = math.cos(alpha), math.sin(alpha)
            near, far = 1.0 + eps * x, 1.0 - eps * x
            f = (2.0 - eps * x) / (far * far) - (2.0 + eps * x) / (near * near)
            f_e = x * (3.0 - eps * x) / (far * far * far) + x * (3.0 + eps * x) / (near * near * near)
            e_xy, e_xx, e_xy_e, e_xx_e = f * x * y, f * x * x, f_e * x * y, f_e * x * x
        ends = -e_xy_e + 2.0 * eps * cc + m * cc_e + n_e * plain + n * plain_e
        cc, sc, ss = 6.0 * (e_xy + 2.0 * ss), 6.0 * (-e_xx - 2.0 * sc), 6.0 * (-e_xy + m * cc + n * plain)
        cc_e, sc_e, ss_e = 6.0 * (e_xy_e + 2.0 * ss_e), -6.0 * (e_xx_e + 2.0 * sc_e), 6.0 * ends
    Fr, Ft = k * b * sc - a * cc, k * b * ss - a * sc
    Fr_e, Ft_e = k * b * sc_e + k_e * b * sc - a * cc_e, k * b * ss_e + k_e * b * ss - a * sc_e
    return Fr, Ft, Fr_e, Ft_e, -cc, k * sc, -sc, k * ss


# Number of places of the positive film that are compared, and of steps by which the best is refined.
SAMPLES, REFINED = 8, 6


@compiled
def pressure_at(kind, eps, g, x, y):
    """Pressure over its scale at Sommerfeld's angle g, and the sign of its slope; x, y: cosine and sine of alpha."""
    q = 1.0 - eps * math.cos(g)
    cos, sin = (math.cos(g) - eps) / q, math.sqrt(1.0 - eps * eps) * math.sin(g) / q
    H, wave, slope = 1.0 + eps * cos, sin * x - cos * y, cos * x + sin * y
    if kind == LONG:
        return (1.0 + H) / (H * H) * wave, slope * H * (1.0 + H) + eps * sin * (2.0 + H) * wave
    return wave / (H * H * H), slope * H + 3.0 * eps * sin * wave


@compiled
def film_pressure(kind, eps, a, b):
    """Largest pressure over its scale [1/s], by the rule of false position (Illinois) between three samples."""
    k = 2.0 / (2.0 + eps * eps) if kind == LONG else 1.0
    size = math.sqrt(a * a + k * k * b * b)
    if size == 0.0:
        return 0.0
    x, y = k * b / size, a / size
    sin1, cos1, _, _, turn = ends_of_sector(eps, math.atan2(y, x))
    begin, step, best, largest = math.atan2(sin1, cos1), turn / (SAMPLES + 1), 0, -1.0
    for i in range(1, SAMPLES + 1):
        now, _ = pressure_at(kind, eps, begin + i * step, x, y)
        if now > largest:
            best, largest = i, now
    left, right = begin + (best - 1) * step, begin + (best + 1) * step
    _, up = pressure_at(kind, eps, left, x, y)
    _, down = pressure_at(kind, eps, right, x, y)
    side = 0
    for _ in range(REFINED):
        if up <= 0.0 or down >= 0.0:
            break
        middle = (left * down - right * up) / (down - up)
        now, slope = pressure_at(kind, eps, middle, x, y)
        largest = max(largest, now)
        if slope > 0.0:
            left, up, down, side = middle, slope, 0.5 * down if side > 0 else down, 1
        else:
            right, down, up, side = middle, slope, 0.5 * up if side < 0 else up, -1
    return size * largest


def pressures(kind: float, extent: float, eps: float, a: float, b: float, theta: np.ndarray) -> np.ndarray:
    """Pressure over its scale [1/s] in the middle of the width at angles from the widest gap (n,)."""
    H, sin = 1.0 + eps * np.cos(theta), np.sin(theta)
    if kind == LONG:
        p = (1.0 + H) / H**2 * (2.0 * b / (2.0 + eps * eps) * sin - a * np.cos(theta))
    else:
        p = (b * sin - a * np.cos(theta)) / H**3
    if extent == WHOLE:
        return np.asarray(p)
    return np.where(b * sin >= 0.0, p, 0.0) if extent == HALF else np.maximum(p, 0.0)


# Finite film: the Reynolds equation with Reynolds' condition p >= 0, and a table of its forces made before a run
#
# On half of the width, with P = p/(mu (R/c)^2) and Z = z/R,
#     d/dtheta (H^3 dP/dtheta) + H^3 d2P/dZ2 = 12 (a cos(theta) - b sin(theta)) where P > 0,
# a linear complementarity problem. Its forces are homogeneous in (a, b), so with s = sqrt(1 - eps^2) they are a size,
# hypot(a, s b), times a function of the eccentricity and of beta = atan2(a, s b): squeeze counts more in a narrow gap.

CELLS, LAYERS = 96, 12  # number of cells around the bearing and on half of its width
ECCENTRICITIES, ANGLES = 26, 48  # number of values of -log(1 - eps) and of beta in a table
THINNEST = 1e-3  # least film over the clearance in a table
LEVEL = -math.log(THINNEST) / (ECCENTRICITIES - 1)  # step of -log(1 - eps)
ROUND_OFF = 1e-13  # source over the largest one that is none
COARSEST = 12  # number of cells around from which the part of the film with P > 0 is found by itself
MOST_SETS = 60  # number of iterations at most by which the part of the film with P > 0 is found
# Fields of a table: forces outwards and along +theta, largest pressure, flow at the sides.
RADIAL, TANGENTIAL, PEAK, SIDE = range(4)
# Parameters behind those of any film: numbers of coefficients, step of -log(1 - eps), first coefficient.
ROWS, COLUMNS, STEP, FIRST = range(TABLE_BEGIN, TABLE_BEGIN + 4)


class FilmResult(NamedTuple):
    """Results of a finite film at the rates a and b, over their scales."""

    radial: float  # over mu R^3 L/c^2
    tangential: float
    peak: float  # over mu (R/c)^2
    side: float  # over R^2 c/6
    pressure: np.ndarray  # (cells - 1, layers) P at the inner nodes
    angle: np.ndarray  # (cells - 1,) theta of these nodes [rad]


def solve_film(
    eps: float, a: float, b: float, ratio: float, *, from_widest: bool = True, pad: tuple[float, float] | None = None,
    cells: int = CELLS, layers: int = LAYERS, film: np.ndarray | None = None,
) -> FilmResult:  # fmt: skip
    """Film at the rates a and b of a bearing with width over diameter `ratio`."""
    # `from_widest`: the oil is supplied at the widest gap, where p = 0; else it is supplied everywhere, and p = 0 where
    # the gap widens most. `pad`: theta at the begin of the part between two grooves, and its angle; p = 0 at both ends.
    # `film`: where P > 0 is expected. Cells are even in Sommerfeld's angle, so they follow the narrow peak of the
    # pressure, and finer towards the sides.
    s = math.sqrt(1.0 - eps * eps)
    start, span = pad or (0.0 if from_widest else math.atan2(-b, a), 2.0 * math.pi)
    end, less = start + span, eps / (1.0 + s)
    turn = span - 2.0 * math.atan2(less * math.sin(end), 1.0 + less * math.cos(end))
    turn += 2.0 * math.atan2(less * math.sin(start), 1.0 + less * math.cos(start))
    turn = turn if pad else span  # of g: to the last bit for whole turns
    g = math.atan2(s * math.sin(start), math.cos(start) + eps) + np.linspace(0.0, turn, 2 * cells + 1)
    q = 1.0 - eps * np.cos(g)
    cos, sin = (np.cos(g) - eps) / q, s * np.sin(g) / q
    slant = 0.5 * math.pi * np.arange(layers + 1) / layers
    z = ratio * np.sin(slant)
    dz = np.diff(np.concatenate([[0.0], 0.5 * (z[1:] + z[:-1])]))  # widths of the cells about the layers
    resistance = ((1.0 + 0.5 * eps**2) * g - 2.0 * eps * np.sin(g) + 0.25 * eps**2 * np.sin(2.0 * g)) / s**5
    around, faces = 1.0 / np.diff(resistance[::2]), a * sin[1::2] + b * cos[1::2]
    cubed = s**7 * (q[1:-2:2] ** -4 + 4.0 * q[2:-1:2] ** -4 + q[3::2] ** -4) * turn / (6.0 * cells)  # Simpson
    f = -12.0 * np.outer(np.diff(faces), dz)
    # Upper bands of the symmetric matrix of the pressures, node by node around and layer by layer
    m, n, along = len(cubed), len(dz), cubed[:, None] / np.diff(z)
    bands = np.zeros((n + 1, m, n))
    bands[n] = np.outer(around[1:] + around[:-1], dz) + along
    bands[n, :, 1:] += along[:, :-1]
    bands[n - 1, :, 1:] = -along[:, :-1]
    bands[0, 1:] = -np.outer(around[1:-1], dz)
    if film is None and cells >= 2 * COARSEST:  # that of half of the cells, whose borders move one cell in an iteration
        half = solve_film(eps, a, b, ratio, from_widest=from_widest, pad=pad, cells=cells // 2, layers=layers)
        film = half.pressure[np.minimum(np.arange(1, cells) // 2, len(half.pressure)) - 1] > 0.0
    P = _non_negative(bands.reshape(n + 1, -1), f.ravel(), (f > 0.0 if film is None else film).ravel()).reshape(f.shape)
    weights = np.cos(slant[:-1]) * slant[1]  # of the trapezoidal rule in `slant` and in g, where P is smooth
    weights[0] *= 0.5
    mean, side = P @ weights * (s / q[2:-1:2] * turn / cells), float((cubed * P[:, -1]).sum() / (z[-1] - z[-2]))
    cos, sin = cos[2:-1:2], sin[2:-1:2]
    return FilmResult(float(mean @ cos), float(mean @ sin), float(P.max()), side, P, np.arctan2(sin, cos))


def _non_negative(bands: np.ndarray, f: np.ndarray, film: np.ndarray) -> np.ndarray:
    """P >= 0 with A P >= f, equal where P > 0; that set by Newton's method on a function with kinks, from `film` on."""
    n = len(bands) - 1
    for _ in range(MOST_SETS):
        own = bands.copy()
        for k in {0, n - 1}:  # rows and columns without film are those of the identity
            own[k, n - k :] *= film[n - k :] & film[: -(n - k)]
        own[n][~film] = 1.0
        P: np.ndarray = scipy.linalg.solveh_banded(own, np.where(film, f, 0.0), check_finite=False)
        slack = f - scipy.linalg.blas.dsbmv(n, 1.0, bands, P)  # what would press where there is no film
        now = np.where(film, P > 0.0, slack > ROUND_OFF * np.abs(f).max())
        if np.array_equal(now, film):
            return P
        film = now
    raise SolveError(f"The part of a finite film with pressure was not found in {MOST_SETS} iterations.")


@lru_cache(maxsize=64)
def film_table(ratio: float, from_widest: bool) -> tuple[float, ...]:
    """Coefficients of cubic splines of the forces by -log(1 - eps) and beta, with their numbers before them."""
    own = _fields(ratio, ANGLES, from_widest=from_widest)
    splines = periodic_splines(open_splines(_both_spins(own, own)))
    return (float(ECCENTRICITIES + 2), float(ANGLES + 3), LEVEL, *splines.ravel().tolist())


def _fields(ratio: float, angles: int, **film: Any) -> np.ndarray:
    """Fields of a table (4, eccentricities, angles/2 + 1) for one direction of spin, from parting to closing films."""
    values, expected = np.zeros((4, ECCENTRICITIES, angles // 2 + 1)), None
    for j in range(angles // 2 + 1):
        beta = 2.0 * math.pi * (j - angles // 4) / angles
        for i in range(ECCENTRICITIES):
            eps = 1.0 - math.exp(-LEVEL * i)
            s = math.sqrt(1.0 - eps * eps)
            found = solve_film(eps, math.sin(beta), math.cos(beta) / s, ratio, film=expected if i else None, **film)
            values[:, i, j] = s**3 * found.radial, s**3 * found.tangential, s**4 * found.peak, s * found.side
            expected = found.pressure > 0.0
    return values


def _both_spins(own: np.ndarray, mirrored: np.ndarray) -> np.ndarray:
    """Fields (4, eccentricities, angles) of a table, by its own half and the half of the other spin."""
    quarter, other = own.shape[2] // 2, mirrored[..., ::-1] * np.array([1.0, -1.0, 1.0, 1.0])[:, None, None]
    return np.concatenate([own[..., quarter:-1], other, own[..., 1:quarter]], axis=2)


def open_splines(values: np.ndarray) -> np.ndarray:
    """Coefficients of cubic splines along the second axis; at the ends the third derivative has no jump."""
    n = values.shape[1]
    A = np.zeros((n + 2, n + 2))
    for i in range(n):
        A[i, i : i + 3] = 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0
    A[n, :5] = A[n + 1, -5:] = 1.0, -4.0, 6.0, -4.0, 1.0
    right = np.concatenate([values, np.zeros_like(values[:, :2])], axis=1)
    return np.asarray(np.einsum("ij,kjl->kil", np.linalg.inv(A), right))


def periodic_splines(values: np.ndarray) -> np.ndarray:
    """Coefficients of periodic cubic splines along the last axis, the first three once more at its end."""
    n = values.shape[2]
    A = np.eye(n) * 4.0 + np.roll(np.eye(n), 1, axis=1) + np.roll(np.eye(n), -1, axis=1)
    return np.asarray(np.einsum("ij,klj->kli", np.linalg.inv(A / 6.0), values)[:, :, np.arange(-1, n + 2) % n])


@compiled
def table_place(p, eps, beta):
    """Cell of a table, by its first coefficient, and the place in it, 0 to 1 along both axes."""
    x, y = -math.log(1.0 - eps) / p[STEP], (beta / (2.0 * math.pi) + 1.0) * (p[COLUMNS] - 3.0)
    i, j = min(int(x), int(p[ROWS]) - 4), int(y)
    return i, j % (int(p[COLUMNS]) - 3), x - i, y - j


@compiled
def spline(u):
    """Values of the four cubic splines of a cell, and their derivatives."""
    w = 1.0 - u
    begin, end = 0.5 * u * u * u - u * u + 2.0 / 3.0, 0.5 * w * w * w - w * w + 2.0 / 3.0
    values = w * w * w / 6.0, begin, end, u * u * u / 6.0
    return values, (-0.5 * w * w, 1.5 * u * u - 2.0 * u, 2.0 * w - 1.5 * w * w, 0.5 * u * u)


@compiled
def table_field(p, field, i, j, x, y):
    """Value of a field, and its derivatives along both axes of the table in cells."""
    columns = int(p[COLUMNS])
    begin = FIRST + (field * int(p[ROWS]) + i) * columns + j
    fx, gx = spline(x)
    fy, gy = spline(y)
    value, by_x, by_y = 0.0, 0.0, 0.0
    for m in range(4):
        k = begin + m * columns
        along, across = 0.0, 0.0
        for n in range(4):
            along += fy[n] * p[k + n]
            across += gy[n] * p[k + n]
        value += fx[m] * along
        by_x += gx[m] * along
        by_y += fx[m] * across
    return value, by_x, by_y


@compiled
def scaled(eps, a, b, R, R_x, R_y, T, T_x, T_y):
    """Force over its scale and its derivatives, as `film_force` gives them, from values of a table."""
    # `R_x`, `R_y` and so on: their derivatives by -log(1 - eps) and beta.
    s2 = 1.0 - eps * eps
    s = math.sqrt(s2)
    B = s * b
    size = math.sqrt(a * a + B * B)
    scale, by_eps, rise = 1.0 / (s2 * s), 1.0 / (1.0 - eps), 3.0 * eps / s2
    x, y = scale * a / size, scale * B / size
    R_b, T_b, shrink = y * R - x * R_y, y * T - x * T_y, -eps * b / s  # by B, and dB/deps
    scale *= size
    return (
        scale * R, scale * T,
        scale * (R_x * by_eps + rise * R) + shrink * R_b, scale * (T_x * by_eps + rise * T) + shrink * T_b,
        x * R + y * R_y, s * R_b, x * T + y * T_y, s * T_b,
    )  # fmt: skip


@compiled
def table_force(p, eps, a, b):
    """Force over its scale and its derivatives, as `film_force` gives them."""
    if a == 0.0 and b == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    i, j, x, y = table_place(p, eps, math.atan2(a, math.sqrt(1.0 - eps * eps) * b))
    R, R_x, R_y = table_field(p, RADIAL, i, j, x, y)
    T, T_x, T_y = table_field(p, TANGENTIAL, i, j, x, y)
    by_level, by_beta = 1.0 / p[STEP], (p[COLUMNS] - 3.0) / (2.0 * math.pi)
    return scaled(eps, a, b, R, R_x * by_level, R_y * by_beta, T, T_x * by_level, T_y * by_beta)


@compiled
def table_scalar(p, field, eps, a, b):
    """Largest pressure or flow at the sides over its scale."""
    s2 = 1.0 - eps * eps
    i, j, x, y = table_place(p, eps, math.atan2(a, math.sqrt(s2) * b))
    value, _, _ = table_field(p, field, i, j, x, y)
    return scalar(field, s2, a, b, value)


@compiled
def scalar(field, s2, a, b, value):
    """Largest pressure or flow at the sides over its scale, from the value of a table."""
    return value * math.sqrt(a * a + s2 * b * b) / (s2 * s2 if field == PEAK else math.sqrt(s2))


# Finite film between axial grooves: tables of the forces of its pads
#
# The oil comes from grooves in the bearing, without pressure, so p = 0 there, and the film falls into pads that do not
# know of each other. A table of a pad has one axis more than that of a whole film: psi, the angle from the widest gap
# to its middle.

# Number of values of psi and of beta in the table of a pad, of cells around it and on half of its width.
TURNS, DIRECTIONS, PAD_CELLS, PAD_LAYERS = 48, 24, 48, 8
# Numbers of coefficients of a field along psi, -log(1 - eps) and beta.
PAD_ROWS, PAD_LINES, PAD_COLUMNS = TURNS + 3, ECCENTRICITIES + 2, DIRECTIONS + 3
FIELD = PAD_ROWS * PAD_LINES * PAD_COLUMNS  # number of coefficients of a field
# Numbers of each pad, behind their count: angle of its middle in the bearing, first coefficient of its table.
MIDDLE, PLACE = 0, 1


@lru_cache(maxsize=16)
def pads_table(ratio: float, grooves: tuple[float, ...], width: float) -> tuple[float, ...]:
    """Number of pads, their middles and places, and a table for each angle of a pad."""
    # `ratio`: width over diameter of the bearing; `grooves`: directions of their middles, in turn, the first once more;
    # `width`: angle of one.
    spans = [round(second - first - width, 12) for first, second in pairwise(grooves)]
    tables = {span: pad_table(ratio, span) for span in spans}
    first, kinds = TABLE_BEGIN + 1 + 2 * len(spans), list(tables)
    ends = zip(pairwise(grooves), spans, strict=True)
    own = [(0.5 * (one + two), first + 4.0 * FIELD * kinds.index(span)) for (one, two), span in ends]
    return (float(len(spans)), *chain(*own), *chain(*tables.values()))


@lru_cache(maxsize=16)
def pad_table(ratio: float, span: float) -> tuple[float, ...]:
    """Coefficients of cubic splines of the fields of a pad by psi, -log(1 - eps) and beta."""
    pads = [(2.0 * math.pi * k / TURNS - 0.5 * span, span) for k in range(TURNS)]
    own = [_fields(ratio, DIRECTIONS, pad=pad, cells=PAD_CELLS, layers=PAD_LAYERS) for pad in pads]
    values = np.stack([_both_spins(own[k], own[-k]) for k in range(TURNS)], axis=1)
    lines = open_splines(periodic_splines(values.reshape(4 * TURNS, ECCENTRICITIES, DIRECTIONS)))
    lines = lines.reshape(4, TURNS, PAD_LINES * PAD_COLUMNS).transpose(0, 2, 1)
    return tuple(periodic_splines(lines).transpose(0, 2, 1).ravel().tolist())


@compiled
def pad_field(p, begin, i, x, y, z):
    """Value of a field, and its derivatives along the axes of the table in cells; i: first coefficient of the cell."""
    fx, gx = spline(x)
    fy, gy = spline(y)
    fz, gz = spline(z)
    value, by_x, by_y, by_z = 0.0, 0.0, 0.0, 0.0
    for l in range(4):
        for m in range(4):
            k = begin + i + (l * PAD_LINES + m) * PAD_COLUMNS
            along, across = 0.0, 0.0
            for n in range(4):
                along += fz[n] * p[k + n]
                across += gz[n] * p[k + n]
            value += fx[l] * fy[m] * along
            by_x += gx[l] * fy[m] * along
            by_y += fx[l] * gy[m] * along
            by_z += fx[l] * fy[m] * across
    return value, by_x, by_y, by_z


@compiled
def pad_place(p, pad, eps, beta, widest):
    """First coefficient of a pad's table, of the cell in it, and the place in the cell, 0 to 1 along the axes."""
    at = TABLE_BEGIN + 1 + 2 * pad
    x = (p[at + MIDDLE] - widest) / (2.0 * math.pi)
    x = (x - math.floor(x)) * TURNS
    y, z = -math.log(1.0 - eps) / LEVEL, (beta / (2.0 * math.pi) + 1.0) * DIRECTIONS
    i, j, k = int(x), min(int(y), PAD_LINES - 4), int(z)
    return int(p[at + PLACE]), ((i % TURNS) * PAD_LINES + j) * PAD_COLUMNS + k % DIRECTIONS, x - i, y - j, z - k


@compiled
def pads_force(p, eps, a, b, widest):
    """Force over its scale and its derivatives by eps, a and b, as `film_force` gives them, then by `widest`."""
    # `widest`: direction of the widest gap in the frame of the bearing.
    R, R_x, R_y, R_z, T, T_x, T_y, T_z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if a == 0.0 and b == 0.0:
        return R, T, R, T, R, R, T, T, R, T
    s2 = 1.0 - eps * eps
    s, size = math.sqrt(s2), TURNS / (2.0 * math.pi)
    by_level, by_beta = 1.0 / LEVEL, DIRECTIONS / (2.0 * math.pi)
    for pad in range(int(p[TABLE_BEGIN])):
        begin, i, x, y, z = pad_place(p, pad, eps, math.atan2(a, s * b), widest)
        v, v_x, v_y, v_z = pad_field(p, begin + RADIAL * FIELD, i, x, y, z)
        R, R_x, R_y, R_z = R + v, R_x - v_x * size, R_y + v_y * by_level, R_z + v_z * by_beta
        v, v_x, v_y, v_z = pad_field(p, begin + TANGENTIAL * FIELD, i, x, y, z)
        T, T_x, T_y, T_z = T + v, T_x - v_x * size, T_y + v_y * by_level, T_z + v_z * by_beta
    Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b = scaled(eps, a, b, R, R_y, R_z, T, T_y, T_z)
    scale = math.sqrt(a * a + s2 * b * b) / (s2 * s)
    return Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b, scale * R_x, scale * T_x


@compiled
def pads_scalar(p, field, eps, a, b, widest):
    """Largest pressure of all pads, or their flow at the sides, over its scale."""
    s2, value = 1.0 - eps * eps, 0.0
    for pad in range(int(p[TABLE_BEGIN])):
        begin, i, x, y, z = pad_place(p, pad, eps, math.atan2(a, math.sqrt(s2) * b), widest)
        own, _, _, _ = pad_field(p, begin + int(field) * FIELD, i, x, y, z)
        value = value + own if field == SIDE else max(value, own)
    return scalar(field, s2, a, b, value)
