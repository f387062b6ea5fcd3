"""Samples of a signal, and their power spectrum."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import scipy

# Samples of a signal: checked, evenly spaced, standardised

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
    steps = np.diff(times)
    step = float((times[-1] - times[0]) / (count - 1))
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
    window = np.hanning(len(x))
    power = np.abs(np.fft.rfft((x - x.mean()) * window)) ** 2
    frequency = np.fft.rfftfreq(len(x))
    mean = float(frequency @ power / power.sum()) if power.sum() > 0.0 else 0.0
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
    in_line = np.zeros(len(f), dtype=bool)
    for k in peaks:
        in_line[max(k - LOBE, 0) : k + LOBE + 1] = True
    line_share = float(density[in_line].sum() / density.sum())
    power = np.array([density[max(k - LOBE, 0) : k + LOBE + 1].sum() * f[1] for k in peaks])
    order = np.argsort(-power, kind="stable")
    kind = "lines" if line_share >= LINES else "broad" if line_share < BROAD else "mixed"
    return PowerSpectrum(f, density, floor, f[peaks][order], power[order], line_share, kind, unit)
