"""The same bytes from any executor, after any kill, and nothing else accepted in their place."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import slow_where
from sweep_models import bistable, content, logistic, logistic_map, mortal_map, results, slow_map, slow_results

import flexmb as fm
from flexmb.dynamics.sweeps.store import SEAL, _sealed
from flexmb.dynamics.systems.given import Map

VALUES = np.linspace(2.8, 3.9, 23)  # 3.3 fails
CARRIED = {"skip": 60, "keep": 20, "direction": "both", "chunks": 3}
GRID = {"a": [2, 1, 3], "b": [5.0, 6.0]}


def diagram(store, make=logistic_map, values=VALUES, **changes):
    return fm.bifurcation(make, "r", values, store=store, **{**CARRIED, **changes})


def pools():
    return {
        "one process": lambda: ProcessPoolExecutor(1),
        "two processes": lambda: ProcessPoolExecutor(2, mp_context=get_context("spawn")),
        "threads": lambda: ThreadPoolExecutor(3),
    }


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """A store that was written without any executor, and its dataset."""
    path = tmp_path_factory.mktemp("reference") / "r.zarr"
    return path, diagram(path)


@pytest.fixture(
    scope="module",
    params=slow_where(lambda n: n != "threads", pools()),
)
def pool(request):
    """An executor; what its processes import serves both tests."""
    with pools()[request.param]() as made:
        yield made


def test_any_executor_writes_the_same_bytes(pool, reference, tmp_path):
    path, dataset = reference
    found = diagram(tmp_path / "s.zarr", executor=pool, pending=3)
    assert found.identical(dataset)
    assert content(tmp_path / "s.zarr") == content(path)


def test_a_function_over_a_grid_does_too(pool, tmp_path):
    alone = fm.sweep(results, GRID, store=tmp_path / "alone.zarr")
    found = fm.sweep(results, GRID, store=tmp_path / "s.zarr", executor=pool)
    assert found.identical(alone)
    assert content(tmp_path / "s.zarr") == content(tmp_path / "alone.zarr")


@pytest.mark.slow
def test_a_mechanism_does_too(tmp_path):
    settings = {"skip": 2, "keep": 3, "direction": "up", "chunks": 2, "period": 2.0 * np.pi}
    pools = {"alone": None, "threads": 2, "more threads": np.int64(5), "pool": ProcessPoolExecutor(2)}
    for name, pool in pools.items():
        fm.bifurcation(
            bistable(), "well.amplitude", [0.1, 0.2, 0.3, 0.4], store=tmp_path / name, executor=pool, **settings
        )
    pool.shutdown()
    for name in ("threads", "more threads", "pool"):
        assert content(tmp_path / "alone") == content(tmp_path / name)


@pytest.mark.slow
def test_a_dask_cluster_writes_the_same_bytes(reference, tmp_path):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        found = diagram(tmp_path / "s.zarr", executor=client.get_executor())
        assert len(client.scheduler_info()["workers"]) == 2
        shift = 1.0  # a lambda with a value from around it: Dask sends functions by value
        added = fm.sweep(lambda a: a + shift, {"a": [1.0, 2.0]}, executor=client.get_executor())
    assert found.identical(reference[1])
    assert content(tmp_path / "s.zarr") == content(reference[0])
    assert added["value"].values.tolist() == [2.0, 3.0]


SCRIPT = """
import sys
from concurrent.futures import ProcessPoolExecutor
import numpy as np
import flexmb as fm
from sweep_models import slow_map, slow_results

if __name__ == "__main__":
    kind, store, workers = sys.argv[1:]
    with ProcessPoolExecutor(int(workers)) as pool:
        if kind == "diagram":
            fm.bifurcation(slow_map, "r", np.linspace(2.8, 3.9, 23), skip=60, keep=20, direction="both", chunks=3,
                           executor=pool, store=store, resume=True)
        else:
            fm.sweep(slow_results, {"a": [2, 1, 3], "b": np.linspace(5.0, 6.0, 9)},
                     executor=pool, store=store, resume=True)
