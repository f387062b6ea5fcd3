"""Power spectrum of a signal, with its lines and the floor between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb import arguments
from flexmb.series.samples import is_constant, samples, spacing

LOBE = 4
"""Half width of the main lobe of the window [bins]."""

ABOVE_FLOOR = 50.0
"""Smallest ratio of a line to the median around it; a random spectrum has one such value in 1e15."""

AROUND = 101
"""Number of bins of the running median."""

LINES, BROAD = 0.99, 0.5
"""Fraction of the power in lines: above the first value the kind is "lines", below the second "broad"."""


@dataclass(frozen=True, eq=False)
class PowerSpectrum(arguments.Checked):
    """The power spectrum of a signal.

    Parameters
    ----------
    frequency : frequencies (k,) [Hz or 1/iteration].
    density : one-sided density (k,) [unit of the signal squared / Hz].
    floor : running median of the density (k,).
    peaks : frequencies of the lines, strongest first.
    power : mean square of each line [unit of the signal squared].
    line_share : fraction of the power in lines.
    kind : "lines" (99 % of the power in lines), "mixed", "broad" (less than half) or "constant".
    units : "Hz" or "1/iteration".
    """

    formerly = (("unit", "units"),)
    frequency: np.ndarray = field(repr=False)
    density: np.ndarray = field(repr=False)
    floor: np.ndarray = field(repr=False)
    peaks: np.ndarray
    power: np.ndarray
    line_share: float
    kind: str
    units: str


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
    from scipy.signal import periodogram

    x = samples("power_spectrum", signal, 64)
    step, rate = spacing("power_spectrum", interval, len(x))
    unit = "Hz" if rate == "1/s" else rate
    f, density = periodogram(x - x.mean(), 1.0 / step, window="blackmanharris", detrend=False)
    if is_constant(x):
        empty = np.empty(0)
        return PowerSpectrum(f, np.zeros_like(f), np.zeros_like(f), empty, empty, 0.0, "constant", unit)
    floor = _floor(density)
    peaks = _lines(density, floor)
    in_line = np.zeros(len(f), dtype=bool)
    for k in peaks:
        in_line[max(k - LOBE, 0) : k + LOBE + 1] = True
    line_share = float(density[in_line].sum() / density.sum())
    power = np.array([density[max(k - LOBE, 0) : k + LOBE + 1].sum() * f[1] for k in peaks])
    order = np.argsort(-power, kind="stable")
    kind = "lines" if line_share >= LINES else "broad" if line_share < BROAD else "mixed"
    return PowerSpectrum(f, density, floor, f[peaks][order], power[order], line_share, kind, unit)


def _floor(density: np.ndarray) -> np.ndarray:
    """Running median of a density (k,)."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(density, size=min(AROUND, len(density)), mode="mirror"))


def _lines(density: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Indices of the local maxima within a main lobe that exceed the floor and round-off."""
    from scipy.ndimage import maximum_filter

    highest = density == maximum_filter(density, size=2 * LOBE + 1, mode="mirror")
    return np.flatnonzero(highest & (density > ABOVE_FLOOR * floor) & (density > 1e-20 * density.max()))
