"""Commands that study a motion: `flexmb sweep`, `flexmb chaos`, and `flexmb explore` on a live page in the browser."""

import argparse
import inspect
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.cli.arguments.parser import Option, keywords_of
from flexmb.cli.arguments.source import Source, field_option
from flexmb.cli.run import flow_options, periods_of, require_folder, require_those_of, tell
from flexmb.dynamics.jobs.files import write_netcdf
from flexmb.dynamics.report import Plan
from flexmb.dynamics.sections import StroboscopicMap
from flexmb.dynamics.sweeps.bifurcation import Family, bifurcation, first_of
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.show.live.knobs import Knobs
from flexmb.show.live.page import Page, length_of, shown
from flexmb.show.reports.study_pages import report, write_chaos
from flexmb.units import quantity

ENDS = "LOW:HIGH, e.g. 10um:0.5mm"
RANGE = "FROM:TO:NUMBER, e.g. 0.5pi:2.5pi:50, or values with commas between them"
# Options that are arguments of `bifurcation` and of `chaos.report`.
ARGUMENTS_OF_BIFURCATION = ("skip", "keep", "direction", "chunks", "exponent", "store", "resume")
ARGUMENTS_OF_REPORT = ("skip", "keep", "exponents", "series", "samples", "dimension", "recurrence")


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
    shared = {name: vars(options)[name] for name in ARGUMENTS_OF_BIFURCATION}
    threads = workers if workers > 1 else None
    given = {"fixed": fixed, "signals": signals, "executor": threads, "progress": not options.quiet, **solver}
    diagram = bifurcation(make, parameter, values, **shared, **given)
    written = [Path(options.store)] if options.store else [write_netcdf(folder / "bifurcation.nc", {"": diagram})]
    if not options.no_plots:
        from flexmb.show.pictures.diagrams import default_signal, plot_bifurcation  # noqa: PLC0415 - when asked for

        for name in dict.fromkeys(pictures or [default_signal(diagram)]):
            written.append(folder / f"bifurcation-{name}.png")
            plot_bifurcation(diagram, name).savefig(written[-1], dpi=150)
    if not options.no_report and (diagram["status"].values != "").any():
        written.append(report(diagram, folder / "bifurcation.html"))
    bad = ~diagram["ok"].values
    failed = f"{bad.sum()} of {bad.size} points failed; the first one: " if bad.any() else ""
    verdicts = Counter(str(verdict) or "failed" for verdict in diagram["verdict"].values.ravel())
    parameter = diagram.attrs["parameter"]
    values, unit = diagram[parameter].values, diagram[parameter].attrs.get("units", "")
    head = f"{diagram.attrs['name']}: {len(values)} values of {parameter} from {values.min():.6g} to {values.max():.6g}"
    lines = (f"  {name:<16s}{count}" for name, count in sorted(verdicts.items()))
    tell("\n".join([f"{head} {unit}".rstrip(), *lines]), written, failed and failed + diagram["status"].values[bad][0])
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


def chaos(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """`flexmb chaos`: exponents, verdict and estimates from signals, written to files and printed.

    The folder has the short name; options are those of the groups "chaos", "method" and "files".  Returns 0 if the
    motion was computed to its end, else 1.
    """
    folder = Path(options.out or Path("out") / name)
    require_those_of(options)
    if options.period is None and not periods_of(mechanism):
        text = f"Mechanism {mechanism.name!r} has no periodic drive, so the period of the section is unknown"
        raise InputError(f"{text}. Give the period of the drive, or about that of the motion: --period 1s.")
    flow = MechanismFlow(mechanism, **flow_options(options))
    signals = [text.strip() for text in options.signals.split(",")] if options.signals else None
    shared = {option: vars(options)[option] for option in ARGUMENTS_OF_REPORT}
    plan = Plan(StroboscopicMap(flow), signals=signals, confirm=not options.no_confirm, **shared)
    plan = plan.checked("flexmb chaos", "--")
    require_folder(folder)
    found = plan.report(progress=not options.quiet)
    written = [found.to_netcdf(folder / "chaos.nc")]
    if not options.no_plots:
        from flexmb.show.pictures.diagrams import plot_report  # noqa: PLC0415 - matplotlib when a picture is asked for

        for file, figure in plot_report(found).items():
            figure.savefig(folder / file, dpi=150)
            written.append(folder / file)
    if not options.no_report and len(found.exponents.points):
        written.append(write_chaos(found.groups, folder / "chaos.html", None, None))
    tell(found.text("--"), written, found.trouble)
    return 0 if found.ok else 1


def explore(source: Source, makers: list[Option], options: argparse.Namespace) -> int:
    """`flexmb explore`: serve a live page until Ctrl-C; returns 0.

    Arguments of the function vary; with --set or --vary, or without arguments, numbers of the parts do.  `makers` are
    the options of the function.
    """
    typed = {option: str(vars(options).get(f"maker.{option.name}", "")) for option in makers}
    ranges = {option.name: _ends_of(text, option) for option, text in typed.items() if ":" in text}
    fixed = keywords_of(options, [option for option in makers if option.name not in ranges])
    wishes = options.vary or []
    words = [options.source, *(f"--set={text}" for text in options.set), *(f"--vary={text}" for text in wishes)]
    if options.set or wishes or not inspect.signature(source.make).parameters:
        if ranges:
            text = f"--{next(iter(ranges))}: a range of an argument goes neither with --set nor with --vary"
            raise InputError(f"{text}. Give its value, or a range of a number of a part.")
        mechanism = source.mechanism(fixed)
        vary: dict[str, tuple[Any, Any] | None] = {}  # None: a range about the value
        for path, equals, span in (text.partition("=") for text in wishes):
            option = field_option(mechanism, path, "vary")
            vary[path] = _ends_of(span, option) if equals else None
        knobs = Knobs(mechanism, vary or None, {})
        words[1:1] = [f"{option.flag}={text}" for option, text in typed.items() if text and option.kind != "flag"]
        words[1:1] = [option.flag for option in makers if option.kind == "flag" and fixed.get(option.name)]
    else:
        knobs = Knobs(source.make, None, fixed, ranges)
    periods = None if options.periods is None else quantity(options.periods, "", "--periods")
    t_end = None if options.t_end is None else quantity(options.t_end, "s", "--t-end")
    page = Page(knobs, length_of(periods, t_end), words, options.store, options.port)
    shown(page, opened=not options.no_open, block=True)
    return 0


def _ends_of(text: str, option: Option) -> tuple[Any, Any]:
    """Ends of a typed range, each with its unit."""
    parts = text.split(":")
    if len(parts) != 2:
        raise InputError(f"{option.flag}: {text!r} is no range; give {ENDS}.")
    return option.value(parts[0]), option.value(parts[1])
