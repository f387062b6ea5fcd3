"""A solution as netCDF: back bit for bit, readable by others, honest about files it cannot read."""

import json
import pickle
import re
import runpy
import shutil
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
from flexmb.results.netcdf import load, udunits
from flexmb.results.solution import Stats

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
solution = handmade["solution"]


def bits(array):
    return np.asarray(array).tobytes()


def test_other_programs_read_the_signals(tmp_path):
    """Values over time and signal; names, units, long names and peaks go along with them."""
    sol = solution()
    with xr.open_dataset(sol.to_netcdf(tmp_path / "a.nc"), engine="h5netcdf") as file:
        values = file["values"]
        assert values.dims == ("time", "signal")
        assert values["signal"].values.tolist() == list(sol.names)
        assert file["time"].dtype == np.float64
        for name in sol.names:
            one, peak = values.sel(signal=name), sol.peak(name)
            assert bits(one.values) == bits(sol.array(name))
            assert str(one["units"].values) == udunits(sol.units(name))
            assert str(one["long_name"].values) == sol[name].attrs["long_name"]
            assert (float(one["peak"]), float(one["peak_time"])) == (peak.value, peak.time)
        assert float(values.sel(signal="P.normal_force", time=0.5)) == pytest.approx(0.0, abs=1e-12)


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
    with pytest.raises(FileFormatError, match=r"a\.nc.*format 99; this version of flexmb reads formats up to 3"):
        load(path)


def test_a_file_that_lacks_signals(tmp_path):
    path = changed(solution().to_netcdf(tmp_path / "a.nc"), lambda d: d.isel(signal=slice(1, None)))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged.*'values' has shape \(101, 16\).*101 x 17 floats"):
        load(path)
    path = changed(solution().to_netcdf(path), lambda d: d.drop_vars("peak"))
    with pytest.raises(FileFormatError, match=r"a\.nc.*damaged.*peak"):
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


def record(**changes):
    """A change of the record of a dataset."""

    def change(dataset):
        found = json.loads(str(dataset["flexmb_record"].values))
        return dataset.assign(flexmb_record=((), json.dumps({**found, **changes})))

    return change


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda d: d.assign_coords(time=np.full(101, np.nan)), "'time' has values that are not finite"),
        (lambda d: d.assign_coords(time=np.full(101, np.inf)), "'time' has values that are not finite"),
        (lambda d: d.assign_coords(signal=d["signal"].values[::-1]), "other names, or another order"),
        (record(ok="no"), "they must be a truth value and a text"),
        (record(ok=7), "they must be a truth value and a text"),
        (record(status=5), "they must be a truth value and a text"),
        (record(stats={"steps": -1}), "statistics of the run are {'steps': -1}"),
        (record(stats={"steps": "x"}), "statistics of the run are {'steps': 'x'}"),
        (lambda d: d.assign(flexmb_record=("line", ["{}", "{}"])), "has 2 values; it must be one text"),
        (lambda d: d.assign_attrs(flexmb_format=np.inf), "cannot be read as a solution"),
    ],
)
def test_a_crafted_file_without_checksum(tmp_path, change, told):
    """What no run has written is refused: numbers would come back under other names, or a failed run as a good one."""
    path = changed(solution().to_netcdf(tmp_path / "a.nc"), change)
    with pytest.raises(FileFormatError, match=re.escape(told)):
        load(path)


def test_a_name_that_is_too_long(tmp_path):
    with pytest.raises(FileFormatError, match=r"File name too long"):
        load(tmp_path / ("x" * 300 + ".nc"))


def test_nobody_can_write_to_what_was_loaded(tmp_path):
    sol = solution()
    back = load(sol.to_netcdf(tmp_path / "a.nc"))
    assert bits(back["crank.x"].values) == bits(sol.array("crank.x"))
    for array in (back.values, back.array("crank.x"), back.time):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


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
    dataset.to_netcdf(path, engine="h5netcdf", encoding={"values": {"zlib": True, "chunksizes": (7, 5)}})
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


