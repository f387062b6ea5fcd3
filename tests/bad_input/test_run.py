"""Arguments of runs and files that cannot be used: the message names value and remedy."""

import re
import sys

import numpy as np
import pytest

import flexmb as fm
from flexmb import checks
from flexmb.errors import FileFormatError, InputError, MissingPackageError

CRANK = fm.RigidLink("crank", (0.0, 0.0), (0.2, 0.0), mass=0.5, inertia=2e-3)
PIN = fm.Revolute("O", fm.GROUND, CRANK, at=(0.0, 0.0))
SWING = fm.Mechanism("swing", [CRANK, PIN], gravity=(0.0, -9.81))
TURN = fm.Mechanism("turn", [CRANK, PIN, fm.Drive("motor", "O", fm.ConstantSpeed(6.0))])

REFUSED = [
    ({"t_end": 0.0}, "simulate 'swing': t_end is 0 s; it must be > 0."),
    ({"t_end": -1.0}, "simulate 'swing': t_end is -1 s; it must be > 0."),
    ({"t_end": np.nan}, "simulate 'swing': t_end is nan; it must be finite in s."),
    ({"t_end": "1"}, "simulate 'swing': t_end is '1'; it must be a number in s."),
    ({}, "t_end is None and periods is None; give either t_end= (seconds) or periods= (of the drives)."),
    ({"periods": 2}, "Mechanism 'swing' has no periodic drive; give t_end= instead of periods=."),
    (
        {"t_end": 1.0, "save_from_period": 1},
        "Mechanism 'swing' has no periodic drive; give t_end= instead of periods=.",
    ),
    ({"t_end": 1.0, "save_from": 2.0}, "saving begins at 2 s, but the run ends at 1 s. Run longer or save earlier."),
    ({"t_end": 1.0, "save_from": -1.0}, "simulate 'swing': save_from is -1 s; it must be >= 0."),
    (
        {"t_end": 1.0, "save": "all"},
        "simulate 'swing': save is 'all'; it must be a number of instants, an interval [s] or 'steps'.",
    ),
    ({"t_end": 1.0, "save": 0}, "simulate 'swing': save is 0; it must be at least 1."),
    ({"t_end": 1.0, "step": "fine"}, "step is 'fine'; it must be FixedStep(size) or Adaptive(...)."),
    ({"t_end": 1.0, "step": 0.0}, "FixedStep: size is 0 s; it must be > 0."),
    (
        {"t_end": 1.0, "method": "rk4"},
        "method is 'rk4'; it must be Newmark(...), RadauIIA(), DormandPrince(), RungeKutta4() or a method of your own "
        "(flexmb/engine/step/method.py).",
    ),
    ({"t_end": 1.0, "method": fm.RungeKutta4()}, "RungeKutta4 has no error estimate; give step=FixedStep(size)."),
    ({"t_end": 1.0, "max_steps": -1}, "simulate 'swing': max_steps is -1; it must be at least 1."),
    ({"t_end": 1.0, "max_steps": "many"}, "simulate 'swing': max_steps is 'many'; it must be a whole number."),
    ({"t_end": 1.0, "redundant": "least"}, "redundant is 'least'. Did you mean 'least-norm'?"),
    ({"t_end": 1e-300}, "t_end is 1e-300 s; it must be at least 1e-100 s."),
    ({"t_end": 1.0, "restart": 5}, "restart is 5; it must be `restart` of a solution of this mechanism."),
    ({"t_end": 1.0, "restart": {}}, "restart does not fit this model"),
]


@pytest.mark.parametrize(("arguments", "message"), REFUSED, ids=[message[:60] for _, message in REFUSED])
def test_refused_with_its_value_and_remedy(arguments, message):
    with pytest.raises(InputError, match=re.escape(message)):
        fm.simulate(SWING, **arguments)


def test_both_times():
    with pytest.raises(InputError, match=r"t_end is 1.0 and periods is 2; give either"):
        fm.simulate(TURN, t_end=1.0, periods=2)


def test_drives_without_a_common_period():
    arm = fm.RigidLink("arm", (0.2, 0.0), (0.4, 0.0), mass=0.1, inertia=1e-3)
    second = [
        arm,
        fm.Revolute("A", CRANK, arm, at=(0.2, 0.0)),
        fm.Drive("tool", "A", fm.ConstantSpeed(6.0 * np.sqrt(2.0))),
    ]
    with pytest.raises(InputError, match=r"periods of its drives, .* have no small common multiple; give t_end="):
        fm.simulate(fm.Mechanism("two", [*TURN.parts, *second]), periods=1)


def test_restart_of_another_model():
    other = fm.simulate(TURN, t_end=0.01, step=1e-3)
    with pytest.raises(
        InputError, match=r"restart does not fit this model .*Use `restart` of a solution of the same mech"
    ):
        fm.simulate(SWING, t_end=0.02, step=1e-3, restart=other.restart)


# -- files -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sol():
    return fm.simulate(SWING, t_end=0.02, step=1e-3)


def test_file_in_the_place_of_a_folder(sol, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match=r"taken.run\.nc' cannot be written .*Give a file in a writable folder"):
        sol.to_netcdf(tmp_path / "taken" / "run.nc")


def test_truncated_file(sol, tmp_path):
    path = sol.to_netcdf(tmp_path / "run.nc")
    path.write_bytes(path.read_bytes()[:4000])
    with pytest.raises(FileFormatError, match=r"run\.nc'.*damaged, truncated or no netCDF file.*Write it again"):
        fm.load(path)


def test_file_of_another_version(sol, tmp_path):
    import h5py

    path = sol.to_netcdf(tmp_path / "run.nc")
    with h5py.File(path, "a") as file:
        file.attrs["flexmb_format"] = 999
    with pytest.raises(FileFormatError, match=r"written in format 999; this version of flexmb reads formats up to 3"):
        fm.load(path)


def test_file_of_someone_else(tmp_path):
    import xarray as xr

    path = tmp_path / "other.nc"
    xr.Dataset({"x": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(FileFormatError, match=r"a netCDF file, but not one of flexmb"):
        fm.load(path)


def test_missing_file(tmp_path):
    with pytest.raises(FileFormatError, match=r"there is no such file. Check the path"):
        fm.load(tmp_path / "none.nc")


# -- optional packages -----------------------------------------------------------------------------------------------


def test_missing_package_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "dask", None)
    with pytest.raises(
        MissingPackageError, match=r"A sweep.* needs the package 'dask'.*pip install 'flexmb\[sweep\]'"
    ) as e:
        checks.package("dask", "sweep", "A sweep on a cluster")
    assert isinstance(e.value, ImportError)


def test_package_that_is_there():
    assert checks.package("json", "dev", "This test").loads("[1]") == [1]
