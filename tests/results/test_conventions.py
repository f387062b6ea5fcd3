"""Files follow the CF conventions: units that UDUNITS reads, long names, global attributes."""

import re
import runpy
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from andrews import andrews

import flexmb as fm
from flexmb.results.contact_intervals import ContactLog
from flexmb.results.netcdf import load, long_name, udunits

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
solution = handmade["solution"]

SYMBOL = r"(?:1|rad|kg|m|s|N|J|W|Pa|Hz|A|V|K|C)"
UDUNITS = re.compile(rf"{SYMBOL}(?:\^?-?\d)?(?:[ /.]{SYMBOL}(?:\^?-?\d)?)*")
"""Grammar of UDUNITS-2 as far as these units need it: products by blanks or dots, quotients, powers."""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    rows = np.array([[1, 2, 0.3, 1.0, 0.1, 2.0, 3.0, 4.0, 5e-6, 0.6, -0.0]])
    sol = solution(contacts=ContactLog(("P", "my joint.front"), rows))
    return sol.to_netcdf(tmp_path_factory.mktemp("cf") / "a.nc")


MIXED = {"values", "peak"}
"""Variables whose entries have the units of their signals."""


@pytest.mark.parametrize("group", [None, "episodes"])
def test_every_variable_has_units_and_a_long_name(path, group):
    with xr.open_dataset(path, engine="h5netcdf", group=group) as file:
        numbers = {name: v for name, v in file.variables.items() if v.dtype.kind == "f"}
        assert all(variable.attrs["long_name"] for variable in numbers.values())
        units = [variable.attrs["units"] for name, variable in numbers.items() if name not in MIXED]
        if group is None:
            assert numbers.keys() >= MIXED
            assert all(file["long_name"].values)
            units += file["units"].values.tolist()
        assert len(units) >= 11
        for unit in units:
            assert UDUNITS.fullmatch(unit), unit


@pytest.mark.parametrize("make", [fm.mechanisms.slider_crank, fm.mechanisms.four_bar, andrews])
def test_units_of_signals_are_read_by_udunits(make):
    signals = fm.compile(make()).names.signals
    for unit in set(signals.units):
        assert UDUNITS.fullmatch(udunits(unit)), unit


@pytest.mark.parametrize(("unit", "written"), [("", "1"), ("/s", "1/s"), ("m/s2", "m/s2"), ("N m", "N m")])
def test_units_in_files(unit, written):
    assert udunits(unit) == written


def test_units_come_back_as_they_were(path):
    sol = load(path)
    assert sol.units("P.mode") == ""
    assert sol["P.mode"].attrs["units"] == ""
    assert sol["crank.ax"].attrs["units"] == "m/s2"


def test_global_attributes(path):
    with xr.open_dataset(path, engine="h5netcdf") as file:
        attrs = file.attrs
    assert attrs["Conventions"] == "CF-1.11"
    assert attrs["title"] == "Motion of the mechanism 'handmade'"
    when, _, made = attrs["history"].partition(": ")
    assert abs((datetime.fromisoformat(when) - datetime.now().astimezone()).total_seconds()) < 600.0
    assert made == "flexmb.Solution.to_netcdf"
    assert re.fullmatch(r"flexmb \S+, Python 3\.\S+, numpy \S+, h5py \S+", attrs["versions"])
    assert attrs["source"].startswith("flexmb ")


def test_names_of_flags_are_single_words(path):
    with xr.open_dataset(path, engine="h5netcdf", group="episodes") as file:
        flags = file["contact"].attrs
        assert flags["flag_meanings"].split(" ") == ["P", "my_joint.front"]
        assert len(np.atleast_1d(flags["flag_values"])) == 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rod.node3.vx", "velocity along x of rod node3"),
        ("P.normal_force", "normal force of P"),
        ("energy.residual", "error of the balance of energies"),
        ("impulse", "impulse"),
    ],
)
def test_long_names(name, words):
    assert long_name(name) == words
