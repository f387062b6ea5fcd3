"""Long runs of a case: section points, largest Lyapunov exponent, sampled signals, distances of neighbours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.case import Case
from nine_bar_study.run import StudyError, StudyRun

from flexmb import checks
from flexmb.dynamics.exponents import FEWEST, Exponents
from flexmb.dynamics.lyapunov import TrajectoryPair, lengths_of, lyapunov
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

SHOWN = 4
"""Periods saved at every step, for phase diagrams."""

PAIR_EACH = 5
"""Periods of the sampled signals per pair of neighbours."""

APART = 1e-9
"""Initial distance of two neighbours [m], in the direction of fastest growth; far above round-off, far below the size
of any set of section points."""

LOOKS = 200
"""Distances of a pair of neighbours per period."""

SAMPLES = 1000
"""Default number of samples per period."""

TANGENT = 2.0
"""Cost of a period with a tangent vector, relative to a period without."""


def growth(case: Case, settle: int, points: int) -> StudyRun:
    """Run of section points and the largest Lyapunov exponent.

    Parameters
    ----------
    case : case with clearance.
    settle : periods before the first section point.
    points : section points, one per period; the exponent is a mean over these periods.
    """
    work = case.cost * (settle + TANGENT * points)
    name = f"{case.name}-growth{settle}+{points}{case.accuracy}"
    return StudyRun(name, measure_growth, case, (("settle", settle), ("points", points)), work)


def attractor(case: Case, settle: int, points: int, series: int, samples: int = SAMPLES) -> StudyRun:
    """Run of section points, the largest Lyapunov exponent, sampled signals and distances of neighbours.

    Parameters
    ----------
    case : case of the model "rigid" or "flexible".
    settle : periods before the first section point.
    points : section points, one per period, >= 50; the exponent is a mean over these periods.
    series : periods of evenly spaced samples after the last section point.
    samples : samples per period.

    Raises
    ------
    InputError : a case of the model "ideal", whose drives prescribe the motion; a number that is too small.
    """
    if case.model == "ideal":
        text = f"Attractor of {case.name!r}: without clearance the drives prescribe the whole motion"
        raise InputError(f"{text}. Give a case whose model is 'rigid' or 'flexible'.")
    settings = {"settle": settle, "points": points, "series": series, "samples": samples}
    for (name, value), least in zip(settings.items(), (0, FEWEST, PAIR_EACH, 50), strict=True):
        checks.count("Attractor", name, value, least)
    name = f"{case.name}-attractor" + ("" if samples == SAMPLES else f"-{samples}samples")
    work = case.cost * (settle + series + SHOWN + 2 * (series // PAIR_EACH) + TANGENT * points)
    return StudyRun(name, measure_attractor, case, tuple(settings.items()), work)


def measure_growth(case: Case, *, settle: int, points: int) -> xr.Dataset:
    """Integrate the motion and a tangent vector.

    Returns
    -------
    xarray.Dataset : over "point": `section.SIGNAL`, section points of the observables and their velocities; attribute
        `resolution`: size of the errors of the integration.  `exponent` and `exponent_error` [1/s]: largest exponent
        of the system and its standard deviation; over "history": the running exponent `history.exponent` [1/s] at
        `history.time` [s].  Attributes: `case`, `period` [s], `settle`; `verdict` and `reason` of the system,
        `verdict.SIGNAL` of each observable.

    Raises
    ------
    StudyError : a run that did not end well.
    """
    import xarray

    flow = MechanismFlow(case.mechanism(), step=case.steps, period=case.period)
    found = _exponents(flow, case, settle, points)
    return xarray.Dataset(_of_section(found, _signals(case, flow)), attrs=_about(case, settle, found))


def measure_attractor(case: Case, *, settle: int, points: int, series: int, samples: int) -> xr.Dataset:
    """Compute section, series, phase curves and pairs of neighbours, each from the end of the part before.

    Returns
    -------
    xarray.Dataset : variables of `measure_growth`.  Over "time": evenly sampled signals.  Over "step", every step of
        the 4 periods after the series: `step.time`, `step.SIGNAL`.  Over "pair" and "lag", from `pair.time` [s] on:
        distances of two neighbours, `apart.state` (norm of the flow [m]) and `apart.SIGNAL` [m], and logarithms
        `growth.state`, `growth.SIGNAL` of the tangent vector, which is continued from pair to pair.

    Raises
    ------
    StudyError : a run that did not end well.
    """
    import xarray

    flow = MechanismFlow(case.mechanism(), step=case.steps, period=case.period)
    found, signals = _exponents(flow, case, settle, points), _signals(case, flow)
    columns = _of_section(found, signals)
    columns |= _of_series(*_sampled(flow, case, signals, series * samples, samples), signals, "time", "")
    columns |= _of_series(*_every_step(flow, case, signals), signals, "step", "step.")
    columns |= _pairs(flow, case, series // PAIR_EACH)
    return xarray.Dataset(columns, attrs=_about(case, settle, found))


Signals = dict[str, tuple[int, str]]
"""Index and unit of each signal of a flow, by name."""


def _signals(case: Case, flow: MechanismFlow) -> Signals:
    names = [name for seen in case.machine.observables for name in (seen.place, seen.rate)]
    places = {name: flow.names.index(name) for name in names}
    return {name: (place, flow.units[place]) for name, place in places.items()}


def _exponents(flow: MechanismFlow, case: Case, settle: int, points: int) -> Exponents:
    found = lyapunov(flow, skip=settle, periods=points, confirm=False)
    if not found.ok:
        raise StudyError(f"{case.name}: the run with tangents did not end: {found.status}")
    return found


def _about(case: Case, settle: int, found: Exponents) -> dict[str, Any]:
    """Attributes of the dataset: case, verdict on the system, verdict of each observable."""
    through = {f"verdict.{name}": str(found.seen_through(name)) for name in case.machine.places}
    judged = {"verdict": str(found.verdict), "reason": found.verdict.reason if found.verdict else ""}
    return {"case": case.name, "period": case.period, "settle": settle} | judged | through


def _of_section(found: Exponents, signals: Signals) -> dict[str, Any]:
    """Variables of section points and of the running exponent."""
    columns: dict[str, Any] = {}
    for name, (_, unit) in signals.items():
        place, noise = found.names.index(name), {}
        if found.signals.resolution is not None:
            noise["resolution"] = float(found.signals.resolution[place])
        columns[f"section.{name}"] = ("point", found.points[:, place], {"units": unit} | noise)
    return columns | {
        "history.time": ("history", found.time, {"units": "s"}),
        "history.exponent": ("history", found.history[:, 0], {"units": "1/s"}),
        "exponent": ((), found.value, {"units": "1/s"}),
        "exponent_error": ((), found.error, {"units": "1/s"}),
    }


def _of_series(times: np.ndarray, rows: np.ndarray, signals: Signals, axis: str, before: str) -> dict[str, Any]:
    """Variables of the signals (k, m) over an axis; `before` is the prefix of their names."""
    columns = {
        f"{before}{name}": (axis, rows[:, k], {"units": unit}) for k, (name, (_, unit)) in enumerate(signals.items())
    }
    return {f"{before}time": (axis, times, {"units": "s"})} | columns


def _observed(flow: MechanismFlow, signals: Signals) -> np.ndarray:
    return flow.observe()[[place for place, _ in signals.values()]]


def _sampled(
    flow: MechanismFlow, case: Case, signals: Signals, count: int, samples: int
) -> tuple[np.ndarray, np.ndarray]:
    """Evenly spaced times (count + 1,) [s] and signals (count + 1, m)."""
    times = flow.time + np.arange(count + 1) * (case.period / samples)
    rows = [_observed(flow, signals)]
    for time in times[1:]:
        _go(flow, time, case)
        rows.append(_observed(flow, signals))
    return times, np.array(rows)


def _every_step(flow: MechanismFlow, case: Case, signals: Signals) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) [s] and signals (k, m) at every step of `SHOWN` periods."""
    end = flow.time + SHOWN * case.period
    times, rows = [flow.time], [_observed(flow, signals)]
    while flow.time < end - 1e-9 * case.period:
        if not flow.take_step(end):
            raise StudyError(f"{case.name}: the motion did not go on: {flow.status}")
        times.append(flow.time)
        rows.append(_observed(flow, signals))
    return np.array(times), np.array(rows)


