"""Neighbours in state space that are distant in time, and their distances."""

from __future__ import annotations

import numpy as np

BLOCK = 1_000_000
"""Largest number of distances in memory."""


def spread(count: int, most: int) -> np.ndarray:
    """At most `most` indices (r,), spread evenly over `count` points."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def nearest(points: np.ndarray, refs: np.ndarray, theiler: int, least: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Nearest neighbour of each reference point, outside a window of time (J. Theiler, Phys. Rev. A 34 (1986) 2427).

    Returned are indices (r,) of the neighbours of points[refs], -1 without a neighbour, and their distances (r,),
    `least` at least.  Points are (n, m), `theiler` is the smallest distance in time of neighbours [samples].
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    neighbour, distance = np.full(len(refs), -1), np.full(len(refs), np.nan)
    unfinished, k = np.arange(len(refs)), 4
    while len(unfinished):
        k = min(k, len(points))
        for block in np.array_split(unfinished, max(1, len(unfinished) * k // BLOCK)):
            d, j = tree.query(points[refs[block]], k=k)
            d, j = d.reshape(len(block), k), j.reshape(len(block), k)
            allowed = (np.abs(j - refs[block][:, None]) > theiler) & (d > least)
            first = allowed.argmax(axis=1)
            has_neighbour = allowed[np.arange(len(block)), first]
            neighbour[block[has_neighbour]] = j[has_neighbour, first[has_neighbour]]
            distance[block[has_neighbour]] = d[has_neighbour, first[has_neighbour]]
        unfinished = unfinished[neighbour[unfinished] < 0]
        if k == len(points) or k > 4096:  # points without a neighbour are left out
            break
        k *= 4
    return neighbour, distance


def typical_log_distance(points: np.ndarray, *, stride: int = 1, shift: int = 0) -> float:
    """Mean logarithm of the distance of two arbitrary points of (n, m); see `distances` for `shift`.

    The distance in time is a multiple of `stride` [samples].
    """
    rng, count = np.random.default_rng(1), len(points)
    i, j = rng.integers(0, count, 5000), rng.integers(0, count, 5000)
    j = i + (j - i) // stride * stride
    inside = (j >= 0) & (j != i)
    d = distances(points, i[inside], j[inside], shift)
    return float(np.log(d[d > 0.0]).mean()) if (d > 0.0).any() else -np.inf


def distances(points: np.ndarray, i: np.ndarray, j: np.ndarray, shift: int) -> np.ndarray:
    """Distances (k,) of points[i] from points[j]; with `shift` > 0 from the orbit through points[j].

    Two samples of one orbit differ along the orbit by up to a sampling interval.  This constant difference would hide
    the growth of the distance.  Therefore the nearest sample within `shift` of j is taken, and the component of its
    distance across the orbit.  Points are (n, m); `shift` is the half width of the search along the orbit [samples].
    """
    if shift == 0:
        return np.asarray(np.linalg.norm(points[j] - points[i], axis=1))
    last = len(points) - 2
    best, least = np.clip(j, 1, last), np.full(len(i), np.inf)
    for s in range(-shift, shift + 1):
        other = np.clip(j + s, 1, last)
        gap = points[other] - points[i]
        square = np.einsum("ij,ij->i", gap, gap)
        nearer = square < least
        best[nearer], least[nearer] = other[nearer], square[nearer]
    gap, along = points[best] - points[i], points[best + 1] - points[best - 1]
    parallel = np.einsum("ij,ij->i", gap, along)
    parallel = parallel**2 / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    return np.asarray(np.sqrt(np.maximum(least - parallel, 0.0)))
