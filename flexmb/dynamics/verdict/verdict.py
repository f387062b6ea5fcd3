"""The verdict on a motion: periodic, quasi-periodic, chaotic, transient or inconclusive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from types import MappingProxyType
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.sections.section_signals import SEPARATE, Columns, columns_of, points_of
from flexmb.dynamics.verdict.cycles import (
    band_count,
    doublings,
    find_approach,
    find_cycle,
    longest_cycle,
    swells,
    without_bands,
)
from flexmb.dynamics.verdict.drift import find_drift
from flexmb.dynamics.verdict.halves import halves_differ
from flexmb.dynamics.verdict.separation import separation
from flexmb.errors import InputError
from flexmb.series.samples import LARGEST
from flexmb.series.zero_one import CHAOTIC, growth_correlations, kind_of

LEAST = 12
"""Points below which there is no verdict at all."""

LEAST_APERIODIC = 100
"""Points below which quasi-periodic and chaotic are not told apart."""

LEAST_CHAOTIC, CLEARLY = 50, 3.0
"""Points with which chaos can be told if the exponent is so many times its error."""

SETTLED = 0.1
"""Part of the record within which points may settle on a cycle that is still called periodic."""

MOST_SIGNALS = 8
"""Columns that the 0-1 test is made of, at most."""

PART = 4
"""The 0-1 test looks at lags up to this part of the record: with a tenth, as in the source, 250 points of a closed
curve may still look chaotic, and banded chaos regular."""

RELATIVE = 1e-4
"""Differences below this part of a signal's spread count as none."""


@dataclass(frozen=True)
class Verdict:
    """What kind of motion it is; `str` gives "periodic-3", "quasi-periodic", "chaotic", "transient", "inconclusive".

    Parameters
    ----------
    kind : "periodic", "quasi-periodic", "chaotic", "transient" or "inconclusive".
    reason : why, and what to do where it is inconclusive or transient, in a sentence or two.
    k : points of the cycle of a periodic motion, or of that which a transient leads to; 0: none.
    evidence : the numbers it rests on: see `judge`.
    """

    kind: str
    reason: str
    k: int = 0
    evidence: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}), repr=False, hash=False)

    def __post_init__(self) -> None:
        checks.one_of("Verdict", "kind", self.kind, KINDS)
        object.__setattr__(self, "evidence", MappingProxyType(dict(self.evidence)))

    def __str__(self) -> str:
        return f"periodic-{self.k}" if self.kind == "periodic" else self.kind

    def __reduce__(self) -> tuple[Any, ...]:  # a mapping proxy cannot be pickled
        return type(self), (self.kind, self.reason, self.k, dict(self.evidence))


KINDS = ("periodic", "quasi-periodic", "chaotic", "transient", "inconclusive")


