"""`flexmb vtk`: VTK files of a saved run."""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.results.netcdf import load
from flexmb.results.vtk import write_vtk


def vtk(options: argparse.Namespace) -> int:
    """`flexmb vtk`: write the VTK files of a saved run, and print the name of their list."""
    print(write_vtk(load(options.file), place_of(options.file, options.out), frames=options.frames))
    return 0


def place_of(file: Path, out: Path | None) -> Path:
    """The .pvd file: beside the run, in the folder `out`, or `out` itself where it has an ending."""
    if out is None:
        return file.with_suffix(".pvd")
    return out / f"{file.stem}.pvd" if out.is_dir() or not out.suffix else out
