"""`flexmb chaos`: exponents, section and verdict of a motion, printed as a table and written to files."""

import argparse
from pathlib import Path

from flexmb.cli.run import flow_options, periods_of, require_folder, require_those_of, tell
from flexmb.dynamics.report import Plan
from flexmb.dynamics.sections import StroboscopicMap
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.show.reports.chaos_page import write_chaos

OWNER = "flexmb chaos"
STEM = "chaos"
# Options that are arguments of `chaos.report`.
SHARED = ("skip", "keep", "exponents", "series", "samples", "dimension", "recurrence")


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
    shared = {option: vars(options)[option] for option in SHARED}
    plan = Plan(StroboscopicMap(flow), signals=signals, confirm=not options.no_confirm, **shared).checked(OWNER, "--")
    require_folder(folder)
    found = plan.report(progress=not options.quiet)
    written = [found.to_netcdf(folder / f"{STEM}.nc")]
    if not options.no_plots:
        from flexmb.show.pictures.diagrams import plot_report  # noqa: PLC0415 - matplotlib when a picture is asked for

        for file, figure in plot_report(found).items():
            figure.savefig(folder / file, dpi=150)
            written.append(folder / file)
    if not options.no_report and len(found.exponents.points):
        written.append(write_chaos(found.groups, folder / f"{STEM}.html", None, None))
    tell(found.text("--"), written, found.trouble)
    return 0 if found.ok else 1
