"""Finite film: the Reynolds equation with Reynolds' condition p >= 0, and a table of its forces made before a run.

On half of the width, with P = p/(mu (R/c)^2) and Z = z/R,

    d/dtheta (H^3 dP/dtheta) + H^3 d2P/dZ2 = 12 (a cos(theta) - b sin(theta)) where P > 0,

a linear complementarity problem.  Its forces are homogeneous in (a, b), so with s = sqrt(1 - eps^2) they are a size,
hypot(a, s b), times a function of the eccentricity and of beta = atan2(a, s b): squeeze counts more in a narrow gap.

Equations (15.1) and (15.6) of docs/theory/films.md.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from flexmb.errors import SolveError
from flexmb.kernels import compiled
from flexmb.parts.bearings.film import TABLE_BEGIN

# Number of cells around the bearing and on half of its width.
CELLS, LAYERS = 96, 12
# Number of values of -log(1 - eps) and of beta in a table.
ECCENTRICITIES, ANGLES = 26, 48
# Least film over the clearance in a table.
THINNEST = 1e-3
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
    eps: float,
    a: float,
    b: float,
    ratio: float,
    *,
    from_widest: bool = True,
    pad: tuple[float, float] | None = None,
    cells: int = CELLS,
    layers: int = LAYERS,
) -> FilmResult:
    """Film at the rates a and b of a bearing with width over diameter `ratio`."""
    # `from_widest`: the oil is supplied at the widest gap, where p = 0; else it is supplied everywhere, and p = 0 where
    # the gap widens most. `pad`: theta at the begin of the part between two grooves, and its angle; p = 0 at both ends.
    # Cells are even in Sommerfeld's angle, so they follow the narrow peak of the pressure, and finer towards the sides.
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
    around = 1.0 / np.diff(resistance[::2])
    faces = a * sin[1::2] + b * cos[1::2]
    cubed = s**7 * (q[1:-2:2] ** -4 + 4.0 * q[2:-1:2] ** -4 + q[3::2] ** -4) * turn / (6.0 * cells)  # Simpson
    f = -12.0 * np.outer(np.diff(faces), dz)
    bands = _bands(around, cubed, dz, np.diff(z))
    film = f > 0.0
    if cells >= 2 * COARSEST:  # the film of half of the cells, whose borders move one cell in an iteration
        half = solve_film(eps, a, b, ratio, from_widest=from_widest, pad=pad, cells=cells // 2, layers=layers)
        film = half.pressure[np.minimum(np.arange(1, cells) // 2, len(half.pressure)) - 1] > 0.0
    P = np.zeros(f.shape)
    if not press(bands, f.ravel(), film.ravel(), np.zeros(bands.shape[::-1]), P.ravel()):
        raise SolveError(f"The part of a finite film with pressure was not found in {MOST_SETS} iterations.")
    weights = np.cos(slant[:-1]) * slant[1]  # of the trapezoidal rule in `slant` and in g, where P is smooth
    weights[0] *= 0.5
    mean = P @ weights * (s / q[2:-1:2] * turn / cells)
    side = float((cubed * P[:, -1]).sum() / (z[-1] - z[-2]))
    return FilmResult(
        float(mean @ cos[2:-1:2]), float(mean @ sin[2:-1:2]), float(P.max()), side, P, np.arctan2(sin, cos)[2:-1:2]
    )


def _bands(around: np.ndarray, cubed: np.ndarray, dz: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """Upper bands of the symmetric matrix of the pressures, node by node around and layer by layer."""
    m, n = len(cubed), len(dz)
    bands = np.zeros((n + 1, m, n))
    along = cubed[:, None] / gaps
    bands[n] = np.outer(around[1:] + around[:-1], dz) + along
    bands[n, :, 1:] += along[:, :-1]
    bands[n - 1, :, 1:] = -along[:, :-1]
    bands[0, 1:] = -np.outer(around[1:-1], dz)
    return np.asarray(bands.reshape(n + 1, m * n))


@compiled
def press(bands, f, film, factor, P):
    """Pressure P >= 0 with A P >= f, equal where P > 0, by Newton's method; True for an end of its iterations."""
    # bands : upper bands of A, the diagonal last;  film : where P > 0, changed;  factor : (nodes, bands) scratch.
    # Rows and columns without film are those of the identity in the Cholesky factor.
    n, nodes, largest = bands.shape[0] - 1, bands.shape[1], 0.0
    for j in range(nodes):
        largest = max(largest, abs(f[j]))
    for _ in range(MOST_SETS):
        for j in range(nodes):
            P[j] = 0.0
            if film[j]:
                P[j] = factor_column(bands, f[j], film, j, factor, P)
        for j in range(nodes - 1, -1, -1):
            if film[j]:
                P[j] /= factor[j, n]
                for i in range(max(0, j - n), j):
                    P[i] -= factor[j, n - j + i] * P[j]
        same = True
        for j in range(nodes):
            load = f[j]  # what would press where there is no film
            for i in range(max(0, j - n), j + 1):
                load -= bands[n - j + i, j] * P[i]
            for i in range(j + 1, min(nodes, j + n + 1)):
                load -= bands[n - i + j, i] * P[i]
            now = P[j] > 0.0 if film[j] else load > ROUND_OFF * largest
            same = same and now == film[j]
            film[j] = now
        if same:
            return True
    return False


