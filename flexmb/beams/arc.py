"""Circular arcs between two points, as the unstressed shape of beams and of their elements.

An arc from `start` to `end` turns by `turn` in all, counter-clockwise > 0; with `turn` 0 it is straight.  With the
distance c of the ends the length is c (turn/2)/sin(turn/2); the tangents at the ends lie turn/2 to the right and to the
left of the line between them.
Equations (2.17) and (2.18) of docs/theory/beam.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flexmb import checks

Point = tuple[float, float]


def checked_turn(label: str, name: str, value: object) -> float:
    """`value` as the turn of an arc [rad], or `InputError`."""
    turn = checks.number(label, name, value, "rad")
    if abs(turn) >= 2.0 * math.pi:
        text = f"{label}: {name} is {turn:g} rad; an arc between two points turns by less than 2 pi"
        checks.refuse(f"{text}. Divide it into several; angles are in rad.")
    return turn


def chord_share(turn: float) -> float:
    """Distance of the ends of an arc over its length: sin(turn/2)/(turn/2)."""
    return math.sin(0.5 * turn) / (0.5 * turn) if turn else 1.0


def tangents(start: Point, end: Point, turn: float, places: Sequence[float]) -> list[float]:
    """Directions of an arc at fractions of its length [rad]."""
    line = math.atan2(end[1] - start[1], end[0] - start[0])
    return [line + (s - 0.5) * turn for s in places] if turn else [line] * len(places)


def points(start: Point, end: Point, turn: float, places: Sequence[float]) -> list[Point]:
    """Points of an arc between its ends [m], at fractions of its length, 0 at the start and 1 at the end.

    From start to end the arc turns by `turn` [rad], between -2 pi and 2 pi.
    """
    (x, y), (dx, dy) = start, (end[0] - start[0], end[1] - start[1])
    if not turn:
        return [(x + s * dx, y + s * dy) for s in places]
    found = []
    for s in places:
        share = math.sin(0.5 * s * turn) / math.sin(0.5 * turn)
        c, d = share * math.cos(0.5 * (s - 1.0) * turn), share * math.sin(0.5 * (s - 1.0) * turn)
        found.append((x + c * dx - d * dy, y + d * dx + c * dy))
    return found


def unstressed_elements(lengths: np.ndarray, bow: np.ndarray, turn: float) -> np.ndarray:
    """l0, u10 and u20 (n, 3) of the elements of an arc: free length [m] and free rotations against the chord [rad].

    `lengths` (n,) of the elements lie along the arc [m], `bow` (n, 3) is the shortening of their chords, see
    `flexmb.beams.shear`; all elements together turn by `turn` [rad].
    """
    half = 0.5 * turn * lengths / lengths.sum()
    chords = lengths * np.sinc(half / math.pi)
    free = chords + lengths / 30.0 * half * half * bow.sum(axis=1)
    return np.stack([free, -half, half], axis=1)