def test_the_number_of_variables_does_not_grow_with_the_signals(tmp_path, monkeypatch):
    made, attached, dimension = [], [], h5py._hl.dims.DimensionProxy
    create, attach = h5py.Group.create_dataset, dimension.attach_scale
    monkeypatch.setattr(h5py.Group, "create_dataset", lambda *a, **k: made.append(1) or create(*a, **k))
    monkeypatch.setattr(dimension, "attach_scale", lambda *a: attached.append(a) or attach(*a))
    sol = many(1000)
    path = sol.to_netcdf(tmp_path / "a.nc")
    assert len(sol.names) == 3002
    assert len(made) < 20
    assert len(attached) < 20
    back = load(path)
    for name in ("time", "values"):
        assert bits(getattr(back, name)) == bits(getattr(sol, name))
    assert bits(back.peaks.values) == bits(sol.peaks.values)
    assert bits(back.peaks.times) == bits(sol.peaks.times)
    assert back.signals == sol.signals
    assert bits(load(back.to_netcdf(path)).values) == bits(sol.values)


# Files of former formats: a variable for each signal, and for each quantity at the nodes of bodies with many nodes


def former(path, sol, tables=()):
    """The solution as a file of format 1, or, with tables such as "plate.node.vy", of format 2."""
    new = sol.to_netcdf(path)
    with xr.open_dataset(new, engine="h5netcdf", decode_cf=False) as file:
        record = json.loads(str(file["flexmb_record"].values[()]))
    variables, left = {}, list(sol.names)
    for table in tables:
        stem, _, quantity = table.rpartition(".")
        names = [name for name in left if name.startswith(stem) and name.endswith(f".{quantity}")]
        peaks = np.array([sol.peak(name) for name in names])
        variables[table] = ("time", stem), np.stack([sol.array(name) for name in names], axis=1)
        variables[f"{table}.peak"], variables[f"{table}.peak_time"] = (stem, peaks[:, 0]), (stem, peaks[:, 1])
        variables[stem] = stem, np.array([int(name[len(stem) :].partition(".")[0]) for name in names])
        left = [name for name in left if name not in names]
    for name in left:
        value, time = sol.peak(name)
        variables[name] = "time", sol.array(name), {"units": sol.units(name), "peak": value, "peak_time": time}
    record = json.dumps({**record, "node_tables": list(tables)} if tables else record)
    attrs = {"flexmb_format": 2 if tables else 1}
    dataset = xr.Dataset({"flexmb_record": ((), record), **variables}, {"time": sol.time}, attrs)
    dataset.to_netcdf(path, engine="h5netcdf", encoding={name: {"_FillValue": None} for name in dataset.variables})
    return path


TABLES = ("plate.node.x", "plate.node.vy", "plate.node.theta")


@pytest.mark.parametrize("tables", [(), TABLES])
def test_files_of_former_formats_are_read_bit_for_bit(tmp_path, tables):
    sol = many(130 if tables else 20)
    back = load(former(tmp_path / "a.nc", sol, tables))
    assert bits(back.time) == bits(sol.time)
    assert bits(back.values) == bits(sol.values)
    assert bits(back.peaks.values) == bits(sol.peaks.values)
    assert bits(back.peaks.times) == bits(sol.peaks.times)
    assert back.signals == sol.signals
    assert back.restart == {}  # the file has no such group


def test_former_files_that_do_not_fit_are_damaged(tmp_path):
    path, whole = tmp_path / "a.nc", former(tmp_path / "whole.nc", many(130), TABLES)
    for change, words in (
        (lambda d: d.drop_vars("O.fx"), "O.fx"),
        (lambda d: d.isel({"plate.node": slice(0, 100)}), "node101"),
        (lambda d: d.assign({"plate.node.x": d["plate.node.x"].astype(np.float32)}), "float32"),
    ):
        changed(shutil.copy(whole, path), change)
        with pytest.raises(FileFormatError, match=rf"a\.nc.*damaged.*{words}"):
            load(path)
