"""Turns of arcs that follow a smooth curve through points."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from flexmb import checks
from flexmb.errors import InputError

Point = tuple[float, float]


def smooth_turns(points: Iterable[Point], closed: bool = False) -> tuple[float, ...]:
    """Turns of arcs from point to point along the cubic spline through points: `turns` of a `FlexibleFrame`.

    The spline has the distances of the points as its parameter and ends that are bent like their neighbours
    ("not-a-knot"; with three points a parabola, with two a line).  Turns have an error of third order of the distances
    of the points at the ends of an open curve, of fourth order and less elsewhere; where the curvature varies, the
    directions of neighbouring arcs differ at a point by an angle of second order.  Frames have no forces from either.

    Parameters
    ----------
    points : the points in order [m], at least two; neighbours apart.
    closed : whether the curve goes on from the last point to the first, which is not repeated.

    Returns
    -------
    tuple of float
        One turn [rad] for each pair of neighbours, counter-clockwise > 0.

    Raises
    ------
    InputError : too few points, neighbours at one place, points too far apart for their turn.

    Examples
    --------
    >>> corner = (0.0, 0.0), (0.1, 0.0), (0.15, 0.05), (0.15, 0.15)
    >>> [round(turn, 3) for turn in smooth_turns(corner)]
    [1.0, 0.587, 1.0]
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - takes long to import

    owner = "smooth_turns"
    given = checks.sequence(owner, "points", points, "points (x, y)")
    path = np.array([checks.point(owner, f"points[{i}]", p) for i, p in enumerate(given)])
    if len(path) < (3 if closed else 2):
        raise InputError(f"{owner}: {len(path)} points make no curve; give at least {3 if closed else 2}.")
    if closed:
        path = np.concatenate([path, path[:1]])
    steps = np.hypot(*np.diff(path, axis=0).T)
    if not np.all(steps > 0.0):
        k = int(np.argmin(steps > 0.0))
        raise InputError(f"{owner}: points[{k}] and the next one are both {tuple(path[k].tolist())}; remove one.")
    spline = CubicSpline(np.cumsum([0.0, *steps]), path, bc_type="periodic" if closed else "not-a-knot")
    slopes = spline(spline.x, 1)
    turns = np.diff(np.unwrap(np.arctan2(slopes[:, 1], slopes[:, 0])))
    if np.abs(turns).max() >= 0.5 * math.pi:
        k = int(np.abs(turns).argmax())
        text = f"{owner}: from points[{k}] to the next one the curve turns by {turns[k]:.3g} rad"
        raise InputError(f"{text}; give points between them, at most pi/2 apart.")
    return tuple(turns.tolist())
