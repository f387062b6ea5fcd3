"""Fatigue: cycles of a stress by rainflow counting, and their damage by a Woehler line."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.display.text import number_text
from flexmb.errors import InputError
from flexmb.results.stress import stress

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.results.solution import Solution

CAPTURED = 0.98
"""Largest saved stress over the largest of all accepted steps, below which cycles are said to be missed."""


@dataclass(frozen=True)
class WoehlerLine:
    """Cycles to failure over the amplitude of a stress: N = cycles (amplitude/sigma_a)^slope (Basquin).

    Parameters
    ----------
    amplitude : stress amplitude that is borne for `cycles` [Pa], > 0.
    slope : exponent k [1], > 0.
    cycles : number of cycles at this point of the line, > 0.
    limit : amplitude up to which there is no damage [Pa], >= 0; 0: every cycle counts.

    Raises
    ------
    InputError : a value out of its range.

    Notes
    -----
    The mean stress of a cycle has no influence; take the line of the load ratio that fits.
    Source: DIN 50100:2022, Load controlled fatigue testing.

    Examples
    --------
    >>> float(WoehlerLine(amplitude=100e6, slope=5.0).life(200e6))
    31250.0
    """

    amplitude: float
    slope: float = 5.0
    cycles: float = 1e6
    limit: float = 0.0

    def __post_init__(self) -> None:
        checks.positive("WoehlerLine", "amplitude", self.amplitude, "Pa")
        checks.positive("WoehlerLine", "slope", self.slope)
        checks.positive("WoehlerLine", "cycles", self.cycles)
        checks.not_negative("WoehlerLine", "limit", self.limit, "Pa")

    def life(self, amplitude: float | np.ndarray) -> np.ndarray:
        """Cycles to failure; infinite up to the limit.

        Parameters
        ----------
        amplitude : stress amplitudes [Pa].
        """
        size = np.asarray(amplitude, dtype=float)
        bears = (size <= self.limit) | (size <= 0.0)
        ratio = self.amplitude / np.where(bears, self.amplitude, size)
        return np.asarray(np.where(bears, math.inf, self.cycles * ratio**self.slope))

    def damage(self, amplitudes: np.ndarray, counts: np.ndarray) -> float:
        """Sum of counts over cycles to failure, 1 at failure (Palmgren and Miner).

        Parameters
        ----------
        amplitudes : (n,) stress amplitudes [Pa].
        counts : (n,) numbers of cycles.
        """
        return float(np.sum(counts / self.life(amplitudes)))


@dataclass(frozen=True, eq=False)
class Fatigue:
    """Cycles of the stress at one point of a body during a run, and their damage.

    Parameters
    ----------
    body : name of the body.
    node : number of the node.
    place : its place as that of a peak [m].
    ranges : (n,) differences of the largest and smallest stress of each cycle [Pa].
    means : (n,) their means [Pa].
    counts : (n,) 1 of a full cycle, 0.5 of a half one.
    duration : time over which cycles were counted [s].
    woehler : the Woehler line; None: no damage.
    captured : largest saved stress at the point over that of all accepted steps [1]; NaN at a chosen point.

    Notes
    -----
    The stress of a mesh is the principal stress that is largest by its absolute value, with its sign.  Of beams, both
    outer fibres are counted in both sections at the node, and that with the larger damage, or range, is kept.  Cycles
    are those of the saved instants, so save finely; `captured` tells what was missed.
    Source of the count: ASTM E1049-85 (2017), section 5.4.4, by the package rainflow.
    """

    body: str
    node: int
    place: tuple[float, float]
    ranges: np.ndarray = field(repr=False)
    means: np.ndarray = field(repr=False)
    counts: np.ndarray = field(repr=False)
    duration: float
    woehler: WoehlerLine | None
    captured: float = math.nan

    @property
    def damage(self) -> float:
        """Damage of the run, 1 at failure; NaN without a Woehler line."""
        return math.nan if self.woehler is None else self.woehler.damage(0.5 * self.ranges, self.counts)

    @property
    def life(self) -> float:
        """Time to failure if the run is repeated [s]; NaN without a Woehler line."""
        return self.duration / self.damage if self.damage != 0.0 else math.inf

    def __repr__(self) -> str:
        text = f"Fatigue of {self.body!r} at node {self.node}: {self.counts.sum():g} cycles in {self.duration:.6g} s"
        text += f", largest range {number_text(float(self.ranges.max(initial=0.0)))} Pa"
        if self.woehler is not None:
            text += f", damage {self.damage:.4g}, life {self.life:.4g} s"
        if self.captured < CAPTURED:
            text += f"; saved instants reach {self.captured:.2g} of the largest stress: save more"
        return text


def cycles_of(series: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ranges, means and counts of the cycles of a signal (n,) by rainflow counting."""
    rainflow = checks.package("rainflow", "fatigue", "Counting cycles")
    rows = [cycle[:3] for cycle in rainflow.extract_cycles(np.asarray(series, dtype=float).tolist())]
    ranges, means, counts = np.array(rows, dtype=float).reshape(-1, 3).T
    return ranges, means, counts


def fatigue(
    sol: Solution,
    body: str,
    woehler: WoehlerLine | None = None,
    *,
    point: tuple[float, float] | int | str | None = None,
    mechanism: Mechanism | None = None,
) -> Fatigue:
    """Cycles and damage at a point of a body; see `Solution.fatigue`."""
    if woehler is not None and not isinstance(woehler, WoehlerLine):
        raise InputError(f"fatigue: woehler is {woehler!r}; it must be a WoehlerLine(amplitude=..., slope=...).")
    peak, wanted = None, point
    if wanted is None:
        if f"{body}.von_mises" not in sol:
            text = f"fatigue: Solution of {sol.name!r} has no signal '{body}.von_mises', whose peak tells the point"
            raise InputError(f"{text}. Give point=..., or stress=True to the body.")
        peak = sol.peak(f"{body}.von_mises")
        wanted = peak.node
    own = stress(sol, body, [] if wanted is None else [wanted], mechanism=mechanism)
    histories = own["signed"].values
    if "bending" in own:
        histories = np.hstack([own["axial"].values + sign * own["bending"].values for sign in (1.0, -1.0)])
    line = woehler if woehler is not None else WoehlerLine(1.0)
    found = [cycles_of(column) for column in histories.T]
    ranges, means, counts = max(found, key=lambda one: line.damage(0.5 * one[0], one[2]))
    seen = math.nan if peak is None or peak.value == 0.0 else float(own["von_mises"].max()) / peak.value
    place = (float(own["x"][0]), float(own["y"][0]))
    span = float(sol.time[-1] - sol.time[0])
    return Fatigue(body, int(own["node"][0]), place, ranges, means, counts, span, woehler, seen)
