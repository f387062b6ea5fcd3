"""Samples of a signal: checked, evenly spaced, standardised."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError

LARGEST = 1e140
"""Largest magnitude of a sample, and inverse of the smallest one: squares and their sums must not overflow."""

ROUND_OFF = 1e-12
"""Spread of a signal, over its largest magnitude, below which it is constant."""


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
    refuse_extremes(f"{owner}: the signal", x)
    return x


def real_numbers(value: Any) -> np.ndarray | None:
    """`value` as a new float64 array; None if it holds other objects, such as complex numbers."""
    try:
        return None if np.iscomplexobj(value) else np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        return None


def refuse_extremes(what: str, x: np.ndarray) -> None:
    """Refuse numbers (n,) whose squares overflow or underflow."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest > LARGEST or 0.0 < largest < 1.0 / LARGEST:
        raise InputError(f"{what} has a magnitude of {largest:.3g}, whose square is no number. Give another unit.")


def spacing(owner: str, interval: Any, count: int) -> tuple[float, str]:
    """Distance of two samples, and unit of a rate.

    `interval` is a distance > 0 [s], evenly spaced times (count,) [s], or None for iterations.
    """
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
    """Number of samples of (n,) in a mean period, at least 2: inverse of the mean frequency, weighted by the power.

    Source: M. T. Rosenstein, J. J. Collins and C. J. De Luca, Physica D 65 (1993) 117.
    """
    window = np.hanning(len(x))
    power = np.abs(np.fft.rfft((x - x.mean()) * window)) ** 2
    frequency = np.fft.rfftfreq(len(x))
    mean = float(frequency @ power / power.sum()) if power.sum() > 0.0 else 0.0
    return max(2.0, 1.0 / mean) if mean > 0.0 else float(len(x))
