"""Runs killed at any instant and files damaged anywhere: the same bits in the end, or an error with a name."""

import io
import os
import random
import signal
import time
from functools import partial

import h5py
import numpy as np
import pytest
from damage import crank, damaged, servo

import flexmb as fm
from flexmb.dynamics.jobs import files
from flexmb.errors import FileFormatError, FlexmbError
from flexmb.run import run as run_module

FEW_OR_MANY = [10, pytest.param(200, marks=pytest.mark.slow)]


def same(one, other):
    """Whether two runs are equal to the last bit."""
    assert one.ok
    assert one.status == other.status
    assert one.notes == other.notes
    for name in ("time", "values"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert np.array_equal(one.peaks.values, other.peaks.values)
    assert np.array_equal(one.contacts.rows, other.contacts.rows, equal_nan=True)
    assert all(np.array_equal(one.restart[name], other.restart[name], equal_nan=True) for name in other.restart)


@pytest.mark.parametrize(
    ("run", "kills"),
    [
        (crank, 6),
        pytest.param(servo, 4, marks=pytest.mark.slow),
        pytest.param(crank, 200, marks=pytest.mark.slow),
        pytest.param(servo, 200, marks=pytest.mark.slow),
    ],
)
def test_killed_at_random_instants_runs_end_with_the_same_bits(tmp_path, monkeypatch, run, kills):
    """kill -9, a fork each; a run is resumed and killed again until it ends before the next kill."""
    monkeypatch.setattr(run_module, "BLOCK_SECONDS", 1e-3 if kills > 10 else 1e-2)
    monkeypatch.setattr(run_module, "FIRST_BLOCK_UPDATES", 200 if kills > 10 else 2000)
    checkpoint, result = tmp_path / "run.checkpoint.nc", tmp_path / "run.nc"
    whole, rng, done, resumed = run(), random.Random(kills), 0, 0
    options = {"checkpoint": checkpoint, "checkpoint_every": 0.0 if run is crank else 0.01}
    run(**options)  # imports what writes files
    began = time.perf_counter()
    run(**options)
    longest = time.perf_counter() - began
    while done < kills or checkpoint.is_file():
        resumed += checkpoint.is_file()
        child = os.fork()
        if not child:
            try:
                run(**options, resume=True).to_netcdf(result)
            finally:
                os._exit(0)
        ended, status, until = 0, 0, time.monotonic() + rng.uniform(0.0, 0.9 * longest)
        awaited = kills <= 10 and not checkpoint.is_file()  # few kills hit runs that can go on
        while not ended and (done >= kills or time.monotonic() < until or (awaited and not checkpoint.is_file())):
            time.sleep(1e-3)
            ended, status = os.waitpid(child, os.WNOHANG)
        if not ended:
            os.kill(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
        done += os.WIFSIGNALED(status)
        if not os.WIFSIGNALED(status):
            same(fm.load(result), whole)
            result.unlink()
    assert resumed > kills // 20  # kills hit runs that had a checkpoint
    print(f"{run.__name__}: {done} kills, {resumed} runs resumed, {longest:.2f} s a run")


@pytest.mark.parametrize("copies", FEW_OR_MANY)
def test_damaged_results_are_refused_or_hold_the_same_numbers(tmp_path, copies):
    whole = crank()
    path = whole.to_netcdf(tmp_path / "run.nc")
    content, rng, refused = path.read_bytes(), random.Random(copies), 0
    for _ in range(copies):
        path.write_bytes(damaged(content, rng))
        try:
            same(fm.load(path), whole)
        except FileFormatError:
            refused += 1
    assert refused >= 0.7 * copies  # the others hold the same numbers
    print(f"{refused} of {copies} damaged results refused")


@pytest.mark.parametrize("copies", FEW_OR_MANY)
def test_damaged_checkpoints_and_restarts_are_refused_or_go_on_with_the_same_bits(tmp_path, monkeypatch, copies):
    whole, half = crank(), tmp_path / "half.nc"
    path = _checkpoint(tmp_path, monkeypatch)
    content, rng, refused = path.read_bytes(), random.Random(copies), 0
    for _ in range(copies):
        path.write_bytes(damaged(content, rng))
        try:
            same(crank(checkpoint=path, resume=True), whole)
        except FileFormatError as error:
            refused += "Remove this checkpoint" in str(error)
        half.write_bytes(path.read_bytes() if path.is_file() else b"")
        try:
            fm.load(half)
        except FileFormatError:
            continue
    assert refused >= 0.7 * copies  # the others hold the same numbers
    print(f"{refused} of {copies} damaged checkpoints refused")


def _checkpoint(folder, monkeypatch):
    """A checkpoint in the middle of a run."""
    path, count = folder / "run.checkpoint.nc", []
    with monkeypatch.context() as context:
        context.setattr(run_module, "BLOCK_SECONDS", 1e-3)
        context.setattr(run_module, "FIRST_BLOCK_UPDATES", 200)

        def stop(checkpoints, run):
            count.append(1)
            if len(count) == 5:
                checkpoints.write(run)
                raise KeyboardInterrupt

        context.setattr("flexmb.run.checkpoint.Checkpoints.after_block", stop)
        assert not crank(checkpoint=path).ok
    return path


CRAFTED = (np.nan, np.inf, -np.inf, -1.0, 0.5, 3.0, 1e3, 1e9, -1e15, 1e18, 1e300)
"""Values that a forger may write into any number of a restart or a checkpoint."""


@pytest.mark.quick(1)
@pytest.mark.parametrize("method", [None, fm.RadauIIA()], ids=["Newmark", "Radau"])
@pytest.mark.parametrize("copies", FEW_OR_MANY)
def test_forged_numbers_of_a_restart_never_leave_the_memory(tmp_path, monkeypatch, copies, method):
    """Each copy in a process of its own, since one beyond its arrays would end this one."""
    mechanism, rng = fm.mechanisms.slider_crank(clearance=5e-4), random.Random(copies)
    restart = fm.simulate(mechanism, periods=0.02, save=5, method=method).restart
    names = [name for name in restart if name != "model"]
    for _ in range(copies):
        forged = {name: array.copy() for name, array in restart.items()}
        for _ in range(rng.choice((1, 1, 5))):
            array = forged[rng.choice(names)]
            if array.size:
                array.flat[rng.randrange(array.size)] = rng.choice(CRAFTED)
        if rng.random() < 0.1:
            forged[rng.choice(names)] = rng.choice((np.zeros(0), np.array("text"), np.zeros((3, 3)), np.array([1j])))
        options = {"periods": 0.021, "save": 5, "method": method, "max_steps": 200}
        _in_a_process(partial(fm.simulate, mechanism, restart=forged, **options))


@pytest.mark.parametrize("value", [1e18, 1e300])
def test_a_restart_that_begins_to_save_after_its_present_is_refused(value):
    """Instants of its grid were due for ever."""
    mechanism = fm.mechanisms.slider_crank(clearance=5e-4)
    found = fm.simulate(mechanism, periods=0.02, save=5).restart
    restart = {**found, "clock": found["clock"].copy()}
    restart["clock"][2] = value
    with pytest.raises(FlexmbError, match="a begin of saving after the present"):
        fm.simulate(mechanism, periods=0.021, save=5, restart=restart)


COUNTERS = ("count", "poses.number", "predictor", "report", "reuse", "clock")


@pytest.mark.slow
@pytest.mark.parametrize("copies", FEW_OR_MANY)
def test_forged_counters_of_a_checkpoint_never_leave_the_memory(tmp_path, monkeypatch, copies):
    path = _checkpoint(tmp_path, monkeypatch)
    content, rng = path.read_bytes(), random.Random(copies)
    content = content[: -files.DIGEST - len(files.SEAL)]
    for k in range(copies):
        image = io.BytesIO(content)
        with h5py.File(image, "r+") as file:
            numbers = file["restart"][COUNTERS[k % len(COUNTERS)]]
            values = numbers[:].ravel()
            values[rng.randrange(values.size)] = rng.choice(CRAFTED)
            numbers[...] = values.reshape(numbers.shape)
        files.write_sealed(path, image.getvalue())
        _in_a_process(lambda: crank(checkpoint=path, resume=True, max_steps=20_000))


def _in_a_process(run):
    """Call a function in a fork: it may return or raise an error with a name, within 20 s."""
    child = os.fork()
    if not child:
        signal.alarm(20)
        code = 3
        try:
            run()
            code = 0
        except FlexmbError:
            code = 0
        except BaseException as error:
            print(f"raw error: {type(error).__name__}: {error}", flush=True)
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    assert status == 0, f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "a raw error"


OUTER = {
    "external link": lambda file, secret: file.__setitem__("values", h5py.ExternalLink(str(secret), "/values")),
    "soft link": lambda file, _: file.__setitem__("values", h5py.SoftLink("/restart/signals")),
    "linked group": lambda file, secret: file.__setitem__("restart", h5py.ExternalLink(str(secret), "/restart")),
    "raw data": lambda file, secret: file.create_dataset(
        "values", shape=_size(file), dtype="f8", external=[(str(secret), 0, h5py.h5f.UNLIMITED)]
    ),
    "text": lambda file, secret: file.create_dataset(
        "flexmb_record", shape=(1,), dtype="S64", external=[(str(secret), 0, 64)]
    ),
    "virtual": lambda file, secret: file.create_virtual_dataset("values", _virtual(file, secret)),
}


def _size(file):
    """Number of instants and of signals."""
    return len(file["time"]), len(file["signal"])


def _virtual(file, secret):
    layout = h5py.VirtualLayout(shape=_size(file), dtype="f8")
    layout[:] = h5py.VirtualSource(str(secret), "values", shape=_size(file))
    return layout


@pytest.fixture(scope="module")
def secret(tmp_path_factory):
    """A result of somebody else."""
    return crank().to_netcdf(tmp_path_factory.mktemp("secret") / "secret.nc")


@pytest.mark.parametrize("kind", OUTER)
def test_a_result_that_leads_to_another_file_is_refused(tmp_path, secret, kind):
    """External links, raw data and virtual data sets of HDF5 would be read from the disk of the reader."""
    path = tmp_path / "run.nc"
    image = io.BytesIO(secret.read_bytes()[: -files.DIGEST - len(files.SEAL)])
    with h5py.File(image, "r+") as file:
        del file[{"linked group": "restart", "text": "flexmb_record"}.get(kind, "values")]
        OUTER[kind](file, secret)
    files.write_sealed(path, image.getvalue())
    with pytest.raises(FileFormatError, match=r"run\.nc.*leads to another file"):
        fm.load(path).array("slider.x")
    with pytest.raises(FileFormatError, match="leads to another file"):
        files.load_netcdf(path)
