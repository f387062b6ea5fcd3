"""Report on a motion: exponents, verdict and estimates from its signals, as a record, a table and datasets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.exponents import Exponents
from flexmb.dynamics.jobs.files import write_netcdf
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.lyapunov import lyapunov
from flexmb.dynamics.sections import StroboscopicMap
from flexmb.dynamics.series.embedding import CorrelationDimension, Recurrence, correlation_dimension, recurrence
from flexmb.dynamics.series.exponent import SeriesExponent, rosenstein
from flexmb.dynamics.series.samples import PowerSpectrum, ZeroOne, power_spectrum, zero_one_test
from flexmb.dynamics.systems.dynamics import as_dynamics
from flexmb.dynamics.verdict import MEANING, meaning_of
from flexmb.errors import InputError
from flexmb.fields import field, record, record_with
from flexmb.late import xr
from flexmb.version import installed_version

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.run.simulate import Step

FEWEST_PERIODS = 20  # smallest number of periods for estimates from a signal
# Smallest number of samples a period; with fewer, 20 periods are too few for a correlation dimension.
FEWEST_SAMPLES = 50
# Signal of the ordinate by signal of the abscissa: the journal in its plane, a position against its velocity.
BESIDE = {"ex": "ey", "x": "vx", "y": "vy", "theta": "omega"}
HALF = np.pi  # half a turn [rad]
ENOUGH = 100  # largest number of samples a period for estimates whose cost grows with their number
LEAST = 20  # smallest number of points of the 0-1 test


@record
class Motion:
    """Signals of the motion, once a period and finely sampled."""

    names: tuple[str, ...] = field("names (m,) of the signals")
    units: tuple[str, ...] = field("their units (m,)")
    points: np.ndarray = field("signals (n, m) once a period [units]")
    period: float = field("time between two points", "s")
    times: np.ndarray = field("times (k,) of the fine samples", "s")
    fine: np.ndarray = field("fine samples (k, m) [units]; k = 0 without fine samples")
    trouble: str = field('reason why the fine samples end early, or ""', default="")


@dataclass(frozen=True)
class SignalEstimates:
    """Estimates from one signal, or "sin(NAME)" of a rotating angle."""

    # The 0-1 test is that of the points, None for too few. The others come from fine samples, None where not selected.
    name: str
    unit: str
    zero_one: ZeroOne | None
    exponent: SeriesExponent | None = None
    spectrum: PowerSpectrum | None = None
    dimension: CorrelationDimension | None = None
    recurrence: Recurrence | None = None


@record_with(eq=False)
class ChaosReport:
    """Report on a motion: its text is a table of all results with errors, units and meanings."""

    exponents: Exponents = field("exponents, section points, verdict")
    period: float = field("time between two points", "s")
    skip: int = field("number of periods before the first point")
    motion: Motion = field("signals once a period and finely sampled")
    signals: tuple[SignalEstimates, ...] = field("estimates from each selected signal")
    planes: tuple[tuple[str, str | None], ...] = field("pairs of signals to be drawn; None: no partner")
    begin: float = field("time of the flow before the first period", "s", default=0.0)

    @property
    def ok(self) -> bool:
        """Whether the motion was computed to its end."""
        return not self.trouble

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

    @cached_property
    def groups(self) -> dict[str, xr.Dataset]:
        """Datasets by the name of their group in the file of `flexmb chaos`.

        The root "" holds all signals once a period, exponents with errors (of the first run alone, and of both runs)
        and history, the exponents of the second run, and the verdict with its evidence.  "motion" holds the fine
        samples of the selected signals, "series" and "spectrum" the estimates from each signal.
        """
        groups, motion = {"": _root(self)}, self.motion
        if motion.times.size:
            columns = zip(motion.names, motion.units, motion.fine.T, strict=True)
            data = {name: ("time", column, {"units": units}) for name, units, column in columns}
            groups["motion"] = xr.Dataset(data, {"time": ("time", motion.times, {"units": "s"})})
        if self.signals:
            groups["series"] = _series(self.signals)
        having = [(f.name, f.spectrum) for f in self.signals if f.spectrum is not None]
        if having:
            most = max(len(spectrum.peaks) for _, spectrum in having)
            dims, (peaks, power) = ("signal", "frequency"), np.full((2, len(having), most), np.nan)
            for k, (_, spectrum) in enumerate(having):
                peaks[k, : len(spectrum.peaks)], power[k, : len(spectrum.peaks)] = spectrum.peaks, spectrum.power
            density, floor = (np.stack([vars(spectrum)[one] for _, spectrum in having]) for one in ("density", "floor"))
            spectra: dict[str, Any] = {"density": (dims, density), "floor": (dims, floor)}
            spectra |= {"line": (("signal", "rank"), peaks, {"units": "Hz"}), "line_power": (("signal", "rank"), power)}
            names = np.array([name for name, _ in having], dtype=object)
            frequency = ("frequency", having[0][1].frequency, {"units": "Hz"})
            groups["spectrum"] = xr.Dataset(spectra, {"signal": names, "frequency": frequency})
        return groups

    @property
    def tree(self) -> xr.DataTree:
        """The groups as one tree."""
        return xr.DataTree.from_dict({name or "/": dataset for name, dataset in self.groups.items()})

    def to_netcdf(self, path: str | Path) -> Path:
        """Write the groups to the file `path`, whose folders are made, as `flexmb chaos` does; returns its path.

        Raises
        ------
        InputError : a path that cannot be written.
        """
        return write_netcdf(checks.path("ChaosReport.to_netcdf", path), self.groups)

    def text(self, option: str = "") -> str:
        """Table of all results; `option` stands before names of arguments in advice, "--" on the command line."""
        return "\n".join(_table(self, option))

    def __repr__(self) -> str:
        return self.text()


@dataclass(frozen=True)
class Plan:
    """Arguments of `report`, with the map of the flow over one period."""

    strobe: StroboscopicMap
    skip: int
    keep: int
    exponents: int
    signals: Sequence[str] | None
    series: int
    samples: int
    dimension: bool
    recurrence: bool
    confirm: bool

    def checked(self, label: str, option: str = "") -> Plan:
        """The plan with the names of the signals; arguments without a possible result are refused."""
        # `label` and `option` begin messages and the names of arguments in them.
        flow, most = self.strobe.flow, self.strobe.dimension
        if 0 < checks.count(label, f"{option}series", self.series, 0) < FEWEST_PERIODS:
            text = f"{label}: {option}series is {self.series}; estimates from signals need {FEWEST_PERIODS} periods"
            raise InputError(f"{text} at least, and 0 leaves them out.")
        if checks.count(label, f"{option}samples", self.samples) < FEWEST_SAMPLES:
            text = f"{label}: {option}samples is {self.samples}; it must be {FEWEST_SAMPLES} at least"
            raise InputError(f"{text}: with fewer samples impacts are missed.")
        if self.series == 0 and (self.dimension or self.recurrence):
            idle, sign = "dimension" if self.dimension else "recurrence", " " if option else "="
            text = f"{label}: {option}{idle} needs the motion between the points"
            raise InputError(f"{text}. Give {option}series{sign}{FEWEST_PERIODS}.")
        if most == 0:
            text = f"Mechanism {flow.name!r}: its drives prescribe the whole motion, so it has no neighbours and no"
            advice = "Give a joint clearance, let a link bend, or drive it by a force or torque."
            raise InputError(f"{text} exponents. {advice}")
        if checks.count(label, f"{option}exponents", self.exponents) > most:
            raise InputError(f"{label}: {option}exponents is {self.exponents}; {flow.name!r} has {most}.")
        places = [flow.number_of(f"{label}: {option}signals", name) for name in self.signals or ()]
        return replace(self, signals=tuple(flow.names[place] for place in dict.fromkeys(places)) or flow.main_signals)

    def report(self, *, progress: bool) -> ChaosReport:
        """Report by this plan: exponents with a second run, and fine samples of further periods of the first run."""
        flow, period, signals = self.strobe.flow, self.strobe.period, tuple(self.signals or ())
        more: dict[str, Any] = {"count": self.exponents, "confirm": self.confirm, "progress": progress}
        exponents = lyapunov(self.strobe, skip=self.skip, periods=self.keep, **more)
        pairs = planes(signals, flow.names)
        names = tuple(dict.fromkeys([*signals, *(name for plane in pairs for name in plane if name is not None)]))
        places = [flow.names.index(name) for name in names]
        times, rows, trouble = list[float](), list[np.ndarray](), ""
        if self.series and exponents.ok and flow.ok:
            bar = ProgressBar(f"{flow.name}, saved", float(self.series), shown=progress, of="periods")
            times, rows, begin = [flow.time], [flow.observe()], flow.time
            for number in range(1, self.series * self.samples + 1):
                if not flow.advance(begin + number * period / self.samples - flow.time):
                    trouble = flow.status
                    break
                times.append(begin + number * period / self.samples)
                rows.append(flow.observe())
                if number % self.samples == 0:
                    bar.update(1)
            bar.close()
        fine, units = np.array(rows).reshape(len(rows), len(flow.names)), tuple(flow.units[place] for place in places)
        motion = Motion(names, units, exponents.points[:, places], period, np.array(times), fine[:, places], trouble)
        found = tuple(self._estimates(motion, name) for name in signals)
        return ChaosReport(exponents, period, self.skip, motion, found, tuple(pairs), self.strobe.origin)

    def _estimates(self, motion: Motion, name: str) -> SignalEstimates:
        """Estimates from one signal of a motion."""
        place = motion.names.index(name)
        unit, points, fine = motion.units[place], motion.points[:, place], motion.fine[:, place]
        label = name
        if goes_round(unit, np.concatenate([points, fine])):
            label, unit, points, fine = f"sin({name})", "", np.sin(points), np.sin(fine)
        zero_one = zero_one_test(points, thin=1) if len(points) >= LEAST else None
        if len(fine) == 0 or motion.trouble:
            return SignalEstimates(label, unit, zero_one)
        thin = max(1, round(motion.period / (motion.times[1] - motion.times[0]) / ENOUGH))
        times, thinned = motion.times[::thin], fine[::thin]
        largest, spectrum = rosenstein(thinned, times), power_spectrum(fine, motion.times)
        dimension = correlation_dimension(thinned) if self.dimension else None
        found = recurrence(thinned) if self.recurrence else None
        return SignalEstimates(label, unit, zero_one, largest, spectrum, dimension, found)


@arguments.checked
def report(
    system: Any, *, skip: int = 20, keep: int = 200, exponents: int = 1, period: float | None = None,
    signals: Sequence[str] | None = None, series: int = 64, samples: int = 400, dimension: bool = False,
    recurrence: bool = False, confirm: bool = True, step: Step | None = None, method: Newmark | None = None,
    progress: bool = False,
) -> ChaosReport:  # fmt: skip
    """Report on one motion: exponents, section, verdict and estimates from its signals, as of `flexmb chaos`.

    Exponents and verdict come first (`lyapunov`).  Then the same motion goes on without tangent vectors, finely
    sampled: exponent by M. T. Rosenstein's method and power spectrum of each signal.  The 0-1 test takes the points.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow, which continues from its present
        state.
    skip : number of periods before the first point, for the transient.
    keep : number of points, one a period; 50 at least.
    exponents : number of exponents, the largest first.
    period : time between two points [s]; None: the common period of the drives.
    signals : names of the signals to be analysed; None: the position of the first journal with clearance, else of the
        slider along its guide, or the angle of the last body; of a differential equation the first entry of its state.
    series : number of finely sampled periods after the points, 20 at least; 0: none, and no estimates from them.
    samples : number of samples in each of these periods, 50 at least.
    dimension : whether the correlation dimension of each signal is estimated; it needs some 300 periods.
    recurrence : whether the recurrence of each signal is quantified.
    confirm : whether a second run confirms errors and verdict, see `lyapunov`.
    step, method : for a mechanism only, see `simulate`.
    progress : whether progress bars with the remaining time are shown.

    Returns
    -------
    ChaosReport : exponents with verdict [1/s], estimates by signal, and all datasets.  After a failure midway ok is
        False, and the record holds the results before the failure.

    Raises
    ------
    InputError : a map; a flow without a period; fewer periods or samples than the estimates need; an unknown signal;
        more exponents than the system has directions; see `lyapunov`.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    `plot_report` draws the pictures of `flexmb chaos`, `to_netcdf` writes its file, `flexmb.report` its page.

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> sprung = fm.chaos.ODE(lambda t, x: [x[1], np.sin(t) - x[0] - x[1]], [0.0, 0.0], period=2.0 * np.pi)
    >>> found = fm.chaos.report(sprung, keep=50, exponents=2, series=0, confirm=False)
    >>> found.exponents.verdict.kind, round(found.exponents.sum, 6)  # the sum is minus the damping
    ('periodic', -1.0)
    """
    flow: Any = as_dynamics("chaos.report", system, period=period, step=step, method=method)
    strobe = StroboscopicMap(flow, period if flow is system else None)
    asked = Plan(strobe, skip, keep, exponents, signals, series, samples, dimension, recurrence, confirm)
    return asked.checked(f"chaos.report {flow.name!r}").report(progress=progress)


def planes(names: Sequence[str], known: Sequence[str]) -> list[tuple[str, str | None]]:
    """Pairs (x, y) of the selected signals to be drawn; y is None for a signal without a partner."""
    pairs = {}
    for x in known:
        owner, dot, last = x.rpartition(".")
        if (beside := f"{owner}{dot}{BESIDE.get(last, '')}") in known:
            pairs[x] = beside
    back = {y: x for x, y in pairs.items()}
    firsts = dict.fromkeys(back.get(name, name) for name in names)
    return [(first, pairs.get(first)) for first in firsts]


def goes_round(unit: str, values: np.ndarray) -> bool:
    """Whether a signal (n,) is an angle with a range above 2 pi."""
    return unit == "rad" and len(values) > 0 and bool(np.ptp(values) > 2.0 * HALF)


def wrapped(unit: str, values: np.ndarray) -> np.ndarray:
    """Values (n,) of a signal; a rotating angle is reduced to -pi ... pi."""
    return (values + HALF) % (2.0 * HALF) - HALF if goes_round(unit, values) else values


# Meaning of the kinds of a power spectrum.
BROAD, EVEN = "chaotic or random", "the signal is constant"
SPECTRUM = {"lines": "periodic or nearly so", "mixed": "lines on a floor", "broad": BROAD, "constant": EVEN}

MORE_THAN = 2.0  # smallest dimension of a chaotic motion in time: curves on a surface cannot cross
ROUND_OFF = 1e-14  # magnitude below which a number is shown as 0
POINTS = 0.5  # dimension below which the set consists of separate points
LINES = 5  # largest number of listed lines of a spectrum


def _table(report: ChaosReport, option: str) -> Iterator[str]:
    """Lines of all results of a report; `option` stands before the names of arguments."""
    exponents, points = report.exponents, len(report.exponents.points)
    yield f"{exponents.name}: {exponents.verdict or 'no verdict'}"
    if exponents.verdict is not None:
        yield f"  {exponents.verdict.reason}"
    yield f"  {points} periods of {report.period:.6g} s, after {report.skip} skipped ones. {exponents.status}"
    yield ""
    second = exponents.confirmed
    origin = "of this run alone" if second is None else "with the difference of the second run"
    yield f"Lyapunov exponents, from the tangent of the steps; errors are one standard deviation, {origin}"
    pairs = [(float(value), float(error)) for value, error in zip(exponents.spectrum, exponents.errors, strict=True)]
    for k, (value, error) in enumerate(pairs):
        name = "largest exponent" if k == 0 else f"exponent {k + 1}"
        yield _line(name, value, error, exponents.units, meaning_of(value, error, report.period))
        if second is not None:
            yield _line("  this run alone", value, float(exponents.statistical[k]), exponents.units, "")
            steps = f"{second.fineness}, another start, {second.periods} periods"
            yield _line("  second run", float(second.spectrum[k]), float(second.errors[k]), exponents.units, steps)
    if len(pairs) > 1:
        text = "rate at which areas grow" if len(pairs) == 2 else "rate at which volumes of the first ones grow"
        yield _line(f"sum of these {len(pairs)}", exponents.sum, None, exponents.units, text)
    if np.isfinite(report.dimension):
        text = "of the section, from the exponents; the motion in time has 1 more"
        yield _line("Lyapunov dimension", report.dimension, None, "", text)
    if exponents.verdict is not None:
        evidence = exponents.verdict.evidence
        yield from ("", "evidence of the verdict")
        yield from (_line(name, evidence[name], None, "", MEANING[name]) for name in evidence if name in MEANING)
    for found in report.signals:
        yield from ("", f"signal {found.name}" + (f" [{found.unit}]" if found.unit else ""))
        yield from _signal(found, exponents, option)


def _line(name: str, value: float, error: float | None, unit: str, meaning: str) -> str:
    number = f"{value if abs(value) > ROUND_OFF else 0.0:.4g}" if np.isfinite(value) else "-"
    band = f"+- {error:.2g}" if error is not None and np.isfinite(error) else ""
    return f"  {name:<24s}{number:>11s} {band:<11s}{unit:<6s}{meaning}".rstrip()


def _signal(f: SignalEstimates, system: Exponents, option: str) -> Iterator[str]:
    """Lines of the estimates from a signal; without a value, the reason."""
    if f.zero_one is not None:
        text = f.zero_one.kind if f.zero_one.ok else f"no value: {f.zero_one.status} Give a larger {option}keep."
        yield _line("0-1 test", f.zero_one.value, f.zero_one.spread if f.zero_one.ok else None, "", text)
    if f.exponent is not None:
        if not f.exponent.ok:
            text = f"no value: {f.exponent.status}"
        elif not np.isfinite(system.error):
            text = ""
        elif abs(f.exponent.value - system.value) <= f.exponent.error + 2.0 * system.error:
            text = "agrees with that of the system within both errors"
        else:
            text = "differs from that of the system: trust the tangent vectors, a signal has finite distances only"
        yield _line("exponent (Rosenstein)", f.exponent.value, f.exponent.error, f.exponent.units, text)
    if f.spectrum is not None:
        strongest = ", ".join(f"{x:.4g}" for x in f.spectrum.peaks[:LINES])
        text = f"of the power in lines: {SPECTRUM[f.spectrum.kind]}"
        text += f"; strongest {strongest} Hz" if strongest else ""
        yield _line("power spectrum", 100.0 * f.spectrum.line_share, None, "%", text)
    if f.dimension is not None:
        value, error, text = f.dimension.value, f.dimension.error, "of the motion in time; the section has 1 less"
        if not f.dimension.ok:
            text = f"no value: {f.dimension.status} Give a larger {option}series."
        elif value < POINTS:
            text = "a few separate points: a cycle that is sampled in step with its period"
        elif str(system.verdict) == "chaotic" and value + error < MORE_THAN:  # contradicts chaos in time
            text = "too low: chaos in time has more than 2. The record shows few neighbours; give a larger"
            text += f" {option}series"
        yield _line("correlation dimension", value, error, "", text)
    if f.recurrence is not None:
        r = f.recurrence
        yield _line("recurrence: rate", r.rate, None, "", "fraction of the pairs of states that are near each other")
        yield _line("  determinism", r.determinism, None, "", "fraction of these that stay so for some samples")
        length = "most samples for which two states stay near each other; the whole record for a periodic motion"
        yield _line("  longest diagonal", r.longest_diagonal, None, "", length)


def _root(report: ChaosReport) -> xr.Dataset:
    exponents, unit = report.exponents, {"units": report.exponents.units}
    number = report.skip + 1 + np.arange(len(exponents.points))
    columns = zip(exponents.names, exponents.signals.units, exponents.points.T, strict=True)
    data: dict[str, Any] = {name: ("period", column, {"units": units}) for name, units, column in columns}
    data["exponent"] = ("number", exponents.spectrum, unit)
    data["exponent_error"] = ("number", exponents.errors, unit)
    data["exponent_statistical"] = ("number", exponents.statistical, unit)
    if exponents.confirmed is not None:
        data["exponent_second"] = ("number", exponents.confirmed.spectrum, unit)
        data["exponent_second_error"] = ("number", exponents.confirmed.errors, unit)
    data["exponent_history"] = (("history_time", "number"), exponents.history, unit)
    coords = {"period": ("period", number), "time": ("period", report.begin + report.period * number, {"units": "s"})}
    coords["number"] = ("number", np.arange(1, len(exponents.spectrum) + 1))
    coords["history_time"] = ("history_time", exponents.time, {"units": "s"})
    attrs = {
        "name": exponents.name, "kind": "chaos", "ok": int(exponents.ok and not report.motion.trouble),
        "status": report.trouble or exponents.status, "period": report.period, "skip": report.skip,
        "lyapunov_dimension": report.dimension, "second_run": str(exponents.confirmed or exponents.unconfirmed),
        "flexmb": installed_version(),
    }  # fmt: skip
    if exponents.verdict is not None:
        attrs |= {"verdict": str(exponents.verdict), "reason": exponents.verdict.reason}
        attrs |= {f"evidence_{name}": value for name, value in exponents.verdict.evidence.items()}
    return xr.Dataset(data, coords, attrs)


def _series(estimates: Sequence[SignalEstimates]) -> xr.Dataset:
    """Estimates by signal, numbers and texts; NaN and "" for missing estimates."""
    names = ("rate", "determinism", "laminarity", "mean_diagonal", "longest_diagonal", "entropy", "trapping_time")
    rows: list[dict[str, float | str]] = []
    for f in estimates:
        wanted: tuple[tuple[Any, dict[str, str]], ...] = (
            (f.zero_one, {"zero_one": "value", "zero_one_spread": "spread", "zero_one_kind": "kind"}),
            (f.exponent, {"rosenstein": "value", "rosenstein_error": "error", "rosenstein_status": "status"}),
            (f.spectrum, {"line_share": "line_share", "spectrum_kind": "kind"}),
            (f.dimension, {"dimension": "value", "dimension_error": "error", "dimension_status": "status"}),
            (f.recurrence, {f"recurrence_{name}": name for name in (*names, "threshold")}),
        )
        found = {key: vars(one)[own] for one, keys in wanted if one is not None for key, own in keys.items()}
        rows.append({"units": f.unit, **found})
    data: dict[str, Any] = {}
    for name in dict.fromkeys(key for row in rows for key in row):
        values = [row.get(name) for row in rows]
        text = any(isinstance(value, str) for value in values)
        filled = [("" if text else np.nan) if value is None else value for value in values]
        data[name] = ("signal", np.array(filled, dtype=object if text else np.float64))
    curves = [f.exponent for f in estimates if f.exponent is not None]
    if curves:
        longest = max(len(c.time) for c in curves)
        for name, which in (("divergence_time", "time"), ("divergence", "curve")):
            table = np.full((len(estimates), longest), np.nan)
            for line, f in zip(table, estimates, strict=True):
                curve = np.zeros(0) if f.exponent is None else vars(f.exponent)[which]
                line[: len(curve)] = curve
            data[name] = (("signal", "step"), table)
    return xr.Dataset(data, {"signal": ("signal", np.array([f.name for f in estimates], dtype=object))})
