"""Sampled signals of a long run: periodic part, cloud, surrogates, growth of distances."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.series.embedding import embed

if TYPE_CHECKING:
    import xarray as xr

SAMPLES = 100
"""Samples a period of estimates: more cost more and change little."""

CLOSE = 1e-9
"""How near a number of samples must be to a whole one."""

REFERENCES = 1500
"""Points from which distances to all others are measured, at most."""

PARTS = 50
"""Parts in which that is done, so that few distances are held at a time."""


def by_period(result: xr.Dataset, name: str, samples: int = SAMPLES) -> np.ndarray:
    """A signal of the even series, (periods, samples), without the last instant.

    Parameters
    ----------
    result : of an `attractor`.
    name : the signal.
    samples : instants a period; those of the series are a multiple of it, or all are taken.
    """
    times, period = result["time"].values, float(result.attrs["period"])
    kept = round(period / float(times[1] - times[0]))
    values = result[name].values[:-1]
    return values[: len(values) // kept * kept].reshape(-1, kept)[:, :: max(kept // samples, 1)]


def without_periodic_part(rows: np.ndarray) -> np.ndarray:
    """Signals (periods, samples) less their mean at each phase of the cranks.

    What is left of a motion with the period of the drives is nothing, of a chaotic one its cloud.
    """
    return rows - rows.mean(axis=0)


def cloud(rows: np.ndarray) -> float:
    """Root mean square of the difference of a signal (periods, samples) and its periodic part."""
    return float(np.sqrt(np.mean(without_periodic_part(rows) ** 2)))


def surrogate(signal: np.ndarray, seed: int = 0) -> np.ndarray:
    """Noise (n,) with the power spectrum of a signal (n,): the phases are drawn anew.

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
    """Mean of ln(d'/d) of all neighbours at a distance d, which is d' after so many samples, by d.

    Estimates from one signal are such means over the neighbours they happen to find.  Of a chaotic motion it is the
    exponent times the time where d is small, zero or less where d is of the size of the attractor; of a periodic one
    it is zero at whole periods.  Distances are root mean squares over the numbers of a vector, in the unit of the
    signal.  (E. Aurell et al., J. Phys. A 30 (1997) 1, for exponents at finite distances.)

    Parameters
    ----------
    signal : samples (n,).
    edges : (k + 1,) of the intervals of distance.
    delay, dimension : of the embedding.
    theiler : neighbours are farther apart than this [samples].
    follow : time for which they are followed [samples].

    Returns
    -------
    Means (k,), NaN where there is no neighbour, and numbers of neighbours (k,).
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
    """Rate and its error [1/s] at which a difference that stays small grows, as the state and each observable see it.

    The error is the scatter of the growth over the periods that were followed, over the root of their number.

    Parameters
    ----------
    result : of an `attractor`.
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
