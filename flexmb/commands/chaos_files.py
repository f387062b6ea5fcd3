"""Files of `flexmb chaos`: one netCDF file with groups, and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flexmb.commands.chaos_study import Findings, Motion, Study, wrapped
from flexmb.version import installed_version

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    from flexmb.pictures.curves.portrait import plot_exponents, plot_section  # noqa: PLC0415 - only when asked for
    from flexmb.pictures.curves.spectrum import plot_spectrum  # noqa: PLC0415

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
    from flexmb.pictures.curves.portrait import plot_phase  # noqa: PLC0415 - only when asked for

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
