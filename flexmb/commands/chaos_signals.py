"""Signals of `flexmb chaos`: which are looked at, what is drawn over what, and what their samples say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb.commands.summary import followed, slides
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.jobs.progress import ProgressBar
from flexmb.model.mechanism import Mechanism
from flexmb.series.correlation import CorrelationDimension, correlation_dimension
from flexmb.series.exponent import SeriesExponent
from flexmb.series.recurrence import Recurrence, recurrence
from flexmb.series.rosenstein import rosenstein
from flexmb.series.spectrum import PowerSpectrum, power_spectrum
from flexmb.series.zero_one import ZeroOne, zero_one_test

BESIDE = {"ex": "ey", "x": "vx", "y": "vy", "theta": "omega"}
"""Over what a signal is drawn: the journal in its plane, a position against its velocity."""

HALF = np.pi

ENOUGH = 100
"""Samples a period for estimates whose cost grows with their number; more of them tell no more."""

LEAST = 20
"""Points that the 0-1 test takes at least."""


@dataclass(frozen=True)
class Motion:
    """Signals of the motion, once a period and finely.

    Parameters
    ----------
    names, units : of the signals (m,).
    points : (n, m) once a period [units].
    period : from point to point [s].
    times : (k,) of the fine samples [s].
    fine : (k, m) samples between which the motion is smooth [units]; none where it was not asked for.
    trouble : why the fine samples end early, or "".
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    points: np.ndarray
    period: float
    times: np.ndarray
    fine: np.ndarray
    trouble: str = ""


@dataclass(frozen=True)
class Findings:
    """What one signal says.

    Parameters
    ----------
    name : the signal, or "sin(NAME)" of an angle that goes all the way round.
    unit : its unit.
    zero_one : the 0-1 test of its points once a period; None: too few of them.
    exponent, spectrum : of the fine samples; None without these.
    dimension, recurrence : of the fine samples; None where not asked for.
    """

    name: str
    unit: str
    zero_one: ZeroOne | None
    exponent: SeriesExponent | None
    spectrum: PowerSpectrum | None
    dimension: CorrelationDimension | None
    recurrence: Recurrence | None


def chosen(mechanism: Mechanism, flow: MechanismFlow, text: str | None) -> list[str]:
    """The signals that are looked at, by the names that the flow has for them.

    Parameters
    ----------
    mechanism : the mechanism.
    flow : its motion.
    text : names with commas between them; None: the place of the first journal with play in its bearing, else the
        position of the slider along its guide, or the angle of the last body.

    Raises
    ------
    InputError : an unknown name.
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
    """What is drawn over what, from the chosen names: (x, y), y is None for a signal that has no partner.

    Parameters
    ----------
    names : the signals that were chosen.
    known : all signals.
    """
    pairs = {x: _beside(x) for x in known if _beside(x) in known}
    back = {y: x for x, y in pairs.items()}
    found: dict[tuple[str, str | None], None] = {}
    for name in names:
        first = back.get(name, name)
        found[first, pairs.get(first)] = None
    return list(found)


def _beside(name: str) -> str:
    owner, _, last = name.rpartition(".")
    return f"{owner}.{BESIDE.get(last, '')}"


def goes_on(flow: MechanismFlow, period: float, periods: int, samples: int, *, shown: bool) -> tuple:
    """The motion from where the flow stands: times (k,) [s], all signals (k, m), why it ended early or "".

    It is the motion whose exponent was found, not a second one: the transient is over, and nothing is computed twice.

    Parameters
    ----------
    flow : the flow; it is left at the end.
    period : of the section [s].
    periods : how long.
    samples : instants a period.
    shown : whether a bar is shown.
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


def looked_at(motion: Motion, name: str, *, dimension: bool, recurrent: bool) -> Findings:
    """What one signal of a motion says.

    Parameters
    ----------
    motion : the motion.
    name : the signal.
    dimension, recurrent : whether the correlation dimension and recurrences are asked for.
    """
    place = motion.names.index(name)
    unit, points, fine = motion.units[place], motion.points[:, place], motion.fine[:, place]
    label = name
    if goes_round(unit, np.concatenate([points, fine])):
        label, unit, points, fine = f"sin({name})", "", np.sin(points), np.sin(fine)
    walk = zero_one_test(points, thin=1) if len(points) >= LEAST else None
    if len(fine) == 0 or motion.trouble:
        return Findings(label, unit, walk, None, None, None, None)
    thin = max(1, round(motion.period / (motion.times[1] - motion.times[0]) / ENOUGH))
    times, some = motion.times[::thin], fine[::thin]
    return Findings(
        label,
        unit,
        walk,
        rosenstein(some, times),
        power_spectrum(fine, motion.times),
        correlation_dimension(some) if dimension else None,
        recurrence(some) if recurrent else None,
    )


def goes_round(unit: str, values: np.ndarray) -> bool:
    """Whether a signal is an angle that goes all the way round, so that only its direction returns."""
    return unit == "rad" and len(values) > 0 and bool(np.ptp(values) > 2.0 * HALF)


def wrapped(unit: str, values: np.ndarray) -> np.ndarray:
    """The values (n,) as they are, or an angle that goes round in -pi ... pi."""
    return (values + HALF) % (2.0 * HALF) - HALF if goes_round(unit, values) else values