def judge(
    points: Any,
    names: Sequence[str],
    *,
    exponent: float | None = None,
    error: float | None = None,
    units: Sequence[str] | None = None,
    driven: Sequence[str] = (),
    floor: float = 1e-6,
    sizes: Sequence[float] | None = None,
) -> Verdict:
    """The verdict on the motion whose successive section points are `points`; one for the system.

    1. Cycle: the shortest k for which all points of each phase in the last quarter lie within 1e-4 of the spread of
       their signal (or `floor`).  If this holds from the first tenth of the record on it is periodic-k, if only later
       transient.  k is at most 200 and a sixth of the points.  Where the exponent is negative ten times as much is
       allowed: nothing but noise can keep such points apart.
    2. Approach: steps over k that shrink from third to third of the record make it transient.
    3. Drift: a signal that moves on by the same amount from point to point, to the tolerance (a cycle may be on top),
       or in the means of sixteen parts of the record, 95 % of whose mean square is a line.  Transient, with the step in
       a point: a motion that moves on for ever is told from one that settles by its rate, not by its place.  An angle
       ("rad") counts modulo 2 pi: one that goes all the way round is no drift, one that has not come round is.
    4. Transient, too, if the halves of the record differ: their means by more than the larger standard deviation, or
       the deviations by more than a factor 3 (of means and deviations or of medians and quartiles, whichever differ
       less); or neighbours part in one and stay together in the other; or a regular motion swells or shrinks from
       quarter to quarter, by more than 5 % in all.  So is what walks away as chance leads it, as the action in a
       chaotic sea does, unless it is an angle.
    5. Chaotic: the exponent lies above its error, and the 0-1 test (K > 0.7) or the separation of neighbours (D > 0.5)
       says chaotic and neither says regular.
    6. Bands that double as far as the record can show (2, 4, 8 ..., of 12 points each), each time with a fourth of the
       mean square at most: at or near a point where period doublings accumulate.  There the exponent is 0 and the
       points are a set of Cantor's kind, no closed curve: inconclusive.
    7. Quasi-periodic: the exponent is 0 within its error, and neither says chaotic, one regular (K < 0.3, D < 0.2).
       Without an exponent both must agree; to a K below 0.7 a D below 0.05 will do, as the 0-1 test needs some 200
       points of a closed curve to come near 0.  An island of a conservative system is a closed curve as well.
    8. All else contradicts itself or is too little: inconclusive.  So is an exponent of 0 without a closed curve, as in
       conservative systems, where neighbours part like a power of time and the exponent falls as log(t) / t.

    The separation D says how much of the way from the distance of nearest neighbours (of points with their two
    successors) to that of arbitrary ones is gone after up to n/5 steps: closed curves keep it, chaos loses it.
    Noise has none.  K, of lags up to n/4, is taken of what is left when the means of bands that are visited in turn
    are taken away; D compares with points of one band.

    A signal that is zero at the section up to round-off (a velocity at a dead centre) is told from one that moves a
    little by `units` or `sizes` only: give them where there is one.

    Parameters
    ----------
    points : (n, m) successive points of a stroboscopic or other section, of all signals, without the known transient;
        at least 12, and 100 to tell quasi-periodic from chaotic; 50 for chaos with an exponent above 3 times its error.
    names : names (m,) of the signals.
    exponent : largest exponent of the system if it is known, of the flow (zero for a periodic motion without
        drive) or of the section [any unit].
    error : half width of its band [same unit]; None: 0.
    units : units (m,) of the signals; "rad" is taken modulo 2 pi.  None: only signals that grow by whole turns are.
    driven : names of the signals that drives prescribe; they say nothing about the motion.
    floor : part of the size of a signal that is round-off or integration error, > 0.
    sizes : sizes (m,) of the signals, such as their largest magnitudes over the run [units]; None: those of the points,
        and at least 1e-3 of the largest of the same unit.

    Returns
    -------
    The verdict.  Its `evidence` holds, where they were found, "points", "signals" (used), "k", "since", "shrink",
    "drift" (in a point), "level" (difference of means over deviation), "loudness" (ratio of deviations), "swelling" (of
    quarters), "bands", "doublings", "zero_one" (K), "separation" (D), "exponent", "error".  Points that are not finite
    make it inconclusive.

    Raises
    ------
    InputError : points and names of different number, an unknown driven signal, an exponent that is no number.

    Notes
    -----
    Sources: G. A. Gottwald and I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129; H. Kantz, Phys. Lett. A 185
    (1994) 77 for the separation; J.-P. Eckmann, S. O. Kamphorst and D. Ruelle, Europhys. Lett. 4 (1987) 973.
    Cost: 0.1 s for 500 points of 4 signals.

    Examples
    --------
    >>> import flexmb as fm
    >>> print(fm.judge([[0.5], [0.8]] * 50, ["x"]))
    periodic-2
    """
    values, labels = points_of(points, names)
    checked = _about_signals(labels, units, driven, sizes)
    known = _exponent(exponent, error)
    floor = checks.positive("judge", "floor", floor)
    evidence: dict[str, float] = {"points": float(len(values)), **known}
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        return Verdict("inconclusive", f"Point {bad[0]} is not finite: the run failed there.", 0, evidence)
    if np.abs(values).max(initial=0.0) > LARGEST:
        return Verdict("inconclusive", f"A signal is above {LARGEST:g}: the motion grows without bound.", 0, evidence)
    if len(values) < LEAST:
        return Verdict("inconclusive", f"{len(values)} points; at least {LEAST} are needed.", 0, evidence)
    columns = columns_of(values, labels, checked[0], checked[1], floor, checked[2])
    evidence["signals"] = float(len(set(columns.names)))
    if not columns.names:
        text = f"Only driven signals ({', '.join(columns.left_out)}), which say nothing. Give others."
        return Verdict("inconclusive", text, 0, evidence)
    return _periodic(columns, evidence) or _transient(columns, evidence) or _aperiodic(columns, evidence)


def _about_signals(
    names: tuple[str, ...], units: Sequence[str] | None, driven: Sequence[str], sizes: Sequence[float] | None
) -> tuple[tuple[str, ...] | None, tuple[str, ...], np.ndarray | None]:
    """Units, driven names and sizes of signals, checked."""
    without_motion = checks.sequence("judge", "driven", driven, "names of signals")
    for name in without_motion:
        checks.one_of("judge", "driven", name, names)
    known = None if units is None else checks.sequence("judge", "units", units, "units")
    if known is not None and len(known) != len(names):
        raise InputError(f"judge: {len(known)} units for {len(names)} names.")
    if sizes is None:
        return known, without_motion, None
    given = checks.sequence("judge", "sizes", sizes, "numbers")
    if len(given) != len(names):
        raise InputError(f"judge: {len(given)} sizes for {len(names)} names.")
    numbers = [checks.not_negative("judge", f"sizes[{k}]", size) for k, size in enumerate(given)]
    return known, without_motion, np.array(numbers)


