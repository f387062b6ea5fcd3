"""Means of turns that are not independent of one another, and what may be said of two of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb.errors import InputError

HIGHER, LOWER, EQUAL, UNTOLD = "higher", "lower", "equal", "no difference within the spread"
COVERAGE = 0.9973
"""Of all intervals: that of three standard deviations of a normal distribution."""

NUMERICAL = 0.01
"""A difference below this part of the larger mean is left to the errors of the steps and decides nothing."""

ALIKE = 0.05
"""Two means whose difference surely lies below this part of the larger one are called equal."""


@dataclass(frozen=True)
class Mean:
    """The mean of a quantity over turns.

    Parameters
    ----------
    value : the mean [unit of the quantity].
    deviation : standard deviation of the turns [same].
    error : standard error of the mean, corrected for the correlation of neighbouring turns [same].
    count : number of turns.
    effective : so many independent turns would have the same error.
    """

    value: float
    deviation: float
    error: float
    count: int
    effective: float

    @classmethod
    def of(cls, values: Sequence[float] | np.ndarray) -> Mean:
        """From the values of successive turns.

        Parameters
        ----------
        values : (n,) one value a turn, at least 2, finite.

        Raises
        ------
        InputError : fewer than 2 values, or values that are not finite.
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

    def scaled(self, factor: float) -> Mean:
        """The same in another unit; `factor` is how many of them are in one of the old."""
        return Mean(factor * self.value, abs(factor) * self.deviation, abs(factor) * self.error, *self._counts)

    @property
    def _counts(self) -> tuple[int, float]:
        return self.count, self.effective


def correlation_time(values: np.ndarray) -> float:
    """Correlation time of a value per turn: number of successive turns that count as one independent turn, >= 1.

    1 + 2 sum of the autocorrelations (n/(n - k) for the lost products), summed in pairs of lags as long as a pair is
    positive: C. J. Geyer, Statistical Science 7 (1992) 473.  Correlations that make a mean more certain are not
    counted on, so the result is never below 1; nor is it above n/2.

    Parameters
    ----------
    values : (n,) of successive turns.
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
    """One mean against another.

    Parameters
    ----------
    verdict : HIGHER, LOWER, EQUAL or UNTOLD: what the first is against the second.
    difference : first less second [unit of both].
    half : half width of its interval [same].
    ratio, low, high : first over second, and the interval's ends; NaN where the second may be zero.
    """

    verdict: str
    difference: float
    half: float
    ratio: float
    low: float
    high: float

    @property
    def shown(self) -> str:
        """The ratio and its interval."""
        if not math.isfinite(self.ratio):
            return "-"
        ratio = plain(self.ratio, 3)
        return ratio if self.high - self.low < 2e-3 else f"{ratio} ({plain(self.low, 3)}..{plain(self.high, 3)})"


def plain(value: float, digits: int) -> str:
    """`value` to so many digits, without an exponent unless it is very small.

    Parameters
    ----------
    value : a number.
    digits : how many of them count.
    """
    return f"{float(f'{value:.{digits}g}'):g}"


def compare(first: Mean, second: Mean) -> Comparison:
    """Comparison of two means: higher, lower, equal or open.

    higher, lower : the interval of the difference lies beyond `NUMERICAL` of the larger mean.
    equal : it lies within `ALIKE` of the larger mean.
    no difference within the spread : neither; more turns would be needed.

    The interval holds the difference with the probability `COVERAGE`: B. L. Welch, Biometrika 34 (1947) 28, with the
    effective numbers of turns; that of the ratio is the same in logarithms.

    Parameters
    ----------
    first, second : the means, in the same unit.
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
    """Of Student's t, two-sided."""
    from scipy.special import ndtri, stdtrit

    if freedom > 1e6:
        return float(ndtri(0.5 + 0.5 * COVERAGE))
    return float(stdtrit(max(freedom, 1.0), 0.5 + 0.5 * COVERAGE))


def binomial_tail(successes: int, trials: int, chance: float) -> float:
    """Probability of at least so many successes by chance alone.

    Parameters
    ----------
    successes, trials : how many of how many.
    chance : of each [1].
    """
    from scipy.special import bdtrc

    return 1.0 if successes <= 0 else float(bdtrc(successes - 1, trials, min(max(chance, 0.0), 1.0)))
