"""A solution as netCDF: back bit for bit, readable by others, honest about files it cannot read."""

import json
import pickle
import runpy
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from flexmb.errors import FileFormatError, InputError
from flexmb.model.shape import RigidShape
from flexmb.model.signal import Signal
from flexmb.results.contact_intervals import ContactLog
from flexmb.results.naming import udunits
from flexmb.results.netcdf import load
from flexmb.results.solution import Stats

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
solution = handmade["solution"]


def bits(array):
    return np.asarray(array).tobytes()


def test_files_are_what_xarray_would_write(tmp_path):
    """Each variable, its attributes and its dimensions, in the words of HDF5 and of netCDF."""
    sol = solution()
    names = [name for name in sol.names if sol.units(name) == udunits(sol.units(name))]
    path = sol.to_netcdf(tmp_path / "a.nc")
    columns = sol.dataset[names]
    for name in names:
        value, time = sol.peak(name)
        columns[name].attrs |= {"peak": value, "peak_time": time}
    columns.to_netcdf(tmp_path / "b.nc", engine="h5netcdf", encoding={name: {"_FillValue": None} for name in names})
    assert names
    with h5py.File(path) as ours, h5py.File(tmp_path / "b.nc") as theirs:
        for name in names:
            one, two = ours[name], theirs[name]
            assert one.attrs.keys() == two.attrs.keys()
            assert np.array_equal(one[()], two[()])
            assert one.dims[0][0] == ours["time"]
            for key in set(one.attrs) - {"DIMENSION_LIST"}:
                assert one.attrs.get_id(key).dtype == two.attrs.get_id(key).dtype
                assert np.array_equal(one.attrs[key], two.attrs[key])
                assert np.shape(one.attrs[key]) == np.shape(two.attrs[key])
    with xr.open_dataset(path, engine="h5netcdf") as ours, xr.open_dataset(tmp_path / "b.nc") as theirs:
        for name in names:
            assert ours[name].identical(theirs[name])


def test_back_bit_for_bit(tmp_path):
    values = solution().values.copy()
    values[0, :4] = [np.nan, -0.0, np.inf, 5e-324]
    stats = Stats(7, 1, 20, 21, 3, np.nextafter(1e-9, 1.0), 1.0 / 3.0, 0.1)
    sol = solution(values=values, stats=stats, ok=False, status="Newton did not converge at t = 0.4 s.")
    back = load(sol.to_netcdf(tmp_path / "a.nc"))
    for name in ("time", "values"):
        assert bits(getattr(back, name)) == bits(getattr(sol, name))
    assert bits(back.peaks.values) == bits(sol.peaks.values)
    assert bits(back.peaks.times) == bits(sol.peaks.times)
    for name in ("signals", "aliases", "shapes", "status", "ok", "stats", "model"):
        assert getattr(back, name) == getattr(sol, name), name
    assert back.ok is False


def test_the_final_state_comes_back_with_its_types(tmp_path):
    restart = {
        "t": np.array(0.3),
        "q": np.array([[1.0, -0.0], [np.nextafter(2.0, 3.0), np.nan]]),
        "lam": np.zeros(0),
        "table": np.zeros((0, 4)),
        "mode": np.array([1, -2], dtype=np.int64),
        "closed": np.array([True, False]),
    }
    back = load(solution(restart=restart).to_netcdf(tmp_path / "a.nc")).restart
    assert list(back) == list(restart)
    for name, array in restart.items():
        assert back[name].dtype == array.dtype
        assert back[name].shape == array.shape
        assert bits(back[name]) == bits(array)


@pytest.mark.parametrize("changes", [{"restart": {}}, {"shapes": ()}, {"aliases": {}}, {"model": {}}])
def test_what_is_empty_stays_empty(tmp_path, changes):
    back = load(solution(**changes).to_netcdf(tmp_path / "a.nc"))
    (name,) = changes
    assert len(getattr(back, name)) == 0


def test_a_run_without_instants(tmp_path):
    zeros = np.zeros(17)
    sol = solution(n=0, peaks=(zeros, zeros))
    back = load(sol.to_netcdf(tmp_path / "a.nc"))
    assert back.values.shape == (0, 17)


def test_records_longer_than_an_attribute_of_hdf5(tmp_path):
    line = tuple((float(k), 1.0 / (k + 1.0)) for k in range(5000))
    shapes = (RigidShape("gear", "", (line,)),)
    assert load(solution(shapes=shapes).to_netcdf(tmp_path / "a.nc")).shapes == shapes