def _exponent(exponent: float | None, error: float | None) -> dict[str, float]:
    """The exponent and its error as evidence; none if it is None or NaN."""
    if _is_unknown(exponent):
        return {}
    value = checks.number("judge", "exponent", exponent)
    band = 0.0 if _is_unknown(error) else checks.not_negative("judge", "error", error)
    return {"exponent": value, "error": band}


def _is_unknown(value: Any) -> bool:
    return value is None or (isinstance(value, Real) and bool(np.isnan(float(value))))


def _tolerances(columns: Columns) -> np.ndarray:
    return np.maximum(columns.floor, RELATIVE * columns.spread) + 1e-300


def _periodic(columns: Columns, evidence: dict[str, float]) -> Verdict | None:
    noise = SEPARATE if _sign(evidence) < 0 else 1.0  # where neighbours meet, nothing else keeps points apart
    cycle = find_cycle(columns.values / (noise * _tolerances(columns)))
    if cycle is None:
        return None
    evidence["k"], evidence["since"] = float(cycle.k), float(cycle.since)
    count = len(columns.values)
    text = f"The points return after {cycle.k} step{'s' if cycle.k > 1 else ''}"
    if cycle.since > SETTLED * count:
        drifts = _drifts(columns, evidence)
        if drifts is not None:
            return drifts
        text += f", but only from point {cycle.since} of {count} on: leave out at least {cycle.since} more."
        return Verdict("transient", text, cycle.k, evidence)
    if _sign(evidence) > 0:
        text += f"; yet the exponent is {_band(evidence)}, above zero. The cycle is unstable, or the exponent wrong."
        return Verdict("inconclusive", text, cycle.k, evidence)
    text += f" from point {cycle.since} on." if cycle.since else "."
    return Verdict("periodic", text, cycle.k, evidence)


