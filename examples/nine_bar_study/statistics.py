"""Means over correlated turns, and comparison of two means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb.errors import InputError

HIGHER, LOWER, EQUAL, UNTOLD = "higher", "lower", "equal", "no difference within the spread"
COVERAGE = 0.9973
"""Probability of all intervals, equal to three standard deviations of a normal distribution."""

NUMERICAL = 0.01
"""Relative difference of two means that may be an error of the integration."""

ALIKE = 0.05
"""Largest relative difference of two equal means."""


@dataclass(frozen=True)
class Mean:
    """Mean of a quantity over successive turns.

    Equation (10.2) of docs/theory/statistics.md.

    Parameters
    ----------
    value : mean [unit of the quantity].
    deviation : standard deviation of the turns [same].
    error : standard error of the mean, corrected for the correlation of neighbouring turns [same].
    count : number of turns.
    effective : number of independent turns with the same standard error.
    """

    value: float
    deviation: float
    error: float
    count: int
    effective: float

    @classmethod
    def of(cls, values: Sequence[float] | np.ndarray) -> Mean:
        """Mean of the values of successive turns.

        Parameters
        ----------
        values : (n,) one finite value per turn, n >= 2.

        Raises
        ------
        InputError : fewer than 2 values, or a value that is not finite.
        """
        x = np.asarray(values, dtype=np.float64).ravel()
        if len(x) < 2 or not np.isfinite(x).all():
            raise InputError(f"Mean: {len(x)} values, all finite: {bool(np.isfinite(x).all())}; give 2 finite ones.")
        tau, s = correlation_time(x), float(x.std(ddof=1))
        return cls(float(x.mean()), s, s * math.sqrt(tau / len(x)), len(x), len(x) / tau)

    @property
    def interval(self) -> float:
        """Half width of the interval that holds the true mean with the probability `COVERAGE` [unit]."""
        return _quantile(self.effective - 1.0) * self.error


def correlation_time(values: np.ndarray) -> float:
    """Correlation time of a value per turn [turns]: turns per independent turn, from 1 to n/2.

    The correlation time is 1 + 2 sum of the autocorrelations.  Autocorrelations of lag k carry the factor n/(n - k).
    The sum ends at the first pair of lags with a negative sum.
    Source: C. J. Geyer, Statistical Science 7 (1992) 473.

    Equation (10.1) of docs/theory/statistics.md.

    Parameters
    ----------
    values : (n,) values of successive turns.
    """
    n = len(values)
    x = values - values.mean()
    power = float(x @ x) / n
    if n < 8 or power <= 0.0:
        return 1.0
    total = 0.0
    for k in range(0, n // 2 - 1, 2):
        pair = sum(float(x[: n - m] @ x[m:]) / (n - m) for m in (k, k + 1)) / power
        if pair <= 0.0:
            break
        total += pair
    return min(max(2.0 * total - 1.0, 1.0), 0.5 * n)


@dataclass(frozen=True)
class Comparison:
    """Comparison of two means.

    Parameters
    ----------
    verdict : HIGHER, LOWER, EQUAL or UNTOLD, the relation of the first mean to the second.
    difference : first mean less second mean [unit of both].
    half : half width of the interval of the difference [same].
    ratio, low, high : first mean over second mean, and ends of its interval; NaN unless both means are positive.
    """

    verdict: str
    difference: float
    half: float
    ratio: float
    low: float
    high: float

    @property
    def shown(self) -> str:
        """Text of the ratio and its interval."""
        if not math.isfinite(self.ratio):
            return "-"
        ratio = plain(self.ratio, 3)
        return ratio if self.high - self.low < 2e-3 else f"{ratio} ({plain(self.low, 3)}..{plain(self.high, 3)})"


def plain(value: float, digits: int) -> str:
    """Text of a number with some significant digits."""
    return f"{float(f'{value:.{digits}g}'):g}"


def compare(first: Mean, second: Mean) -> Comparison:
    """Compare two means: higher, lower, equal or undecided.

    higher, lower : the interval of the difference lies beyond `NUMERICAL` of the larger mean.
    equal : the interval of the difference lies within `ALIKE` of the larger mean.
    no difference within the spread : all other cases; a verdict needs more turns.

    The interval holds the difference with the probability `COVERAGE`: B. L. Welch, Biometrika 34 (1947) 28, with
    effective numbers of turns.  The interval of the ratio is the interval of the difference of the logarithms.

    Equation (10.4) of docs/theory/statistics.md.
    """
    half = _quantile(_freedom((first.error, first.effective), (second.error, second.effective)))
    half *= math.hypot(first.error, second.error)
    difference, size = first.value - second.value, max(abs(first.value), abs(second.value))
    if difference - half > NUMERICAL * size:
        verdict = HIGHER
    elif difference + half < -NUMERICAL * size:
        verdict = LOWER
    else:
        verdict = EQUAL if abs(difference) + half <= ALIKE * size else UNTOLD
    return Comparison(verdict, difference, half, *_ratio(first, second))


def _ratio(first: Mean, second: Mean) -> tuple[float, float, float]:
    if min(first.value, second.value) <= 0.0:
        return math.nan, math.nan, math.nan
    parts = (first.error / first.value, second.error / second.value)
    freedom = _freedom((parts[0], first.effective), (parts[1], second.effective))
    width = _quantile(freedom) * math.hypot(*parts)
    ratio = first.value / second.value
    return ratio, ratio * math.exp(-width), ratio * math.exp(width)


def _freedom(*parts: tuple[float, float]) -> float:
    """Welch's degrees of freedom of (error, effective number) of two means."""
    below = sum(error**4 / max(number - 1.0, 1.0) for error, number in parts)
    return sum(error**2 for error, _ in parts) ** 2 / below if below > 0.0 else math.inf


def _quantile(freedom: float) -> float:
    """Quantile of Student's t of the two-sided probability `COVERAGE`."""
    from scipy.special import ndtri, stdtrit

    if freedom > 1e6:
        return float(ndtri(0.5 + 0.5 * COVERAGE))
    return float(stdtrit(max(freedom, 1.0), 0.5 + 0.5 * COVERAGE))


def binomial_tail(successes: int, trials: int, chance: float) -> float:
    """Probability of at least `successes` in a number of independent trials."""
    from scipy.special import bdtrc

    return 1.0 if successes <= 0 else float(bdtrc(successes - 1, trials, min(max(chance, 0.0), 1.0)))
