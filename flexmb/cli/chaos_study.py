"""Study of a motion by `flexmb chaos`: exponents, verdict, estimates from its signals; its files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sections.maps import StroboscopicMap
from flexmb.dynamics.series.correlation import CorrelationDimension, Recurrence, correlation_dimension, recurrence
from flexmb.dynamics.series.exponent import SeriesExponent, rosenstein
from flexmb.dynamics.series.samples import PowerSpectrum, power_spectrum
from flexmb.dynamics.series.zero_one import ZeroOne, zero_one_test
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.model.mechanism import Mechanism
from flexmb.results.status import followed, slides
from flexmb.version import installed_version

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Study of a motion by `flexmb chaos`: exponents and verdict of the motion, and estimates from its signals

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


# Files of `flexmb chaos`: one netCDF file with groups, and pictures

HARMONICS = 25.0
"""Largest frequency of a drawn spectrum, over the frequency of the section."""

LEAST_SPREAD, ROOM = 1e-3, 0.1
"""Spread of a section, over the spread of the motion, below which it is not enlarged; margin of the picture."""

PORTRAIT = 20
"""Number of periods of a phase portrait."""


def datasets(study: Study) -> dict[str, xr.Dataset]:
    """Datasets of a study by the name of the group in the file.

    The root holds all signals once a period, exponents with errors (of the first run alone, and of both runs) and
    history, the exponents of the second run, and the verdict with its evidence.  "motion" holds the fine samples of the
    selected signals, "series" and "spectrum" the estimates from each signal.
    """
    groups = {"": _root(study)}
    if study.motion.times.size:
        groups["motion"] = _motion(study.motion)
    if study.findings:
        groups["series"] = _series(study.findings)
    if any(finding.spectrum is not None for finding in study.findings):
        groups["spectrum"] = _spectra(study.findings)
    return groups


def _root(study: Study) -> xr.Dataset:
    exponents, unit = study.exponents, {"units": study.exponents.units}
    number = study.skip + 1 + np.arange(len(exponents.points))
    data: dict[str, Any] = {
        name: ("period", column, {"units": units})
        for name, units, column in zip(exponents.names, study.units, exponents.points.T, strict=True)
    }
    data["exponent"] = ("number", exponents.spectrum, unit)
    data["exponent_error"] = ("number", exponents.errors, unit)
    data["exponent_statistical"] = ("number", exponents.statistical, unit)
    if exponents.confirmed is not None:
        data["exponent_second"] = ("number", exponents.confirmed.spectrum, unit)
        data["exponent_second_error"] = ("number", exponents.confirmed.errors, unit)
    data["exponent_history"] = (("history_time", "number"), exponents.history, unit)
    coords = {
        "period": ("period", number),
        "time": ("period", study.period * number, {"units": "s"}),
        "number": ("number", np.arange(1, len(exponents.spectrum) + 1)),
        "history_time": ("history_time", exponents.time, {"units": "s"}),
    }
    attrs = {
        "name": exponents.name,
        "kind": "chaos",
        "ok": int(exponents.ok and not study.motion.trouble),
        "status": study.trouble or exponents.status,
        "period": study.period,
        "skip": study.skip,
        "lyapunov_dimension": study.dimension,
        "second_run": str(exponents.confirmed or exponents.unconfirmed),
        "flexmb": installed_version(),
    }
    if exponents.verdict is not None:
        attrs |= {"verdict": str(exponents.verdict), "reason": exponents.verdict.reason}
        attrs |= {f"evidence_{name}": value for name, value in exponents.verdict.evidence.items()}
    return xr.Dataset(data, coords, attrs)


def _motion(motion: Motion) -> xr.Dataset:
    columns = zip(motion.names, motion.units, motion.fine.T, strict=True)
    data = {name: ("time", column, {"units": units}) for name, units, column in columns}
    return xr.Dataset(data, {"time": ("time", motion.times, {"units": "s"})})


def _series(findings: list[Findings]) -> xr.Dataset:
    """Estimates by signal, numbers and texts; NaN and "" for missing estimates."""
    rows = [_row(finding) for finding in findings]
    data: dict[str, Any] = {}
    for name in dict.fromkeys(key for row in rows for key in row):
        values = [row.get(name) for row in rows]
        text = any(isinstance(value, str) for value in values)
        blank = "" if text else np.nan
        column = np.array([blank if v is None else v for v in values], dtype=object if text else np.float64)
        data[name] = ("signal", column)
    curves = [f.exponent for f in findings if f.exponent is not None]
    if curves:
        longest = max(len(c.time) for c in curves)
        for name, which in (("divergence_time", "time"), ("divergence", "curve")):
            table = np.full((len(findings), longest), np.nan)
            for row, f in zip(table, findings, strict=True):
                curve = np.zeros(0) if f.exponent is None else vars(f.exponent)[which]
                row[: len(curve)] = curve
            data[name] = (("signal", "step"), table)
    return xr.Dataset(data, {"signal": ("signal", np.array([f.name for f in findings], dtype=object))})


def _row(f: Findings) -> dict[str, float | str]:
    row: dict[str, float | str] = {"units": f.unit}
    if f.zero_one is not None:
        row |= {"zero_one": f.zero_one.value, "zero_one_spread": f.zero_one.spread, "zero_one_kind": f.zero_one.kind}
    if f.exponent is not None:
        row |= {"rosenstein": f.exponent.value, "rosenstein_error": f.exponent.error}
        row["rosenstein_status"] = f.exponent.status
    if f.spectrum is not None:
        row |= {"line_share": f.spectrum.line_share, "spectrum_kind": f.spectrum.kind}
    if f.dimension is not None:
        row |= {"dimension": f.dimension.value, "dimension_error": f.dimension.error}
        row["dimension_status"] = f.dimension.status
    if f.recurrence is not None:
        names = ("rate", "determinism", "laminarity", "mean_diagonal", "longest_diagonal", "entropy", "trapping_time")
        row |= {f"recurrence_{name}": float(vars(f.recurrence)[name]) for name in (*names, "threshold")}
    return row


def _spectra(findings: list[Findings]) -> xr.Dataset:
    having = [(f.name, f.spectrum) for f in findings if f.spectrum is not None]
    most = max(len(spectrum.peaks) for _, spectrum in having)
    dims, peaks, power = (
        ("signal", "frequency"),
        np.full((len(having), most), np.nan),
        np.full((len(having), most), np.nan),
    )
    for k, (_, spectrum) in enumerate(having):
        peaks[k, : len(spectrum.peaks)], power[k, : len(spectrum.peaks)] = spectrum.peaks, spectrum.power
    data = {
        "density": (dims, np.stack([spectrum.density for _, spectrum in having])),
        "floor": (dims, np.stack([spectrum.floor for _, spectrum in having])),
        "line": (("signal", "rank"), peaks, {"units": "Hz"}),
        "line_power": (("signal", "rank"), power),
    }
    names = np.array([name for name, _ in having], dtype=object)
    return xr.Dataset(data, {"signal": names, "frequency": ("frequency", having[0][1].frequency, {"units": "Hz"})})


def pictures(study: Study, folder: Path) -> list[Path]:
    """Pictures of section, phase portrait, convergence of the exponents and spectra, as far as there are data."""
    from flexmb.show.pictures.diagrams import plot_exponents, plot_section  # noqa: PLC0415 - only when asked for
    from flexmb.show.pictures.signals import plot_spectrum  # noqa: PLC0415

    figures: dict[str, Figure] = {}
    number = study.skip + 1 + np.arange(len(study.motion.points))
    for x, y in study.planes if len(number) else []:
        title = f"{study.exponents.name}: once a period of {study.period:.4g} s"
        data = _columns(study.motion, study.motion.points, "period", number)
        section = plot_section(data, x, y, title=title)
        _widened(section, study.motion, x, y)
        figures["-".join(["section", x, *([y] if y else [])])] = section
        if y and len(study.motion.times):
            figures[f"phase-{x}-{y}"] = _portrait(study, x, y)
    if len(study.exponents.history) and np.isfinite(study.exponents.history).any():
        figures["exponents"] = plot_exponents(study.exponents)
    for f in study.findings:
        if f.spectrum is not None:
            figures[f"spectrum-{f.name.removeprefix('sin(').removesuffix(')')}"] = plot_spectrum(
                f.spectrum, signal=f.name, units=f.unit, up_to=HARMONICS / study.period
            )
    written = []
    for name, figure in figures.items():
        written.append(folder / f"{name}.png")
        figure.savefig(written[-1], dpi=150)
    return written


def _portrait(study: Study, x: str, y: str) -> Figure:
    """Phase portrait of the last periods of the motion."""
    from flexmb.show.pictures.diagrams import plot_phase  # noqa: PLC0415 - only when asked for

    motion = study.motion
    late = motion.times >= motion.times[-1] - PORTRAIT * study.period
    number = round((motion.times[late][-1] - motion.times[late][0]) / study.period)
    title = f"{study.exponents.name}: the last {number} periods"
    figure = plot_phase(_columns(motion, motion.fine[late], "time", motion.times[late]), x, y, title=title)
    if x.endswith(".ex"):  # the journal moves in a circle
        figure.axes[0].set_aspect("equal", adjustable="box")
    return figure


def _widened(figure: Figure, motion: Motion, x: str, y: str | None) -> None:
    """Widen the axes around the points of a cycle, so that round-off is not enlarged."""
    ax = figure.axes[0]
    for name, limits in ((x, ax.set_xlim), (y, ax.set_ylim)) if y else ((x, ax.set_ylim),):
        place = motion.names.index(str(name))
        unit, points, fine = motion.units[place], motion.points[:, place], motion.fine[:, place]
        points = wrapped(unit, points)
        size = float(np.ptp(fine)) if len(fine) else float(np.abs(points).max())
        if size > 0.0 and np.ptp(points) < LEAST_SPREAD * size:
            middle = 0.5 * float(points.min() + points.max())
            limits(middle - ROOM * size, middle + ROOM * size)


def _columns(motion: Motion, values: np.ndarray, axis: str, along: np.ndarray) -> xr.Dataset:
    """Signals along an axis for a picture; a curve breaks where an angle passes -pi or pi."""
    data = {}
    for name, unit, column in zip(motion.names, motion.units, values.T, strict=True):
        values_shown = wrapped(unit, column).copy()
        if axis == "time" and unit == "rad":
            values_shown[1:][np.abs(np.diff(values_shown)) > np.pi] = np.nan
        data[name] = (axis, values_shown, {"units": unit})
    return xr.Dataset(data, {axis: (axis, along)})
