"""The 0-1 test for chaos."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.series.samples import is_constant, mean_period, samples, standardised
from flexmb.fields import field, record_with
from flexmb.late import scipy

ENOUGH = 200  # smallest number of samples after thinning
REGULAR, CHAOTIC = 0.3, 0.7  # limits of K: below the first the signal is regular, above the second chaotic


@record_with(eq=False)
class ZeroOne:
    """Result of the 0-1 test."""

    value: float = field("median of the correlations K: about 0 of regular, 1 of chaotic or random signals, or NaN")
    spread: float = field("half the distance of the quartiles of the correlations")
    kind: str = field('"regular" (below 0.3), "chaotic" (above 0.7) or "undecided"')
    ok: bool = field("whether there are enough samples")
    status: str = field("result in a sentence")
    thin: int = field("distance of the samples that are used [samples]")
    frequencies: np.ndarray = field("angles c (k,) [rad/sample]", repr=False)
    correlations: np.ndarray = field("K_c (k,)", repr=False)


def zero_one_test(signal: Any, *, thin: int | None = None, count: int = 100, seed: int = 0) -> ZeroOne:
    """The 0-1 test for chaos of Gottwald and Melbourne: 0 regular, 1 chaotic.

    The signal phi drives p(n) = sum phi(j) cos(j c), q(n) = sum phi(j) sin(j c).  K_c is the correlation with n of the
    modified mean square displacement, M_c(n) - <phi>^2 (1 - cos n c) / (1 - cos c), for n up to a tenth of the
    record; K is the median over random c in (pi/5, 4 pi/5).

    The test is for deterministic signals: noise gives 1 as well.  Oversampled chaos would give 0, so only every s-th
    sample is used, with s a quarter of the mean period (rounded, at least 1).  Intermittent and banded chaos needs
    records much longer than the laminar phases.

    Equations (9.10) and (9.11) of docs/theory/exponents.md.

    Parameters
    ----------
    signal : samples (n,), evenly spaced; their interval does not matter.
    thin : distance of the samples to be used [samples]; None: a quarter of the mean period.
    count : number of angles c.
    seed : seed of the angles.

    Raises
    ------
    InputError : a signal that is not finite or has fewer than 20 samples.

    Notes
    -----
    Source: G. A. Gottwald and I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129, eqs (2.1)-(2.6), section 3.
    Cost: 0.2 s for 1e4 samples.

    Examples
    --------
    >>> import flexmb as fm, numpy as np
    >>> fm.chaos.zero_one_test(np.sin(np.arange(1000.0))).kind
    'regular'
    """
    x = samples("zero_one_test", signal, 20)
    count = checks.count("zero_one_test", "count", count)
    angles = np.random.default_rng(seed).uniform(np.pi / 5, 4 * np.pi / 5, count)
    if is_constant(x):
        text = "The signal is constant: regular."
        return ZeroOne(0.0, 0.0, "regular", True, text, 1, angles, np.zeros(count))
    step = max(1, round(mean_period(x) / 4.0)) if thin is None else checks.count("zero_one_test", "thin", thin)
    phi = standardised(x)[::step]
    record = f"{len(x)} samples" if step == 1 else f"{len(phi)} samples, one in {step} of {len(x)}"
    if len(phi) < ENOUGH:
        text = f"{record}; at least {ENOUGH * step} are needed."
        return ZeroOne(np.nan, np.nan, "undecided", False, text, step, angles, np.full(count, np.nan))
    correlations = growth_correlations(phi, angles)
    value = float(np.median(correlations))
    spread = 0.5 * float(np.subtract(*np.quantile(correlations, [0.75, 0.25])))
    kind = kind_of(value)
    return ZeroOne(value, spread, kind, True, f"K = {value:.3f} of {record}: {kind}.", step, angles, correlations)


def kind_of(value: float) -> str:
    """Kind of a signal by its median K: 'regular', 'chaotic' or 'undecided'."""
    if value < REGULAR:
        return "regular"
    return "chaotic" if value > CHAOTIC else "undecided"


def growth_correlations(phi: np.ndarray, angles: np.ndarray, ratio: int = 10) -> np.ndarray:
    """K_c (k,) of a signal (n,) for angles c (k,) [rad/sample], from lags up to n / `ratio`."""
    lags = np.arange(1, len(phi) // ratio + 1)
    count = len(phi) - len(lags)
    found, n = np.zeros(len(angles)), lags - lags.mean()
    for k, c in enumerate(angles):
        walk = np.cumsum(phi * np.exp(1j * c * np.arange(1, len(phi) + 1)))  # p + i q
        square = np.concatenate([[0.0], np.cumsum(np.abs(walk) ** 2)])
        end_squares = square[lags + count] - square[lags]
        cross = scipy.signal.fftconvolve(walk, np.conj(walk[:count][::-1]), mode="valid").real[lags]
        mean_square = (end_squares + square[count] - 2.0 * cross) / count
        growth = mean_square - phi.mean() ** 2 * (1.0 - np.cos(lags * c)) / (1.0 - np.cos(c))
        growth = growth - growth.mean()  # of the modified mean square displacement
        scale = np.sqrt((n @ n) * (growth @ growth))
        found[k] = n @ growth / scale if scale > 0.0 else 0.0
    return found