@compiled
def factor_column(bands, load, film, j, factor, P):
    """Write column j of the Cholesky factor; unknown j of the forward substitution."""
    n = bands.shape[0] - 1
    first = max(0, j - n)
    for i in range(first, j + 1):
        entry = bands[n - j + i, j] if film[i] else 0.0
        if film[i]:
            for k in range(max(first, i - n), i):
                entry -= factor[i, n - i + k] * factor[j, n - j + k]
            entry = entry / factor[i, n] if i < j else math.sqrt(entry)
        factor[j, n - j + i] = entry
        if i < j:
            load -= entry * P[i]
    return load / factor[j, n]


@lru_cache(maxsize=64)
def film_table(ratio: float, from_widest: bool) -> tuple[float, ...]:
    """Coefficients of cubic splines of the forces by -log(1 - eps) and beta, with their numbers before them."""
    end = -math.log(THINNEST)
    levels, quarter = np.linspace(0.0, end, ECCENTRICITIES), ANGLES // 4
    values = np.zeros((4, ECCENTRICITIES, ANGLES))
    for i, level in enumerate(levels):
        eps = 1.0 - math.exp(-level)
        s = math.sqrt(1.0 - eps * eps)
        for j in range(-quarter, quarter + 1):
            a, b = math.sin(2.0 * math.pi * j / ANGLES), math.cos(2.0 * math.pi * j / ANGLES) / s
            found = solve_film(eps, a, b, ratio, from_widest=from_widest)
            own = s**3 * found.radial, s**3 * found.tangential, s**4 * found.peak, s * found.side
            values[:, i, j % ANGLES] = own
            values[:, i, (2 * quarter - j) % ANGLES] = own[0], -own[1], own[2], own[3]  # mirrored spin
    splines = periodic_splines(open_splines(values))
    return (float(ECCENTRICITIES + 2), float(ANGLES + 3), end / (ECCENTRICITIES - 1), *splines.ravel().tolist())


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
    x = -math.log(1.0 - eps) / p[STEP]
    y = (beta / (2.0 * math.pi) + 1.0) * (p[COLUMNS] - 3.0)
    i, j = min(int(x), int(p[ROWS]) - 4), int(y)
    return i, j % (int(p[COLUMNS]) - 3), x - i, y - j


@compiled
def spline(u):
    """Values of the four cubic splines of a cell, and their derivatives."""
    w = 1.0 - u
    return (
        (w * w * w / 6.0, 0.5 * u * u * u - u * u + 2.0 / 3.0, 0.5 * w * w * w - w * w + 2.0 / 3.0, u * u * u / 6.0),
        (-0.5 * w * w, 1.5 * u * u - 2.0 * u, 2.0 * w - 1.5 * w * w, 0.5 * u * u),
    )


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
