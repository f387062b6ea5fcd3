"""Outlines of bodies: closed chains of straight lines and arcs, their rounds; biarcs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks, planar
from flexmb.errors import InputError
from flexmb.fields import Input, field, record
from flexmb.parts.cams.curves import ClosedCurve, crossing, point_array, sampled, tuples

# Biarcs: smooth curves as chains of circular arcs with common tangents

TRIED_POINTS = 8  # points of a pair of arcs at which the distance from the curve is measured
MOST_PARTS = 64  # largest number of pairs of arcs of a span


def biarcs(spans: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Points (m, 2) and bulges (m,) of arcs within `tolerance` [m] of spans (n, 2, 8), or None for too many."""
    # Each part of a span becomes two arcs that share its ends and tangents, with equal tangent lengths. Source: D. S.
    # Meek, D. J. Walton, Approximation of discrete data by G1 arc splines, Computer-Aided Design 24 (1992) 301-306.
    parts = 1
    while parts <= MOST_PARTS:
        points, slopes = sampled(spans, parts), sampled(spans, parts, 1)
        tangents = slopes / np.hypot(*slopes.T)[:, None]
        ends, end_tangents = np.roll(points, -1, axis=0), np.roll(tangents, -1, axis=0)
        # Points where both arcs of each pair meet, for tangents of equal length d at both ends
        chord = ends - points
        along = np.sum(chord * (tangents + end_tangents), axis=1)
        bend = 1.0 - np.sum(tangents * end_tangents, axis=1)
        square = np.sum(chord * chord, axis=1)
        d = square / (along + np.sqrt(along * along + 2.0 * bend * square))
        joints = np.asarray(0.5 * (points + ends + d[:, None] * (tangents - end_tangents)))
        first, second = _bulges(tangents, joints - points), -_bulges(-end_tangents, joints - ends)
        curve = sampled(spans, parts * TRIED_POINTS).reshape(len(points), TRIED_POINTS, 2)
        away = np.minimum(_distance(curve, points, joints, first), _distance(curve, joints, ends, second))
        if away.max() <= tolerance:
            return np.stack([points, joints], axis=1).reshape(-1, 2), np.stack([first, second], axis=1).ravel()
        parts *= 2
    return None


def _bulges(tangents: np.ndarray, chords: np.ndarray) -> np.ndarray:
    """Bulges of arcs by their first tangents and chords."""
    across = tangents[:, 0] * chords[:, 1] - tangents[:, 1] * chords[:, 0]
    return np.asarray(np.tan(0.5 * np.arctan2(across, np.sum(tangents * chords, axis=1))))


def _distance(points: np.ndarray, starts: np.ndarray, ends: np.ndarray, bulges: np.ndarray) -> np.ndarray:
    """Distances of points (n, m, 2) from the circles of n arcs."""
    chord, b = ends - starts, bulges[:, None]
    middle, left = 0.5 * (starts + ends), np.column_stack([-chord[:, 1], chord[:, 0]])
    # |p - centre| - radius without dividing by a bulge that may be 0: (power of p) / (|p - centre| + radius)
    to = points - middle[:, None, :]
    along, square = np.sum(to * left[:, None, :], axis=2), np.sum(chord * chord, axis=1)[:, None]
    power = 4.0 * b * (np.sum(to * to, axis=2) - 0.25 * square) - 2.0 * (1.0 - b * b) * along
    centre = 4.0 * b[:, :, None] * to - (1.0 - b * b)[:, :, None] * left[:, None, :]
    return np.asarray(np.abs(power) / (np.hypot(*centre.transpose(2, 0, 1)) + np.sqrt(square) * (1.0 + b * b)))


ARC_POINTS = 48  # points of a drawn or examined quarter of a circle; shorter arcs have fewer
LARGEST_BULGE = math.tan(math.pi / 8.0)  # bulge of a quarter of a circle; longer arcs are halved
SMOOTH = 1e-9  # sine of the angle of two pieces [1] up to which they join without a corner
DOUBLED = 1e-12  # length of a piece over the size of the outline below which its ends count as one point


