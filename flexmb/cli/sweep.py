"""`flexmb sweep`: a bifurcation diagram of a mechanism over one parameter."""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.cli.arguments.parser import Option, keywords_of
from flexmb.cli.arguments.source import Source, field_option
from flexmb.cli.run import flow_options, require_folder, require_those_of, tell
from flexmb.dynamics.jobs.files import write_netcdf
from flexmb.dynamics.sweeps.bifurcation import Family, bifurcation, first_of
from flexmb.errors import InputError
from flexmb.show.reports.report import report
from flexmb.units import quantity

if TYPE_CHECKING:
    import xarray as xr

RANGE = "FROM:TO:NUMBER, e.g. 0.5pi:2.5pi:50, or values with commas between them"
STEM = "bifurcation"
# Options that are arguments of `bifurcation`.
SHARED = ("skip", "keep", "direction", "chunks", "exponent", "store", "resume")


def sweep(source: Source, makers: list[Option], options: argparse.Namespace) -> int:
    """`flexmb sweep`: compute a diagram, write it and its pictures; returns 0 if all points succeeded, else 1.

    Options are those of the groups "sweep", "method" and "files"; `makers` are those of the function of the mechanism.
    """
    make, parameter, values, fixed = _varied(source, makers, options)
    folder = Path(options.out or Path("out") / source.name)
    require_those_of(options)
    require_folder(folder)
    workers, solver = checks.count("flexmb sweep", "--workers", options.workers), flow_options(options)
    signals = options.signals.split(",") if options.signals else None
    pictures = options.plot.split(",") if options.plot and not options.no_plots else []
    known = signals or (first_of(Family(make, parameter, fixed, **solver), values).names if pictures else ())
    for name in pictures:  # before the long run
        checks.one_of("--plot", "signal", name, known)
    shared = {name: vars(options)[name] for name in SHARED}
    threads = workers if workers > 1 else None
    given = {"fixed": fixed, "signals": signals, "executor": threads, "progress": not options.quiet, **solver}
    diagram = bifurcation(make, parameter, values, **shared, **given)
    written = [Path(options.store)] if options.store else [write_netcdf(folder / f"{STEM}.nc", {"": diagram})]
    if not options.no_plots:
        from flexmb.show.pictures.diagrams import default_signal, plot_bifurcation  # noqa: PLC0415 - when asked for

        for name in dict.fromkeys(pictures or [default_signal(diagram)]):
            written.append(folder / f"{STEM}-{name}.png")
            plot_bifurcation(diagram, name).savefig(written[-1], dpi=150)
    if not options.no_report and (diagram["status"].values != "").any():
        written.append(report(diagram, folder / f"{STEM}.html"))
    bad = ~diagram["ok"].values
    failed = f"{bad.sum()} of {bad.size} points failed; the first one: " if bad.any() else ""
    tell(_summary(diagram), written, failed and failed + diagram["status"].values[bad][0])
    return 1 if failed else 0


def values_of(text: str, option: Option) -> list[float]:
    """Values of a typed range "FROM:TO:NUMBER" or "A,B,C", each with its unit; whole numbers for a count."""
    if ":" not in text:
        return [option.value(part) for part in text.split(",")]
    parts = text.split(":")
    if len(parts) != 3:
        raise InputError(f"{option.flag}: {text!r} is no range; give {RANGE}.")
    first, last = (quantity(part, option.unit, option.flag) for part in parts[:2])
    typed = quantity(parts[2], "", f"{option.flag}: number of values")
    number = checks.count("flexmb sweep", f"the number of values in {option.flag}", typed)
    values = np.linspace(first, last, number).tolist()
    return [option.value(repr(value)) for value in values] if option.kind == "count" else values


def _varied(
    source: Source, makers: list[Option], options: argparse.Namespace
) -> tuple[Any, str, list[float], dict[str, Any]]:
    """Function or mechanism, parameter, its values, and fixed values of other parameters."""
    numbers = [option.name for option in makers if option.kind in ("number", "count")]
    typed = {name: vars(options).get(f"maker.{name}") or "" for name in numbers}
    ranges = [option for option in makers if any(sign in typed.get(option.name, "") for sign in ":,")]
    if len(ranges) + (options.vary is not None) != 1:
        flags = ", ".join([option.flag for option in ranges] + (["--vary"] if options.vary else [])) or "none"
        example = next((f"{option.flag} " for option in makers if option.name in typed), "--vary crank.mass=")
        text = f"flexmb sweep: one parameter must have a range, found: {flags}"
        raise InputError(f"{text}. Give it as {example}{RANGE}.")
    fixed = keywords_of(options, [option for option in makers if option not in ranges])
    if ranges:
        option = ranges[0]
        return source.make, option.name, values_of(typed[option.name], option), fixed
    mechanism = source.mechanism(fixed)
    path, equals, text = options.vary.partition("=")
    if not equals:
        raise InputError(f"--vary: {options.vary!r} names no range; give PART.FIELD={RANGE}.")
    return mechanism, path, values_of(text, field_option(mechanism, path, "vary")), {}


def _summary(diagram: xr.Dataset) -> str:
    """Number of points by verdict, as a text."""
    verdicts = Counter(str(verdict) or "failed" for verdict in diagram["verdict"].values.ravel())
    parameter = diagram.attrs["parameter"]
    values, unit = diagram[parameter].values, diagram[parameter].attrs.get("units", "")
    head = f"{diagram.attrs['name']}: {len(values)} values of {parameter} from {values.min():.6g} to {values.max():.6g}"
    lines = (f"  {name:<16s}{count}" for name, count in sorted(verdicts.items()))
    return "\n".join([f"{head} {unit}".rstrip(), *lines])
