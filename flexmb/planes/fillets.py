"""Rounded corners of polygons: tangent arcs in their places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from flexmb import checks
from flexmb.errors import InputError

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

FEWEST_ON_ARC = 3
"""Least number of edges on an arc, so its nodes show a circle."""

SAME_PLACE = 1e-9
"""Distance over the longest edge [1] below which the ends of two arcs are one point."""

STRAIGHT = 1e-6
"""Turn of the outline at a corner up to which it is straight [rad]."""


def checked_fillets(label: str, fillet: float | Sequence[float], corners: int) -> Array:
    """Radius of each corner [m], 0 for sharp ones; `fillet` is one radius for all corners, or one for each [m]."""
    if isinstance(fillet, str) or np.ndim(fillet) == 0:
        return np.full(corners, checks.not_negative(label, "fillet", fillet, "m"))
    radii = [checks.not_negative(label, f"fillet[{i}]", radius, "m") for i, radius in enumerate(fillet)]  # type: ignore[arg-type]
    if len(radii) != corners:
        raise InputError(
            f"{label}: fillet has {len(radii)} radii, the outline {corners} corners. Give one number, or one for each "
            "corner, 0 for a sharp one."
        )
    return np.array(radii)


def rounded(label: str, corners: Array, radii: Array, size: float) -> tuple[Array, list[Indices]]:
    """A polygon with arcs as fine polylines in place of its corners, and the numbers of the points on each arc.

    Corners (n, 2) stand counter-clockwise, and radii (n,) of 0 are sharp corners [m]; edges on the arcs have `size` [m]
    at most.  The new corners (p, 2) [m] include the tangent points of arcs.  Arcs that do not fit onto an edge are
    refused.
    """
    after, before = np.roll(corners, -1, axis=0) - corners, corners - np.roll(corners, 1, axis=0)
    lengths = np.linalg.norm(after, axis=1)
    turns = _turns(before, after)
    tangents = radii * np.tan(0.5 * np.abs(turns))  # from the corner to where the arc begins
    _require_room(label, radii, tangents, lengths)
    points: list[Array] = []
    arcs: list[Indices] = []
    count = 0
    for corner, radius, turn, reach, way, length in zip(corners, radii, turns, tangents, after, lengths, strict=True):
        if radius == 0.0 or abs(turn) < STRAIGHT:
            piece = corner[None, :]
        else:
            piece = _arc(corner, radius, turn, reach, way / length, size)
            arcs.append(count + np.arange(len(piece)))
        points.append(piece)
        count += len(piece)
    found = np.concatenate(points)
    return _without_repeats(found, arcs, lengths.max())


def _turns(before: Array, after: Array) -> Array:
    """Turn of the direction at each corner [rad], > 0 to the left."""
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.arctan2(cross, (before * after).sum(axis=1)))


def _require_room(label: str, radii: Array, tangents: Array, lengths: Array) -> None:
    ends = np.roll(tangents, -1)
    lacking = tangents + ends - lengths * (1.0 + 1e-12)
    if lacking.max() <= 0.0:
        return
    i = int(lacking.argmax())
    j = (i + 1) % len(radii)
    most = lengths[i] / (tangents[i] + ends[i])
    raise InputError(
        f"{label}: the fillets of {radii[i]:g} and {radii[j]:g} m at corners {i} and {j} take "
        f"{tangents[i] + ends[i]:.4g} m of the edge between them, which is {lengths[i]:.4g} m long. "
        f"Make them smaller, {most:.3g} times these radii at most."
    )


def _arc(corner: Array, radius: float, turn: float, reach: float, ahead: Array, size: float) -> Array:
    """Points on the arc at a corner, in the order of the outline; `ahead` is the direction behind the corner."""
    side = np.sign(turn)
    inwards = side * np.array([-ahead[1], ahead[0]])
    centre = corner + reach * ahead + radius * inwards
    count = max(FEWEST_ON_ARC, int(np.ceil(abs(turn) * radius / size)))
    angle = np.arctan2(-inwards[1], -inwards[0]) - turn * (1.0 - np.arange(count + 1) / count)
    return np.asarray(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def _without_repeats(points: Array, arcs: list[Indices], size: float) -> tuple[Array, list[Indices]]:
    """Points, each place once, where an arc begins at the end of another one."""
    kept = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > SAME_PLACE * size
    numbers = (np.cumsum(kept) - 1) % kept.sum()  # the first point may be the last one
    return points[kept], [numbers[arc] for arc in arcs]
