"""All commands in the order of the help page, with their options; a new command is one entry here and a function."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexmb.engine.step.step_size import RTOL

UNITS_HELP = "Numbers may carry a unit: 0.5mm, 50um, 2pi, 3000rpm, 30deg, 0.1ms; without one they are SI."
# Arguments of the function of a command: (options); (mechanism, name, options); (source, maker options, options).
OPTIONS, MECHANISM, SOURCE = "options", "mechanism", "source"
# An option ("--name VALUE", help) or argument ("name VALUE", help), without VALUE a flag.
# A third entry is its default (of whole numbers also the type), its type, or keywords of `add_argument`. A list holds
# options that exclude each other; a text "TITLE" or "TITLE: DESCRIPTION" begins a group.
Row = Any


def add_rows(parser: Any, rows: tuple[Row, ...] | list[Row]) -> None:
    """Add options and arguments to a parser or group; a default stands in the help."""
    group = parser
    for row in rows:
        if isinstance(row, str):
            title, _, text = row.partition(": ")
            group = parser.add_argument_group(title, text or None)
        elif isinstance(row, list):
            add_rows(group.add_mutually_exclusive_group(), row)
        else:
            (name, _, value), text, more = row[0].partition(" "), row[1], row[2] if len(row) > 2 else {}
            if not isinstance(more, dict):
                more = {"type": more} if isinstance(more, type) else {"default": more}
            if isinstance(default := more.get("default"), int):
                more |= {"type": int}
            if default is not None and "default" not in text:
                text = f"{text} (default {default})"
            shape = {"metavar": value} if value else {"action": "store_true"}
            group.add_argument(name, help=text, **shape, **more)


@dataclass(frozen=True)
class Command:
    """A command of `flexmb`."""

    name: str  # its name; the function of the same name lies in `flexmb/cli/NAME.py`, or where `call` says
    help: str  # first line of its help
    rows: tuple[Row, ...]  # its options, see `Row`
    examples: tuple[str, ...]  # lines as they are typed, shown at the end of its help; tests parse them
    takes: str = OPTIONS  # arguments of its function.  Other values than OPTIONS: it begins with a mechanism
    more: str = ""  # sentences below its options
    call: str = ""  # module and function, where they have other names than the command

    @property
    def begins_with_mechanism(self) -> bool:
        """Whether its first argument is a mechanism, of which the parameters are options."""
        return self.takes != OPTIONS

    @property
    def place(self) -> tuple[str, str]:
        """Module and name of its function."""
        module, _, function = (self.call or f"{self.name}.{self.name}").rpartition(".")
        return f"flexmb.cli.{module}", function


FILE = ("file RUN.nc", "file of `flexmb run`", Path)
TRUSTED = "the mechanism; needed {}where the file is of a run of FILE.py, which is executed"
QUIET = ("--quiet", "no progress and no messages; the summary is printed")


def _method(names: str) -> tuple[Row, ...]:
    step = ("--step TIME", "fixed step, e.g. 10us (default: error-controlled steps)")
    rtol = ("--rtol X", f"relative tolerance of the velocities in a step (default {RTOL:g})")
    return "method", [step, rtol], ("--method NAME", names)


def _files(results: str, page: str, *rows: Row) -> tuple[Row, ...]:
    out = ("--out DIR", f"folder of {results} (default out/NAME)")
    return out, *rows, ("--no-plots", "no pictures"), ("--no-report", f"no {page}"), QUIET


RUN = (
    "time",
    [("--periods X", "length of the run in periods of the drives (default 2)"),
     ("--t-end TIME", "length of the run, e.g. 0.5s")],
    ("--save-from-period X", "first saved period, also for peaks (default 0)"),
    ("--save N", "saved instants a period, an interval as 1ms, or `steps` (default 1000)"),
    ("--restart RUN.nc", "start from the end of this run of the mechanism", Path),
    "interruptions",
    ("--checkpoint TIME", "time between checkpoints, from which --resume goes on", "30s"),
    ("--resume", "go on with a run that was ended from outside, bit for bit"),
    *_method("generalised-alpha[:RADIUS] (default), hht[:ALPHA], wbz[:ALPHA], trapezoidal, runge-kutta, "
             "dormand-prince; runge-kutta needs --step; dormand-prince is for rigid motion and impacts"),
    "files",
    *_files("the results", "report.html", ("--frames N", "number of VTK frames", 100), ("--no-vtk", "no VTK files")),
)  # fmt: skip
SWEEP = (
    "sweep: Give one option of the mechanism a range: --speed 0.5pi:2.5pi:50, or values: 1,2,4.",
    ("--vary PART.FIELD=RANGE", "range of a field of a part, e.g. P1.clearance=0.1mm:1mm:10"),
    ("--skip N", "periods before the first point", 50),
    ("--keep N", "points at each value (default 100, the fewest for chaos without --exponent)", 100),
    ("--direction NAME",
     "start of each value: cold (default), from the value below (up) or above (down), or both", "cold"),
    ("--chunks N", "chunks of up and down with a cold start each", 1),
    ("--signals A,B", "signals to keep (default all)"),
    ("--period TIME", "time between two points (default the period of the drives)"),
    ("--exponent", "also the largest Lyapunov exponent at each value"),
    *_method("methods of `flexmb run` except runge-kutta and dormand-prince"),
    ("--workers N", "number of points at a time, in threads", 1),
    "files",
    ("--store DIR.zarr", "store of all finished points (zarr)"),
    ("--resume", "continue an existing store"),
    *_files("dataset and pictures", "bifurcation.html",
            ("--plot A,B", "signals of the pictures (default: one signal)")),
)  # fmt: skip
CHAOS = (
    "chaos",
    ("--skip N", "periods before the first point", 20),
    ("--keep N", "points, one a period", 200),
    ("--exponents K", "number of exponents", 1),
    ("--period TIME", "time between two points (default the period of the drives)"),
    ("--signals A,B", "signals to be drawn and analysed (default: one signal)"),
    ("--series N", "number of finely sampled periods (default 64; 0: none)", 64),
    ("--samples N", "samples in each of them", 400),
    ("--dimension", "also the correlation dimension of each signal; it needs some 300 periods"),
    ("--recurrence", "also the recurrence quantification of each signal"),
    ("--no-confirm", "no second run with finer steps, a fifth as long, which confirms errors and verdict"),
    *_method("methods of `flexmb run` except runge-kutta and dormand-prince"),
    "files",
    *_files("results and pictures", "chaos.html"),
)
EXPLORE = (
    "explore: Every number and switch of the mechanism gets a slider. A value given here is where it starts; "
    "--speed 50:500 is a range.",
    ("--vary PART.FIELD[=RANGE]", "number of a part, e.g. B.clearance=10um:0.5mm; may be given several times",
     {"action": "append"}),
    [("--periods X", "length of a run in periods of the drives (default 2)"),
     ("--t-end TIME", "length of a run, e.g. 0.5s")],
    ("--store FOLDER", "keep the points of diagrams; the same diagram goes on from there", Path),
    ("--port N", "port of the page, so that links to it stay the same (default: a free one)", int),
    ("--no-open", "print the address alone, and do not open the browser"),
)  # fmt: skip
CHECK = (("--step TIME", "fixed step that a run is to take: is it short enough?"), ("--json", "report as JSON"))
FRAMES = ("--frames N", "number of frames (default: all instants, at most 200)", int)
VTK = (FILE, FRAMES, ("--out PLACE", "a folder, or FILE.pvd (default: beside RUN.nc)", Path))
REPORT = (
    ("file RUN.nc", "file of `flexmb run`, `sweep` or `chaos`", Path),
    ("name NAME", TRUSTED.format("for its examination "), {"nargs": "?"}),
    ("--out FILE.html", "default: report.html beside a run", Path),
    ("--frames N", "most frames", 1000),
)
ANIMATE = (
    FILE,
    ("--out FILE", "the film: .mp4, .gif, or .html (report)", {"required": True}),
    ("--seconds TIME", "length of the film", "4s"),
    ("--fps N", "frames a second", "25"),
    ("--from TIME", "begin of the motion (default: of the run)", {"dest": "begin"}),
    ("--to TIME", "end of the motion (default: of the run)", {"dest": "end"}),
    ("--magnify X", "factor of the deformation", "1"),
    ("--colour NAME", "colours: moment (default), axial or shear of beams, von_mises of meshes, or none", "moment"),
    ("--traces A,B", "points whose paths are drawn, or all (default: some markers)"),
    ("--forces A,B", "joints whose forces are drawn, or all (default: none)"),
    ("--follow NAME", "body, node or marker that stays in the middle (default: none)"),
    ("--size WxH", "width and height in pixels, e.g. 600x400"),
)
PLOT = (
    FILE,
    ("signals SIGNAL", "a signal a panel, e.g. slider.ax; signals joined by commas share a panel", {"nargs": "+"}),
    ("--out FILE", "the picture: .png, .pdf, .svg", {"required": True}),
    ("--x SIGNAL", "signal of the abscissa", "time"),
    ("--title TEXT", "title of the picture (default: name of the mechanism)"),
)

COMMANDS = (
    Command("new", "write a commented model file to begin with",
            (("file NAME", "name of the model; the file is NAME.py", Path), ("--force", "replace an existing file")),
            ("flexmb new press", "flexmb run press.py --speed 300rpm")),
    Command("list", "ready mechanisms and their options", (), ("flexmb list", "flexmb list | head -5"),
            call="arguments.parser.list_mechanisms"),
    Command("check", "all that is wrong with a mechanism; degrees of freedom, mass, natural frequencies", CHECK,
            ("flexmb check nine-bar --clearance 0.5mm", "flexmb check four-bar --set crank.mass=50g --json"),
            MECHANISM, "Exit status 1 where a run could not be right.", call="new.check"),
    Command("run", "simulate a mechanism and write its results", RUN,
            ("flexmb run slider-crank --speed 3000rpm --clearance 50um --flexible --periods 3",
             "flexmb run slider-crank --set slider.mass=200g --set gravity=0,-9.81 --t-end 20ms --no-vtk",
             "flexmb run nine-bar --clearance 0.5mm --quiet --resume"),
            MECHANISM, "A model file, FILE.py, is code that is executed: run only files that you trust."),
    Command("explore", "a page in the browser with sliders: change it and see it", EXPLORE,
            ("flexmb explore nine-bar --clearance 0.5mm",
             "flexmb explore slider-crank --speed 50:500 --clearance 10um:0.5mm --periods 4",
             "flexmb explore slider-crank --clearance 0.1mm --vary slider.mass=0.1:0.5 --no-open"), SOURCE,
            "The page listens on this machine alone; Ctrl-C ends it. It needs pip install 'flexmb[live]'.",
            call="studies.explore"),
    Command("vtk", "write VTK files of a saved run", VTK,
            ("flexmb vtk out/slider-crank/slider-crank.nc",
             "flexmb vtk out/slider-crank/slider-crank.nc --out frames --frames 50"), call="saved.vtk"),
    Command("report", "write the HTML page of a saved run, diagram or study", REPORT,
            ("flexmb report out/slider-crank/slider-crank.nc",
             "flexmb report out/press/press.nc press.py --out press.html"), call="saved.report"),
    Command("animate", "film of a saved run: GIF or MP4", ANIMATE,
            ("flexmb animate out/slider-crank/slider-crank.nc --out slider-crank.gif",
             "flexmb animate out/slider-crank/slider-crank.nc --out rod.mp4 --seconds 8s --magnify 50 --forces all"),
            more=UNITS_HELP, call="saved.animate"),
    Command("plot", "signals of a saved run as a picture", PLOT,
            ("flexmb plot out/slider-crank/slider-crank.nc slider.ax B.normal_force --out forces.png",
             "flexmb plot out/slider-crank/slider-crank.nc B.ey --x B.ex --out orbit.png"), call="saved.plot"),
    Command("rerun", "repeat a saved run and compare the results",
            (FILE, ("name NAME", TRUSTED.format(""), {"nargs": "?"}), QUIET),
            ("flexmb rerun out/slider-crank/slider-crank.nc", "flexmb rerun out/press/press.nc press.py"),
            call="saved.rerun"),
    Command("sweep", "a bifurcation diagram over one parameter", SWEEP,
            ("flexmb sweep nine-bar --speed 0.5pi:2.5pi:9 --clearance 0.5mm --keep 30 --workers 2",
             "flexmb sweep slider-crank --clearance 0.1mm --vary slider.mass=0.1:0.3:5 --set rod.mass=0.2",
             "flexmb sweep slider-crank --clearance 0.1mm:1mm:10 --store out/diagram.zarr --resume"), SOURCE,
            call="studies.sweep"),
    Command("chaos", "exponents, section and verdict: periodic or chaotic", CHAOS,
            ("flexmb chaos slider-crank --clearance 0.5mm --exponents 2",
             "flexmb chaos slider-crank --clearance 0.5mm --set slider.mass=0.2 --series 0 --no-plots"), MECHANISM,
            call="studies.chaos"),
    Command("completion", "print a script that completes commands and options in a shell",
            (("shell SHELL", "bash, zsh or fish", {"choices": ("bash", "zsh", "fish")}),),
            ('eval "$(flexmb completion bash)"', "flexmb completion zsh > ~/.zfunc/_flexmb",
             "flexmb completion fish > ~/.config/fish/completions/flexmb.fish")),
)  # fmt: skip
