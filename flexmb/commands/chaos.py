"""`flexmb chaos`: is the motion of a mechanism periodic or chaotic, how sure is that, and what does it look like."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexmb import checks
from flexmb.commands.chaos_signals import Findings, Motion, chosen, goes_on, looked_at, planes
from flexmb.commands.files import require_folder, require_packages
from flexmb.commands.run import flow_options, periods_of
from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.jobs.files import write_netcdf
from flexmb.model.mechanism import Mechanism

OWNER = "flexmb chaos"
STEM = "chaos"

FEWEST_PERIODS = 20
"""Periods below which no estimate from a signal has a value."""

FEWEST_SAMPLES = 50
"""Samples a period below which 20 periods are too few for a correlation dimension."""


@dataclass(frozen=True)
class Study:
    """All that was found about a motion.

    Parameters
    ----------
    exponents : exponents, points once a period, verdict.
    period : time from one point to the next [s].
    skip : periods before the first point.
    units : of all signals, those of `exponents.names`.
    motion : signals once a period and finely.
    findings : what each chosen signal says.
    planes : what is drawn over what.
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
        """Why it is not all there, or ""."""
        return self.motion.trouble if self.exponents.ok else self.exponents.status

    @property
    def dimension(self) -> float:
        """Lyapunov dimension of the section; NaN unless the exponents reach from a sum >= 0 to one below 0.

        j + (sum of the first j) / |exponent j + 1|, j the most that add up to >= 0 (J. L. Kaplan and J. A. Yorke,
        Lecture Notes in Mathematics 730 (1979) 204).
        """
        sums = np.cumsum(self.exponents.spectrum)
        if len(sums) < 2 or not np.isfinite(sums).all() or sums[0] < 0.0 or sums[-1] >= 0.0:
            return float("nan")
        j = int(np.argmax(sums < 0.0))
        return float(j + sums[j - 1] / abs(self.exponents.spectrum[j]))


def chaos(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """Find exponents, verdict and what signals say, write everything; 0 if the motion was computed to its end, else 1.

    Parameters
    ----------
    mechanism : the mechanism.
    name : short name, for the folder.
    options : what stands in the groups "chaos", "method" and "files" of the command line.

    Raises
    ------
    FlexmbError : what `lyapunov` refuses; no period, an unknown signal, a folder that cannot be written.
    """
    from flexmb.commands import chaos_files, chaos_table  # noqa: PLC0415 - xarray when it is needed

    folder = Path(options.out or Path("out") / name)
    pictures = {} if options.no_plots else {"matplotlib": ("pictures", " or leave them out with --no-plots")}
    require_packages({"h5netcdf": ("results", ""), **pictures})
    _check(mechanism, options)
    flow = MechanismFlow(mechanism, **flow_options(options))
    _check_directions(flow, options.exponents)
    signals = chosen(mechanism, flow, options.signals)
    require_folder(folder)
    study = _study(flow, signals, options)
    written = [write_netcdf(folder / f"{STEM}.nc", chaos_files.datasets(study))]
    if not options.no_plots:
        written += chaos_files.pictures(study, folder)
    if not options.quiet:
        print(chaos_table.table(study))
        print("\nwritten:", *(f"  {path}" for path in written), sep="\n")
    if study.trouble:
        print(f"flexmb: {study.trouble}", file=sys.stderr)
    return 1 if study.trouble else 0


def _check(mechanism: Mechanism, options: argparse.Namespace) -> None:
    """Refuse what no result can be had with, before the long run."""
    if options.period is None and not periods_of(mechanism):
        text = f"Mechanism {mechanism.name!r} has no periodic drive, so nothing says when to look at it"
        raise InputError(f"{text}. Give the period of what drives it, or about that of its motion: --period 1s.")
    series = checks.count(OWNER, "--series", options.series, 0)
    if 0 < series < FEWEST_PERIODS:
        text = f"{OWNER}: --series is {series}; estimates from signals need {FEWEST_PERIODS} periods at least"
        raise InputError(f"{text}, and 0 leaves them out.")
    if checks.count(OWNER, "--samples", options.samples) < FEWEST_SAMPLES:
        text = f"{OWNER}: --samples is {options.samples}; it must be {FEWEST_SAMPLES} at least"
        raise InputError(f"{text}: impacts are missed between samples that are farther apart.")
    if series == 0 and (options.dimension or options.recurrence):
        asked = "--dimension" if options.dimension else "--recurrence"
        raise InputError(f"{OWNER}: {asked} needs the motion between the points. Give --series {FEWEST_PERIODS}.")


def _check_directions(flow: MechanismFlow, exponents: int) -> None:
    """Refuse more exponents than there are directions in which neighbours can differ."""
    most = flow.dimension
    if most == 0:
        text = (
            f"Mechanism {flow.name!r}: its drives prescribe the whole motion, so it has no neighbours and no exponents"
        )
        raise InputError(f"{text}. Give a joint play, let a link bend, or drive it by a force or torque.")
    if checks.count(OWNER, "--exponents", exponents) > most:
        raise InputError(f"{OWNER}: --exponents is {exponents}; {flow.name!r} has {most}.")


def _study(flow: MechanismFlow, signals: list[str], options: argparse.Namespace) -> Study:
    """The exponents and a second run that confirms them, then the first motion for some periods more."""
    period = StroboscopicMap(flow).period
    shown = not options.quiet
    asked = {"count": options.exponents, "confirm": not options.no_confirm, "progress": shown}
    found = lyapunov(flow, skip=options.skip, periods=options.keep, **asked)
    drawn = planes(signals, flow.names)
    names = list(dict.fromkeys([*signals, *(name for plane in drawn for name in plane if name is not None)]))
    places = [flow.names.index(name) for name in names]
    series = options.series if found.ok else 0
    times, fine, trouble = goes_on(flow, period, series, options.samples, shown=shown)
    units = tuple(flow.units[place] for place in places)
    motion = Motion(tuple(names), units, found.points[:, places], period, times, fine[:, places], trouble)
    wanted = {"dimension": options.dimension, "recurrent": options.recurrence}
    findings = [looked_at(motion, name, **wanted) for name in signals]
    return Study(found, period, options.skip, flow.units, motion, findings, drawn)