def test_other_programs_read_the_signals(tmp_path):
    path = solution().to_netcdf(tmp_path / "a.nc")
    with xr.open_dataset(path, engine="h5netcdf") as file:
        force = file["P.normal_force"]
        assert force.attrs["units"] == "N"
        assert force.attrs["peak"] == pytest.approx(100.0)
        assert force.attrs["peak_time"] == 0.25
        assert file["time"].dtype == np.float64
        assert float(force.sel(time=0.5)) == pytest.approx(0.0, abs=1e-12)


def test_folders_are_made_and_an_older_file_is_replaced(tmp_path):
    path = tmp_path / "out" / "deep" / "a.nc"
    assert solution(n=5).to_netcdf(str(path)) == path
    solution(n=9).to_netcdf(path)
    assert len(load(path).time) == 9
    assert [file.name for file in path.parent.iterdir()] == ["a.nc"]


def test_a_write_that_fails_leaves_the_old_file(tmp_path):
    path = solution(n=5).to_netcdf(tmp_path / "a.nc")
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"cannot be written as JSON.*plain numbers"):
        solution(n=9, model={"name": "x", "law": object()}).to_netcdf(path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.parametrize("where", ["file.txt/a.nc", "folder"])
def test_a_path_that_cannot_be_written(tmp_path, where):
    (tmp_path / "file.txt").write_text("text")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "inside").write_text("text")
    with pytest.raises(InputError, match=f"{where}.*cannot be written.*writable folder"):
        solution().to_netcdf(tmp_path / where)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileFormatError, match=r"none\.nc.*no such file"):
        load(tmp_path / "none.nc")
    with pytest.raises(FileFormatError, match="no such file"):
        load(tmp_path)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file(tmp_path, share):
    path = solution().to_netcdf(tmp_path / "cut.nc")
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(FileFormatError, match=r"cut\.nc.*truncated"):
        load(path)


def test_a_file_that_is_no_netcdf(tmp_path):
    path = tmp_path / "text.nc"
    path.write_text("time, crank.x\n0.0, 0.1\n")
    with pytest.raises(FileFormatError, match=r"text\.nc.*no netCDF file"):
        load(path)


