"""Finite film between axial grooves: tables of the forces of its pads.

The oil comes from grooves in the bearing, without pressure, so p = 0 there, and the film falls into pads that do not
know of each other.  A table of a pad has one axis more than that of a whole film: psi, the angle from the widest gap to
its middle.

Equation (15.6) of docs/theory/films.md.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import chain, pairwise

import numpy as np

from flexmb.kernels import compiled
from flexmb.parts.bearings.film import TABLE_BEGIN
from flexmb.parts.bearings.reynolds import (
    ECCENTRICITIES,
    RADIAL,
    SIDE,
    TANGENTIAL,
    THINNEST,
    open_splines,
    periodic_splines,
    scalar,
    scaled,
    solve_film,
    spline,
)

# Number of values of psi and of beta in the table of a pad, of cells around it and on half of its width.
TURNS, DIRECTIONS, PAD_CELLS, PAD_LAYERS = 48, 24, 48, 8
# Numbers of coefficients of a field along psi, -log(1 - eps) and beta.
ROWS, LINES, COLUMNS = TURNS + 3, ECCENTRICITIES + 2, DIRECTIONS + 3
LEVEL = -math.log(THINNEST) / (ECCENTRICITIES - 1)  # step of -log(1 - eps)
FIELD = ROWS * LINES * COLUMNS  # number of coefficients of a field
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
    own = [
        (0.5 * (one + two), first + 4.0 * FIELD * kinds.index(span))
        for (one, two), span in zip(pairwise(grooves), spans, strict=True)
    ]
    return (float(len(spans)), *chain(*own), *chain(*tables.values()))


@lru_cache(maxsize=16)
def pad_table(ratio: float, span: float) -> tuple[float, ...]:
    """Coefficients of cubic splines of the fields of a pad by psi, -log(1 - eps) and beta."""
    values, quarter = np.zeros((4, TURNS, ECCENTRICITIES, DIRECTIONS)), DIRECTIONS // 4
    for i in range(ECCENTRICITIES):
        eps = 1.0 - math.exp(-LEVEL * i)
        s = math.sqrt(1.0 - eps * eps)
        for k in range(TURNS):
            pad = 2.0 * math.pi * k / TURNS - 0.5 * span, span
            for j in range(-quarter, quarter + 1):
                a, b = math.sin(2.0 * math.pi * j / DIRECTIONS), math.cos(2.0 * math.pi * j / DIRECTIONS) / s
                found = solve_film(eps, a, b, ratio, pad=pad, cells=PAD_CELLS, layers=PAD_LAYERS)
                own = s**3 * found.radial, s**3 * found.tangential, s**4 * found.peak, s * found.side
                values[:, k, i, j % DIRECTIONS] = own
                values[:, -k % TURNS, i, (2 * quarter - j) % DIRECTIONS] = own[0], -own[1], own[2], own[3]  # mirrored
    lines = open_splines(periodic_splines(values.reshape(4 * TURNS, ECCENTRICITIES, DIRECTIONS)))
    lines = lines.reshape(4, TURNS, LINES * COLUMNS).transpose(0, 2, 1)
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
            k = begin + i + (l * LINES + m) * COLUMNS
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
    i, j, k = int(x), min(int(y), LINES - 4), int(z)
    return int(p[at + PLACE]), ((i % TURNS) * LINES + j) * COLUMNS + k % DIRECTIONS, x - i, y - j, z - k


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
