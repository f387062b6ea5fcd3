"""`flexmb list`, `flexmb check` and `flexmb vtk`."""

from __future__ import annotations

import inspect
from pathlib import Path

from flexmb.commands.options import options_of, shown_default
from flexmb.commands.source import ready
from flexmb.equilibrium.mechanism_report import check
from flexmb.model.mechanism import Mechanism
from flexmb.results.netcdf import load
from flexmb.results.vtk import write_vtk


def list_mechanisms() -> int:
    """Print every ready mechanism with its options."""
    for name, make in ready().items():
        print(f"{name}: {(inspect.getdoc(make) or '').splitlines()[0]}")
        for option in options_of(make):
            print(f"    {option.flag:<18s}{option.help}{shown_default(option)}")
        print()
    print("Run one of them:      flexmb run NAME [options]")
    print("or a mechanism of your own:  flexmb run FILE.py[:NAME]")
    return 0


def check_mechanism(mechanism: Mechanism) -> int:
    """Print degrees of freedom, redundancies and natural frequencies."""
    print(check(mechanism))
    return 0


def write_frames(path: Path, out: Path | None, frames: int | None) -> int:
    """Write the VTK files of a run that is on disk."""
    print(write_vtk(load(path), out or path.with_suffix(".pvd"), frames=frames))
    return 0
