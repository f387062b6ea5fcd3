"""Runs and figures that worker processes import; each run notes in a file that it was computed."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from flexmb.paper.motion import StudyError
from flexmb.paper.plate import Page, Plate
from flexmb.sweeps.family import STOPPED


@dataclass(frozen=True)
class Ramp:
    """A run whose result is value * (0, 1, 2)."""

    name: str
    journal: str
    value: float = 1.0
    how: str = "well"
    work: float = 1.0

    def fingerprint(self):
        return f"{self.name} {self.value}"

    def compute(self):
        with Path(self.journal).open("a") as file:
            file.write(f"{self.name}\n")
        if self.how == "fails":
            raise StudyError(f"{self.name}: turn 3 did not end: Newton did not converge")
        if self.how == "stopped":
            raise StudyError(f"{self.name}: turn 1 did not end: {STOPPED} at t = 0.1 s")
        if self.how == "Ctrl-C":
            raise KeyboardInterrupt
        if self.how == "slow":
            time.sleep(60.0)
        return xr.Dataset({"y": ("x", self.value * np.arange(3.0))})


def plate(number, *runs):
    return Plate(number, f"Figure of {len(runs)} runs", runs, lambda results: drawn([results[run] for run in runs]))


def drawn(datasets):
    from matplotlib.figure import Figure

    figure = Figure()
    ax = figure.subplots()
    for data in datasets:
        ax.plot(data["y"].values)
    return figure, xr.concat(datasets, "run")


def page(name, *runs, slow=False, picture=False):
    def write(results):
        return f"The sum is {sum(float(results[run]['y'].sum()) for run in runs):g}.", results[runs[0]]

    return Page(name, f"Page {name}", runs, write, plate(0, *runs).draw if picture else None, slow)


def check_data(data, path):
    """It can be written and read, every variable says what it is, and every number with a fraction its unit."""
    data.to_netcdf(path, engine="h5netcdf")
    with xr.open_dataset(path, engine="h5netcdf") as back:
        for name, variable in back.variables.items():
            assert variable.attrs.get("long_name"), name
            assert variable.dtype.kind != "f" or variable.attrs.get("units"), name
