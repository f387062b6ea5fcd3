"""The results by which claims are judged, by the cases that they are of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.study.item import once
from flexmb.study.run import Results, StudyRun
from flexmb.study.statistics import Mean, plain

if TYPE_CHECKING:
    import xarray as xr

SI = {"%": "1", "um": "m", "": "1", "m/s^2": "m/s2"}
"""SI units by units of tables, where they are not the same."""


class Measure(NamedTuple):
    """A measure of a turn.

    Parameters
    ----------
    name : its name in results.
    text : its name in tables.
    unit, factor : unit of tables, so many to one of SI.
    """

    name: str
    text: str
    unit: str = ""
    factor: float = 1.0

    @property
    def si(self) -> str:
        """Its unit in results."""
        return SI.get(self.unit, self.unit)

    @property
    def signal(self) -> str:
        """The signal of which it is the peak."""
        return self.name.removeprefix("peak.")

    def shown(self, mean: Mean) -> str:
        """A mean [SI] with the standard deviation of its turns, in the unit of tables."""
        value, spread = self.factor * mean.value, self.factor * mean.deviation
        text = plain(value, 4) if spread <= 1e-4 * abs(value) else f"{plain(value, 4)} ± {plain(spread, 2)}"
        return f"{text} {self.unit}".rstrip()


class Key(NamedTuple):
    """The case of a result, in short.

    Parameters
    ----------
    model : "ideal", "rigid" or "flexible".
    speed : of the drives [unit of the machine].
    clearance : of the joint [m]; 0 for the ideal mechanism.
    law : friction at the joint.
    """

    model: str
    speed: float
    clearance: float = 0.0
    law: str = ""


def ideal(speed: float) -> Key:
    """The ideal mechanism at a speed [unit of the machine]."""
    return Key("ideal", speed)


@dataclass(frozen=True)
class Evidence:
    """Results of runs.

    Parameters
    ----------
    motions : settled turns, as `measure_motion` returns them.
    starts : the first turns.
    growths : exponents and section points, as `measure_growth` returns them.
    diagrams : as `bifurcation` returns them, by parameter ("speed", "clearance") and model.
    """

    motions: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    starts: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    growths: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    diagrams: Mapping[tuple[str, str], xr.Dataset] = field(default_factory=dict)

    def has(self, *keys: Key) -> bool:
        """Whether there are settled turns of all of them."""
        return all(key in self.motions for key in keys)

    def mean(self, key: Key, measure: Measure) -> Mean:
        """Mean of a measure over the settled turns [SI]."""
        return Mean.of(self.motions[key][measure.name].values)

    def peak(self, speed: float, measure: Measure) -> float:
        """Largest value of a measure of the ideal mechanism at a speed [SI]."""
        return float(self.motions[ideal(speed)][measure.name].values.max())

    def speeds(self, model: str, clearance: float, law: str) -> list[float]:
        """Speeds with settled turns of a model with a clearance [m] and a friction law, rising."""
        return sorted(k.speed for k in self.motions if (k.model, k.clearance, k.law) == (model, clearance, law))

    def range_of(self, signal: str, speed: float) -> float:
        """Range of a signal of the ideal mechanism [SI], or of any other at this speed; NaN if there is none."""
        for key in sorted(self.motions, key=lambda key: key.model != "ideal"):
            if key.speed == speed:
                return float(np.ptp(self.motions[key][signal].values))
        return math.nan


@dataclass(frozen=True)
class Plan:
    """The runs that evidence comes from; fields as of `Evidence`.

    Parameters
    ----------
    motions, starts, growths : runs by their cases.
    diagrams : runs by parameter and model.
    """

    motions: Mapping[Key, StudyRun] = field(default_factory=dict)
    starts: Mapping[Key, StudyRun] = field(default_factory=dict)
    growths: Mapping[Key, StudyRun] = field(default_factory=dict)
    diagrams: Mapping[tuple[str, str], StudyRun] = field(default_factory=dict)

    @property
    def runs(self) -> tuple[StudyRun, ...]:
        """All of them, each once."""
        return once([run for group in self._groups for run in group.values()])

    def read(self, results: Results) -> Evidence:
        """The evidence in some results."""
        return Evidence(*({key: results[run] for key, run in group.items()} for group in self._groups))

    @property
    def _groups(self) -> list[Mapping[tuple, StudyRun]]:
        return [getattr(self, one.name) for one in fields(self)]
