"""Study of a motion by `flexmb chaos`: exponents and verdict of the motion, and estimates from its signals."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.jobs.progress import ProgressBar
from flexmb.model.mechanism import Mechanism
from flexmb.results.main_signals import followed, slides
from flexmb.series.correlation import CorrelationDimension, correlation_dimension
from flexmb.series.exponent import SeriesExponent
from flexmb.series.recurrence import Recurrence, recurrence
from flexmb.series.rosenstein import rosenstein
from flexmb.series.spectrum import PowerSpectrum, power_spectrum
from flexmb.series.zero_one import ZeroOne, zero_one_test

BESIDE = {"ex": "ey", "x": "vx", "y": "vy", "theta": "omega"}
"""Signal of the ordinate by signal of the abscissa: the journal in its plane, a position against its velocity."""

HALF = np.pi
"""Half a turn [rad]."""

ENOUGH = 100
"""Largest number of samples a period for estimates whose cost grows with their number."""

LEAST = 20
"""Smallest number of points of the 0-1 test."""


@dataclass(frozen=True)
class Motion:
    """Signals of the motion, once a period and finely sampled.

    Parameters
    ----------
    names, units : names and units (m,) of the signals.
    points : signals (n, m) once a period [units].
    period : time between two points [s].
    times : times (k,) of the fine samples [s].
    fine : fine samples (k, m) [units]; k = 0 without fine samples.
    trouble : reason why the fine samples end early, or "".
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    points: np.ndarray
    period: float
    times: np.ndarray
    fine: np.ndarray
    trouble: str = ""


Continued = tuple[np.ndarray, np.ndarray, str]
"""Times (k,) [s], all signals (k, m), and reason of an early end or ""."""


@dataclass(frozen=True)
class Findings:
    """Estimates from one signal.

    Parameters
    ----------
    name : name of the signal, or "sin(NAME)" for a rotating angle.
    unit : unit of the signal.
    zero_one : 0-1 test of the points; None: too few points.
    exponent, spectrum : estimates from the fine samples; None without fine samples.
    dimension, recurrence : estimates from the fine samples; None if not selected.
    """

    name: str
    unit: str
    zero_one: ZeroOne | None
    exponent: SeriesExponent | None
    spectrum: PowerSpectrum | None
    dimension: CorrelationDimension | None
    recurrence: Recurrence | None


@dataclass(frozen=True)
class Study:
    """All results on a motion.

    Parameters
    ----------
    exponents : exponents, section points, verdict.
    period : time between two points [s].
    skip : number of periods before the first point.
    units : units of all signals in `exponents.names`.
    motion : signals once a period and finely sampled.
    findings : estimates from each selected signal.
    planes : pairs of signals to be drawn.
    """

    exponents: Exponents
    period: float
    skip: int
    units: tuple[str, ...]
    motion: Motion
    findings: list[Findings]
    planes: list[tuple[str, str | None]]

    @property
    def trouble(self) -> str:
        """Reason why results are missing, or ""."""
        return self.motion.trouble if self.exponents.ok else self.exponents.status

    @property
    def dimension(self) -> float:
        """Lyapunov dimension of the section; NaN unless the exponents reach from a sum >= 0 to a sum < 0.

        j + (sum of the first j) / |exponent j + 1|, with the largest j whose sum is >= 0 (J. L. Kaplan and J. A. Yorke,
        Lecture Notes in Mathematics 730 (1979) 204).
        """
        sums = np.cumsum(self.exponents.spectrum)
        if len(sums) < 2 or not np.isfinite(sums).all() or sums[0] < 0.0 or sums[-1] >= 0.0:
            return float("nan")
        j = int(np.argmax(sums < 0.0))
        return float(j + sums[j - 1] / abs(self.exponents.spectrum[j]))


def study_of(flow: MechanismFlow, signals: list[str], options: argparse.Namespace) -> Study:
    """Study of a motion: exponents with a second run, and fine samples of further periods of the first run."""
    period = StroboscopicMap(flow).period
    shown = not options.quiet
    run_options = {"count": options.exponents, "confirm": not options.no_confirm, "progress": shown}
    exponents = lyapunov(flow, skip=options.skip, periods=options.keep, **run_options)
    planes_of_signals = planes(signals, flow.names)
    names = list(
        dict.fromkeys([*signals, *(name for plane in planes_of_signals for name in plane if name is not None)])
    )
    places = [flow.names.index(name) for name in names]
    series = options.series if exponents.ok else 0
    times, fine, trouble = continued_motion(flow, period, series, options.samples, shown=shown)
    units = tuple(flow.units[place] for place in places)
    motion = Motion(tuple(names), units, exponents.points[:, places], period, times, fine[:, places], trouble)
    estimates = {"dimension": options.dimension, "recurrent": options.recurrence}
    findings = [signal_findings(motion, name, **estimates) for name in signals]
    return Study(exponents, period, options.skip, flow.units, motion, findings, planes_of_signals)


