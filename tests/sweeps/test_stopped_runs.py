"""A point succeeds only if every run in it has reached its end; Ctrl-C ends a sweep and stores nothing of its point."""

import os
import signal
import subprocess
import sys
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from cases import slow_where
from sweep_models import CARELESS, bistable, careless, content, interrupted_once, named_by_itself, started_by_a_run

import flexmb as fm


def pools():
    return {
        "alone": lambda: None,
        "threads": lambda: 2,
        "pool of threads": lambda: ThreadPoolExecutor(2),
        "processes": lambda: ProcessPoolExecutor(2, mp_context=get_context("spawn")),
    }


@pytest.mark.parametrize("name", slow_where(lambda n: n == "processes", pools()))
def test_a_run_that_stops_early_fails_its_point(name, tmp_path):
    """The function returns what it read from two runs; the second of them stops early at 40 steps."""
    pool = pools()[name]()
    found = fm.sweep(careless, {"most": CARELESS}, executor=pool, store=tmp_path / "s")
    if isinstance(pool, Executor):
        pool.shutdown()
    assert found["ok"].values.tolist() == [True, False, True, False]
    assert found["status"].values[0] == "done"
    assert "A run did not reach its end: simulate 'slider-crank': Stopped after 40" in found["status"].values[1]
    assert np.isfinite(found["x"].values).tolist() == [True, False, True, False]
    assert fm.sweeps.load_sweep(tmp_path / "s").identical(found)
    assert fm.sweep(careless, {"most": CARELESS}, store=tmp_path / "s", resume=True).identical(found)


def test_the_number_of_stopped_runs_is_told():
    found = fm.sweep(lambda most: [careless(most), careless(most)][0], {"most": [40]})
    assert "(and 1 more)" in str(found["status"].values[0])


def test_a_function_may_decide_itself():
    """What it says counts, whatever its runs did; without a word of its own its runs decide."""
    found = fm.sweep(named_by_itself, {"say": [0, 1, 2, 3]})
    assert found["ok"].values.tolist() == [False, True, False, False]
    assert found["status"].values[1] == "with 40 steps"
    assert all("Stopped after 40 steps" in status for status in found["status"].values[[0, 2]])
    assert "ok = 0.5; it must be True or False" in found["status"].values[3]
    assert sorted(found.data_vars) == ["ok", "status", "x"]
    refused = fm.sweep(lambda a: {"ok": a > 1}, {"a": [1]})
    assert refused["status"].values[0] == "The function returned ok = False."


def test_exponents_and_sections_that_stop_early_do_too():
    """A map that leaves all bounds after a few iterations."""

    def leaving(kind):
        system = fm.chaos.Map(lambda x: [x[0] ** 3], [2.0])
        if kind == "section":
            return float(len(fm.stroboscopic(system, skip=5, keep=50)["x0"]))
        return float((fm.lyapunov if kind == "lyapunov" else fm.chaos.benettin)(system, periods=50).value)

    found = fm.sweep(leaving, {"kind": ["lyapunov", "benettin", "section"]})
    assert not found["ok"].values.any()
    assert all("did not reach its end" in status for status in found["status"].values)


def test_a_diagram_whose_function_runs_something_first():
    found = fm.bifurcation(started_by_a_run, "r", [2.8, 3.1], skip=5, keep=3)
    assert found["ok"].values.tolist() == [True, False]
    assert "Stopped after 3 steps" in found["status"].values[1]


def test_require():
    mechanism = fm.mechanisms.slider_crank()
    sol = fm.simulate(mechanism, t_end=1e-3)
    assert sol.require() is sol
    with pytest.raises(fm.errors.SolveError, match=r"Run of 'slider-crank': Stopped after 3 steps"):
        fm.simulate(mechanism, t_end=1e-3, max_steps=3).require()
    found = fm.sweep(lambda m: fm.simulate(mechanism, t_end=1e-3, max_steps=m).require().stats.steps, {"m": [3]})
    assert found["status"].values[0].startswith("SolveError: Run of 'slider-crank': Stopped after 3 steps")


