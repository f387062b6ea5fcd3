"""All commands in the order of the help page; a new command is one entry here, and a function of its options."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

from flexmb.cli.arguments import options

UNITS_HELP = "Numbers may carry a unit: 0.5mm, 50um, 2pi, 3000rpm, 30deg, 0.1ms; without one they are SI."

OPTIONS, MECHANISM, SOURCE = "options", "mechanism", "source"
"""Arguments of the function of a command: (options); (mechanism, name, options); (source, maker options, options)."""


@dataclass(frozen=True)
class Command:
    """A command of `flexmb`.

    Parameters
    ----------
    name : its name; the function of the same name lies in `flexmb/cli/NAME.py`, or where `call` says.
    help : first line of its help.
    add : function that adds its options to a parser.
    examples : lines as they are typed, shown at the end of its help; tests parse them.
    takes : arguments of its function.  Other values than OPTIONS: it begins with a mechanism.
    more : sentences below its options.
    call : module and function, where they have other names than the command.
    """

    name: str
    help: str
    add: Callable[[argparse.ArgumentParser], None]
    examples: tuple[str, ...]
    takes: str = OPTIONS
    more: str = ""
    call: str = ""

    @property
    def begins_with_mechanism(self) -> bool:
        """Whether its first argument is a mechanism, of which the parameters are options."""
        return self.takes != OPTIONS

    @property
    def place(self) -> tuple[str, str]:
        """Module and name of its function."""
        module, _, function = (self.call or f"{self.name}.{self.name}").rpartition(".")
        return f"flexmb.cli.{module}", function


COMMANDS = (
    Command(
        "new",
        "write a commented model file to begin with",
        options.add_new,
        ("flexmb new press", "flexmb run press.py --speed 300rpm"),
    ),
    Command(
        "list",
        "ready mechanisms and their options",
        options.add_nothing,
        ("flexmb list", "flexmb list | head -5"),
        call="arguments.source.list_mechanisms",
    ),
    Command(
        "check",
        "all that is wrong with a mechanism; degrees of freedom, mass, natural frequencies",
        options.add_check,
        (
            "flexmb check nine-bar --clearance 0.5mm",
            "flexmb check four-bar --set crank.mass=50g --json",
        ),
        MECHANISM,
        "Exit status 1 where a run could not be right.",
        call="new.check",
    ),
    Command(
        "run",
        "simulate a mechanism and write its results",
        options.add_run,
        (
            "flexmb run slider-crank --speed 3000rpm --clearance 50um --flexible --periods 3",
            "flexmb run slider-crank --set slider.mass=200g --set gravity=0,-9.81 --t-end 20ms --no-vtk",
            "flexmb run nine-bar --clearance 0.5mm --quiet --resume",
        ),
        MECHANISM,
        "A model file, FILE.py, is code that is executed: run only files that you trust.",
    ),
    Command(
        "vtk",
        "write VTK files of a saved run",
        options.add_vtk,
        (
            "flexmb vtk out/slider-crank/slider-crank.nc",
            "flexmb vtk out/slider-crank/slider-crank.nc --out frames --frames 50",
        ),
        call="saved.vtk",
    ),
    Command(
        "report",
        "write the HTML page of a saved run, diagram or study",
        options.add_report,
        (
            "flexmb report out/slider-crank/slider-crank.nc",
            "flexmb report out/press/press.nc press.py --out press.html",
        ),
        call="saved.report",
    ),
    Command(
        "animate",
        "film of a saved run: GIF or MP4",
        options.add_animate,
        (
            "flexmb animate out/slider-crank/slider-crank.nc --out slider-crank.gif",
            "flexmb animate out/slider-crank/slider-crank.nc --out rod.mp4 --seconds 8s --magnify 50 --forces all",
        ),
        more=UNITS_HELP,
        call="saved.animate",
    ),
    Command(
        "plot",
        "signals of a saved run as a picture",
        options.add_plot,
        (
            "flexmb plot out/slider-crank/slider-crank.nc slider.ax B.normal_force --out forces.png",
            "flexmb plot out/slider-crank/slider-crank.nc B.ey --x B.ex --out orbit.png",
        ),
        call="saved.plot",
    ),
    Command(
        "rerun",
        "repeat a saved run and compare the results",
        options.add_rerun,
        ("flexmb rerun out/slider-crank/slider-crank.nc", "flexmb rerun out/press/press.nc press.py"),
        call="saved.rerun",
    ),
    Command(
        "sweep",
        "a bifurcation diagram over one parameter",
        options.add_sweep,
        (
            "flexmb sweep nine-bar --speed 0.5pi:2.5pi:9 --clearance 0.5mm --keep 30 --workers 2",
            "flexmb sweep slider-crank --clearance 0.1mm --vary slider.mass=0.1:0.3:5 --set rod.mass=0.2",
            "flexmb sweep slider-crank --clearance 0.1mm:1mm:10 --store out/diagram.zarr --resume",
        ),
        SOURCE,
    ),
    Command(
        "chaos",
        "exponents, section and verdict: periodic or chaotic",
        options.add_chaos,
        (
            "flexmb chaos slider-crank --clearance 0.5mm --exponents 2",
            "flexmb chaos slider-crank --clearance 0.5mm --set slider.mass=0.2 --series 0 --no-plots",
        ),
        MECHANISM,
    ),
    Command(
        "completion",
        "print a script that completes commands and options in a shell",
        options.add_completion,
        (
            'eval "$(flexmb completion bash)"',
            "flexmb completion zsh > ~/.zfunc/_flexmb",
            "flexmb completion fish > ~/.config/fish/completions/flexmb.fish",
        ),
    ),
)
