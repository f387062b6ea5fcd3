"""Rounds of an outline: runs of convex arcs and corners between straight and hollow pieces."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb.cams.curves.outline import SMOOTH, Outline

ROUNDED, POINTED, END = 0.0, 1.0, 2.0
"""Kinds of arcs of a round: an arc; a corner; the end of an arc at a straight piece."""


@dataclass(frozen=True)
class RoundArc:
    """Arc of a round.

    Parameters
    ----------
    at : centre [m]; of a corner and of an end the point itself.
    radius : radius [m], 0 of a corner and of an end.
    begin, end : directions of the outward normals at both ends [rad].
    kind : `ROUNDED`, `POINTED` or `END`.
    """

    at: tuple[float, float]
    radius: float
    begin: float
    end: float
    kind: float


def rounds(outline: Outline) -> list[list[RoundArc]]:
    """Rounds along an outline; one whose pieces are all convex arcs is a single round."""
    pieces = _pieces(outline)
    breaks = [k for k, piece in enumerate(pieces) if not isinstance(piece, RoundArc)]
    if not breaks:
        return [[piece for piece in pieces if isinstance(piece, RoundArc)]]
    found = []
    for before, after in zip(breaks, [*breaks[1:], breaks[0] + len(pieces)], strict=True):
        own = [piece for k in range(before + 1, after) if isinstance(piece := pieces[k % len(pieces)], RoundArc)]
        if own:
            found.append([*_end(own[0], pieces[before], start=True), *own, *_end(own[-1], pieces[after % len(pieces)])])
    return found


def _pieces(outline: Outline) -> list[RoundArc | bool]:
    """Arcs and corners along an outline; True in place of straight pieces, False of hollow arcs and corners."""
    n, hollow, found = len(outline.points), set(outline.hollow_corners()), list[RoundArc | bool]()
    for k in range(n):
        before, (start, end) = outline.directions(k - 1 if k else n - 1)[1], outline.directions(k)
        if k in hollow:
            found.append(False)
        elif before[0] * start[1] - before[1] * start[0] > SMOOTH:
            found.append(RoundArc(outline.points[k], 0.0, _normal(before), _normal(start), POINTED))
        radius = outline.radius(k)
        if radius > 0.0:
            found.append(RoundArc(outline.centre(k), radius, _normal(start), _normal(end), ROUNDED))
        else:
            found.append(radius == 0.0)
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
