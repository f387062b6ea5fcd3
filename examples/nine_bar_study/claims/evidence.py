"""Evidence of claims: results of runs by the keys of their cases."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from nine_bar_study.item import once
from nine_bar_study.run import Results, StudyRun
from nine_bar_study.statistics import Mean, plain

if TYPE_CHECKING:
    import xarray as xr

SI = {"%": "1", "um": "m", "": "1", "m/s^2": "m/s2"}
"""SI unit of each unit of tables that is not an SI unit."""


class Measure(NamedTuple):
    """Measure of one turn: peak, share of free flight, penetration, number of onsets.

    Parameters
    ----------
    name : name of the variable in results.
    text : name in tables.
    unit, factor : unit of tables, and values in this unit per SI unit.
    """

    name: str
    text: str
    unit: str = ""
    factor: float = 1.0

    @property
    def si(self) -> str:
        """Unit of the measure in results."""
        return SI.get(self.unit, self.unit)

    @property
    def signal(self) -> str:
        """Name of the signal whose peak is the measure."""
        return self.name.removeprefix("peak.")

    def shown(self, mean: Mean) -> str:
        """Text of a mean [SI] and the standard deviation of the turns, in the unit of tables."""
        value, spread = self.factor * mean.value, self.factor * mean.deviation
        text = plain(value, 4) if spread <= 1e-4 * abs(value) else f"{plain(value, 4)} ± {plain(spread, 2)}"
        return f"{text} {self.unit}".rstrip()


class Key(NamedTuple):
    """Key of a case: model, speed, clearance, friction law.

    Parameters
    ----------
    model : "ideal", "rigid" or "flexible".
    speed : speed of the drives [unit of the machine].
    clearance : clearance of the joint [m]; 0 for the model "ideal".
    law : name of the friction law of the joint.
    """

    model: str
    speed: float
    clearance: float = 0.0
    law: str = ""


def ideal(speed: float) -> Key:
    """Key of the ideal mechanism at a speed [unit of the machine]."""
    return Key("ideal", speed)


@dataclass(frozen=True)
class Evidence:
    """Results of runs by the keys of their cases.

    Parameters
    ----------
    motions : settled turns, results of `measure_motion`.
    starts : first turns, results of `measure_motion`.
    growths : exponents and section points, results of `measure_growth`.
    diagrams : results of `bifurcation`, by parameter ("speed", "clearance") and model.
    """

    motions: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    starts: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    growths: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    diagrams: Mapping[tuple[str, str], xr.Dataset] = field(default_factory=dict)

    def has(self, *keys: Key) -> bool:
        """Whether settled turns of all `keys` are present."""
        return all(key in self.motions for key in keys)

    def mean(self, key: Key, measure: Measure) -> Mean:
        """Mean of a measure over the settled turns of a case [SI]."""
        return Mean.of(self.motions[key][measure.name].values)

    def peak(self, speed: float, measure: Measure) -> float:
        """Largest value of a measure over the settled turns of the ideal mechanism at a speed [SI]."""
        return float(self.motions[ideal(speed)][measure.name].values.max())

    def range_of(self, signal: str, speed: float) -> float:
        """Range of a signal at a speed [SI], of the ideal mechanism if present; NaN without settled turns."""
        for key in sorted(self.motions, key=lambda key: key.model != "ideal"):
            if key.speed == speed:
                return float(np.ptp(self.motions[key][signal].values))
        return math.nan


@dataclass(frozen=True)
class Plan:
    """Runs whose results are the evidence; the fields correspond to the fields of `Evidence`.

    Parameters
    ----------
    motions, starts, growths : runs by the keys of their cases.
    diagrams : runs by parameter and model.
    """

    motions: Mapping[Key, StudyRun] = field(default_factory=dict)
    starts: Mapping[Key, StudyRun] = field(default_factory=dict)
    growths: Mapping[Key, StudyRun] = field(default_factory=dict)
    diagrams: Mapping[tuple[str, str], StudyRun] = field(default_factory=dict)

    @property
    def runs(self) -> tuple[StudyRun, ...]:
        """All runs, each once."""
        return once([run for group in self._groups for run in group.values()])

    def read(self, results: Results) -> Evidence:
        """Evidence of the results of all runs."""
        return Evidence(*({key: results[run] for key, run in group.items()} for group in self._groups))

    @property
    def _groups(self) -> list[Mapping[Any, StudyRun]]:
        return [getattr(self, one.name) for one in fields(self)]
