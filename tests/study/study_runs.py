"""Runs and figures that worker processes import; each run notes in a file that it was computed."""

import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from nine_bar_study.item import StudyFigure, StudyPage
from nine_bar_study.run import StudyError, StudyRun

import flexmb as fm


def interrupted(run, options, steps):
    raise KeyboardInterrupt


def ramp(name, journal, value=1.0, how="well", work=1.0):
    """A run whose result is value * (0, 1, 2)."""
    settings = {"name": name, "journal": journal, "value": value, "how": how}
    return StudyRun(name, measure_ramp, None, tuple(settings.items()), work)


def measure_ramp(case, *, name, journal, value, how):
    with Path(journal).open("a") as file:
        file.write(f"{name}\n")
    if how == "fails":
        raise StudyError(f"{name}: turn 3 did not end: Newton did not converge")
    if how == "stopped":
        with pytest.MonkeyPatch.context() as patch:  # Ctrl-C during a simulation
            patch.setattr("flexmb.run.run.Run.advance", interrupted)
            fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-3)
    if how == "Ctrl-C":
        raise KeyboardInterrupt
    if how == "slow":
        time.sleep(60.0)
    return xr.Dataset({"y": ("x", value * np.arange(3.0))})


def figure(number, *runs):
    return StudyFigure(
        number, f"Figure of {len(runs)} runs", runs, lambda results: drawn([results[run] for run in runs])
    )


def drawn(datasets):
    from matplotlib.figure import Figure

    picture = Figure()
    ax = picture.subplots()
    for data in datasets:
        ax.plot(data["y"].values)
    return picture, xr.concat(datasets, "run")


def page(name, *runs, slow=False, picture=False):
    def write(results):
        return f"The sum is {sum(float(results[run]['y'].sum()) for run in runs):g}.", results[runs[0]]

    return StudyPage(name, f"Page {name}", runs, write, figure(0, *runs).draw if picture else None, slow)


def check_data(data, path):
    """It can be written and read, every variable says what it is, and every number with a fraction its unit."""
    data.to_netcdf(path, engine="h5netcdf")
    with xr.open_dataset(path, engine="h5netcdf") as back:
        for name, variable in back.variables.items():
            assert variable.attrs.get("long_name"), name
            assert variable.dtype.kind != "f" or variable.attrs.get("units"), name
