"""Curves of bodies: smooth closed curves, straight faces, rollers."""

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
from flexmb.parts.cams.spans import crossing, curvatures, sampled, values_at

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
        check_joined(points, spans)
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
        turn = 2.0 * math.pi
        values = [
            checks.point("ClosedCurve.from_function", f"function({turn * k / n:.6g})", function(turn * k / n))
            for k in range(n + 1)
        ]
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
        raise InputError(
            f"{owner}: the last point lies {chords[-1]:.4g} m from the first one, {chords[-1] / chords[:-1].max():.0f} "
            "times as far as neighbours lie apart, so the curve is not closed. Give points all the way round."
        )
    return points


def check_joined(points: np.ndarray, spans: np.ndarray) -> None:
    """Refuse spans that do not begin at the points, or do not go on smoothly at the next point."""
    size = float(np.ptp(points, axis=0).max())
    ends, next_starts = spans.sum(axis=2), np.roll(spans[:, :, 0], -1, axis=0)
    arriving, leaving = spans @ np.arange(8.0), np.roll(spans[:, :, 1], -1, axis=0)
    turn = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
    along = np.sum(arriving * leaving, axis=1)
    apart = np.hypot(*(spans[:, :, 0] - points).T) + np.hypot(*(ends - next_starts).T)
    wrong = (apart > DOUBLED * size) | ~(np.abs(turn) <= LARGEST_TURN * along)
    if np.any(wrong):
        k = int(np.argmax(wrong))
        x, y = points[k]
        text = f"ClosedCurve: span {k} from ({x:.6g}, {y:.6g}) m begins elsewhere or has a corner at its end. Leave"
        raise InputError(f"{text} spans out (None) where the points are others; a curve with corners is an Outline.")


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
