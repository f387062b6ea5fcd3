"""One case on its attractor: where it is once a period, its exponent, signals over long, and neighbours that part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.analysis.exponents import FEWEST, Exponents
from flexmb.analysis.lyapunov import Pair, lyapunov
from flexmb.analysis.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.integrate.run import installed_version
from flexmb.paper.case import Case
from flexmb.paper.motion import StudyError
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

APART = 1e-10
"""Distance of two neighbours at the start [m]; far above what one step's round-off does, far below what counts."""

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
        return digest(("attractor", self.case.mechanism(), *numbers, installed_version()))

    def compute(self) -> xr.Dataset:
        """Compute one motion after the other, each from where the one before ended.

        Returns
        -------
        xarray.Dataset : over "point": `section.SIGNAL` once a period.  `exponent` and `exponent_error`, the largest of
            the system [1/s], and over "history" how it converges: `history.time` [s], `history.exponent` [1/s].  Over
            "time", evenly spaced: the signals.  Over "step", every step of a few periods more: `step.time`,
            `step.SIGNAL`.  Over "pair" and "lag": distances of two neighbours, `apart.state` (in the weights of the
            flow [m]) and `apart.SIGNAL` of the observed signals.  Attributes: `case`, `period`, `settle`; `verdict` and
            `reason` of the system, `verdict.SIGNAL` through each observed signal.

        Raises
        ------
        StudyError : a run that did not end well.
        """
        import xarray

        flow = MechanismFlow(self.case.mechanism())
        places = [flow.names.index(name) for name in SIGNALS]
        units = {name: {"units": flow.units[place]} for name, place in zip(SIGNALS, places, strict=True)}
        found = lyapunov(flow, skip=self.settle, periods=self.points)
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
        """Distances of neighbours, each pair from another phase of the cranks."""
        places, pairs, T = [flow.names.index(name) for name in OBSERVED], self.series // PAIR_EACH, self.case.period
        table = np.empty((pairs, LOOKS + 1, 1 + len(OBSERVED)))
        for number in range(pairs):
            pair = Pair.beside(flow, APART, number)
            begin = flow.time
            table[number, 0] = _distances(pair, places)
            for look in range(1, LOOKS + 1):
                for system in (pair.first, pair.second):
                    self._go(system, begin + look * T / LOOKS)
                table[number, look] = _distances(pair, places)
            self._go(flow, begin + T + T / pairs)
        names = ("state", *OBSERVED)
        columns = {f"apart.{name}": (("pair", "lag"), table[..., k], {"units": "m"}) for k, name in enumerate(names)}
        return {"lag": ("lag", np.arange(LOOKS + 1) * T / LOOKS, {"units": "s"})} | columns

    def _go(self, flow: Any, time: float) -> None:
        if not flow.advance(time - flow.time):
            raise StudyError(f"{self.name}: the motion did not go on: {flow.status}")


def _distances(pair: Pair, places: Sequence[int]) -> np.ndarray:
    """Distance of the states, and of each signal (m,) [m]."""
    gaps = np.abs(pair.second.observe()[places] - pair.first.observe()[places])
    return np.concatenate([[pair.length(pair.apart())], gaps])


def _of_section(found: Exponents, places: Sequence[int], units: dict[str, dict[str, str]]) -> dict[str, Any]:
    """Points once a period, and the exponent as it converges."""
    points = {
        f"section.{name}": ("point", found.points[:, place], units[name])
        for name, place in zip(units, places, strict=True)
    }
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
