"""Experiments on a long run: the sign of exponents estimated from one observable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.samples import (
    SAMPLES,
    by_period,
    cloud,
    growth_by_distance,
    surrogate,
    without_periodic_part,
)

from flexmb.dynamics.series.exponent import wolf

if TYPE_CHECKING:
    import xarray as xr

EDGES = 10.0 ** np.arange(-8.0, -0.9, 0.5)
"""Limits of the intervals of distance [m], two intervals per decade."""

FOLLOWED = (0.1, 1.0)
"""Times for which the distance of neighbours is followed [periods]."""

DIMENSION = 4
FEWEST = 30
"""Least number of neighbours in an interval."""

FAR = 10.0
"""Distance of points at different phases of the cranks, over the deviation from the periodic part."""


@dataclass(frozen=True, eq=False)
class ByDistance:
    """Growth rates of the distance of neighbours over the initial distance.

    Parameters
    ----------
    signal : text of the signal.
    rates : growth rates (followed, distance) [1/s]; NaN for fewer than 30 neighbours.
    numbers : numbers of neighbours (followed, distance).
    cloud : root mean square of the deviation of the signal from its periodic part [m].
    spread : standard deviation of the signal [m].
    """

    signal: str
    rates: np.ndarray
    numbers: np.ndarray
    cloud: float
    spread: float

    def pooled(self, least: float, most: float, row: int) -> float:
        """Mean growth rate of all neighbours between two distances [1/s]; NaN without neighbours.

        Parameters
        ----------
        least, most : distances [m].
        row : index in `FOLLOWED`.
        """
        inside = (EDGES[:-1] >= least) & (EDGES[1:] <= most * (1.0 + 1e-9)) & np.isfinite(self.rates[row])
        numbers = self.numbers[row, inside]
        return float(self.rates[row, inside] @ numbers / numbers.sum()) if numbers.sum() else float("nan")

    @property
    def nearest(self) -> float:
        """Growth rate of the nearest neighbours over the shorter time [1/s]; NaN without neighbours."""
        known = np.flatnonzero(np.isfinite(self.rates[0]))
        return float(self.rates[0, known[0]]) if len(known) else float("nan")


def signals_of(result: xr.Dataset, samples: int = SAMPLES) -> dict[str, np.ndarray]:
    """Signals of the experiments by name, each (periods, samples) [m]."""
    slider = by_period(result, "slider.x", samples)
    joint = by_period(result, "P1.ex", samples)
    return {
        "slider.x": slider,
        "slider.x less its periodic part": without_periodic_part(slider),
        "P1.ex": joint,
        "P1.ex less its periodic part": without_periodic_part(joint),
    }


def by_distance(result: xr.Dataset) -> list[ByDistance]:
    """Growth rates of the distance of neighbours for each signal of the experiments."""
    period, found = float(result.attrs["period"]), []
    for name, rows in signals_of(result).items():
        rates, numbers = [], []
        for part in FOLLOWED:
            samples = max(round(part * rows.shape[1]), 1)
            options = {"delay": max(rows.shape[1] // 10, 1), "dimension": DIMENSION, "theiler": rows.shape[1]}
            growth, count = growth_by_distance(rows.ravel(), EDGES, follow=samples, **options)
            rates.append(np.where(count >= FEWEST, growth / (samples / rows.shape[1] * period), np.nan))
            numbers.append(count)
        found.append(ByDistance(name, np.array(rates), np.array(numbers), cloud(rows), float(rows.std())))
    return found


SETTINGS: dict[str, dict[str, Any]] = {
    "as found": {},
    "followed 0.03 periods": {"followed": 0.03},
    "followed 0.1": {"followed": 0.1},
    "followed 0.5": {"followed": 0.5},
    "followed 1": {"followed": 1.0},
    "50 samples": {"followed": 0.1, "samples": 50},
    "200 samples": {"followed": 0.1, "samples": 200},
    "dimension 3": {"followed": 0.1, "dimension": 3},
    "dimension 8": {"followed": 0.1, "dimension": 8},
    "half the record": {"followed": 0.1, "part": 2},
}
"""Settings of Wolf's estimate; defaults: 100 samples per period, dimension 5, the whole record."""


def wolf_by_settings(result: xr.Dataset) -> dict[str, dict[str, tuple[float, bool]]]:
    """Wolf's estimate [1/s] by signal and setting, and whether the checks of the estimator accept the estimate.

    An additional signal is noise with the spectrum of "slider.x less its periodic part".
    """
    found: dict[str, dict[str, tuple[float, bool]]] = {}
    for setting, options in SETTINGS.items():
        samples, part = options.get("samples", SAMPLES), options.get("part", 1)
        signals = signals_of(result, samples)
        signals["noise like the second"] = surrogate(signals["slider.x less its periodic part"].ravel())[None]
        for name, rows in signals.items():
            values = rows.ravel()[: rows.size // part]
            found.setdefault(name, {})[setting] = _wolf(values, samples, float(result.attrs["period"]), options)
    return found


def _wolf(values: np.ndarray, samples: int, period: float, options: dict[str, Any]) -> tuple[float, bool]:
    """Estimate [1/s], NaN for too few pairs, and whether the checks of the estimator accept the estimate."""
    given: dict[str, Any] = {}
    if options:
        given["evolve"] = max(round(options["followed"] * samples), 1)
        given["dimension"] = options.get("dimension", 5)
    estimate = wolf(values, period / samples, **given)
    return (float(estimate.curve[-1]) if len(estimate.curve) else float("nan")), estimate.ok