def _pairs(flow: MechanismFlow, case: Case, pairs: int) -> dict[str, Any]:
    """Variables of distances of neighbours and of growth of the tangent vector; each pair starts at another phase."""
    period, places = case.period, case.machine.places
    linear = _Linear(flow, [flow.names.index(name) for name in places])
    _go(flow, flow.time + period / pairs, case, linear)  # the tangent vector turns to the direction of fastest growth
    table, begins = np.empty((2, pairs, LOOKS + 1, 1 + len(places))), np.empty(pairs)
    for number in range(pairs):
        pair = TrajectoryPair(flow, APART, linear.W[:, 0])
        begins[number] = flow.time
        table[:, number, 0] = _distances(pair, linear.places), linear.logs()
        for look in range(1, LOOKS + 1):
            time = begins[number] + look * period / LOOKS
            _go(pair.first, time, case, linear)
            _go(pair.second, time, case)
            table[:, number, look] = _distances(pair, linear.places), linear.logs()
        _go(flow, flow.time + period / pairs, case, linear)
    columns: dict[str, Any] = {"lag": ("lag", np.arange(LOOKS + 1) * period / LOOKS, {"units": "s"})}
    columns["pair.time"] = ("pair", begins, {"units": "s"})
    for k, name in enumerate(("state", *places)):
        columns[f"apart.{name}"] = (("pair", "lag"), table[0, ..., k], {"units": "m"})
        columns[f"growth.{name}"] = (("pair", "lag"), table[1, ..., k], {"units": "1"})
    return columns