def selected_signals(mechanism: Mechanism, flow: MechanismFlow, text: str | None) -> list[str]:
    """Names of the signals to be analysed, in `text` separated by commas.

    None: the position of the first journal with clearance, else the position of the slider along its guide, or the
    angle of the last body.
    """
    if text:
        places = [flow.number_of("flexmb chaos: --signals", name.strip()) for name in text.split(",")]
        return [flow.names[place] for place in dict.fromkeys(places)]
    journal = next((name for name in flow.names if name.endswith(".ex")), None)
    if journal is not None:
        return [journal, _beside(journal)]
    body = followed(mechanism)
    if body is None:
        return [flow.names[0]]
    guide = slides(mechanism, body)
    axis = "theta" if guide is None else "x" if abs(guide.along[0]) >= abs(guide.along[1]) else "y"
    return [flow.names[flow.number_of("flexmb chaos", f"{body.name}.{axis}")]]


def planes(names: Sequence[str], known: Sequence[str]) -> list[tuple[str, str | None]]:
    """Pairs (x, y) of the selected signals to be drawn; y is None for a signal without a partner."""
    pairs = {x: _beside(x) for x in known if _beside(x) in known}
    back = {y: x for x, y in pairs.items()}
    planes_found: dict[tuple[str, str | None], None] = {}
    for name in names:
        first = back.get(name, name)
        planes_found[first, pairs.get(first)] = None
    return list(planes_found)


def _beside(name: str) -> str:
    owner, _, last = name.rpartition(".")
    return f"{owner}.{BESIDE.get(last, '')}"


def continued_motion(flow: MechanismFlow, period: float, periods: int, samples: int, *, shown: bool) -> Continued:
    """Fine samples from the present state on: times (k,) [s], signals (k, m), reason of an early end or "".

    `period` is the time between two section points [s], with `samples` samples; the flow stays at the end.
    """
    if periods == 0 or not flow.ok:
        return np.zeros(0), np.zeros((0, len(flow.names))), ""
    begin, progress = flow.time, ProgressBar(f"{flow.name}, saved", float(periods), shown=shown, of="periods")
    times, rows, trouble = [begin], [flow.observe()], ""
    for number in range(1, periods * samples + 1):
        if not flow.advance(begin + number * period / samples - flow.time):
            trouble = flow.status
            break
        times.append(begin + number * period / samples)
        rows.append(flow.observe())
        if number % samples == 0:
            progress.update(1)
    progress.close()
    return np.array(times), np.array(rows), trouble


def signal_findings(motion: Motion, name: str, *, dimension: bool, recurrent: bool) -> Findings:
    """Estimates from one signal of a motion."""
    place = motion.names.index(name)
    unit, points, fine = motion.units[place], motion.points[:, place], motion.fine[:, place]
    label = name
    if goes_round(unit, np.concatenate([points, fine])):
        label, unit, points, fine = f"sin({name})", "", np.sin(points), np.sin(fine)
    zero_one = zero_one_test(points, thin=1) if len(points) >= LEAST else None
    if len(fine) == 0 or motion.trouble:
        return Findings(label, unit, zero_one, None, None, None, None)
    thin = max(1, round(motion.period / (motion.times[1] - motion.times[0]) / ENOUGH))
    times, thinned = motion.times[::thin], fine[::thin]
    return Findings(
        label,
        unit,
        zero_one,
        rosenstein(thinned, times),
        power_spectrum(fine, motion.times),
        correlation_dimension(thinned) if dimension else None,
        recurrence(thinned) if recurrent else None,
    )


def goes_round(unit: str, values: np.ndarray) -> bool:
    """Whether a signal (n,) is an angle with a range above 2 pi."""
    return unit == "rad" and len(values) > 0 and bool(np.ptp(values) > 2.0 * HALF)


def wrapped(unit: str, values: np.ndarray) -> np.ndarray:
    """Values (n,) of a signal; a rotating angle is reduced to -pi ... pi."""
    return (values + HALF) % (2.0 * HALF) - HALF if goes_round(unit, values) else values
