"""Numerical derivatives with an estimate of their error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

STEPS, ORDERS = 22, 5
"""Number of step sizes, and largest number of extrapolations."""
ROUND_OFF = float(np.finfo(float).eps)
"""Relative round-off of a float."""


def slope(function: Callable[[float], Any], x: float, scale: float, noise: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """df/dx and its uncertainty, entry by entry, from central differences with steps that shrink from scale / 8.

    Each halving of the step is extrapolated (errors in h^2, h^4, ...).  The result is the value that differs least from
    its neighbours, so the step suits the function, and the uncertainty is large at a kink and with round-off.  The
    function of one number gives an array of any shape, and may change over the length `scale` > 0; `noise` is the
    round-off of its values beyond that of their own size.

    Source: C. J. F. Ridders, Accurate computation of F'(x) and F'(x)F''(x), Advances in Engineering Software 4 (1982)
    75-76.
    """
    best: Any = None
    uncertain: Any = np.inf
    before: list[np.ndarray] = []
    last: Any = np.inf
    for k in range(STEPS):
        h = scale / 8.0 / 2.0**k
        upper, lower = np.asarray(function(x + h)), np.asarray(function(x - h))
        span = (x + h) - (x - h)
        row = [(upper - lower) / span]
        for order, older in enumerate(before[:ORDERS], 1):
            factor = 4.0**order
            row.append((factor * row[-1] - older) / (factor - 1.0))
        if k > 0:
            change = np.maximum(np.abs(row[-1] - row[-2]), np.abs(row[-1] - before[-1]))
            change = np.where(np.isfinite(change), change, np.inf)
            blur = (2.0 * ROUND_OFF * np.maximum(np.abs(upper), np.abs(lower)) + noise) / span
            doubt = np.maximum(change, 0.01 * last) + blur  # two values may agree by accident, hardly three
            better = doubt < uncertain
            best = row[-1] if best is None else np.where(better, row[-1], best)
            uncertain = np.where(better, doubt, uncertain)
            last = change
        before = row
    return best, uncertain


def gradient(function: Callable[[Any], Any], x: Any, scale: Any, noise: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by the entries of x and their uncertainties, with the entries of x as last dimension."""
    if np.ndim(x) == 0:
        return slope(function, float(x), float(scale), noise)

    def along(j: int) -> Callable[[float], Any]:
        def moved(s: float) -> Any:
            y = np.array(x)
            y[j] = s
            return function(y)

        return moved

    steps = np.broadcast_to(scale, np.shape(x))
    columns = [slope(along(j), float(x[j]), float(s), noise) for j, s in enumerate(steps)]
    return np.stack([c for c, _ in columns], axis=-1), np.stack([u for _, u in columns], axis=-1)
