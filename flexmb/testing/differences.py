"""Derivatives from values alone, with an estimate of their error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

STEPS, ORDERS = 22, 5


def slope(function: Callable[[float], Any], x: float, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """df/dx and its uncertainty, entry by entry, from central differences with steps that shrink from scale / 8.

    Each halving of the step is extrapolated (errors in h^2, h^4, ...), and of all the values the one that its
    neighbours confirm best is taken.  So the step suits the function, and the uncertainty stays large at a kink.

    Parameters
    ----------
    function : of one number, to an array of any shape.
    x : where.
    scale : length over which the function may change, > 0.

    Notes
    -----
    Source: C. J. F. Ridders, Accurate computation of F'(x) and F'(x)F''(x), Advances in Engineering Software 4 (1982)
    75-76.
    """
    best: Any = None
    uncertain: Any = None
    before: list[np.ndarray] = []
    last: Any = np.inf
    for k in range(STEPS):
        h = scale / 8.0 / 2.0**k
        low, high = x - h, x + h
        row = [(np.asarray(function(high)) - np.asarray(function(low))) / (high - low)]
        for order, older in enumerate(before[:ORDERS], 1):
            factor = 4.0**order
            row.append((factor * row[-1] - older) / (factor - 1.0))
        if k > 0:
            change = np.maximum(np.abs(row[-1] - row[-2]), np.abs(row[-1] - before[-1]))
            doubt = np.maximum(change, 0.01 * last)  # two values may agree by accident, hardly three
            better = doubt < (np.inf if uncertain is None else uncertain)
            best = row[-1] if best is None else np.where(better, row[-1], best)
            uncertain = doubt if uncertain is None else np.where(better, doubt, uncertain)
            last = change
        before = row
    return best, uncertain


def gradient(function: Callable[[Any], Any], x: Any, scale: Any) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by the entries of x (a number or an array) and their uncertainties, the entries of x last."""
    if np.ndim(x) == 0:
        return slope(function, float(x), float(scale))

    def along(j: int) -> Callable[[float], Any]:
        def moved(s: float) -> Any:
            y = np.array(x)
            y[j] = s
            return function(y)

        return moved

    columns = [slope(along(j), float(x[j]), float(s)) for j, s in enumerate(np.broadcast_to(scale, np.shape(x)))]
    return np.stack([c for c, _ in columns], axis=-1), np.stack([u for _, u in columns], axis=-1)
