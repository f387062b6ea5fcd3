"""Claims on instants: whether peaks coincide (3), and whether two friction laws hit at the same times (12)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.paper.claims.evidence import (
    FAST,
    LARGE,
    MIDDLE,
    PLAY_MODELS,
    QUANTITIES,
    RESPONSES,
    SMALL,
    Evidence,
    Key,
    shown,
)
from flexmb.paper.claims.finding import ASIDE, Finding, Part, by_rule, expect, finding
from flexmb.paper.statistics import HIGHER, binomial_tail, compare

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
    """How many peaks lie at others.

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
        """AGREES, DISAGREES or UNDECIDED; see `peaks_coincide`."""
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


def peaks_coincide(seen: Evidence) -> Finding:
    """Claim 3: peaks of acceleration and torques occur at the times of the peaks of the contact force.

    Rule, at 2 pi rad/s for each model and clearance, over the shown turns: peaks are maxima of at least half of the
    largest one, and coincide within 0.5 % of a turn.  It agrees if at least 80 % of the peaks of the response lie at a
    peak of the force, which chance does in less than one case of 1000.  It disagrees if less than 50 % do, or no more
    than chance would have it (probability above 5 %, where chance would not reach half of them anyway).
    """
    parts = []
    for model in PLAY_MODELS:
        for clearance in (SMALL, LARGE):
            key = Key(model, MIDDLE, clearance)
            if seen.has(key):
                parts += [_response(seen, key, quantity) for quantity in RESPONSES]
    return finding(parts)


def _response(seen: Evidence, key: Key, quantity: str) -> Part:
    data = seen.motions[key]
    time, period = data["time"].values, float(data.attrs["period"])
    signal = quantity.removeprefix("peak.")
    responses = peaks_of(time, data[signal].values, APART * period)
    forces = peaks_of(time, data["P1.force"].values, APART * period)
    found = coincidence(responses, forces, (time[0], time[-1]), WINDOW * period)
    values = {"hits": found.hits, "peaks": found.peaks, "chance": found.chance, "lag": found.lag}
    return Part(f"{QUANTITIES[quantity][0]}, {key.text}", found.verdict, found.text, values)


def friction_laws(seen: Evidence) -> Finding:
    """Claim 12: modified Coulomb and LuGre give the same impact times, and LuGre gives the higher peaks.

    Rule, rigid, 2.5 pi rad/s, 0.5 mm.  Impact times: the peaks of the contact force of one law lie at those of the
    other, by the rule of claim 3, in the first turn after the same start, and in the shown settled turns.  Peaks: means
    of acceleration and torques with LuGre against modified Coulomb, by `compare`.  Beside it, not counted: the same
    coincidence of two successive turns of modified Coulomb, which shows what another start alone would do.
    """
    coulomb, lugre = Key("rigid", FAST), Key("rigid", FAST, LARGE, "lugre")
    parts = []
    if coulomb in seen.starts and lugre in seen.starts:
        first, second = seen.starts[coulomb], seen.starts[lugre]
        parts += [_same_times("first turn", second, first, 0, 0), _equal_landings(first, second)]
    if seen.has(coulomb, lugre):
        first, second = seen.motions[coulomb], seen.motions[lugre]
        parts.append(_same_times("settled turn", second, first, 0, 0))
        control = _same_times("control: a turn of Coulomb against the one before", first, first, 1, 0)
        parts.append(Part(control.what, ASIDE, f"{control.numbers}: {control.verdict}", control.values))
        for quantity in RESPONSES:
            a, b = seen.mean(lugre, quantity), seen.mean(coulomb, quantity)
            found = compare(a, b)
            text = f"{shown(a, quantity)} against {shown(b, quantity)}, ratio {found.shown}: {found.verdict}"
            what = f"{QUANTITIES[quantity][0]}, LuGre against Coulomb"
            parts.append(Part(what, expect(found, HIGHER), text, {"ratio": found.ratio}))
    return finding(parts)


def _turn(data: xr.Dataset, number: int) -> tuple[np.ndarray, float]:
    """Peaks of the force in one of the shown turns, as times since its begin [s], and the period."""
    time, period = data["time"].values, float(data.attrs["period"])
    begin = time[0] + number * period
    inside = (time >= begin) & (time <= begin + period)
    return peaks_of(time[inside] - begin, data["P1.force"].values[inside], APART * period), period


def _same_times(what: str, one: xr.Dataset, other: xr.Dataset, turn: int, of_other: int) -> Part:
    peaks, period = _turn(one, turn)
    others, _ = _turn(other, of_other)
    found = coincidence(peaks, others, (0.0, period), WINDOW * period)
    values = {"hits": found.hits, "peaks": found.peaks, "chance": found.chance}
    return Part(f"impact times, {what}", found.verdict, found.text, values)


def _equal_landings(first: xr.Dataset, second: xr.Dataset) -> Part:
    """How long the landings of both laws follow each other from the same start."""
    a, b = first["contact.start"].values, second["contact.start"].values
    period = float(first.attrs["period"])
    count = min(len(a), len(b))
    apart = np.abs(a[:count] - b[:count]) > WINDOW * period
    same = int(apart.argmax()) if apart.any() else count
    until = float(a[min(same, count - 1)]) if count else 0.0
    text = f"the first {same} landings agree within {1e3 * WINDOW * period:.2g} ms, until {1e3 * until:.3g} ms"
    return Part("landings in their order", ASIDE, text, {"same": same, "until": until})
