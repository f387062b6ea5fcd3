"""Closed curves as numbers of kernels: spans of polynomials, boxes around them, closest points.

A curve of n spans is a polynomial of degree 7 a span, x(u) and y(u) with u from 0 to 1, traversed counter-clockwise.
Behind SPANS and BOXES stand the boxes, circles around groups of spans (centre on the curve, radius, first span, end),
and behind these the coefficients: eight of x and eight of y, from the constant on.  A search passes the boxes, then the
starts of the spans in the boxes that may hold the point, and ends with Newton's method to round-off.
"""

import math

import numpy as np

from flexmb.kernels import compiled

# Geometry of polygons and spans: areas, crossings, coefficients of spans, curvatures

# Coefficients of the polynomial of degree 7 on [0, 1] by value and three derivatives at 0, then at 1.
HERMITE = np.linalg.inv([
    [0.0 if power < order else math.perm(power, order) * (1.0 if end or power == order else 0.0) for power in range(8)]
    for end in (0, 1) for order in range(4)
])  # fmt: skip

CROSSING_BLOCK = 256  # number of segments that are compared with all others at once


def hermite_spans(starts: np.ndarray, ends: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Spans (n, 2, 8) of a curve in the coordinates (x, y) by derivatives at both ends of each."""
    # `starts` and `ends` (4, 2, n) are values and three derivatives of x and y by the parameter; `steps` (n,) are
    # changes of the parameter over each span.
    factors = steps[None, :] ** np.arange(4)[:, None]
    data = np.concatenate([starts * factors[:, None, :], ends * factors[:, None, :]])
    return np.asarray(np.einsum("ij,jan->nai", HERMITE, data))


def sampled(spans: np.ndarray, samples: int, order: int = 0) -> np.ndarray:
    """Points (n samples, 2) of spans, or derivatives by the parameter of each span, from the start of each on."""
    return values_at(spans, np.arange(samples) / samples, order).reshape(-1, 2)


def values_at(spans: np.ndarray, u: np.ndarray, order: int) -> np.ndarray:
    """Derivatives (n, samples, 2) of spans at the parameters u (samples,)."""
    powers = np.array([math.perm(k, order) * u ** max(0, k - order) * (k >= order) for k in range(8)])
    return np.asarray(np.einsum("nai,iu->nua", spans, powers))


def _until_crossing(a: np.ndarray, d: np.ndarray, b: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shares s, t (n, m) of sides d (n, 2) from a and e (m, 2) from b up to where both cross; inf or nan: parallel."""
    between = b[None, :, :] - a[:, None, :]
    det = d[:, None, 0] * e[None, :, 1] - d[:, None, 1] * e[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (between[..., 0] * e[None, :, 1] - between[..., 1] * e[None, :, 0]) / det
        return s, (between[..., 0] * d[:, None, 1] - between[..., 1] * d[:, None, 0]) / det


def crossing(points: np.ndarray) -> tuple[float, float] | None:
    """A point where a closed polygon (n, 2) crosses itself, or None."""
    n, d = len(points), np.roll(points, -1, axis=0) - points
    for begin in range(0, n, CROSSING_BLOCK):
        i = np.arange(begin, min(n, begin + CROSSING_BLOCK))
        s, t = _until_crossing(points[i], d[i], points, d)
        apart = (np.arange(n)[None, :] - i[:, None]) % n
        hit = (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0) & (apart > 1) & (apart < n - 1)
        for row, column in np.argwhere(hit)[:1]:
            x, y = points[i[row]] + s[row, column] * d[i[row]]
            return float(x), float(y)
    return None


def meeting(one: np.ndarray, two: np.ndarray, tolerance: float) -> tuple[float, float] | None:
    """A point where two closed polygons (n, 2), (m, 2) cross, or None; within the tolerance [m] they touch."""
    d, e = np.roll(one, -1, axis=0) - one, np.roll(two, -1, axis=0) - two
    s, t = _until_crossing(one, d, two, e)
    first, second = tolerance / np.hypot(*d.T)[:, None], tolerance / np.hypot(*e.T)[None, :]
    for row, column in np.argwhere((s > first) & (s < 1.0 - first) & (t > second) & (t < 1.0 - second))[:1]:
        x, y = one[row] + s[row, column] * d[row]
        return float(x), float(y)
    return None


def curvatures(spans: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n samples, 2) of spans and curvatures there [1/m], > 0 where the curve is convex."""
    (dx, dy), (ddx, ddy) = sampled(spans, samples, 1).T, sampled(spans, samples, 2).T
    return sampled(spans, samples), (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3


SPANS, BOXES, FIRST_BOX = range(3)  # places at the begin of a curve: number of spans, number of boxes, first box
BOX_X, BOX_Y, BOX_RADIUS, BOX_FIRST, BOX_END, BOX_SIZE = range(6)  # places in a box, and its length
C6, C7, SPAN_Y = range(6, 9)  # places of the last two coefficients of x in a span, and of the first one of y
SPAN_SIZE = 16  # numbers of a span
MOST_ITERATIONS = 40  # largest number of Newton iterations
LEAST_STEP = 1e-14  # change of u below which a point is found [1]
HALF_SPAN = 0.5  # step of u [1] where the distance is not convex


@compiled
def horner(p, k, u):
    """Polynomial of degree 7 with the coefficients p[k], ..., p[k + C7], and its two derivatives."""
    value, slope, half_bend = p[k + C7], 0.0, 0.0
    for i in range(C6, -1, -1):
        half_bend = half_bend * u + slope
        slope = slope * u + value
        value = value * u + p[k + i]
    return value, slope, 2.0 * half_bend


@compiled
def span_place(p, base, span):
    """Place of the coefficients of a span."""
    return base + FIRST_BOX + BOX_SIZE * int(p[base + BOXES]) + SPAN_SIZE * span


@compiled
def turned_on(p, base, span, u):
    """Span and u of a step that may have left the span."""
    n = int(p[base + SPANS])
    if u < 0.0:
        return (span + n - 1) % n, max(0.0, 1.0 + u)
    if u > 1.0:
        return (span + 1) % n, min(1.0, u - 1.0)
    return span, u


@compiled
def moved(p, base, span, u, step):
    """Span and u after a step; a step out of a span ends there first, since the next span goes on differently."""
    if (u == 0.0 and step < 0.0) or (u == 1.0 and step > 0.0):
        return turned_on(p, base, span, u + step)
    return span, max(0.0, min(1.0, u + step))


@compiled
def frame_at(p, k, u):
    """Point, unit tangent, curvature (> 0: convex) at u of the span with its coefficients at k."""
    x, dx, ddx = horner(p, k, u)
    y, dy, ddy = horner(p, k + SPAN_Y, u)
    speed = math.sqrt(dx * dx + dy * dy)
    return x, y, dx / speed, dy / speed, (dx * ddy - dy * ddx) / (speed * speed * speed)


@compiled
def away_of(x, y, a, b, near):
    """Square of the distance of (x, y) from the point (a, b) if `near`; else its way against the direction (a, b)."""
    return (a - x) ** 2 + (b - y) ** 2 if near else -(a * x + b * y)


@compiled
def away_of_box(p, k, a, b, near):
    """Distance of the middle of a box, see `away_of`."""
    away = away_of(p[k + BOX_X], p[k + BOX_Y], a, b, near)
    return math.sqrt(away) if near else away


@compiled
def extreme(p, base, a, b, near):
    """Point nearest to (a, b) if `near`, else farthest along the unit vector (a, b); unit tangent and curvature."""
    # Span whose start is nearest to the point (a, b) if `near`, else farthest along the direction (a, b)
    boxes, bound = int(p[base + BOXES]), math.inf
    for i in range(boxes):
        bound = min(bound, away_of_box(p, base + FIRST_BOX + BOX_SIZE * i, a, b, near))
    best, found = math.inf, 0
    for i in range(boxes):
        k = base + FIRST_BOX + BOX_SIZE * i
        if away_of_box(p, k, a, b, near) - p[k + BOX_RADIUS] > bound:
            continue
        for span in range(int(p[k + BOX_FIRST]), int(p[k + BOX_END])):
            c = span_place(p, base, span)
            away = away_of(p[c], p[c + SPAN_Y], a, b, near)
            if away < best:
                best, found = away, span
    span, u = found, 0.0
    for _ in range(MOST_ITERATIONS):
        k = span_place(p, base, span)
        x, dx, ddx = horner(p, k, u)
        y, dy, ddy = horner(p, k + SPAN_Y, u)
        ex, ey, square = (x - a, y - b, dx * dx + dy * dy) if near else (-a, -b, 0.0)
        slope, bend = ex * dx + ey * dy, square + ex * ddx + ey * ddy
        step = max(-1.0, min(1.0, -slope / bend)) if bend > 0.0 else -HALF_SPAN if slope > 0.0 else HALF_SPAN
        span, u = moved(p, base, span, u, step)
        if abs(step) <= LEAST_STEP:
            break
    return frame_at(p, span_place(p, base, span), u)


@compiled
def nearest_starts(p, one, other, c, s, X, Y):
    """Spans of two curves whose starts are nearest to each other; the frame of `other` at (X, Y), turned by (c, s)."""
    best = math.inf  # square of the least distance of the middles of boxes, which are points of the curves
    for b in range(int(p[other + BOXES])):
        k = other + FIRST_BOX + BOX_SIZE * b
        x, y = X + c * p[k + BOX_X] - s * p[k + BOX_Y], Y + s * p[k + BOX_X] + c * p[k + BOX_Y]
        for a in range(int(p[one + BOXES])):
            j = one + FIRST_BOX + BOX_SIZE * a
            best = min(best, (x - p[j + BOX_X]) ** 2 + (y - p[j + BOX_Y]) ** 2)
    first, second, near = 0, 0, math.sqrt(best)
    for b in range(int(p[other + BOXES])):
        k = other + FIRST_BOX + BOX_SIZE * b
        x, y = X + c * p[k + BOX_X] - s * p[k + BOX_Y], Y + s * p[k + BOX_X] + c * p[k + BOX_Y]
        for a in range(int(p[one + BOXES])):
            j = one + FIRST_BOX + BOX_SIZE * a
            reach = p[j + BOX_RADIUS] + p[k + BOX_RADIUS] + near
            if (x - p[j + BOX_X]) ** 2 + (y - p[j + BOX_Y]) ** 2 > reach * reach:
                continue
            for span in range(int(p[k + BOX_FIRST]), int(p[k + BOX_END])):
                d = span_place(p, other, span)
                px, py = X + c * p[d] - s * p[d + SPAN_Y], Y + s * p[d] + c * p[d + SPAN_Y]
                away = p[j + BOX_RADIUS] + near
                if (px - p[j + BOX_X]) ** 2 + (py - p[j + BOX_Y]) ** 2 > away * away:
                    continue
                for mine in range(int(p[j + BOX_FIRST]), int(p[j + BOX_END])):
                    e = span_place(p, one, mine)
                    square = (px - p[e]) ** 2 + (py - p[e + SPAN_Y]) ** 2
                    if square <= best:
                        best, first, second, near = square, mine, span, math.sqrt(square)
    return first, second


@compiled
def common_normal(p, one, other, c, s, X, Y):
    """Points of two curves on a common normal, tangent of the first, curvatures, in its frame; see `nearest_starts`."""
    first, second = nearest_starts(p, one, other, c, s, X, Y)
    u, w = 0.0, 0.0
    for _ in range(MOST_ITERATIONS):
        k, m = span_place(p, one, first), span_place(p, other, second)
        x, dx, ddx = horner(p, k, u)
        y, dy, ddy = horner(p, k + SPAN_Y, u)
        a, da, dda = horner(p, m, w)
        b, db, ddb = horner(p, m + SPAN_Y, w)
        ex, ey = X + c * a - s * b - x, Y + s * a + c * b - y
        fx, fy, ffx, ffy = c * da - s * db, s * da + c * db, c * dda - s * ddb, s * dda + c * ddb
        along, across = ex * dx + ey * dy, dx * fy - dy * fx
        along_u, along_w = ex * ddx + ey * ddy - dx * dx - dy * dy, fx * dx + fy * dy
        across_u, across_w = ddx * fy - ddy * fx, dx * ffy - dy * ffx
        det = along_u * across_w - along_w * across_u
        du, dw = 0.0, 0.0
        if det != 0.0:
            du = max(-1.0, min(1.0, (along_w * across - across_w * along) / det))
            dw = max(-1.0, min(1.0, (across_u * along - along_u * across) / det))
        first, u = turned_on(p, one, first, u + du)
        second, w = turned_on(p, other, second, w + dw)
        if abs(du) <= LEAST_STEP and abs(dw) <= LEAST_STEP:
            break
    x, y, tx, ty, bend = frame_at(p, span_place(p, one, first), u)
    a, b, _, _, other_bend = frame_at(p, span_place(p, other, second), w)
    return x, y, X + c * a - s * b, Y + s * a + c * b, tx, ty, bend, other_bend
