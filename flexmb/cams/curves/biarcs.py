"""Biarcs: smooth curves as chains of circular arcs with common tangents."""

from __future__ import annotations

import numpy as np

from flexmb.cams.curves.geometry import sampled

TRIED_POINTS = 8
"""Points of a pair of arcs at which the distance from the curve is measured."""

MOST_PARTS = 64
"""Largest number of pairs of arcs of a span."""


def biarcs(spans: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Points (m, 2) and bulges (m,) of arcs within `tolerance` [m] of spans (n, 2, 8), or None if too many are needed.

    Each part of a span becomes two arcs that share its ends and tangents, with equal tangent lengths.
    Source: D. S. Meek, D. J. Walton, Approximation of discrete data by G1 arc splines, Computer-Aided Design 24 (1992)
    301-306.
    """
    parts = 1
    while parts <= MOST_PARTS:
        points, slopes = sampled(spans, parts), sampled(spans, parts, 1)
        tangents = slopes / np.hypot(*slopes.T)[:, None]
        ends, end_tangents = np.roll(points, -1, axis=0), np.roll(tangents, -1, axis=0)
        joints = _joints(points, tangents, ends, end_tangents)
        first, second = _bulges(tangents, joints - points), -_bulges(-end_tangents, joints - ends)
        curve = sampled(spans, parts * TRIED_POINTS).reshape(len(points), TRIED_POINTS, 2)
        away = np.minimum(_distance(curve, points, joints, first), _distance(curve, joints, ends, second))
        if away.max() <= tolerance:
            chain = np.stack([points, joints], axis=1).reshape(-1, 2)
            return chain, np.stack([first, second], axis=1).ravel()
        parts *= 2
    return None


def _joints(points: np.ndarray, tangents: np.ndarray, ends: np.ndarray, end_tangents: np.ndarray) -> np.ndarray:
    """Points where both arcs of each pair meet, for tangents of equal length d at both ends."""
    chord = ends - points
    along = np.sum(chord * (tangents + end_tangents), axis=1)
    bend = 1.0 - np.sum(tangents * end_tangents, axis=1)
    square = np.sum(chord * chord, axis=1)
    d = square / (along + np.sqrt(along * along + 2.0 * bend * square))
    found: np.ndarray = 0.5 * (points + ends + d[:, None] * (tangents - end_tangents))
    return found


def _bulges(tangents: np.ndarray, chords: np.ndarray) -> np.ndarray:
    """Bulges of arcs by their first tangents and chords."""
    across = tangents[:, 0] * chords[:, 1] - tangents[:, 1] * chords[:, 0]
    along = np.sum(tangents * chords, axis=1)
    found: np.ndarray = np.tan(0.5 * np.arctan2(across, along))
    return found


def _distance(points: np.ndarray, starts: np.ndarray, ends: np.ndarray, bulges: np.ndarray) -> np.ndarray:
    """Distances of points (n, m, 2) from the circles of n arcs."""
    chord, b = ends - starts, bulges[:, None]
    middle, left = 0.5 * (starts + ends), np.column_stack([-chord[:, 1], chord[:, 0]])
    # |p - centre| - radius without dividing by a bulge that may be 0: (power of p) / (|p - centre| + radius)
    to = points - middle[:, None, :]
    along = np.sum(to * left[:, None, :], axis=2)
    square = np.sum(chord * chord, axis=1)[:, None]
    power = 4.0 * b * (np.sum(to * to, axis=2) - 0.25 * square) - 2.0 * (1.0 - b * b) * along
    centre = 4.0 * b[:, :, None] * to - (1.0 - b * b)[:, :, None] * left[:, None, :]
    found: np.ndarray = np.abs(power) / (np.hypot(*centre.transpose(2, 0, 1)) + np.sqrt(square) * (1.0 + b * b))
    return found
