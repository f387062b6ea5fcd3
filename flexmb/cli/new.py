"""`flexmb new` and `flexmb check`: a model file to begin with, and its examination."""

import argparse
import re
import shlex
from importlib.resources import files
from keyword import iskeyword
from pathlib import Path

from flexmb.dynamics.jobs.files import write_text
from flexmb.errors import InputError
from flexmb.findings.check import check as examined
from flexmb.model.mechanism import Mechanism
from flexmb.units import quantity

SOUND, WRONG = 0, 1  # exit statuses: no error among the findings, at least one error


def check(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """`flexmb check`: print degrees of freedom, mass, natural frequencies and all findings.

    Returns 0 without errors among the findings, else 1.  `name` is for files, of which there are none.
    """
    report = examined(mechanism, None if options.step is None else quantity(options.step, "s", "--step"))
    print(report.to_json() if options.json else report)
    return SOUND if report.ok else WRONG


def new(options: argparse.Namespace) -> int:
    """`flexmb new`: write a model file, of a name that is free and fits a module, and print the next commands."""
    path = Path(options.file)
    path = path if path.suffix == ".py" else path.with_name(f"{path.name}.py")
    if not path.stem.isidentifier() or iskeyword(path.stem):
        plain = re.sub(r"\W", "_", path.stem) or "model"
        plain = plain if plain.isidentifier() and not iskeyword(plain) else f"m{plain}"
        text = f"{path.stem!r} is no name of a Python file, such as {plain!r}"
        raise InputError(f"{text}. Take letters, digits and underscores, with a letter first.")
    if path.exists() and not options.force:
        raise InputError(f"{str(path)!r} is there already. Take another name, or replace it with --force.")
    model = files("flexmb.cli").joinpath("assets", "model.txt").read_text(encoding="utf-8")
    write_text(path, model.replace("@NAME@", path.stem).replace("@FILE@", path.name))
    print(f"{path} is a slider-crank with comments on clearances, flexible links, springs and loads. Next:")
    typed = shlex.quote(str(path))
    print(f"  flexmb check {typed}\n  flexmb run {typed} --speed 300rpm")
    return 0
