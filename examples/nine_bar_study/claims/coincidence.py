"""Parts of claims on instants: coincident peaks of two signals, equal times of impacts of two motions."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from nine_bar_study.claims.finding import ASIDE, Part, by_rule
from nine_bar_study.motion import APART, peaks_of
from nine_bar_study.statistics import binomial_tail

if TYPE_CHECKING:
    import xarray as xr

WINDOW = 5e-3
"""Largest distance of coincident peaks over the period; about the resolution of a figure of one turn."""

SHARE, FEW = 0.8, 0.5
"""Share of coincident peaks at or above which a claim agrees, and below which it disagrees."""

CHANCE = 1e-3
"""Probability of the hits by chance below which a claim may agree."""

LIKELY = 0.05
"""Probability of the hits by chance above which a claim disagrees, if the windows cover less than `FEW` of the time."""
FEWEST = 3
"""Least number of peaks for a verdict."""


class Coincidence(NamedTuple):
    """Peaks that coincide with peaks of another signal or motion.

    Parameters
    ----------
    hits, peaks : number of coincident peaks, and number of all peaks.
    chance : share of the time within the window of any other peak.
    probability : probability of at least `hits` coincidences by chance.
    lag : median delay of the peaks after the nearest other peak [s].
    """

    hits: int
    peaks: int
    chance: float
    probability: float
    lag: float

    @property
    def verdict(self) -> str:
        """AGREES, DISAGREES or UNDECIDED by the rule of claims on peaks."""
        share = self.hits / self.peaks if self.peaks else 0.0
        enough = self.peaks >= FEWEST
        agrees = enough and share >= SHARE and self.probability < CHANCE
        disagrees = enough and (share < FEW or (self.probability > LIKELY and self.chance < FEW))
        return by_rule(agrees=agrees, disagrees=disagrees and not agrees)

    @property
    def text(self) -> str:
        """Text of the numbers for tables."""
        share = f"{self.hits} of {self.peaks} peaks, {100 * self.chance:.2g} % of the time would by chance"
        return f"{share} (probability {self.probability:.1g}), median lag {1e3 * self.lag:+.2g} ms"


def coincidence(peaks: np.ndarray, others: np.ndarray, span: tuple[float, float], window: float) -> Coincidence:
    """Coincidence of peaks with other peaks.

    Parameters
    ----------
    peaks, others : instants [s].
    span : begin and end of the observed time [s].
    window : largest distance of coincident peaks [s].
    """
    if not len(peaks) or not len(others):
        return Coincidence(0, len(peaks), 0.0, 1.0, float("nan"))
    lags = peaks[:, None] - others[None, :]
    lags = lags[np.arange(len(peaks)), np.abs(lags).argmin(axis=1)]
    hits = int((np.abs(lags) <= window).sum())
    ends = np.clip(np.stack([others - window, others + window], axis=1), *span)
    covered, reached = 0.0, span[0]
    for begin, end in ends[np.argsort(ends[:, 0])]:
        covered += max(end - max(begin, reached), 0.0)
        reached = max(reached, end)
    chance = covered / (span[1] - span[0])
    return Coincidence(hits, len(peaks), chance, binomial_tail(hits, len(peaks), chance), float(np.median(lags)))


def coinciding(data: xr.Dataset, what: str, signal: str, force: str) -> Part:
    """Part of a claim that the peaks of a signal coincide with the peaks of the contact force, over all settled turns.

    Parameters
    ----------
    data : settled turns.
    what : text of the signal and the case.
    signal, force : name of the signal and of the contact force.
    """
    period = float(data.attrs["period"])
    responses, forces = (np.sort(data[f"large.{name}"].values) for name in (signal, force))
    begin = (int(data.attrs["first_turn"]) - 1) * period
    found = coincidence(responses, forces, (begin, begin + data.sizes["turn"] * period), WINDOW * period)
    values = {"hits": found.hits, "peaks": found.peaks, "chance": found.chance, "lag": found.lag}
    return Part(what, found.verdict, found.text, values)


def same_times(what: str, force: str, one: xr.Dataset, other: xr.Dataset, turns: tuple[int, int] = (0, 0)) -> Part:
    """Part of a claim that the force peaks of one turn of two motions coincide.

    Parameters
    ----------
    what : text of the turns.
    force : name of the contact force.
    one, other : settled turns of both motions.
    turns : index of the compared turn among the saved turns, of each motion.
    """
    (peaks, period), (others, _) = (_turn(data, k, force) for data, k in zip((one, other), turns, strict=True))
    found = coincidence(peaks, others, (0.0, period), WINDOW * period)
    values = {"hits": found.hits, "peaks": found.peaks, "chance": found.chance}
    return Part(f"impact times, {what}", found.verdict, found.text, values)


def _turn(data: xr.Dataset, number: int, force: str) -> tuple[np.ndarray, float]:
    """Instants of the force peaks of a saved turn, from the begin of the turn (k,) [s], and the period [s]."""
    time, period = data["time"].values, float(data.attrs["period"])
    begin = time[0] + number * period
    inside = (time >= begin) & (time <= begin + period)
    return peaks_of(time[inside] - begin, data[force].values[inside], APART * period), period


def equal_landings(first: xr.Dataset, second: xr.Dataset) -> Part:
    """Part, not counted, on the equal onsets of contact of two motions with the same start."""
    a, b = first["contact.start"].values, second["contact.start"].values
    period = float(first.attrs["period"])
    count = min(len(a), len(b))
    apart = np.abs(a[:count] - b[:count]) > WINDOW * period
    same = int(apart.argmax()) if apart.any() else count
    until = float(a[min(same, count - 1)]) if count else 0.0
    text = f"the first {same} landings agree within {1e3 * WINDOW * period:.2g} ms, until {1e3 * until:.3g} ms"
    return Part("landings in their order", ASIDE, text, {"same": same, "until": until})
