"""Samples of a signal, their power spectrum, and the 0-1 test for chaos."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import scipy

# Largest magnitude of a sample, and inverse of the smallest one: squares and their sums must not overflow.
LARGEST = 1e140
ROUND_OFF = 1e-12  # spread of a signal, over its largest magnitude, below which it is constant


def samples(owner: str, signal: Any, least: int) -> np.ndarray:
    """`signal` as finite float64 values (n,), `least` of them at least, and not too large."""
    x = real_numbers(signal)
    if x is None:
        raise InputError(f"{owner}: the signal is no list of numbers.")
    if x.ndim != 1:
        raise InputError(f"{owner}: the signal has shape {x.shape}; it must be one signal (n,). Give one column.")
    bad = np.flatnonzero(~np.isfinite(x))
    if len(bad):
        where = f"sample {bad[0]} is {x[bad[0]]}"
        raise InputError(f"{owner}: {where}, {len(bad)} of {len(x)} are not finite. Cut them off before.")
    if len(x) < least:
        raise InputError(f"{owner}: the signal has {len(x)} samples; at least {least} are needed.")
    largest = float(np.abs(x).max(initial=0.0))
    if largest > LARGEST or 0.0 < largest < 1.0 / LARGEST:
        text = f"{owner}: the signal has a magnitude of {largest:.3g}, whose square is no number"
        raise InputError(f"{text}. Give another unit.")
    return x


def real_numbers(value: Any) -> np.ndarray | None:
    """`value` as a new float64 array; None if it holds other objects, such as complex numbers."""
    try:
        return None if np.iscomplexobj(value) else np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return None


def spacing(owner: str, interval: Any, count: int) -> tuple[float, str]:
    """Distance of two samples, and unit of a rate."""
    # `interval` is a distance > 0 [s], evenly spaced times (count,) [s], or None for iterations.
    if interval is None:
        return 1.0, "1/iteration"
    if np.ndim(interval) == 0:
        value = interval if not isinstance(interval, np.ndarray) else interval.item()
        return checks.positive(owner, "interval", value, "s"), "1/s"
    times = samples(f"{owner}: interval", interval, 2)
    if len(times) != count:
        raise InputError(f"{owner}: interval holds {len(times)} times for {count} samples.")
    steps, step = np.diff(times), float((times[-1] - times[0]) / (count - 1))
    if step <= 0.0 or np.abs(steps - step).max() > 1e-3 * step:
        text = f"the times are not evenly spaced: steps of {steps.min():g} s to {steps.max():g} s"
        remedy = "Interpolate the signal on even times before."
        if count > 2 and np.abs(steps[:-1] - steps[:-1].mean()).max() <= 1e-3 * steps[:-1].mean():
            remedy = "The last one alone is odd, the end of the run beyond its save grid: leave the last sample out."
        raise InputError(f"{owner}: {text}. {remedy}")
    return step, "1/s"


def is_constant(x: np.ndarray) -> bool:
    """Whether the samples (n,) differ by no more than round-off."""
    return bool(np.ptp(x) <= ROUND_OFF * np.abs(x).max())


def standardised(x: np.ndarray) -> np.ndarray:
    """Samples (n,) less their mean, over their standard deviation."""
    centred = x - x.mean()
    return np.asarray(centred / centred.std())


def mean_period(x: np.ndarray) -> float:
    """Number of samples of (n,) in a mean period, at least 2: inverse of the mean frequency, weighted by the power."""
    # Source: M. T. Rosenstein, J. J. Collins and C. J. De Luca, Physica D 65 (1993) 117.
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    mean = float(np.fft.rfftfreq(len(x)) @ power / power.sum()) if power.sum() > 0.0 else 0.0
    return max(2.0, 1.0 / mean) if mean > 0.0 else float(len(x))


LOBE = 4  # half width of the main lobe of the window [bins]
ABOVE_FLOOR = 50.0  # smallest ratio of a line to the median around it; a random spectrum has one such value in 1e15
AROUND = 101  # number of bins of the running median
# Fraction of the power in lines: above the first value the kind is "lines", below the second "broad".
LINES, BROAD = 0.99, 0.5


@record_with(eq=False)
class PowerSpectrum(arguments.Checked):
    """The power spectrum of a signal."""

    formerly = (("unit", "units", "0.3"),)
    frequency: np.ndarray = field("frequencies (k,) [Hz or 1/iteration]", repr=False)
    density: np.ndarray = field("one-sided density (k,) [unit of the signal squared / Hz]", repr=False)
    floor: np.ndarray = field("running median of the density (k,)", repr=False)
    peaks: np.ndarray = field("frequencies of the lines, strongest first")
    power: np.ndarray = field("mean square of each line [unit of the signal squared]")
    line_share: float = field("fraction of the power in lines")
    kind: str = field('"lines" (99 % of the power in lines), "mixed", "broad" (less than half) or "constant"')
    units: str = field('"Hz" or "1/iteration"')


def power_spectrum(signal: Any, interval: Any = None) -> PowerSpectrum:
    """Power spectrum of a signal: density, lines, floor, and kind (lines or broad).

    The density is one periodogram of the whole record with a Blackman-Harris window (side lobes at -92 dB).  The length
    of the record is the limit of resolution.  A line is a local maximum 50 times above the median of the 101 values
    around the maximum.  Periodic and quasi-periodic signals have lines only.  Chaos has a broad floor, with lines if
    its phase is coherent (Rossler) or its bands are visited in turn.  Noise has a broad floor, too.  A trend over the
    whole record looks like power at the lowest frequencies.

    Parameters
    ----------
    signal : samples (n,), at least 64; 20 periods of the slowest line to separate lines.
    interval : time between samples [s], or their times (n,) [s]; None: iterations of a map.

    Raises
    ------
    InputError : a signal that is too short or not finite, times that are not evenly spaced.

    Notes
    -----
    Source: F. J. Harris, Proc. IEEE 66 (1978) 51, for the window.  Cost: 10 ms for 1e4 samples.

    Examples
    --------
    >>> import flexmb as fm, numpy as np
    >>> t = 0.01 * np.arange(4000)
    >>> found = fm.chaos.power_spectrum(2.0 * np.sin(2.0 * np.pi * 5.0 * t), 0.01)
    >>> found.kind, round(float(found.peaks[0]), 2), round(float(found.power[0]), 2)  # 2^2 / 2
    ('lines', 5.0, 2.0)
    """
    x = samples("power_spectrum", signal, 64)
    step, rate = spacing("power_spectrum", interval, len(x))
    unit = "Hz" if rate == "1/s" else rate
    f, density = scipy.signal.periodogram(x - x.mean(), 1.0 / step, window="blackmanharris", detrend=False)
    if is_constant(x):
        empty = np.empty(0)
        return PowerSpectrum(f, np.zeros_like(f), np.zeros_like(f), empty, empty, 0.0, "constant", unit)
    floor = np.asarray(scipy.ndimage.median_filter(density, size=min(AROUND, len(density)), mode="mirror"))
    highest = density == scipy.ndimage.maximum_filter(density, size=2 * LOBE + 1, mode="mirror")
    peaks = np.flatnonzero(highest & (density > ABOVE_FLOOR * floor) & (density > 1e-20 * density.max()))
    near = np.unique(peaks[:, None] + np.arange(-LOBE, LOBE + 1))
    bins = near[(near >= 0) & (near < len(f))]  # each belongs to the nearest line
    line_share = float(density[bins].sum() / density.sum())
    owner = np.searchsorted(0.5 * (peaks[1:] + peaks[:-1]), bins)
    power = np.bincount(owner, density[bins], minlength=len(peaks)) * f[1]
    order = np.argsort(-power, kind="stable")
    kind = "lines" if line_share >= LINES else "broad" if line_share < BROAD else "mixed"
    return PowerSpectrum(f, density, floor, f[peaks][order], power[order], line_share, kind, unit)


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
        return ZeroOne(0.0, 0.0, "regular", True, "The signal is constant: regular.", 1, angles, np.zeros(count))
    step = max(1, round(mean_period(x) / 4.0)) if thin is None else checks.count("zero_one_test", "thin", thin)
    phi = standardised(x)[::step]
    record = f"{len(x)} samples" if step == 1 else f"{len(phi)} samples, one in {step} of {len(x)}"
    if len(phi) < ENOUGH:
        text = f"{record}; at least {ENOUGH * step} are needed."
        return ZeroOne(np.nan, np.nan, "undecided", False, text, step, angles, np.full(count, np.nan))
    correlations = growth_correlations(phi, angles)
    value = float(np.median(correlations))
    spread, kind = 0.5 * float(np.subtract(*np.quantile(correlations, [0.75, 0.25]))), kind_of(value)
    return ZeroOne(value, spread, kind, True, f"K = {value:.3f} of {record}: {kind}.", step, angles, correlations)


def kind_of(value: float, regular: float = REGULAR, chaotic: float = CHAOTIC) -> str:
    """Kind of a motion by a measure, such as the median K, and its limits: 'regular', 'chaotic' or 'undecided'."""
    return "regular" if value < regular else "chaotic" if value > chaotic else "undecided"


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
