"""Nearest neighbours of embedded points, without points closer in time than the Theiler window."""

from __future__ import annotations

import numpy as np

BLOCK = 1_000_000
"""Distances that are held at a time."""


def spread(count: int, most: int) -> np.ndarray:
    """At most `most` indices (r,), spread evenly over `count` points."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def nearest(points: np.ndarray, refs: np.ndarray, theiler: int, least: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Nearest neighbour of each of `points[refs]`, more than `theiler` samples apart and farther than `least`.

    Points (n, m), refs (r,); indices (r,), -1 where there is none, and distances (r,).
    J. Theiler, Phys. Rev. A 34 (1986) 2427, for the window.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    near, distance = np.full(len(refs), -1), np.full(len(refs), np.nan)
    open_, k = np.arange(len(refs)), 4
    while len(open_):
        k = min(k, len(points))
        for part in np.array_split(open_, max(1, len(open_) * k // BLOCK)):
            d, j = tree.query(points[refs[part]], k=k)
            d, j = d.reshape(len(part), k), j.reshape(len(part), k)
            allowed = (np.abs(j - refs[part][:, None]) > theiler) & (d > least)
            first = allowed.argmax(axis=1)
            hit = allowed[np.arange(len(part)), first]
            near[part[hit]] = j[hit, first[hit]]
            distance[part[hit]] = d[hit, first[hit]]
        open_ = open_[near[open_] < 0]
        if k == len(points) or k > 4096:  # so many at one spot: the others have spoken
            break
        k *= 4
    return near, distance


def typical_log_distance(points: np.ndarray, *, stride: int = 1, shift: int = 0) -> float:
    """Mean logarithm of the distance of two arbitrary points (n, m), a multiple of `stride` apart in time.

    `shift` as of `distances`.
    """
    rng, count = np.random.default_rng(1), len(points)
    i, j = rng.integers(0, count, 5000), rng.integers(0, count, 5000)
    j = i + (j - i) // stride * stride
    inside = (j >= 0) & (j != i)
    d = distances(points, i[inside], j[inside], shift)
    return float(np.log(d[d > 0.0]).mean()) if (d > 0.0).any() else -np.inf


def distances(points: np.ndarray, i: np.ndarray, j: np.ndarray, shift: int) -> np.ndarray:
    """Distances (k,) of points[i] from points[j]; with `shift` > 0 from the orbit through points[j].

    Two samples of one orbit are apart along it by any part of a sampling interval, and stay so: a constant that hides
    the growth of the rest.  So the nearest of the samples within `shift` of j is taken, and of its distance the part
    across the orbit there.
    """
    if shift == 0:
        return np.linalg.norm(points[j] - points[i], axis=1)
    last = len(points) - 2
    best, least = np.clip(j, 1, last), np.full(len(i), np.inf)
    for s in range(-shift, shift + 1):
        other = np.clip(j + s, 1, last)
        gap = points[other] - points[i]
        square = np.einsum("ij,ij->i", gap, gap)
        nearer = square < least
        best[nearer], least[nearer] = other[nearer], square[nearer]
    gap, along = points[best] - points[i], points[best + 1] - points[best - 1]
    part = np.einsum("ij,ij->i", gap, along)
    part = part**2 / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    return np.sqrt(np.maximum(least - part, 0.0))