@pytest.mark.parametrize(
    "kind", ["sweep", pytest.param("diagram", marks=pytest.mark.slow), pytest.param("exponent", marks=pytest.mark.slow)]
)
def test_ctrl_c_ends_a_sweep_and_keeps_nothing_of_its_point(kind, tmp_path):
    """The third point is interrupted in the middle of its run; resume=True computes it, and all that follow."""
    store, flag = tmp_path / "s", tmp_path / "flag"

    def computed(**more):
        with interrupted_once(flag, {"sweep": 3, "diagram": 6, "exponent": 90}[kind]):
            if kind == "sweep":
                return fm.sweep(careless, {"most": [100_000, 90_000, 80_000, 70_000]}, **more)
            settings = {"skip": 1, "keep": 4, "exponent": 50 if kind == "exponent" else False, "period": 5.0}
            return fm.bifurcation(bistable, "amplitude", [0.1, 0.2, 0.3], **settings, **more)

    flag.touch()
    with pytest.raises(KeyboardInterrupt):
        computed(store=store)
    part = fm.sweeps.load_sweep(store)
    assert 0 < part["ok"].values.sum() < part["ok"].size
    assert all(ok == (status != "") for ok, status in zip(part["ok"].values, part["status"].values, strict=True))
    assert not flag.exists()
    whole = computed(store=store, resume=True)
    assert whole["ok"].values.all()
    assert whole.identical(computed(store=tmp_path / "whole"))
    assert content(store) == content(tmp_path / "whole")


def test_ctrl_c_in_a_point_leaves_its_checkpoint(tmp_path):
    flag, path = tmp_path / "flag", tmp_path / "run.nc"
    flag.touch()

    def run(a):
        sol = fm.simulate(fm.mechanisms.slider_crank(), t_end=0.01, checkpoint=path, resume=True)
        return sol.peak("slider.x").value

    with pytest.raises(KeyboardInterrupt), interrupted_once(flag, 2):
        fm.sweep(run, {"a": [1]})
    assert path.is_file()
    assert (
        float(fm.sweep(run, {"a": [1]})["value"][0])
        == fm.simulate(fm.mechanisms.slider_crank(), t_end=0.01).peak("slider.x").value
    )
    assert not path.exists()


SCRIPT = """
import sys
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import nullcontext
import flexmb as fm
from sweep_models import long_run

if __name__ == "__main__":
    store, kind = sys.argv[1:]
    with ProcessPoolExecutor(2) if kind == "processes" else nullcontext(2 if kind == "threads" else None) as pool:
        fm.sweep(long_run, {"k": list(range(400))}, store=store, executor=pool, resume=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["alone", "threads", "processes"])
def test_a_signal_from_the_keyboard_ends_a_sweep(kind, tmp_path):
    """SIGINT to the whole group, as a terminal sends it: every stored point is a whole one."""
    import time

    script, store = tmp_path / "run.py", tmp_path / "s"
    script.write_text(SCRIPT)
    process = subprocess.Popen([sys.executable, str(script), str(store), kind], start_new_session=True)
    status, deadline = store / "status" / "c", time.monotonic() + 120.0
    while process.poll() is None and len(list(status.glob("*"))) < 4 and time.monotonic() < deadline:
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(60.0) != 0
    part = fm.sweeps.load_sweep(store)
    finished = part["status"].values != ""
    assert 4 <= finished.sum() < 400
    assert part["ok"].values[finished].all()
    assert set(part["status"].values[finished]) == {"done"}


@pytest.mark.slow
def test_dask_tells_stopped_runs(tmp_path):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        found = fm.sweep(careless, {"most": CARELESS}, executor=client.get_executor(), store=tmp_path / "s")
    assert found["ok"].values.tolist() == [True, False, True, False]
    assert np.isnan(found["x"].values[1])