def test_a_netcdf_file_of_someone_else(tmp_path):
    path = tmp_path / "weather.nc"
    xr.Dataset({"wind": ("time", np.arange(3.0))}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(FileFormatError, match=r"weather\.nc.*not one of flexmb"):
        load(path)


def changed(path, change):
    """The file with `change` applied to its dataset."""
    with xr.open_dataset(path, engine="h5netcdf", decode_cf=False) as file:
        dataset = file.load()
    change(dataset).to_netcdf(path, engine="h5netcdf")
    return path


def test_a_newer_format(tmp_path):
    path = changed(solution().to_netcdf(tmp_path / "a.nc"), lambda d: d.assign_attrs(flexmb_format=99))
    with pytest.raises(FileFormatError, match=r"a\.nc.*format 99; this version of flexmb reads formats up to 2"):
        load(path)


def test_a_file_that_lacks_a_signal(tmp_path):
    path = changed(solution().to_netcdf(tmp_path / "a.nc"), lambda d: d.drop_vars("crank.x"))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged.*crank\.x"):
        load(path)


def test_a_record_that_is_no_json(tmp_path):
    path = changed(solution().to_netcdf(tmp_path / "a.nc"), lambda d: d.assign(flexmb_record=((), "{]")))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged"):
        load(path)


def test_episodes_come_back_bit_for_bit_and_can_be_read_by_others(tmp_path):
    rows = np.array([[1, 2, 0.3, 1.0, 0.1, 2.0, 3.0, 4.0, 5e-6, 0.6, -0.0], [0, 1, np.nan, np.nan, *range(7)]])
    sol = solution(contacts=ContactLog(("P", "G.upper_front"), rows))
    path = sol.to_netcdf(tmp_path / "a.nc")
    back = load(path)
    assert bits(back.contacts.rows) == bits(rows)
    assert back.contacts.names == sol.contacts.names
    with xr.open_dataset(path, engine="h5netcdf", group="episodes") as file:
        assert file["impulse"].attrs["units"] == "N s"
        assert file["start"].values.tolist() == [0.1, 0.0]
        assert file["contact"].attrs["flag_meanings"] == "P G.upper_front"


def test_contacts_without_episodes_come_back(tmp_path):
    back = load(solution(contacts=ContactLog(("P",))).to_netcdf(tmp_path / "a.nc"))
    assert back.contacts.names == ("P",)
    assert back.contacts.rows.shape == (0, 11)


def test_a_file_from_before_there_were_episodes(tmp_path):
    """Neither the group nor the names of the contacts are in it."""

    def older(dataset):
        record = json.loads(str(dataset["flexmb_record"].values[()]))
        del record["contacts"]
        return dataset.assign(flexmb_record=((), json.dumps(record)))

    back = load(changed(solution().to_netcdf(tmp_path / "a.nc"), older))
    assert back.contacts.names == ()
    assert len(back.episodes()) == 0


def test_a_file_that_lacks_its_episodes(tmp_path):
    path = changed(solution(contacts=ContactLog(("P",))).to_netcdf(tmp_path / "a.nc"), lambda d: d)  # without groups
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged"):
        load(path)


def unsealed(tmp_path, **changes):
    """A file without checksum, as earlier versions and other programs write them."""
    return changed(solution(**changes).to_netcdf(tmp_path / "old.nc"), lambda d: d)


def raised(error):
    """Raise an error, as an expression."""
    raise error


@pytest.mark.parametrize("error", [AttributeError("no attribute 'split'"), IndexError("out of range")])
def test_whatever_the_library_stumbles_over_is_a_damaged_file(tmp_path, monkeypatch, error):
    """Single wrong bytes have made the library raise these."""
    path = solution().to_netcdf(tmp_path / "a.nc")
    monkeypatch.setattr("h5py.AttributeManager.get", lambda *_: raised(error))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged"):
        load(path)


def test_damaged_bytes_of_a_file_without_checksum(tmp_path):
    """Whatever the bytes are, the file is read or refused."""
    path = unsealed(tmp_path)
    content, random = path.read_bytes(), np.random.default_rng(3)
    for _ in range(40):
        damaged = bytearray(content)
        for place in random.integers(0, len(content), size=random.integers(1, 30)):
            damaged[place] = random.integers(0, 256)
        path.write_bytes(damaged[: random.integers(1, len(content))] if random.random() < 0.2 else damaged)
        with suppress(FileFormatError):
            load(path)


def test_signals_stay_in_the_bytes_of_the_file_until_they_are_used(tmp_path, monkeypatch):
    from flexmb.results.naming import LateValues

    sol = solution()
    path = sol.to_netcdf(tmp_path / "a.nc")
    made = []
    matrix = LateValues.matrix
    monkeypatch.setattr(LateValues, "matrix", lambda self: made.append(1) or matrix(self))
    back = load(path)
    assert bits(back.array("crank.x")) == bits(sol.array("crank.x"))
    assert bits(back["crank.x"].values) == bits(sol.array("crank.x"))
    assert back.dataset.sizes["time"] == len(sol.time)
    with pytest.raises(ValueError, match="read-only"):
        back.array("crank.x")[0] = 1.0
    assert not made
    assert bits(back.values) == bits(sol.values)
    assert bits(back.array("crank.x")) == bits(sol.array("crank.x"))
    assert bits(back.values) == bits(sol.values)
    assert made == [1]
    with pytest.raises(ValueError, match="read-only"):
        back.values[0] = 1.0


def test_a_loaded_solution_does_not_need_its_file_any_more(tmp_path):
    """It may be replaced, damaged or removed, and no handle of it is open."""
    sol = solution()
    path = sol.to_netcdf(tmp_path / "a.nc")
    back = load(path)
    open_files = [link for link in Path("/proc/self/fd").glob("*") if link.exists() and link.resolve() == path]
    assert not open_files
    path.write_bytes(b"other")
    path.unlink()
    assert bits(back.values) == bits(sol.values)
    assert bits(pickle.loads(pickle.dumps(load(sol.to_netcdf(path)))).values) == bits(sol.values)  # noqa: S301 - own
    assert bits(load(back.to_netcdf(tmp_path / "b.nc")).values) == bits(sol.values)


def test_files_of_other_writers_are_read_too(tmp_path):
    """Compressed, in pieces, or with bytes in another order, as other programs write them."""
    sol = solution()
    path = sol.to_netcdf(tmp_path / "a.nc")
    with xr.open_dataset(path, engine="h5netcdf", decode_cf=False) as file:
        dataset = file.load()
    packed = {str(name): {"zlib": True, "chunksizes": (7,)} for name in sol.names}
    dataset.to_netcdf(path, engine="h5netcdf", encoding=packed)
    assert bits(load(path).values) == bits(sol.values)


def test_loading_takes_less_than_half_a_second_in_a_fresh_process(tmp_path, root):
    """150 signals; nothing that is slow to import is needed for it."""
    names = [f"rod.node{k}.x" for k in range(150)]
    values = np.arange(150.0 * 1000).reshape(1000, 150)
    peaks = (np.ones(150), np.zeros(150))
    signals, time = tuple(Signal(name, "m") for name in names), np.arange(1000.0)
    path = solution(time=time, values=values, signals=signals, peaks=peaks, aliases={}).to_netcdf(tmp_path / "a.nc")
    code = (
        "import sys, time, h5py; began = time.process_time(); import flexmb; sol = flexmb.load(sys.argv[1]); "
        "took = time.process_time() - began; slow = {'numba', 'xarray', 'scipy'} & set(sys.modules); "
        "print(took, len(sol.names), slow)"
    )
    command = [sys.executable, "-c", code, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=root, check=True)
    took, number, slow = done.stdout.split(maxsplit=2)
    assert number == "150"
    assert slow.strip() == "set()"
    assert float(took) < 0.5


def many(n_nodes, n=5):
    """A solution of a body with many nodes, one of which has a name, and of a joint."""
    axes = {"x": "m", "vy": "m/s", "theta": "rad"}
    signals = [Signal(f"plate.{node}.{axis}", unit) for axis, unit in axes.items() for node in
               ("start", *(f"node{k}" for k in range(n_nodes) if k != 7))]  # fmt: skip
    signals += [Signal("plate.node3.ax", "m/s2"), Signal("O.fx", "N")]
    random = np.random.default_rng(5)
    peaks = (random.random(len(signals)), random.random(len(signals)))
    values = random.normal(size=(n, len(signals)))
    return solution(time=np.arange(float(n)), values=values, signals=signals, peaks=peaks, aliases={}, shapes=())


def test_bodies_with_many_nodes_have_one_variable_a_quantity(tmp_path, monkeypatch):
    """The number of variables does not grow with that of the nodes, and lists of variables are written once."""
    made, attached, dimension = [], [], h5py._hl.dims.DimensionProxy
    create, attach = h5py.Group.create_dataset, dimension.attach_scale
    monkeypatch.setattr(h5py.Group, "create_dataset", lambda *a, **k: made.append(1) or create(*a, **k))
    monkeypatch.setattr(dimension, "attach_scale", lambda *a: attached.append(a) or attach(*a))
    sol = many(1000)
    path = sol.to_netcdf(tmp_path / "a.nc")
    assert len(sol.names) == 3002
    assert len(made) < 30
    assert len(attached) < 20
    attached.clear()
    solution(restart={}).to_netcdf(tmp_path / "b.nc")
    assert not attached
    back = load(path)
    for name in ("time", "values"):
        assert bits(getattr(back, name)) == bits(getattr(sol, name))
    assert bits(back.peaks.values) == bits(sol.peaks.values)
    assert bits(back.peaks.times) == bits(sol.peaks.times)
    assert back.signals == sol.signals
    assert bits(load(back.to_netcdf(path)).values) == bits(sol.values)


def test_other_programs_read_bodies_with_many_nodes(tmp_path):
    sol = many(200)
    with xr.open_dataset(sol.to_netcdf(tmp_path / "a.nc"), engine="h5netcdf") as file:
        table = file["plate.node.vy"]
        assert table.dims == ("time", "plate.node")
        assert table.attrs == {"units": "m/s", "long_name": "velocity along y of plate node"}
        for k in (0, 8, 199):
            name = f"plate.node{k}.vy"
            assert bits(table.sel({"plate.node": k})) == bits(sol.array(name))
            assert float(file["plate.node.vy.peak"].sel({"plate.node": k})) == sol.peak(name).value
            assert float(file["plate.node.vy.peak_time"].sel({"plate.node": k})) == sol.peak(name).time
        assert bits(file["plate.start.x"]) == bits(sol.array("plate.start.x"))
        assert bits(file["plate.node3.ax"]) == bits(sol.array("plate.node3.ax"))  # saved at one node alone
        assert file.attrs["flexmb_format"] == 2


def test_tables_that_do_not_fit_are_a_damaged_file(tmp_path):
    path = many(200).to_netcdf(tmp_path / "a.nc")
    changed(path, lambda d: d.isel({"plate.node": slice(0, 150)}))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged.*node151"):
        load(path)
    changed(many(200).to_netcdf(path), lambda d: d.assign({"plate.node.x": d["plate.node.x"].astype(np.float32)}))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged.*float32"):
        load(path)
