"""The results by which claims are judged, under names that say of what they are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb.paper.plate import Results, Run
from flexmb.paper.statistics import Mean, plain

if TYPE_CHECKING:
    import xarray as xr

LARGE, SMALL, SMALLEST = 0.5e-3, 0.05e-3, 0.01e-3
"""Clearances of the paper [m]; the last one is where its diagrams begin."""

SLOW, MIDDLE, FAST = 0.5, 2.0, 2.5
"""Speeds of the paper over pi [rad/s]."""

PLAY_MODELS = ("rigid", "flexible")

QUANTITIES = {
    "peak.P1.force": ("contact force", "N", 1.0),
    "peak.slider.ax": ("slider acceleration", "m/s^2", 1.0),
    "peak.motor1.torque": ("torque 1", "N m", 1.0),
    "peak.motor4.torque": ("torque 4", "N m", 1.0),
    "flight": ("free flight", "%", 100.0),
    "penetration": ("penetration", "um", 1e6),
    "landings": ("landings a turn", "", 1.0),
}
"""Measures of a turn: what they are called, and in what unit they are shown, so many to one of SI."""

SI = {"%": "1", "um": "m", "": "1", "m/s^2": "m/s2"}

PEAKS = ("peak.P1.force", "peak.slider.ax", "peak.motor1.torque", "peak.motor4.torque")
RESPONSES = PEAKS[1:]


class Key(NamedTuple):
    """Of what a result is.

    Parameters
    ----------
    model : "ideal", "rigid" or "flexible".
    speed : over pi [rad/s].
    clearance : at P1 [m]; 0 for the ideal mechanism.
    law : "coulomb", "lugre" or "none", the friction at P1.
    """

    model: str
    speed: float
    clearance: float = LARGE
    law: str = "coulomb"

    @property
    def text(self) -> str:
        """For tables."""
        play = f", {1e3 * self.clearance:.3g} mm" if self.clearance else ""
        law = {"coulomb": "", "lugre": ", LuGre", "none": ", no friction"}[self.law]
        return f"{self.model}, {self.speed:g} pi rad/s{play}{law}"


def ideal(speed: float) -> Key:
    """The ideal mechanism at a speed over pi [rad/s]."""
    return Key("ideal", speed, 0.0)


@dataclass(frozen=True)
class Evidence:
    """Results of runs.

    Parameters
    ----------
    motions : settled turns, as `Motion` returns them.
    starts : the first turns.
    growths : exponents and section points, as `Growth` returns them (and `Attractor`).
    diagrams : as `bifurcation` returns them, by parameter ("speed", "clearance") and model.
    """

    motions: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    starts: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    growths: Mapping[Key, xr.Dataset] = field(default_factory=dict)
    diagrams: Mapping[tuple[str, str], xr.Dataset] = field(default_factory=dict)

    def has(self, *keys: Key) -> bool:
        """Whether there are settled turns of all of them."""
        return all(key in self.motions for key in keys)

    def mean(self, key: Key, quantity: str) -> Mean:
        """Mean of a measure over the settled turns [SI].

        Parameters
        ----------
        key : of what.
        quantity : one of `QUANTITIES`.
        """
        return Mean.of(self.motions[key][quantity].values)

    def speeds(self, model: str, law: str = "coulomb") -> list[float]:
        """Speeds over pi at which there are settled turns with 0.5 mm of play, rising.

        Parameters
        ----------
        model : "rigid" or "flexible".
        law : friction at P1.
        """
        return sorted(k.speed for k in self.motions if (k.model, k.clearance, k.law) == (model, LARGE, law))

    def stroke(self, speed: float) -> float:
        """Of the slider of the ideal mechanism [m], or of any other at this speed; NaN if there is none."""
        for key in sorted(self.motions, key=lambda key: key.model != "ideal"):
            if key.speed == speed:
                return float(np.ptp(self.motions[key]["slider.x"].values))
        return math.nan


@dataclass(frozen=True)
class Plan:
    """The runs that evidence comes from; fields as of `Evidence`.

    Parameters
    ----------
    motions, starts, growths : runs by what they are of.
    diagrams : runs by parameter and model.
    """

    motions: Mapping[Key, Run] = field(default_factory=dict)
    starts: Mapping[Key, Run] = field(default_factory=dict)
    growths: Mapping[Key, Run] = field(default_factory=dict)
    diagrams: Mapping[tuple[str, str], Run] = field(default_factory=dict)

    @property
    def runs(self) -> tuple[Run, ...]:
        """All of them, each once."""
        found: dict[Any, None] = {}
        for group in (self.motions, self.starts, self.growths, self.diagrams):
            found.update(dict.fromkeys(group.values()))
        return tuple(found)

    def read(self, results: Results) -> Evidence:
        """The evidence.

        Parameters
        ----------
        results : by runs.
        """
        groups = (self.motions, self.starts, self.growths, self.diagrams)
        return Evidence(*({key: results[run] for key, run in group.items()} for group in groups))


def shown(mean: Mean, quantity: str) -> str:
    """A mean with the standard deviation of its turns, in the unit of tables.

    Parameters
    ----------
    mean : in SI.
    quantity : one of `QUANTITIES`.
    """
    _, unit, factor = QUANTITIES[quantity]
    value, spread = factor * mean.value, factor * mean.deviation
    text = plain(value, 4) if spread <= 1e-4 * abs(value) else f"{plain(value, 4)} ± {plain(spread, 2)}"
    return f"{text} {unit}".rstrip()


def si_unit(quantity: str) -> str:
    """The unit of a measure in results.

    Parameters
    ----------
    quantity : one of `QUANTITIES`.
    """
    _, unit, _ = QUANTITIES[quantity]
    return SI.get(unit, unit)