"""


def finished(store):
    return len([file for file in (store / "status" / "c").rglob("*") if file.is_file()]) if store.exists() else 0


def killed(command, store, points):
    """Run the command until so many points are finished, then kill it and its workers at once."""
    process = subprocess.Popen(command, start_new_session=True)
    deadline = time.monotonic() + 60.0
    while finished(store) < points and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.002)
    was_running = process.poll() is None
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return was_running


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "workers"), [("diagram", 1), ("diagram", 2), ("sweep", 2)])
def test_killed_and_gone_on_with(kind, workers, tmp_path):
    script, store, whole = tmp_path / "run.py", tmp_path / "s.zarr", tmp_path / "whole.zarr"
    script.write_text(SCRIPT)
    command = [sys.executable, str(script), kind, str(store), str(workers)]
    assert killed(command, store, 3)
    first = finished(store)
    assert killed(command, store, first + 6)
    second = finished(store)
    assert 3 <= first < second < (46 if kind == "diagram" else 27)
    if kind == "diagram":
        diagram(whole, slow_map, fixed={})
    else:
        fm.sweep(slow_results, {"a": [2, 1, 3], "b": np.linspace(5.0, 6.0, 9)}, store=whole)
    subprocess.run(command, check=True)
    assert content(store) == content(whole)


@pytest.mark.slow
def test_fifty_kills_of_a_sweep(tmp_path):
    """SIGKILL at 50 random moments of one sweep, workers included: the store ends with the bytes of an unbroken one."""
    script, store, whole = tmp_path / "run.py", tmp_path / "s.zarr", tmp_path / "whole.zarr"
    script.write_text(SCRIPT.replace("np.linspace(5.0, 6.0, 9)", "np.linspace(5.0, 6.0, 700)"))
    command, rng = [sys.executable, str(script), "sweep", str(store), "2"], np.random.default_rng(3)
    kills, seen = 0, [0]
    while kills < 50 and seen[-1] < 2100:
        process = subprocess.Popen(command, start_new_session=True)
        if kills % 2:  # at work: a slow machine may need seconds to begin
            deadline = time.monotonic() + 60.0
            while finished(store) <= seen[-1] and process.poll() is None and time.monotonic() < deadline:
                time.sleep(0.01)
        time.sleep(rng.uniform(0.0, 1.0) if kills % 2 else rng.uniform(0.3, 3.0))
        kills += process.poll() is None
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        seen.append(finished(store))
    assert kills == 50
    assert seen == sorted(seen)  # no finished point is ever lost
    assert len(set(seen)) > 5
    subprocess.run(command, check=True)
    fm.sweep(slow_results, {"a": [2, 1, 3], "b": np.linspace(5.0, 6.0, 700)}, store=whole)
    assert content(store) == content(whole)


@pytest.mark.slow
def test_every_state_of_a_killed_write_is_gone_on_with(reference, tmp_path):
    """Any file may be missing, and a temporary one may be left: the store ends with the same bytes."""
    path, dataset = reference
    whole, store = content(path), tmp_path / "s.zarr"
    rng = np.random.default_rng(0)
    for _ in range(2):
        shutil.copytree(path, store)
        points = [(0, k) for k in range(len(VALUES))] + [(1, k) for k in range(len(VALUES))]
        for row, k in rng.permutation(points)[:7]:  # the status is written last: without it nothing else counts
            (store / "status" / "c" / str(row) / str(k)).unlink()
            for column in ("points", "verdict", "ok"):
                found = next((file for file in (store / column / "c" / str(row) / str(k)).rglob("*")), None)
                chunk = found if found is not None else store / column / "c" / str(row) / str(k)
                if chunk.is_file() and rng.random() < 0.5:
                    chunk.write_bytes(rng.bytes(len(chunk.read_bytes()))) if column == "points" else chunk.unlink()
        (store / "points" / "c" / "0" / "5.4711.partial").write_bytes(b"half")
        assert diagram(store, resume=True).identical(dataset)
        assert content(store) == whole
        shutil.rmtree(store)


@pytest.mark.slow
def test_killed_before_there_was_a_store(reference, tmp_path):
    for leftover in ([], ["zarr.json.0815.partial"]):
        store = tmp_path / f"s{len(leftover)}.zarr"
        store.mkdir()
        for name in leftover:
            (store / name).write_bytes(b"{")
        diagram(store, resume=True)
        assert content(store) == content(reference[0])


@pytest.mark.slow
def test_killed_while_it_was_laid_out(reference, tmp_path):
    for gone in ("points", "r", "state"):
        store = tmp_path / "s.zarr"
        shutil.copytree(reference[0], store)
        shutil.rmtree(store / gone)
        shutil.rmtree(store / "status", ignore_errors=True)
        diagram(store, resume=True)
        assert content(store) == content(reference[0])
        shutil.rmtree(store)


@pytest.mark.slow
def test_a_store_can_be_read_by_others(reference):
    path, dataset = reference
    raw = xr.open_zarr(path, consolidated=False).load()
    np.testing.assert_array_equal(raw["points"].isel(signal=0).values, dataset["x0"].values)
    assert raw["status"].values.tolist() == dataset["status"].values.tolist()
    assert raw["seam"].values.tolist() == dataset["seam"].values.tolist()
    assert fm.sweeps.load_sweep(path).identical(dataset)


def test_nothing_in_a_store_says_when_and_where(reference):
    host, user = os.uname().nodename, str(Path.home())
    everything = b"".join(content(reference[0]).values())
    assert host.encode() not in everything
    assert user.encode() not in everything
    assert str(reference[0]).encode() not in everything


def test_a_finished_store_computes_nothing(reference, tmp_path):
    store = tmp_path / "s.zarr"
    shutil.copytree(reference[0], store)
    before = {file: file.stat().st_mtime_ns for file in store.rglob("*/c/**/*") if "points" in str(file)}
    began = time.perf_counter()
    assert diagram(store, resume=True).identical(reference[1])
    assert time.perf_counter() - began < 2.0
    assert before == {file: file.stat().st_mtime_ns for file in before}


def test_a_store_is_not_overwritten(reference):
    with pytest.raises(fm.errors.InputError, match=r"it is there already.*resume=True"):
        diagram(reference[0])


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"skip": 61}, "skip: 60 there, 61 now"),
        ({"keep": 21}, "keep: 20 there, 21 now"),
        ({"values": VALUES + 1e-15}, "values: 23 from"),
        ({"fixed": {"start": 0.4}}, "fixed"),
        ({"direction": "up"}, "direction: both there, up now"),
        ({"chunks": 2}, "chunks"),
        ({"exponent": 100}, "exponent"),
        ({"make": slow_map}, "make: sweep_models.logistic_map there, sweep_models.slow_map now"),
        ({"make": Map(logistic, [0.3], parameters={"r": 3.0})}, "make"),
    ],
)
def test_the_store_of_another_sweep_is_refused(changes, named, reference):
    before = content(reference[0])
    with pytest.raises(fm.errors.InputError, match="written by another sweep") as error:
        diagram(reference[0], resume=True, **changes)
    assert named in str(error.value)
    assert content(reference[0]) == before


def test_the_store_of_another_version_is_refused(reference, tmp_path):
    store = tmp_path / "s.zarr"
    shutil.copytree(reference[0], store)
    attributes = json.loads((store / "zarr.json").read_text())
    attributes["attributes"]["fingerprint"]["flexmb"] = "0.0.1"
    del attributes["attributes"][SEAL]
    (store / "zarr.json").write_bytes(_sealed(attributes))
    with pytest.raises(fm.errors.InputError, match=r"flexmb: 0\.0\.1 there"):
        diagram(store, resume=True)
    attributes["attributes"]["flexmb_sweep_format"] = 99
    (store / "zarr.json").write_text(json.dumps(attributes))
    with pytest.raises(fm.errors.FileFormatError, match="format 99"):
        diagram(store, resume=True)


def test_a_mechanism_with_another_number_is_another_model(tmp_path):
    settings = {"skip": 1, "keep": 2, "period": 6.0, "store": tmp_path / "s"}
    fm.bifurcation(bistable(), "well.amplitude", [0.1], **settings)
    other = bistable().with_({"mass.mass": np.nextafter(1.0, 2.0)})
    with pytest.raises(fm.errors.InputError, match="model: "):
        fm.bifurcation(other, "well.amplitude", [0.1], resume=True, **settings)


def test_other_folders_are_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(fm.errors.FileFormatError, match="holds other files"):
        diagram(tmp_path, resume=True)
    with pytest.raises(fm.errors.FileFormatError, match="a file"):
        diagram(tmp_path / "notes.txt")
    xr.Dataset({"x": ("t", np.zeros(2))}).to_zarr(tmp_path / "x.zarr", zarr_format=3, consolidated=False)
    with pytest.raises(fm.errors.FileFormatError, match="not one of flexmb"):
        diagram(tmp_path / "x.zarr", resume=True)
    with pytest.raises(fm.errors.FileFormatError, match="there is none"):
        fm.sweeps.load_sweep(tmp_path / "nothing")
    (tmp_path / "y.zarr").mkdir()
    (tmp_path / "y.zarr" / "zarr.json").write_text("{")
    with pytest.raises(fm.errors.FileFormatError, match="cannot be read"):
        diagram(tmp_path / "y.zarr", resume=True)
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.quick(1)
@pytest.mark.parametrize("file", ["points/zarr.json", "points/c/0/0/0/0", "status/c/0/0", "ok/c/0/0"])
def test_a_damaged_store_is_refused_by_name(reference, tmp_path, file):
    """Chunks and descriptions are renamed into place, so only a failing disk or another program cuts them short."""
    path = shutil.copytree(reference[0], tmp_path / "r.zarr")
    (path / file).write_bytes((path / file).read_bytes()[:-1])
    with pytest.raises(fm.errors.FileFormatError, match=r"r.zarr': cannot be read .* Delete it"):
        diagram(path, resume=True)
    with pytest.raises(fm.errors.FileFormatError, match="cannot be read"):
        fm.sweeps.load_sweep(path)


def test_workers_that_die_leave_a_store_to_go_on_with(tmp_path):
    flag, settings = tmp_path / "flag", {"skip": 5, "keep": 2, "pending": 2, "store": tmp_path / "s"}
    flag.write_text("")
    values = [2.5, 2.6, 3.0, 3.1, 3.2]  # computed from both ends inwards
    with ProcessPoolExecutor(1) as pool, pytest.raises(fm.errors.WorkerError, match="resume=True"):
        fm.bifurcation(mortal_map, "r", values, fixed={"flag": str(flag)}, executor=pool, **settings)
    part = fm.sweeps.load_sweep(tmp_path / "s")
    assert part["ok"].values.tolist() == [True, False, False, False, True]
    assert part["status"].values[2] == ""
    flag.unlink()
    found = fm.bifurcation(mortal_map, "r", values, fixed={"flag": str(flag)}, resume=True, **settings)
    assert found["ok"].values.all()
    settings["store"] = tmp_path / "whole"
    fm.bifurcation(mortal_map, "r", values, fixed={"flag": str(flag)}, **settings)
    assert content(tmp_path / "s") == content(tmp_path / "whole")


def test_a_pool_that_was_shut_down():
    pool = ProcessPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(fm.errors.WorkerError, match="after shutdown"):
        fm.sweep(slow_results, GRID, executor=pool)


@pytest.mark.slow
def test_digests_do_not_depend_on_the_process(capsys):
    """Here, and in a process whose sets are ordered by another seed."""
    code = (
        "from flexmb.dynamics.sweeps.store import digest\n"
        "from flexmb.dynamics.systems.mechanism_flow import MechanismFlow\n"
        "import sweep_models as m, flexmb as fm\n"
        "print(digest(MechanismFlow(m.bistable(), period=6.0)), digest(m.results), digest({'b': {1, 2}, 'a': 'x'}),"
        "digest(MechanismFlow(fm.mechanisms.slider_crank(clearance=1e-4))))"
    )
    other = {**os.environ, "PYTHONHASHSEED": "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"}
    there = subprocess.run([sys.executable, "-c", code], env=other, check=True, capture_output=True, text=True).stdout
    exec(code, {})
    assert capsys.readouterr().out == there
