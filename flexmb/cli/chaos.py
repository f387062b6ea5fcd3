"""`flexmb chaos`: exponents, section and verdict of a motion, printed as a table and written to files."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from flexmb import checks
from flexmb.cli.chaos_study import Findings, Study, selected_signals, study_of
from flexmb.cli.run import flow_options, periods_of, require_folder, require_packages
from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.dynamics.jobs.files import write_netcdf
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.dynamics.verdict import MEANING, meaning_of
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.show.reports.chaos_page import write_chaos

OWNER = "flexmb chaos"
STEM = "chaos"

FEWEST_PERIODS = 20
"""Smallest number of periods for estimates from a signal."""

FEWEST_SAMPLES = 50
"""Smallest number of samples a period; with fewer, 20 periods are too few for a correlation dimension."""

SPECTRUM = {
    "lines": "periodic or nearly so",
    "mixed": "lines on a floor",
    "broad": "chaotic or random",
    "constant": "the signal is constant",
}
"""Meaning of the kinds of a power spectrum."""

MORE_THAN = 2.0
"""Smallest dimension of a chaotic motion in time: curves on a surface cannot cross."""

ROUND_OFF = 1e-14
"""Magnitude below which a number is shown as 0."""

HALF = 0.5
"""Dimension below which the set consists of separate points."""

LINES = 5
"""Largest number of listed lines of a spectrum."""


def chaos(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """`flexmb chaos`: exponents, verdict and estimates from signals, written to files and printed.

    The folder has the short name; options are those of the groups "chaos", "method" and "files".  Returns 0 if the
    motion was computed to its end, else 1.
    """
    from flexmb.cli import chaos_study as chaos_files  # noqa: PLC0415 - imports xarray

    folder = Path(options.out or Path("out") / name)
    pictures = {} if options.no_plots else {"matplotlib": ("pictures", " or leave them out with --no-plots")}
    require_packages({"h5netcdf": ("results", ""), **pictures})
    _check(mechanism, options)
    flow = MechanismFlow(mechanism, **flow_options(options))
    _check_directions(flow, options.exponents)
    signals = selected_signals(mechanism, flow, options.signals)
    require_folder(folder)
    study = study_of(flow, signals, options)
    groups = chaos_files.datasets(study)
    written = [write_netcdf(folder / f"{STEM}.nc", groups)]
    if not options.no_plots:
        written += chaos_files.pictures(study, folder)
    if not options.no_report and len(study.exponents.points):
        written.append(write_chaos(groups, folder / f"{STEM}.html", None, None))
    print(table(study))
    print("\nwritten:", *(f"  {path}" for path in written), sep="\n")
    if study.trouble:
        print(f"flexmb: {study.trouble}", file=sys.stderr)
    return 1 if study.trouble else 0


def _check(mechanism: Mechanism, options: argparse.Namespace) -> None:
    """Refuse options without a possible result, before the long run."""
    if options.period is None and not periods_of(mechanism):
        text = f"Mechanism {mechanism.name!r} has no periodic drive, so the period of the section is unknown"
        raise InputError(f"{text}. Give the period of the drive, or about that of the motion: --period 1s.")
    series = checks.count(OWNER, "--series", options.series, 0)
    if 0 < series < FEWEST_PERIODS:
        text = f"{OWNER}: --series is {series}; estimates from signals need {FEWEST_PERIODS} periods at least"
        raise InputError(f"{text}, and 0 leaves them out.")
    if checks.count(OWNER, "--samples", options.samples) < FEWEST_SAMPLES:
        text = f"{OWNER}: --samples is {options.samples}; it must be {FEWEST_SAMPLES} at least"
        raise InputError(f"{text}: with fewer samples impacts are missed.")
    if series == 0 and (options.dimension or options.recurrence):
        asked = "--dimension" if options.dimension else "--recurrence"
        raise InputError(f"{OWNER}: {asked} needs the motion between the points. Give --series {FEWEST_PERIODS}.")


def _check_directions(flow: MechanismFlow, exponents: int) -> None:
    """Refuse more exponents than independent directions."""
    most = flow.dimension
    if most == 0:
        text = (
            f"Mechanism {flow.name!r}: its drives prescribe the whole motion, so it has no neighbours and no exponents"
        )
        raise InputError(f"{text}. Give a joint clearance, let a link bend, or drive it by a force or torque.")
    if checks.count(OWNER, "--exponents", exponents) > most:
        raise InputError(f"{OWNER}: --exponents is {exponents}; {flow.name!r} has {most}.")


def table(study: Study) -> str:
    """Table of all results of a study, with errors, units and meanings."""
    exponents, points = study.exponents, len(study.exponents.points)
    lines = [f"{exponents.name}: {exponents.verdict or 'no verdict'}"]
    lines += [f"  {exponents.verdict.reason}"] if exponents.verdict is not None else []
    lines += [
        f"  {points} periods of {study.period:.6g} s, after {study.skip} skipped ones. {exponents.status}",
        "",
        *_exponents(exponents, study.period),
    ]
    if np.isfinite(study.dimension):
        text = "of the section, from the exponents; the motion in time has 1 more"
        lines.append(_line("Lyapunov dimension", study.dimension, None, "", text))
    if exponents.verdict is not None:
        lines += ["", "evidence of the verdict", *_evidence(exponents)]
    for finding in study.findings:
        lines += [
            "",
            f"signal {finding.name}" + (f" [{finding.unit}]" if finding.unit else ""),
            *_signal(finding, exponents),
        ]
    return "\n".join(lines)


def _line(name: str, value: float, error: float | None, unit: str, meaning: str) -> str:
    number = f"{value if abs(value) > ROUND_OFF else 0.0:.4g}" if np.isfinite(value) else "-"
    band = f"+- {error:.2g}" if error is not None and np.isfinite(error) else ""
    return f"  {name:<24s}{number:>11s} {band:<11s}{unit:<6s}{meaning}".rstrip()


def _exponents(exponents: Exponents, period: float) -> Iterator[str]:
    """Lines of the exponents with their errors, and of both runs if there was a second run."""
    second = exponents.confirmed
    origin = "of this run alone" if second is None else "with the difference of the second run"
    yield f"Lyapunov exponents, from the tangent of the steps; errors are one standard deviation, {origin}"
    pairs = list(zip(exponents.spectrum, exponents.errors, strict=True))
    for k, (value, error) in enumerate(pairs):
        name = "largest exponent" if k == 0 else f"exponent {k + 1}"
        yield _line(name, float(value), float(error), exponents.units, meaning_of(float(value), float(error), period))
        if second is not None:
            yield _line("  this run alone", float(value), float(exponents.statistical[k]), exponents.units, "")
            steps = f"{second.fineness}, another start, {second.periods} periods"
            yield _line("  second run", float(second.spectrum[k]), float(second.errors[k]), exponents.units, steps)
    if len(pairs) > 1:
        text = "rate at which areas grow" if len(pairs) == 2 else "rate at which volumes of the first ones grow"
        yield _line(f"sum of these {len(pairs)}", exponents.sum, None, exponents.units, text)


def _evidence(exponents: Exponents) -> Iterator[str]:
    verdict = exponents.verdict
    for name, value in ({} if verdict is None else verdict.evidence).items():
        if name in MEANING:
            yield _line(name, value, None, "", MEANING[name])


def _signal(f: Findings, system: Exponents) -> Iterator[str]:
    """Lines of the estimates from a signal; without a value, the reason."""
    if f.zero_one is not None:
        text = f.zero_one.kind if f.zero_one.ok else f"no value: {f.zero_one.status} Give a larger --keep."
        yield _line("0-1 test", f.zero_one.value, f.zero_one.spread if f.zero_one.ok else None, "", text)
    if f.exponent is not None:
        text = _compared(f, system) if f.exponent.ok else f"no value: {f.exponent.status}"
        yield _line("exponent (Rosenstein)", f.exponent.value, f.exponent.error, f.exponent.units, text)
    if f.spectrum is not None:
        strongest = ", ".join(f"{x:.4g}" for x in f.spectrum.peaks[:LINES])
        text = f"of the power in lines: {SPECTRUM[f.spectrum.kind]}" + (
            f"; strongest {strongest} Hz" if strongest else ""
        )
        yield _line("power spectrum", 100.0 * f.spectrum.line_share, None, "%", text)
    if f.dimension is not None:
        yield _line("correlation dimension", f.dimension.value, f.dimension.error, "", _about_dimension(f, system))
    if f.recurrence is not None:
        r = f.recurrence
        yield _line("recurrence: rate", r.rate, None, "", "fraction of the pairs of states that are near each other")
        yield _line("  determinism", r.determinism, None, "", "fraction of these that stay so for some samples")
        length = "most samples for which two states stay near each other; the whole record for a periodic motion"
        yield _line("  longest diagonal", r.longest_diagonal, None, "", length)


def _about_dimension(f: Findings, system: Exponents) -> str:
    """Meaning of a correlation dimension; a dimension below 2 contradicts chaos in time."""
    dimension = f.dimension
    if dimension is None or not dimension.ok:
        return "" if dimension is None else f"no value: {dimension.status} Give a larger --series."
    if dimension.value < HALF:
        return "a few separate points: a cycle that is sampled in step with its period"
    if str(system.verdict) == "chaotic" and dimension.value + dimension.error < MORE_THAN:
        return "too low: chaos in time has more than 2. The record shows few neighbours; give a larger --series"
    return "of the motion in time; the section has 1 less"


def _compared(f: Findings, system: Exponents) -> str:
    """Comparison of the exponent of a signal with that of the system."""
    if f.exponent is None or not np.isfinite(system.error):
        return ""
    difference = abs(f.exponent.value - system.value)
    if difference <= f.exponent.error + 2.0 * system.error:
        return "agrees with that of the system within both errors"
    return "differs from that of the system: trust the tangent vectors, a signal has finite distances only"
