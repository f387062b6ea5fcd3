"""One case on its attractor: where it is once a period, its exponent, signals over long, and neighbours that part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.benettin import TrajectoryPair
from flexmb.dynamics.exponents.exponents import FEWEST, Exponents
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.exponents.renormalisation import lengths_of
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.paper.case import Case
from flexmb.paper.effort import Effort
from flexmb.paper.motion import StudyError
from flexmb.run.run import installed_version
from flexmb.sweeps.fingerprint import digest

if TYPE_CHECKING:
    import xarray as xr

SIGNALS = ("P1.ex", "P1.ey", "P1.vex", "P1.vey", "slider.x", "slider.vx")
OBSERVED = ("P1.ex", "P1.ey", "slider.x")
"""Signals through which the paper looks for an exponent."""

SHOWN = 4
"""Periods that are kept at every step, for curves in a plane."""

PAIR_EACH = 5
"""Periods of the series for each pair of neighbours that is followed."""

APART = 1e-9
"""Distance of two neighbours at the start [m], in the direction that grows most; far above round-off, far below what
counts."""

LOOKS = 200
"""Looks at a pair of neighbours in the period for which it is followed."""

WORK = {"rigid": (0.05, 0.13), "flexible": (0.8, 1.7)}
"""About the processor time of a period with impacts [s], without and with a tangent vector."""


@dataclass(frozen=True)
class Attractor:
    """The long motion of a case with play, which `Motion` shows for a few turns only.

    Parameters
    ----------
    case : the case, "rigid" or "flexible".
    settle : periods before the first point.
    points : periods with a point and the exponent, 50 at least.
    series : periods of evenly spaced signals after that.
    samples : of these, instants a period.

    Raises
    ------
    InputError : an ideal mechanism, whose drives prescribe its motion; numbers that are too small.
    """

    case: Case
    settle: int
    points: int
    series: int
    samples: int = 1000

    def __post_init__(self) -> None:
        if self.case.model == "ideal":
            text = f"Attractor of {self.case.name!r}: without play the drives prescribe the whole motion"
            raise InputError(f"{text}. Give a case whose model is 'rigid' or 'flexible'.")
        for name, least in (("settle", 0), ("points", FEWEST), ("series", PAIR_EACH), ("samples", 50)):
            checks.count("Attractor", name, getattr(self, name), least)

    @property
    def name(self) -> str:
        """Stem of the file of results."""
        return f"{self.case.name}-attractor" + ("" if self.samples == 1000 else f"-{self.samples}samples")

    @property
    def work(self) -> float:
        """About how much processor time it takes [s]."""
        plain, carrying = WORK[self.case.model]
        pairs = 2 * (self.series // PAIR_EACH)
        periods = plain * (self.settle + self.series + SHOWN + pairs) + carrying * self.points
        return periods * (self.case.elements / 4.0) ** 1.5

    def fingerprint(self) -> str:
        """A text that changes with everything the result depends on."""
        numbers = (self.settle, self.points, self.series, self.samples, SIGNALS, SHOWN, PAIR_EACH, APART, LOOKS)
        return digest(("attractor", self.case.mechanism(), *numbers, repr(self.case.steps()), installed_version()))

    def compute(self) -> xr.Dataset:
        """Compute one motion after the other, each from where the one before ended.

        Returns
        -------
        xarray.Dataset : over "point": `section.SIGNAL` once a period, whose attribute `resolution` says which
            differences may be errors of the integration.  `exponent` and `exponent_error`, the largest of the system
            [1/s], and over "history" how it converges: `history.time` [s], `history.exponent` [1/s].  Over
            "time", evenly spaced: the signals.  Over "step", every step of a few periods more: `step.time`,
            `step.SIGNAL`.  Over "pair" and "lag", from `pair.time` [s] on: distances of two neighbours, `apart.state`
            (in the weights of the flow [m]) and `apart.SIGNAL` of the observed signals, and logarithms `growth.state`,
            `growth.SIGNAL` of a difference that stays small; it goes on from pair to pair.  Attributes: `case`,
            `period`, `settle`; `verdict` and `reason` of the system, `verdict.SIGNAL` through each observed signal.

        Raises
        ------
        StudyError : a run that did not end well.
        """
        import xarray

        flow = MechanismFlow(self.case.mechanism(), step=self.case.steps(), period=self.case.period)
        places = [flow.names.index(name) for name in SIGNALS]
        units = {name: {"units": flow.units[place]} for name, place in zip(SIGNALS, places, strict=True)}
        found = lyapunov(flow, skip=self.settle, periods=self.points, confirm=False)
        if not found.ok:
            raise StudyError(f"{self.name}: the run with tangents did not end: {found.status}")
        columns = _of_section(found, places, units)
        columns |= _of_series(*self._series(flow, places), units, "time", "")
        columns |= _of_series(*self._steps(flow, places), units, "step", "step.")
        columns |= self._pairs(flow)
        about = {"case": self.case.name, "period": self.case.period, "settle": self.settle}
        return xarray.Dataset(columns, attrs=about | _judgements(found))

    def _series(self, flow: MechanismFlow, places: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        """Evenly spaced times (k,) [s] and signals (k, m)."""
        times = flow.time + np.arange(self.series * self.samples + 1) * (self.case.period / self.samples)
        rows = [flow.observe()[places]]
        for time in times[1:]:
            self._go(flow, time)
            rows.append(flow.observe()[places])
        return times, np.array(rows)

    def _steps(self, flow: MechanismFlow, places: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        """Times (k,) [s] and signals (k, m) at every step of the shown periods."""
        end = flow.time + SHOWN * self.case.period
        times, rows = [flow.time], [flow.observe()[places]]
        while flow.time < end - 1e-9 * self.case.period:
            if not flow.take_step(end):
                raise StudyError(f"{self.name}: the motion did not go on: {flow.status}")
            times.append(flow.time)
            rows.append(flow.observe()[places])
        return np.array(times), np.array(rows)

    def _pairs(self, flow: MechanismFlow) -> dict[str, Any]:
        """Distances of neighbours, each pair from another phase of the cranks, and how small differences grow."""
        pairs, T = self.series // PAIR_EACH, self.case.period
        linear = _Linear(flow, [flow.names.index(name) for name in OBSERVED])
        self._go(flow, flow.time + T / pairs, linear)  # it turns to the direction that grows most
        table, begins = np.empty((2, pairs, LOOKS + 1, 1 + len(OBSERVED))), np.empty(pairs)
        for number in range(pairs):
            pair = TrajectoryPair(flow, flow.copy(), flow.weights, APART)
            pair.renormalise(linear.W[:, 0])
            begins[number] = flow.time
            table[:, number, 0] = _distances(pair, linear.places), linear.logs()
            for look in range(1, LOOKS + 1):
                time = begins[number] + look * T / LOOKS
                self._go(pair.first, time, linear)
                self._go(pair.second, time)
                table[:, number, look] = _distances(pair, linear.places), linear.logs()
            self._go(flow, flow.time + T / pairs, linear)
        names, axes = ("state", *OBSERVED), ("pair", "lag")
        columns: dict[str, Any] = {"lag": ("lag", np.arange(LOOKS + 1) * T / LOOKS, {"units": "s"})}
        columns["pair.time"] = ("pair", begins, {"units": "s"})
        for k, name in enumerate(names):
            columns[f"apart.{name}"] = (axes, table[0, ..., k], {"units": "m"})
            columns[f"growth.{name}"] = (axes, table[1, ..., k], {"units": "1"})
        return columns

    def _go(self, flow: Any, time: float, linear: _Linear | None = None) -> None:
        """Up to a time, with a small difference or without."""
        if not flow.advance(time - flow.time, None if linear is None else linear.W):
            raise StudyError(f"{self.name}: the motion did not go on: {flow.status}")
        if linear is not None:
            linear.shorten()


class _Linear:
    """A difference that stays small, of which only the logarithm grows.

    Parameters
    ----------
    flow : the motion that it goes along with.
    places : of the signals whose differences are asked for.
    """

    def __init__(self, flow: MechanismFlow, places: Sequence[int]) -> None:
        self.flow, self.places, self.log = flow, places, 0.0
        self.W = flow.tangent_basis(1)

    def shorten(self) -> None:
        """Make it of length 1, and note by what it was longer."""
        length = float(lengths_of(self.W, self.flow.weights)[0])
        if not 0.0 < length < np.inf:
            raise StudyError(f"{self.flow.name}: a small difference became {length} at {self.flow.time:g} s")
        self.W /= length
        self.W[self.flow.records] = 0.0
        self.log += np.log(length)

    def logs(self) -> np.ndarray:
        """Logarithms of its length, and of what it does to each signal (m,)."""
        gaps = [abs(float(self.flow.slopes(place, self.W)[0])) for place in self.places]
        return self.log + np.log(np.maximum([1.0, *gaps], 1e-300))


def _distances(pair: TrajectoryPair, places: Sequence[int]) -> np.ndarray:
    """Distance of the states, and of each signal (m,) [m]."""
    gaps = np.abs(pair.second.observe()[places] - pair.first.observe()[places])
    return np.concatenate([[pair.length(pair.difference())], gaps])


def _of_section(found: Exponents, places: Sequence[int], units: dict[str, dict[str, str]]) -> dict[str, Any]:
    """Points once a period, and the exponent as it converges."""
    points = {}
    for name, place in zip(units, places, strict=True):
        noise = {} if found.signals.resolution is None else {"resolution": float(found.signals.resolution[place])}
        points[f"section.{name}"] = ("point", found.points[:, place], units[name] | noise)
    return points | {
        "history.time": ("history", found.time, {"units": "s"}),
        "history.exponent": ("history", found.history[:, 0], {"units": "1/s"}),
        "exponent": ((), found.value, {"units": "1/s"}),
        "exponent_error": ((), found.error, {"units": "1/s"}),
    }


def _of_series(
    times: np.ndarray, rows: np.ndarray, units: dict[str, dict[str, str]], axis: str, before: str
) -> dict[str, Any]:
    """Signals (k, m) over an axis, under their names with something before them."""
    columns = {f"{before}{name}": (axis, rows[:, k], units[name]) for k, name in enumerate(units)}
    return {f"{before}time": (axis, times, {"units": "s"})} | columns


def _judgements(found: Exponents) -> dict[str, str]:
    """The verdict on the system, and through each observed signal."""
    through = {f"verdict.{name}": str(found.seen_through(name)) for name in OBSERVED}
    return {"verdict": str(found.verdict), "reason": found.verdict.reason if found.verdict else ""} | through


def by_clearance(effort: Effort) -> tuple[Attractor, Attractor]:
    """The runs with 0.05 and 0.5 mm of play at 2 pi rad/s.

    Parameters
    ----------
    effort : how long they are; a quick look has two beam elements a link.
    """
    return _at(effort, 2.0, 0.05e-3), _at(effort, 2.0, 0.5e-3)


def by_speed(effort: Effort) -> tuple[Attractor, Attractor]:
    """The runs at 0.5 and 2.5 pi rad/s with 0.5 mm of play.

    Parameters
    ----------
    effort : how long they are; a quick look has two beam elements a link.
    """
    return _at(effort, 0.5, 0.5e-3), _at(effort, 2.5, 0.5e-3)


def _at(effort: Effort, speed: float, clearance: float) -> Attractor:
    elements = 2 if effort.name == "quick" else 4
    case = Case(model="flexible", speed=speed, clearance=clearance, elements=elements)
    return Attractor(case, effort.settle, effort.points, effort.series)