def _go(flow: Any, time: float, case: Case, linear: _Linear | None = None) -> None:
    """Advance a flow to a time [s], with its tangent vector if given."""
    if not flow.advance(time - flow.time, None if linear is None else linear.W):
        raise StudyError(f"{case.name}: the motion did not go on: {flow.status}")
    if linear is not None:
        linear.shorten()


class _Linear:
    """Tangent vector of a flow with the logarithm of its growth.

    Parameters
    ----------
    flow : flow that carries the tangent vector.
    places : indices of the observed signals.
    """

    def __init__(self, flow: MechanismFlow, places: Sequence[int]) -> None:
        self.flow, self.places, self.log = flow, places, 0.0
        self.W = flow.tangent_basis(1)

    def shorten(self) -> None:
        """Normalise the tangent vector and add the logarithm of its length to `log`."""
        length = float(lengths_of(self.W, self.flow.weights)[0])
        if not 0.0 < length < np.inf:
            raise StudyError(f"{self.flow.name}: a small difference became {length} at {self.flow.time:g} s")
        self.W /= length
        self.W[self.flow.records] = 0.0
        self.log += np.log(length)

    def logs(self) -> np.ndarray:
        """Logarithms of the length of the tangent vector and of the differences of the signals (1 + m,)."""
        gaps = [abs(float(self.flow.slopes(place, self.W)[0])) for place in self.places]
        return self.log + np.log(np.maximum([1.0, *gaps], 1e-300))


def _distances(pair: TrajectoryPair, places: Sequence[int]) -> np.ndarray:
    """Distances of the states and of the signals (1 + m,) [m]."""
    gaps = np.abs(pair.second.observe()[places] - pair.first.observe()[places])
    return np.concatenate([[pair.length(pair.second.state() - pair.first.state())], gaps])
