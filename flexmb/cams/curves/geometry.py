"""Geometry of polygons and spans: areas, crossings, coefficients of spans, curvatures."""

from __future__ import annotations

import math

import numpy as np

HERMITE = np.linalg.inv(
    np.array(
        [
            [
                (0.0 if power < order else math.perm(power, order) * (1.0 if end or power == order else 0.0))
                for power in range(8)
            ]
            for end in (0, 1)
            for order in range(4)
        ]
    )
)
"""Coefficients of the polynomial of degree 7 on [0, 1] by value and three derivatives at 0, then at 1."""

CROSSING_BLOCK = 256
"""Number of segments that are compared with all others at once."""


def hermite_spans(starts: np.ndarray, ends: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Spans (n, 2, 8) of a curve in the coordinates (x, y) by derivatives at both ends of each.

    `starts` and `ends` (4, 2, n) are values and three derivatives of x and y by the parameter; `steps` (n,) are changes
    of the parameter over each span.
    """
    factors = steps[None, :] ** np.arange(4)[:, None]
    data = np.concatenate([starts * factors[:, None, :], ends * factors[:, None, :]])
    coefficients: np.ndarray = np.einsum("ij,jan->nai", HERMITE, data)
    return coefficients


def sampled(spans: np.ndarray, samples: int, order: int = 0) -> np.ndarray:
    """Points (n samples, 2) of spans, or derivatives by the parameter of each span, from the start of each on."""
    u = np.arange(samples) / samples
    powers = np.array([math.perm(k, order) * u ** max(0, k - order) * (k >= order) for k in range(8)])
    found: np.ndarray = np.einsum("nai,iu->nua", spans, powers).reshape(-1, 2)
    return found


def reversed_spans(spans: np.ndarray) -> np.ndarray:
    """Spans (n, 2, 8) of a curve traversed the other way."""
    flip = np.array([[math.comb(j, i) * (-1.0) ** i for j in range(8)] for i in range(8)])
    found: np.ndarray = np.einsum("ij,naj->nai", flip, spans)[::-1]
    return found


def area(points: np.ndarray) -> float:
    """Area of a polygon (n, 2), > 0 for a counter-clockwise one."""
    x, y = points.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def crossing(points: np.ndarray) -> tuple[float, float] | None:
    """A point where a closed polygon (n, 2) crosses itself, or None."""
    n = len(points)
    a, d = points, np.roll(points, -1, axis=0) - points
    for begin in range(0, n, CROSSING_BLOCK):
        i = np.arange(begin, min(n, begin + CROSSING_BLOCK))
        between = a[None, :, :] - a[i, None, :]
        det = d[i, None, 0] * d[None, :, 1] - d[i, None, 1] * d[None, :, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (between[..., 0] * d[None, :, 1] - between[..., 1] * d[None, :, 0]) / det
            t = (between[..., 0] * d[i, None, 1] - between[..., 1] * d[i, None, 0]) / det
        apart = (np.arange(n)[None, :] - i[:, None]) % n
        hit = (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0) & (apart > 1) & (apart < n - 1)
        if np.any(hit):
            row, column = (int(k[0]) for k in np.nonzero(hit))
            x, y = a[i[row]] + s[row, column] * d[i[row]]
            return float(x), float(y)
    return None


def meeting(one: np.ndarray, two: np.ndarray, tolerance: float) -> tuple[float, float] | None:
    """A point where two closed polygons (n, 2), (m, 2) cross one another, or None.

    Within the tolerance [m] from the ends of their sides they only touch.
    """
    d, e = np.roll(one, -1, axis=0) - one, np.roll(two, -1, axis=0) - two
    between = two[None, :, :] - one[:, None, :]
    det = d[:, None, 0] * e[None, :, 1] - d[:, None, 1] * e[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (between[..., 0] * e[None, :, 1] - between[..., 1] * e[None, :, 0]) / det
        t = (between[..., 0] * d[:, None, 1] - between[..., 1] * d[:, None, 0]) / det
    first, second = tolerance / np.hypot(*d.T)[:, None], tolerance / np.hypot(*e.T)[None, :]
    hit = (s > first) & (s < 1.0 - first) & (t > second) & (t < 1.0 - second)
    if not np.any(hit):
        return None
    row, column = (int(k[0]) for k in np.nonzero(hit))
    x, y = one[row] + s[row, column] * d[row]
    return float(x), float(y)


def curvatures(spans: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n samples, 2) of spans and curvatures there [1/m], > 0 where the curve is convex."""
    (dx, dy), (ddx, ddy) = sampled(spans, samples, 1).T, sampled(spans, samples, 2).T
    return sampled(spans, samples), (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