def _transient(columns: Columns, evidence: dict[str, float]) -> Verdict | None:
    tolerances, count = _tolerances(columns), len(columns.values)
    scaled = columns.values / tolerances
    spread = float(np.ptp(scaled, axis=0).max())
    approach = find_approach(scaled, spread) or find_approach(scaled[count // 2 :], spread)
    if approach is not None:
        evidence["k"], evidence["shrink"] = float(approach.k), approach.rate
        text = f"The points still creep towards a {approach.k}-cycle: steps shrink by {approach.rate:.4g} a point"
        more = np.log(max(approach.left, 1.0)) / -np.log(approach.rate) if 0.0 < approach.rate < 1.0 else np.inf
        advice = f"some {np.ceil(more):.0f} more points" if np.isfinite(more) else "more points"
        return Verdict("transient", f"{text}; leave out these and {advice}.", approach.k, evidence)
    drifts = _drifts(columns, evidence)
    if drifts is not None:
        return drifts
    level, loudness = halves_differ(columns.values, tolerances)
    evidence["level"], evidence["loudness"] = level, loudness
    if level <= 1.0 and loudness <= 3.0:
        return None
    text = f"The halves of the record differ: their means by {level:.2g} standard deviations, these by {loudness:.2g}"
    text += " times. Leave out more points, or take more"
    advice = "What walks away as chance leads it is to be left out, or given as rad if it counts modulo 2 pi"
    return Verdict("transient", f"{text}. {advice}." if _sign(evidence) > 0 else f"{text}.", 0, evidence)


def _drifts(columns: Columns, evidence: dict[str, float]) -> Verdict | None:
    """The verdict on points that move on from period to period; None: they do not."""
    found = find_drift(columns.values, _tolerances(columns))
    if found is None:
        return None
    evidence["drift"], evidence["k"] = found.step, float(found.k)
    whole = found.step * (len(columns.values) - 1)
    text = f"{columns.names[found.column]} moves on by {found.step:.3g} a point, {whole:.3g} over the record"
    if found.k > 1:
        text += f", with a {found.k}-cycle on top"
    advice = "Leave out more points if it comes to rest; if it goes on for ever, look at its rate instead"
    return Verdict("transient", f"{text}. {advice}; give an angle the unit rad and enough points to come round.",
                   found.k, evidence)  # fmt: skip


def _aperiodic(columns: Columns, evidence: dict[str, float]) -> Verdict:
    count = len(columns.values)
    clearly = evidence.get("exponent", 0.0) > CLEARLY * evidence.get("error", 0.0)
    if count < (LEAST_CHAOTIC if clearly else LEAST_APERIODIC):
        text = f"No cycle of up to {longest_cycle(count)} points. To tell more {LEAST_APERIODIC} are needed"
        return Verdict("inconclusive", f"{text}; there are {count}.", 0, evidence)
    clear = columns.spread > SEPARATE * columns.floor
    if not clear.any():
        text = (
            f"The points differ by less than {SEPARATE:g} times the floor: a cycle with the integration's noise, or a"
        )
        return Verdict("inconclusive", f"{text} motion too small to see. Integrate more finely.", 0, evidence)
    z = columns.values[:, clear]
    z = (z - z.mean(axis=0)) / z.std(axis=0)
    bands = band_count(z)
    left = without_bands(z, bands)[:, :: -(-z.shape[1] // MOST_SIGNALS)]
    angles = np.random.default_rng(0).uniform(np.pi / 5, 4 * np.pi / 5, 60)
    K = float(np.median([np.median(growth_correlations(column, angles, PART)) for column in left.T]))
    D = separation(z, bands)
    evidence.update(bands=float(bands), doublings=float(doublings(z)), zero_one=K, separation=D)
    return _changing(z, bands, evidence) or _weighed(kind_of(K), _kind_of_separation(D), evidence)


def _changing(z: np.ndarray, bands: int, evidence: dict[str, float]) -> Verdict | None:
    """The verdict on points (n, m) whose kind or amplitude changes within the record; None: they do not."""
    half = len(z) // 2
    if half >= LEAST_APERIODIC:
        kinds = [_kind_of_separation(separation(part, bands)) for part in (z[:half], z[half:])]
        if set(kinds) == {"regular", "chaotic"}:
            text = f"The first half of the record is {kinds[0]}, the second {kinds[1]}. Leave out more points."
            return Verdict("transient", text, 0, evidence)
    swelling = swells(z)
    evidence["swelling"] = swelling
    if evidence["zero_one"] < CHAOTIC and evidence["separation"] < 0.2 and swelling > 1.05:
        text = f"A regular motion whose amplitude changes by a factor {swelling:.3g} from first to last quarter."
        return Verdict("transient", f"{text} Leave out more points, or take more.", 0, evidence)
    return None


def _kind_of_separation(D: float) -> str:
    if D < 0.2:
        return "regular"
    return "chaotic" if D > 0.5 else "undecided"


def _weighed(walk: str, parting: str, evidence: dict[str, float]) -> Verdict:
    """The verdict on points without cycle and without transient, from three witnesses."""
    said, sign = {walk, parting}, _sign(evidence)
    D = evidence["separation"]
    far = f"separation {D:.2f} ({parting})" if np.isfinite(D) else "too few points to find neighbours"
    told = f"0-1 test {evidence['zero_one']:.2f} ({walk}), {far}"
    if "exponent" in evidence:
        told = f"exponent {_band(evidence)}, {told}"
        chaotic = sign > 0 and "chaotic" in said and "regular" not in said
        closed = sign == 0 and "regular" in said and "chaotic" not in said
    else:
        together = walk != "chaotic" and evidence["separation"] < 0.05
        chaotic, closed = said == {"chaotic"}, said == {"regular"} or together
    if chaotic:
        return Verdict("chaotic", f"No cycle, and neighbours part: {told}.", 0, evidence)
    if evidence["doublings"]:
        text = f"Bands double again and again, {2 ** evidence['doublings']:.0f} are seen: {told}"
        advice = "At or near a point where period doublings accumulate, chaos and long cycles look alike"
        return Verdict("inconclusive", f"{text}. {advice}: take more points, or another parameter.", 0, evidence)
    if closed:
        return Verdict("quasi-periodic", f"No cycle, and neighbours stay together: {told}.", 0, evidence)
    if sign < 0:
        text = f"No cycle of up to {longest_cycle(int(evidence['points']))} points, yet a negative exponent: {told}."
        return Verdict("inconclusive", f"{text} A longer cycle, or one not reached yet: take more points.", 0, evidence)
    if "exponent" in evidence and sign == 0:
        text = f"An exponent of zero, but no closed curve is seen: {told}. Neighbours part like a power of time, as in"
        advice = "a conservative system, which a finite record does not decide; or chaos is too weak to be told yet"
        return Verdict("inconclusive", f"{text} {advice}: take more points.", 0, evidence)
    advice = "Take more points" + ("" if "exponent" in evidence else ", or give the exponent of the system")
    return Verdict("inconclusive", f"The witnesses do not agree: {told}. {advice}.", 0, evidence)


def _sign(evidence: Mapping[str, float]) -> int:
    """1, 0, -1: the exponent lies above, within, below its error about zero; 0 as well if it is not known."""
    value, error = evidence.get("exponent", 0.0), evidence.get("error", 0.0)
    return int(value > error) - int(value < -error)


def _band(evidence: Mapping[str, float]) -> str:
    return f"{evidence['exponent']:.3g} +- {evidence['error']:.2g}"