@record
class Outline(Input):
    """Closed chain of straight lines and circular arcs, with corners: wheels with slots, ratchets, pawls.

    Points are in either direction; stored counter-clockwise.  A bulge is that of the line from its point to the next
    one: > 0 for an arc that turns counter-clockwise, 0 for a straight line, at most 1, a semicircle.

    Raises
    ------
    InputError : too few points, points that coincide, bulges out of range, an outline that crosses itself.

    Notes
    -----
    The bulge is that of polylines of drawings (DXF).  Arcs of more than a quarter of a turn are stored as two.

    Examples
    --------
    A square with a round side:

    >>> body = Outline(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), bulges=(0.0, 1.0, 0.0, 0.0))
    >>> f"{body.area:.9f}"
    '1.392699082'
    """

    points: Any = field("(n, 2) points in the reference configuration, in order, n >= 2", "m")
    bulges: Any = field("(n,) tan(angle/4) of the arcs; left out: all straight", default=())

    def __post_init__(self) -> None:
        points = point_array("Outline", self.points)
        given = checks.sequence("Outline", "bulges", self.bulges, "numbers") or (0.0,) * len(points)
        bulges = np.array([checks.between("Outline", f"bulges[{k}]", b, -1.0, 1.0) for k, b in enumerate(given)])
        if len(bulges) != len(points):
            raise InputError(f"Outline: {len(points)} points and {len(bulges)} bulges; give one bulge for each point.")
        if len(points) < 2 or (len(points) == 2 and not np.any(bulges)):
            raise InputError(f"Outline: {len(points)} points enclose nothing; give at least 3, or 2 and an arc.")
        chords, size = np.hypot(*(np.roll(points, -1, axis=0) - points).T), float(np.ptp(points, axis=0).max())
        if chords.min() <= DOUBLED * size:
            k = int(np.argmin(chords))
            x, y = points[k]
            raise InputError(f"Outline: points {k} and {k + 1} are both ({x:.6g}, {y:.6g}) m; leave one of them out.")
        while np.any(np.abs(bulges) > LARGEST_BULGE * (1.0 + SMOOTH)):  # arcs of more than a quarter of a turn
            corners, halves = [], []
            for start, end, b in zip(points, np.roll(points, -1, axis=0), bulges, strict=True):
                corners.append(start)
                if abs(b) <= LARGEST_BULGE * (1.0 + SMOOTH):
                    halves.append(b)
                    continue
                chord = end - start
                corners.append(0.5 * (start + end) + 0.5 * b * np.array([chord[1], -chord[0]]))
                halves += [math.tan(0.5 * math.atan(b))] * 2
            points, bulges = np.array(corners), np.array(halves)
        polygon = _polygon(points, bulges)
        if planar.area(polygon) < 0.0:
            points, bulges = points[::-1], -np.roll(bulges[::-1], -1)
        if (place := crossing(polygon)) is not None:
            text = f"Outline: it crosses itself near ({place[0]:.6g}, {place[1]:.6g}) m."
            raise InputError(f"{text} Sort its points along the way.")
        object.__setattr__(self, "points", tuples(points))
        object.__setattr__(self, "bulges", tuples(bulges))

    @classmethod
    def from_curve(cls, curve: ClosedCurve, tolerance: float) -> Outline:
        """Outline of arcs with common tangents (biarcs), at most `tolerance` > 0 [m] away from a closed `curve`.

        Raises
        ------
        InputError : a tolerance that needs more than 128 arcs between two points of the curve.
        """
        name = "Outline.from_curve"
        checks.instance(name, "curve", curve, ClosedCurve, "a ClosedCurve")
        found = biarcs(curve.array, checks.positive(name, "tolerance", tolerance, "m"))
        if found is None:
            text = f"{name}: tolerance is {tolerance:g} m, beside a curve of {curve.size:.4g} m;"
            text += " it needs more than 128 arcs between two points."
            raise InputError(f"{text} Use CurveOnCurve, which takes the curve itself, or a larger tolerance.")
        return cls(*found)

    def __repr__(self) -> str:
        return f"Outline({len(self.points)} pieces)"

    @property
    def size(self) -> float:
        """Largest extent along X or Y [m]."""
        return float(np.ptp(self.polygon, axis=0).max())

    @property
    def area(self) -> float:
        """Area [m^2]."""
        angles, radii = 4.0 * np.arctan(self.bulges), [self.radius(k) for k in range(len(self.points))]
        return planar.area(np.array(self.points)) + float(0.5 * np.square(radii) @ (angles - np.sin(angles)))

    @property
    def polygon(self) -> np.ndarray:
        """Points (n, 2) of the outline, arcs resolved [m]."""
        return _polygon(np.array(self.points), np.array(self.bulges))

    @property
    def flatness(self) -> float:
        """Largest distance of `polygon` from the outline, or a larger one of a single chord [m]."""
        bends = [(abs(self.radius(k)), 2.0 * math.atan(abs(b))) for k, b in enumerate(self.bulges)]
        return max(radius * (1.0 - math.cos(min(half, 0.25 * math.pi / ARC_POINTS))) for radius, half in bends)

    def radius(self, k: int) -> float:
        """Radius of piece `k` [m], < 0 for a hollow arc, 0 for a straight line."""
        if self.bulges[k] == 0.0:
            return 0.0
        chord, b = math.dist(self.points[k], self.points[(k + 1) % len(self.points)]), self.bulges[k]
        return float(chord * (1.0 + b * b) / (4.0 * b))

    def centre(self, k: int) -> tuple[float, float]:
        """Centre of piece `k` [m], for a straight line its middle."""
        (x, y), (a, b) = self.points[k], self.points[(k + 1) % len(self.points)]
        bulge = self.bulges[k]
        if bulge == 0.0:
            return 0.5 * (x + a), 0.5 * (y + b)
        lever = (1.0 - bulge * bulge) / (4.0 * bulge)  # of the centre, to the left of the chord, over its length
        return 0.5 * (x + a) - lever * (b - y), 0.5 * (y + b) + lever * (a - x)

    def directions(self, k: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """Unit tangents at both ends of piece `k`."""
        (x, y), (a, b) = self.points[k], self.points[(k + 1) % len(self.points)]
        chord, half = math.atan2(b - y, a - x), 2.0 * math.atan(self.bulges[k])
        return (math.cos(chord - half), math.sin(chord - half)), (math.cos(chord + half), math.sin(chord + half))

    def bend(self, k: int) -> float:
        """Angle by which the outline bends outwards at point `k` [rad]; at a cusp half a turn, < 0 of a slit."""
        (ax, ay), (bx, by) = self.directions(k - 1)[1], self.directions(k)[0]
        sine, cosine = ax * by - ay * bx, ax * bx + ay * by
        if cosine < 0.0 and abs(sine) <= SMOOTH:  # convex arcs leave a slit between them, hollow ones are a tip
            return -math.copysign(math.pi, sum(1.0 / r for r in (self.radius(k - 1), self.radius(k)) if r))
        return math.atan2(sine, cosine)

    def hollow_corners(self) -> list[int]:
        """Numbers of the points at which the outline bends inwards."""
        return [k for k in range(len(self.points)) if self.bend(k) < -SMOOTH]

    def chains(self, radius: float = 0.0) -> list[list[int]]:
        """Numbers of the pieces between hollow places for a circle of a `radius` [m], 0 for corners alone.

        Hollow places are hollow corners, and hollow arcs that a circle does not fit into.  An outline with one of them
        has two chains; the second one begins at the point farthest from it.
        """
        n = len(self.points)
        narrow = {(k + 1) % n for k in range(n) if -radius <= self.radius(k) < 0.0}
        corners = sorted(narrow.union(self.hollow_corners()))
        if not corners:
            return [list(range(n))]
        if len(corners) == 1:
            hollow = self.points[corners[0]]
            far = max(range(n), key=lambda k: math.dist(self.points[k], hollow))
            corners.append(far if far > corners[0] else far + n)
        ends = [*corners[1:], corners[0] + n]
        return [[k % n for k in range(first, end)] for first, end in zip(corners, ends, strict=True)]

    def drawing(self) -> tuple[tuple[float, float], ...]:
        """Points of a closed polyline in the reference configuration [m], for pictures."""
        points = self.polygon
        return tuples(np.vstack([points, points[:1]]))  # type: ignore[no-any-return]


def _polygon(points: np.ndarray, bulges: np.ndarray) -> np.ndarray:
    """Points of the outline, arcs resolved."""
    found = []
    for k, b in enumerate(bulges):
        start, end = points[k], points[(k + 1) % len(points)]
        if b == 0.0:
            found.append(start[None])
            continue
        # a point at the fraction u of the angle, by the sines of both parts
        half = 2.0 * math.atan(b)
        count = math.ceil(ARC_POINTS * abs(half) / (0.25 * math.pi) - SMOOTH)
        u, chord = np.arange(count) / count, end - start
        far, turn = np.sin(half * u) / math.sin(half), -half * (1.0 - u)
        along, across = far * np.cos(turn), far * np.sin(turn)
        found.append(start + np.outer(along, chord) + np.outer(across, np.array([-chord[1], chord[0]])))
    return np.concatenate(found)


ROUNDED, POINTED, END = 0.0, 1.0, 2.0  # kinds of arcs of a round: an arc; a corner; end of an arc at a straight piece


@dataclass(frozen=True)
class RoundArc:
    """Arc of a round."""

    at: tuple[float, float]  # centre [m]; of a corner and of an end the point itself
    radius: float  # radius [m], 0 of a corner and of an end
    begin: float  # directions of the outward normals at both ends [rad]
    end: float
    kind: float  # `ROUNDED`, `POINTED` or `END`


def rounds(outline: Outline) -> list[list[RoundArc]]:
    """Rounds along an outline; one whose pieces are all convex arcs is a single round."""
    # Arcs and corners along the outline; True in place of straight pieces, False of hollow arcs and corners
    n, hollow, pieces = len(outline.points), set(outline.hollow_corners()), list[RoundArc | bool]()
    for k in range(n):
        before, (start, end) = outline.directions(k - 1 if k else n - 1)[1], outline.directions(k)
        if k in hollow:
            pieces.append(False)
        elif outline.bend(k) > SMOOTH:
            pieces.append(RoundArc(outline.points[k], 0.0, _normal(before), _normal(start), POINTED))
        if (radius := outline.radius(k)) > 0.0:
            pieces.append(RoundArc(outline.centre(k), radius, _normal(start), _normal(end), ROUNDED))
        else:
            pieces.append(radius == 0.0)
    breaks = [k for k, piece in enumerate(pieces) if not isinstance(piece, RoundArc)]
    if not breaks:
        return [[piece for piece in pieces if isinstance(piece, RoundArc)]]
    found = []
    for first, last in zip(breaks, [*breaks[1:], breaks[0] + len(pieces)], strict=True):
        own = [piece for k in range(first + 1, last) if isinstance(piece := pieces[k % len(pieces)], RoundArc)]
        if own:
            found.append([*_end(own[0], pieces[first], start=True), *own, *_end(own[-1], pieces[last % len(pieces)])])
    return found


def _end(arc: RoundArc, neighbour: RoundArc | bool, start: bool = False) -> list[RoundArc]:
    """The end of an arc at a straight piece, on which a flat side may rest; none at another piece."""
    if arc.kind == POINTED or neighbour is not True:
        return []
    angle = arc.begin if start else arc.end
    at = arc.at[0] + arc.radius * math.cos(angle), arc.at[1] + arc.radius * math.sin(angle)
    return [RoundArc(at, 0.0, angle, angle, END)]


def _normal(tangent: tuple[float, float]) -> float:
    """Direction of the outward normal at a tangent [rad]."""
    return math.atan2(-tangent[0], tangent[1])
