"""Means of series whose neighbours are not independent, with their standard errors."""

import math

import numpy as np


def mean_and_error(values, blocks=20) -> tuple[float, float]:
    """Mean of a series and its standard error from the means of blocks, correlation of neighbours counted."""
    values = np.asarray(values, dtype=float)
    size = len(values) // blocks
    means = values[: size * blocks].reshape(blocks, size).mean(axis=1)
    away = means - means.mean()
    r = max(0.0, float(away[1:] @ away[:-1] / max(away @ away, 1e-300)))
    return float(values.mean()), math.sqrt(away @ away / (blocks - 1) / blocks * (1.0 + r) / (1.0 - r))
