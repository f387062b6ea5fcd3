"""Sampled signals of a long run: periodic part, deviations from the periodic part, surrogates, growth of distances."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.dynamics.series.embedding import embed

if TYPE_CHECKING:
    import xarray as xr

SAMPLES = 100
"""Samples per period of estimates; a larger number costs more and changes the estimates little."""

REFERENCES = 1500
"""Largest number of reference points, whose distances to all points are computed."""

PARTS = 50
"""Number of blocks of reference points, which limits the memory of the distances."""


def by_period(result: xr.Dataset, name: str, samples: int = SAMPLES) -> np.ndarray:
    """Evenly sampled signal of a long run without its last instant (periods, samples).

    Parameters
    ----------
    result : result of an `attractor`.
    name : name of the signal.
    samples : samples per period; the run has an integer multiple of samples, or fewer.
    """
    times, period = result["time"].values, float(result.attrs["period"])
    kept = round(period / float(times[1] - times[0]))
    values = result[name].values[:-1]
    rows: np.ndarray = values[: len(values) // kept * kept].reshape(-1, kept)
    return rows[:, :: max(kept // samples, 1)]


def without_periodic_part(rows: np.ndarray) -> np.ndarray:
    """Deviation of a signal (periods, samples) from its mean at each phase of the drives (periods, samples).

    The deviation of a motion with the period of the drives is zero.
    """
    deviation: np.ndarray = rows - rows.mean(axis=0)
    return deviation


def cloud(rows: np.ndarray) -> float:
    """Root mean square of the deviation of a signal (periods, samples) from its periodic part."""
    return float(np.sqrt(np.mean(without_periodic_part(rows) ** 2)))


def surrogate(signal: np.ndarray, seed: int = 0) -> np.ndarray:
    """Noise (n,) with the power spectrum of a signal (n,) and random phases.

    Source: J. Theiler, S. Eubank, A. Longtin, B. Galdrikian and J. D. Farmer, Physica D 58 (1992) 77.
    """
    spectrum = np.fft.rfft(signal)
    turned = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(spectrum)))
    turned[0] = 1.0
    if len(signal) % 2 == 0:
        turned[-1] = 1.0
    return np.fft.irfft(turned * spectrum, len(signal))


def growth_by_distance(
    signal: np.ndarray, edges: np.ndarray, *, delay: int, dimension: int, theiler: int, follow: int
) -> tuple[np.ndarray, np.ndarray]:
    """Mean growth ln(d'/d) of the distance of neighbours over the initial distance d; d' is the distance later.

    For a chaotic motion the mean is the exponent times the time if d is small.  It is zero or negative if d is of the
    size of the attractor.  For a periodic motion the mean is zero after whole periods.  Distances are root mean squares
    over the entries of an embedded vector, in the unit of the signal.  Exponents at finite distances: E. Aurell et al.,
    J. Phys. A 30 (1997) 1.

    Parameters
    ----------
    signal : samples of the signal (n,).
    edges : limits of the intervals of distance (k + 1,) [unit of the signal].
    delay, dimension : delay [samples] and dimension of the embedding.
    theiler : least separation in time of two neighbours [samples].
    follow : time from d to d' [samples].

    Returns
    -------
    Means (k,), NaN for an interval without neighbours, and numbers of neighbours (k,).
    """
    from scipy.spatial.distance import cdist

    points = embed(signal, delay, dimension) / np.sqrt(dimension)
    count, bins = len(points) - follow, len(edges) - 1
    sums, numbers = np.zeros(bins), np.zeros(bins)
    refs = np.unique(np.linspace(0, count - 1, REFERENCES).astype(int))
    for part in np.array_split(refs, PARTS):
        before, after = cdist(points[part], points[:count]), cdist(points[part + follow], points[follow:])
        far = (np.abs(part[:, None] - np.arange(count)) > theiler) & (before > 0.0) & (after > 0.0)
        place = np.digitize(before[far], edges) - 1
        inside = (place >= 0) & (place < bins)
        growth = np.log(after[far][inside] / before[far][inside])
        sums += np.bincount(place[inside], growth, bins)
        numbers += np.bincount(place[inside], minlength=bins)
    return np.where(numbers > 0, sums / np.maximum(numbers, 1.0), np.nan), numbers


def growth_rates(result: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Growth rate of the tangent vector and its standard error [1/s], by "state" and by observable.

    The standard error is the standard deviation of the growth over the periods, divided by the root of their number.
    """
    names = [str(name).removeprefix("growth.") for name in result.data_vars if str(name).startswith("growth.")]
    begins, period = result["pair.time"].values, float(result.attrs["period"])
    time = float(begins[-1] - begins[0]) + period
    found = {}
    for name in names:
        logs = result[f"growth.{name}"].values
        each = result["growth.state"].values[:, -1] - result["growth.state"].values[:, 0]
        error = float(each.std(ddof=1) / np.sqrt(len(each)) / period) if len(each) > 1 else float("nan")
        found[name] = (float(logs[-1, -1] - logs[0, 0]) / time, error)
    return found
