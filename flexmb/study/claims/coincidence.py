"""Parts on instants: whether peaks of two signals coincide, and whether two motions hit at the same times."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.study.claims.finding import ASIDE, Part, by_rule
from flexmb.study.statistics import binomial_tail

if TYPE_CHECKING:
    import xarray as xr

COUNTED = 0.5
"""Peaks count from this part of the largest one on."""

APART = 1e-3
"""Least distance of two peaks, as a part of the turn: of those that are closer the larger one counts."""

WINDOW = 5e-3
"""Peaks that are closer coincide, as a part of the turn: about what can be seen in a figure of one turn."""

SHARE, FEW = 0.8, 0.5
"""Parts of the peaks that coincide from which a claim agrees, and below which it disagrees."""

CHANCE = 1e-3
"""Probability of the share by chance that is not believed; and of a chance so good that nothing could be seen."""

LIKELY = 0.05
FEWEST = 3


class Coincidence(NamedTuple):
    """Share of peaks at the same instants as other peaks.

    Parameters
    ----------
    hits, peaks : how many of how many.
    chance : share of the time that lies within the window of any of the others.
    probability : of as many hits or more by chance.
    lag : median of the times by which the peaks follow the nearest of the others [s].
    """

    hits: int
    peaks: int
    chance: float
    probability: float
    lag: float

    @property
    def verdict(self) -> str:
        """AGREES, DISAGREES or UNDECIDED; the rule of claims on peaks."""
        share = self.hits / self.peaks if self.peaks else 0.0
        enough = self.peaks >= FEWEST
        agrees = enough and share >= SHARE and self.probability < CHANCE
        disagrees = enough and (share < FEW or (self.probability > LIKELY and self.chance < FEW))
        return by_rule(agrees=agrees, disagrees=disagrees and not agrees)

    @property
    def text(self) -> str:
        """For tables."""
        share = f"{self.hits} of {self.peaks} peaks, {100 * self.chance:.2g} % of the time would by chance"
        return f"{share} (probability {self.probability:.1g}), median lag {1e3 * self.lag:+.2g} ms"


def peaks_of(time: np.ndarray, values: np.ndarray, apart: float) -> np.ndarray:
    """Instants of the large peaks of a signal's size, in order (k,) [s].

    Parameters
    ----------
    time, values : (n,) the signal at every step [s, any unit].
    apart : least distance of two peaks [s].
    """
    size = np.abs(values)
    inner = np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])) + 1
    kept: list[float] = []
    for k in inner[np.argsort(-size[inner], kind="stable")]:
        if size[k] < COUNTED * size.max():
            break
        if all(abs(time[k] - other) >= apart for other in kept):
            kept.append(float(time[k]))
    return np.sort(np.array(kept))


def coincidence(peaks: np.ndarray, others: np.ndarray, span: tuple[float, float], window: float) -> Coincidence:
    """Which peaks lie within a window of others.

    Parameters
    ----------
    peaks, others : instants [s].
    span : begin and end of the time looked at [s].
    window : largest distance [s].
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
    """The peaks of a signal, which must lie at the peaks of the force.

    Parameters
    ----------
    data : settled turns.
    what : the signal and the case in words.
    signal, force : names of the signals.
    """
    time, period = data["time"].values, float(data.attrs["period"])
    responses, forces = (peaks_of(time, data[name].values, APART * period) for name in (signal, force))
    found = coincidence(responses, forces, (time[0], time[-1]), WINDOW * period)
    values = {"hits": found.hits, "peaks": found.peaks, "chance": found.chance, "lag": found.lag}
    return Part(what, found.verdict, found.text, values)


def same_times(what: str, force: str, one: xr.Dataset, other: xr.Dataset, turns: tuple[int, int] = (0, 0)) -> Part:
    """The force peaks of a turn of one motion, which must lie at those of a turn of another.

    Parameters
    ----------
    what : the turns in words.
    force : name of the force.
    one, other : the motions.
    turns : numbers of the shown turns.
    """
    (peaks, period), (others, _) = (_turn(data, k, force) for data, k in zip((one, other), turns, strict=True))
    found = coincidence(peaks, others, (0.0, period), WINDOW * period)
    values = {"hits": found.hits, "peaks": found.peaks, "chance": found.chance}
    return Part(f"impact times, {what}", found.verdict, found.text, values)


def _turn(data: xr.Dataset, number: int, force: str) -> tuple[np.ndarray, float]:
    """Peaks of the force in one of the shown turns, as times since its begin [s], and the period."""
    time, period = data["time"].values, float(data.attrs["period"])
    begin = time[0] + number * period
    inside = (time >= begin) & (time <= begin + period)
    return peaks_of(time[inside] - begin, data[force].values[inside], APART * period), period


def equal_landings(first: xr.Dataset, second: xr.Dataset) -> Part:
    """For how long the landings of two motions follow each other from the same start; not counted."""
    a, b = first["contact.start"].values, second["contact.start"].values
    period = float(first.attrs["period"])
    count = min(len(a), len(b))
    apart = np.abs(a[:count] - b[:count]) > WINDOW * period
    same = int(apart.argmax()) if apart.any() else count
    until = float(a[min(same, count - 1)]) if count else 0.0
    text = f"the first {same} landings agree within {1e3 * WINDOW * period:.2g} ms, until {1e3 * until:.3g} ms"
    return Part("landings in their order", ASIDE, text, {"same": same, "until": until})
