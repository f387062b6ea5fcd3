"""Profile of a worn surface, and the places that it leaves to the centre of the journal.

The angles are phi_i = 2 pi i/n in the axes of the worn body, u the directions there, h_i the depths.  The places that a
worn joint leaves free are e . u_i <= c + h_i for all i: a convex set.  What no journal can reach is a valley.  The set
is known by its support sigma and the radius of curvature rho = sigma + sigma'', which is linear between the angles.

Equations (16.1) to (16.3) of docs/theory/wear.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

# Error of a force that a foundation carries over this force, which counts as none [1].
CARRIED = 1e-12
# Least cosine of an angle from the normal at which a foundation carries something [1].
LEAST_COSINE = 1e-9


class Surface(NamedTuple):
    """Tables by angle of the free places; each (n,)."""

    cos: np.ndarray  # directions u
    sin: np.ndarray
    support: np.ndarray  # sigma [m]
    slope: np.ndarray  # sigma' [m]
    radius: np.ndarray  # rho >= 0 [m]
    wall: np.ndarray  # place of the surface, sigma or beyond in valleys [m]


def surface(clearance: float, depths: Sequence[float] | np.ndarray) -> Surface:
    """Tables of a surface with the `depths` h (n,) [m]."""
    h = np.array(depths, dtype=float)
    n, step = len(h), 2.0 * np.pi / len(h)
    phi, cos, sin = step * np.arange(n), np.cos(step), np.sin(step)
    x, y = np.cos(phi), np.sin(phi)
    reached = _reached(clearance, h, x, y)
    bend = np.roll(reached, 1) - 2.0 * cos * reached + np.roll(reached, -1)
    rho = np.maximum(clearance + bend / (2.0 * (1.0 - cos)), 0.0)
    waves = np.cos(step * np.arange(n // 2 + 1))
    factor = (waves - cos + (1.0 - waves) * sin / step) / (1.0 - cos)
    sigma = clearance + np.fft.irfft(np.fft.rfft(reached) * factor, n)
    rest = sigma - rho
    slope = (np.roll(rho, -1) - rho) / step + (np.roll(rest, -1) - rest * cos) / sin
    return Surface(x, y, sigma, slope, rho, np.minimum(sigma, clearance + reached) + h - reached)


def _reached(clearance: float, h: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Depths that a journal can reach (n,): the largest support of a convex set below c + h, less c."""
    # The lines that bound the set are the corners of the convex hull of the points u/(c + h), polar to it.
    n, scale = len(h), 1.0 / (clearance + h)
    first = int(np.argmin(h))
    order = [*range(first, n), *range(first), first]
    dual = list(zip((x * scale).tolist(), (y * scale).tolist(), strict=True))
    kept: list[int] = []
    for i in order:
        while len(kept) > 1 and _turns_right(dual[kept[-2]], dual[kept[-1]], dual[i]):
            kept.pop()
        kept.append(i)
    reached = h.copy()
    for a, b in pairwise(kept):
        skipped = np.arange(a + 1, b if b > a else b + n) % n
        if len(skipped):
            across = x[a] * y[b] - y[a] * x[b]
            corner = (
                ((clearance + h[a]) * y[b] - (clearance + h[b]) * y[a]) / across,
                ((clearance + h[b]) * x[a] - (clearance + h[a]) * x[b]) / across,
            )
            reached[skipped] = np.minimum(h[skipped], corner[0] * x[skipped] + corner[1] * y[skipped] - clearance)
    return reached


def _turns_right(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    """Whether the way from a over b to c does not turn to the left."""
    return (b[0] - a[0]) * (c[1] - b[1]) <= (b[1] - a[1]) * (c[0] - b[0])


def shares(tables: Surface, x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Shares of the angles in the pressure (rows, n), each row with the sum 1."""
    # x, y : centre of the journal in the axes of the worn body (rows,) [m]; angle : of the normal there (rows,) [rad].
    depth = np.outer(x, tables.cos) + np.outer(y, tables.sin) - tables.wall
    np.maximum(depth, 0.0, out=depth)
    total, n = depth.sum(axis=1), len(tables.cos)
    narrow = np.flatnonzero(total <= 0.0)  # narrower than the distance of two angles
    place = angle[narrow] / (2.0 * np.pi) * n
    left = np.floor(place)
    depth[narrow, left.astype(int) % n] = 1.0 - (place - left)
    depth[narrow, (left.astype(int) + 1) % n] += place - left
    total[narrow] = 1.0
    return np.asarray(depth / total[:, None])


def settled(
    tables: Surface, x: np.ndarray, y: np.ndarray, angle: np.ndarray, depth: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places of the journal's centre, moved along the normal until the pressure carries a force; each (rows,) [m]."""
    # depth : of the contact at the places x, y; force : over the stiffness of an angle [m]. The force that the pressure
    # carries is a convex function of the depth, so Newton's method from above ends with the angles that are pressed.
    nx, ny = np.cos(angle), np.sin(angle)
    free = np.outer(x - depth * nx, tables.cos) + np.outer(y - depth * ny, tables.sin) - tables.wall
    near = np.maximum(np.outer(nx, tables.cos) + np.outer(ny, tables.sin), LEAST_COSINE)
    d = ((force[:, None] / near - free) / near).min(axis=1)
    while True:
        pressed = np.maximum(free + d[:, None] * near, 0.0)
        excess = (pressed * near).sum(axis=1) - force
        if not (excess > CARRIED * force).any():
            return x + (d - depth) * nx, y + (d - depth) * ny
        d -= excess / (near**2 * (pressed > 0.0)).sum(axis=1)


def smoothed(depths: np.ndarray) -> np.ndarray:
    """Means of a depth and its neighbours, weights 1/4, 1/2, 1/4; the sum stays the same."""
    return np.asarray(0.5 * depths + 0.25 * (np.roll(depths, 1) + np.roll(depths, -1)))
