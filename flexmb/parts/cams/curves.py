"""Curves of bodies: smooth closed curves, straight faces, rollers; closed curves as numbers of kernels, closest points.

A curve of n spans is a polynomial of degree 7 a span, x(u) and y(u) with u from 0 to 1, traversed counter-clockwise.
Behind SPANS and BOXES stand the boxes, circles around groups of spans (centre on the curve, radius, first span, end),
and behind these the coefficients: eight of x and eight of y, from the constant on.  A search passes the boxes, then the
starts of the spans in the boxes that may hold the point, and ends with Newton's method to round-off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from flexmb import checks, display, planar
from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, field, point, positive, record
from flexmb.kernels import compiled

CIRCLE_POINTS = 72  # number of segments of a drawn circle


@record
class Line(Input, Shown):
    """Straight segment, e.g. the face of a flat follower.

    Raises
    ------
    InputError : ends that coincide or are not finite.
    """

    start: tuple[float, float] = field("one end", "m", point)
    end: tuple[float, float] = field("the other end", "m", point)

    def __post_init__(self) -> None:
        super().__post_init__()
        if math.dist(self.start, self.end) == 0.0:
            text = f"Line: both ends are {self.start};"
            raise InputError(f"{text} a segment needs a length. Use PointOnCurve for an edge.")

    @property
    def length(self) -> float:
        """Distance of the ends [m]."""
        return math.dist(self.start, self.end)

    @property
    def size(self) -> float:
        """The length [m]."""
        return self.length

    def drawing(self) -> tuple[tuple[float, float], ...]:
        """Both ends [m], for pictures."""
        return self.start, self.end


@record
class CircularCurve(Input, Shown):
    """Circle, e.g. a roller or a pin.

    Raises
    ------
    InputError : a radius that is not > 0.

    Notes
    -----
    The circle is fixed to its body.  A roller that turns on its follower is a body of its own with a `Revolute`.
    """

    centre: tuple[float, float] = field("its centre", "m", point)
    radius: float = field("its radius", "m", positive, hint="For an edge without radius use PointOnCurve(...).")

    @property
    def size(self) -> float:
        """The diameter [m]."""
        return 2.0 * self.radius

    def drawing(self) -> tuple[tuple[float, float], ...]:
        """Points of a closed polyline in the reference configuration [m], for pictures."""
        x, y = self.centre
        angles = [2.0 * math.pi * k / CIRCLE_POINTS for k in range(CIRCLE_POINTS + 1)]
        return tuple((x + self.radius * math.cos(a), y + self.radius * math.sin(a)) for a in angles)


# Smooth closed curve of a body: a spline through points, the profile of a cam

FEWEST_POINTS = 8  # fewest points of a spline
LARGEST_CHORD = 10.0  # closing chord over the longest other chord from which a curve counts as not closed
DOUBLED = 1e-9  # distance of neighbouring points over the size of the curve below which they count as one
LARGEST_TURN = 1e-6  # tangent of the angle of two spans [1] up to which a curve has no corner
SAMPLES = 8  # points of a span at which curvature and crossings are examined
DRAWN_POINTS = 360  # fewest points of a drawing


@record
class ClosedCurve(Input):
    """Closed curve without corners: a periodic quintic spline through points.

    Points are in order, in either direction; stored counter-clockwise.  The first one is not repeated at the end (a
    repeated one is left out).  Other curves than the spline have `spans`, polynomials x(u), y(u) with 0 <= u <= 1 from
    each point to the next.

    Raises
    ------
    InputError : too few points, points that coincide, that are not finite or do not close, a curve that crosses itself.

    Notes
    -----
    The parameter of the spline is the length of the chords; four derivatives by it are continuous.  Points should be
    evenly spaced: the second derivative is exact to order 4 of the spacing.  Measured points with noise belong smoothed
    first, since a spline passes through all of them.  The body that carries the curve is named by the part; the points
    move with it from the reference configuration on.
    Source: C. de Boor, A Practical Guide to Splines, Springer 1978.

    Examples
    --------
    An eccentric disc of radius 30 mm:

    >>> u = np.linspace(0.0, 2.0 * math.pi, 181)[:-1]
    >>> disc = ClosedCurve(np.column_stack([0.01 + 0.03 * np.cos(u), 0.03 * np.sin(u)]))
    >>> f"{disc.length:.9f}"
    '0.188495559'
    """

    points: Any = field("(n, 2) points in the reference configuration, n >= 8", "m")
    spans: Any = field("(n, 2, 8) coefficients of the polynomials; None: of the spline", default=None, repr=False)

    def __post_init__(self) -> None:
        points = checked_points("ClosedCurve", self.points)
        spans = spline(points) if self.spans is None else np.array(self.spans, dtype=float)
        if spans.shape != (len(points), 2, 8) or not np.all(np.isfinite(spans)):
            text = f"ClosedCurve: spans has the shape {spans.shape};"
            text += f" it must be ({len(points)}, 2, 8), of finite numbers"
            raise InputError(f"{text}, one span for each point. Leave spans out for a spline.")
        # spans must begin at the points, and go on smoothly at the next point
        ends, next_starts = spans.sum(axis=2), np.roll(spans[:, :, 0], -1, axis=0)
        arriving, leaving = spans @ np.arange(8.0), np.roll(spans[:, :, 1], -1, axis=0)
        turn = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
        apart = np.hypot(*(spans[:, :, 0] - points).T) + np.hypot(*(ends - next_starts).T)
        wrong = apart > DOUBLED * float(np.ptp(points, axis=0).max())
        wrong |= ~(np.abs(turn) <= LARGEST_TURN * np.sum(arriving * leaving, axis=1))
        if np.any(wrong):
            k = int(np.argmax(wrong))
            x, y = points[k]
            text = f"ClosedCurve: span {k} from ({x:.6g}, {y:.6g}) m begins elsewhere or has a corner at its end."
            text += " Leave spans out (None) where the points are others;"
            raise InputError(f"{text} a curve with corners is an Outline.")
        polygon = sampled(spans, SAMPLES)
        if planar.area(polygon) < 0.0:
            flip = np.array([[math.comb(j, i) * (-1.0) ** i for j in range(8)] for i in range(8)])
            spans = np.asarray(np.einsum("ij,naj->nai", flip, spans)[::-1])  # of the curve traversed the other way
        place = crossing(polygon)
        if place is not None:
            text = f"ClosedCurve: the curve crosses itself near ({place[0]:.6g}, {place[1]:.6g}) m."
            raise InputError(f"{text} Sort the points along the curve, or space them more evenly there.")
        object.__setattr__(self, "points", tuples(spans[:, :, 0]))
        object.__setattr__(self, "spans", tuples(spans))

    @classmethod
    def from_function(cls, function: Callable[[float], Any], points: int = 180) -> ClosedCurve:
        """The spline through `points` points of a `function`: (x, y) [m] by a parameter from 0 to 2 pi.

        Raises
        ------
        InputError : a function whose values at 0 and 2 pi differ.
        """
        n = checks.count("ClosedCurve.from_function", "points", points, FEWEST_POINTS)
        angles = [2.0 * math.pi * k / n for k in range(n + 1)]
        values = [checks.point("ClosedCurve.from_function", f"function({u:.6g})", function(u)) for u in angles]
        gap, size = math.dist(values[0], values[-1]), float(np.ptp(np.array(values), axis=0).max())
        if gap > 1e-6 * size:
            text = f"ClosedCurve.from_function: function(0) and function(2 pi) are {gap:.4g} m apart,"
            raise InputError(f"{text} so the curve is not closed. Give a function of period 2 pi.")
        return cls(values[:-1])

    def __repr__(self) -> str:
        return f"ClosedCurve({len(self.points)} points, {self.size:.6g} m wide, {self.length:.6g} m long)"

    def _repr_html_(self) -> str:
        least, most, _ = self.extreme_curvature()
        rows = [("width", f"{self.size:.6g}", "m"), ("length", f"{self.length:.6g}", "m")]
        rows += [("least curvature", f"{least:.6g}", "1/m"), ("largest curvature", f"{most:.6g}", "1/m")]
        return display.page("ClosedCurve", f"{len(self.points)} points", display.table(rows))

    @cached_property
    def array(self) -> np.ndarray:
        """Coefficients (n, 2, 8) of the spans."""
        return np.array(self.spans)

    @property
    def length(self) -> float:
        """Length of the curve [m]."""
        nodes, weights = np.polynomial.legendre.leggauss(8)
        slopes = values_at(self.array, 0.5 * (nodes + 1.0), 1)
        return float(np.sum(0.5 * weights * np.hypot(slopes[..., 0], slopes[..., 1])))

    @property
    def size(self) -> float:
        """Largest extent along X or Y [m]."""
        return float(np.ptp(sampled(self.array, SAMPLES), axis=0).max())

    def extreme_curvature(self) -> tuple[float, float, tuple[float, float]]:
        """Least and largest curvature [1/m], < 0 where the curve is concave, and the place of the least one [m]."""
        points, bend = curvatures(self.array, SAMPLES)
        k = int(np.argmin(bend))
        return float(bend[k]), float(bend.max()), (float(points[k, 0]), float(points[k, 1]))

    def drawing(self) -> tuple[tuple[float, float], ...]:
        """Points of a closed polyline in the reference configuration [m], for pictures."""
        points = sampled(self.array, max(1, -(-DRAWN_POINTS // len(self.points))))
        return tuples(np.vstack([points, points[:1]]))  # type: ignore[no-any-return]


def tuples(values: Any) -> Any:
    """An array as nested tuples of floats."""
    return tuple(tuples(v) for v in values) if np.ndim(values) > 1 else tuple(map(float, values))


def checked_points(owner: str, given: Any) -> np.ndarray:
    """Points (n, 2) of a closed curve, distinct, the closing one left out; or `InputError`."""
    points = point_array(owner, given)
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if len(points) > 1 and math.dist(points[0], points[-1]) <= DOUBLED * size:
        points = points[:-1]
    if len(points) < FEWEST_POINTS:
        raise InputError(f"{owner}: {len(points)} points; give at least {FEWEST_POINTS} that differ, in order.")
    chords = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    k = int(np.argmin(chords))
    if chords[k] <= DOUBLED * size:
        x, y = points[k]
        raise InputError(f"{owner}: points {k} and {k + 1} are both ({x:.6g}, {y:.6g}) m; leave one of them out.")
    if chords[-1] > LARGEST_CHORD * chords[:-1].max():
        text = f"{owner}: the last point lies {chords[-1]:.4g} m from the first one,"
        text += f" {chords[-1] / chords[:-1].max():.0f} times as far as neighbours lie apart, so the curve is not"
        raise InputError(f"{text} closed. Give points all the way round.")
    return points


def point_array(owner: str, given: Any) -> np.ndarray:
    """Array (n, 2) of finite points, or `InputError` that names the first wrong one."""
    found = []
    for k, p in enumerate(checks.sequence(owner, "points", given, "points (x, y)")):
        found.append(checks.point(owner, f"points[{k}]", p))
        if not all(map(math.isfinite, found[-1])):
            raise InputError(f"{owner}: points[{k}] is {p!r}; it must be a pair (x, y) of finite numbers in m.")
    return np.array(found).reshape(-1, 2)


def spline(points: np.ndarray) -> np.ndarray:
    """Spans (n, 2, 8) of the periodic quintic spline through points (n, 2), over the length of the chords."""
    closed = np.vstack([points, points[:1]])
    steps = np.hypot(*np.diff(closed, axis=0).T)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    found = make_interp_spline(at, closed, k=5, bc_type="periodic")
    spans = np.zeros((len(points), 2, 8))
    for order in range(6):
        values = found(at[:-1], nu=order) if order else points
        spans[:, :, order] = values * (steps**order / math.factorial(order))[:, None]
    return spans


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
        half_bend, slope, value = half_bend * u + slope, slope * u + value, value * u + p[k + i]
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
