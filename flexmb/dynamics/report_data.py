"""Datasets of a report on a motion, by the groups of its file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flexmb.version import installed_version

if TYPE_CHECKING:
    from flexmb.dynamics.report import ChaosReport, SignalEstimates


def datasets(report: ChaosReport) -> dict[str, xr.Dataset]:
    """Datasets of a report by the name of their group, see `ChaosReport.groups`."""
    groups = {"": _root(report)}
    motion = report.motion
    if motion.times.size:
        columns = zip(motion.names, motion.units, motion.fine.T, strict=True)
        data = {name: ("time", column, {"units": units}) for name, units, column in columns}
        groups["motion"] = xr.Dataset(data, {"time": ("time", motion.times, {"units": "s"})})
    if report.signals:
        groups["series"] = _series(report.signals)
    if any(estimate.spectrum is not None for estimate in report.signals):
        having = [(f.name, f.spectrum) for f in report.signals if f.spectrum is not None]
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
    coords = {"period": ("period", number), "time": ("period", report.period * number, {"units": "s"})}
    coords["number"] = ("number", np.arange(1, len(exponents.spectrum) + 1))
    coords["history_time"] = ("history_time", exponents.time, {"units": "s"})
    attrs = {
        "name": exponents.name,
        "kind": "chaos",
        "ok": int(exponents.ok and not report.motion.trouble),
        "status": report.trouble or exponents.status,
        "period": report.period,
        "skip": report.skip,
        "lyapunov_dimension": report.dimension,
        "second_run": str(exponents.confirmed or exponents.unconfirmed),
        "flexmb": installed_version(),
    }
    if exponents.verdict is not None:
        attrs |= {"verdict": str(exponents.verdict), "reason": exponents.verdict.reason}
        attrs |= {f"evidence_{name}": value for name, value in exponents.verdict.evidence.items()}
    return xr.Dataset(data, coords, attrs)


def _series(estimates: Sequence[SignalEstimates]) -> xr.Dataset:
    """Estimates by signal, numbers and texts; NaN and "" for missing estimates."""
    rows = [_row(estimate) for estimate in estimates]
    data: dict[str, Any] = {}
    for name in dict.fromkeys(key for row in rows for key in row):
        values = [row.get(name) for row in rows]
        text = any(isinstance(value, str) for value in values)
        blank = "" if text else np.nan
        column = np.array([blank if v is None else v for v in values], dtype=object if text else np.float64)
        data[name] = ("signal", column)
    curves = [f.exponent for f in estimates if f.exponent is not None]
    if curves:
        longest = max(len(c.time) for c in curves)
        for name, which in (("divergence_time", "time"), ("divergence", "curve")):
            table = np.full((len(estimates), longest), np.nan)
            for row, f in zip(table, estimates, strict=True):
                curve = np.zeros(0) if f.exponent is None else vars(f.exponent)[which]
                row[: len(curve)] = curve
            data[name] = (("signal", "step"), table)
    return xr.Dataset(data, {"signal": ("signal", np.array([f.name for f in estimates], dtype=object))})


def _row(f: SignalEstimates) -> dict[str, float | str]:
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
