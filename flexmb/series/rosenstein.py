"""The largest exponent from nearest neighbours, by the method of Rosenstein."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from flexmb.series.exponent import BLOCKS, SeriesExponent, block_means, estimate, straight_part
from flexmb.series.neighbours import distances, nearest, spread

REFERENCES = 2000
"""Largest number of points whose neighbours are observed; they are evenly spread over the record."""


def rosenstein(
    signal: Any,
    interval: Any = None,
    *,
    delay: int | None = None,
    dimension: int | None = None,
    theiler: int | None = None,
) -> SeriesExponent:
    """Largest exponent: slope of <ln |distance of nearest neighbours|> over time.

    The straight part begins one step after the time that a vector covers.  It ends where the error of its slope is
    smallest, at the latest where the mean logarithm is 1.5 below that of arbitrary points.  There is no value without
    4 points and a rise by a factor e, or if the slope does not exceed its error, as for periodic, quasi-periodic and
    random signals.

    For a flow (8 samples or more in a mean period) the distance is measured to the orbit of the neighbour instead of
    the neighbour, because two samples differ along the orbit by a constant up to a sampling interval.  For Rossler's x
    the estimate is then 0.071 instead of 0.046 (exact: 0.0714).

    The method is not suited to zero or negative exponents, nor to signals whose noise exceeds the distance of nearest
    neighbours.  It needs some 10^d to 30^d samples for an attractor of dimension d, and 20 mean periods.

    Parameters
    ----------
    signal : samples (n,), at least 500.
    interval : time between samples [s], or their times (n,) [s]; None: iterations of a map.
    delay : delay of the embedding [samples]; None: from `embedding`.
    dimension : dimension of the embedding; None: from `embedding`.
    theiler : smallest distance in time of neighbours [samples]; None: a mean period, and the window of a vector.

    Raises
    ------
    InputError : a signal that is too short or not finite, times that are not evenly spaced.

    Notes
    -----
    Source: M. T. Rosenstein, J. J. Collins and C. J. De Luca, Physica D 65 (1993) 117.
    Cost: 0.1 s for 1e4 samples of a map, 1 s of a flow.

    Examples
    --------
    >>> import flexmb as fm
    >>> x = [0.3]
    >>> for _ in range(4999):
    ...     x.append(4.0 * x[-1] * (1.0 - x[-1]))
    >>> abs(fm.chaos.rosenstein(x).value - 0.6931) < 0.03
    True
    """
    options = {"delay": delay, "dimension": dimension, "theiler": theiler}
    return estimate("rosenstein", partial(straight_part, _curves), signal, interval, options)


def _curves(points: np.ndarray, theiler: int, steps: np.ndarray, shift: int) -> np.ndarray:
    """Curves (blocks, k) of the mean logarithm of the distance, from points (n, m)."""
    count = len(points) - int(steps[-1])
    refs = spread(count, REFERENCES)
    neighbours, _ = nearest(points[:count], refs, theiler, least=1e-12)
    refs, neighbours = refs[neighbours >= 0], neighbours[neighbours >= 0]
    if len(refs) < 10 * BLOCKS:
        return np.empty((0, len(steps)))
    logs = np.empty((len(steps), len(refs)))
    for row, step in zip(logs, steps, strict=True):
        row[:] = distances(points, refs + step, neighbours + step, shift)
    logs = np.log(np.maximum(logs, 1e-12))
    return block_means(logs)
