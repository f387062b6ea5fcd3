"""Compilation in a second process."""

import multiprocessing
import os
import subprocess
import sys

import pytest

import flexmb as fm
from flexmb.engine.compiled import ahead
from flexmb.engine.dormand_prince.method import advance_dormand_prince
from flexmb.engine.newmark.method import advance
from flexmb.engine.radau.method import advance_radau
from flexmb.engine.step.runge_kutta import advance_explicit

LOOPS = {
    advance: {},
    advance_radau: {"method": fm.RadauIIA()},
    advance_dormand_prince: {"method": fm.DormandPrince()},
    advance_explicit: {"method": fm.RungeKutta4(), "step": 1e-6},
}


@pytest.mark.slow
@pytest.mark.parametrize("loop", LOOPS, ids=lambda loop: loop.__qualname__)
def test_annotations_are_the_types_that_a_run_calls_with(loop):
    fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-5, **LOOPS[loop])
    assert ahead.argument_types(loop.py_func) == loop.signatures[0]


@pytest.mark.parametrize("method", [fm.Newmark(), fm.RadauIIA(), fm.RungeKutta4(), fm.DormandPrince()], ids=repr)
def test_methods_name_their_loops(method):
    assert set(method.loops) <= set(LOOPS)
    assert len(method.loops) == 1


def script(monkeypatch, text):
    """The second process runs this text instead."""
    monkeypatch.setattr(ahead, "command", lambda _: [sys.executable, "-c", text])


def test_each_function_is_waited_for(monkeypatch):
    script(monkeypatch, "print('one', flush=True); print('two', flush=True); import time; time.sleep(60)")
    process = ahead.SecondProcess(["one", "two", "three"])
    process.wait_for("two")
    assert process.left == ["three"]
    process.wait_for("one")
    process.stop()
    process.wait_for("three")
    assert process.left == []


@pytest.mark.parametrize("text", ["raise SystemExit(3)", "print('noise')", "import os; os.abort()"])
def test_a_process_that_dies_is_not_waited_for(monkeypatch, text):
    script(monkeypatch, text)
    process = ahead.SecondProcess(["one"])
    process.wait_for("one")
    assert process.left == []


@pytest.fixture
def empty(monkeypatch):
    """Nothing is compiled, and two cores are there."""
    started = []
    monkeypatch.setattr(ahead, "running", [])
    monkeypatch.setattr(ahead, "asked", set())
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    monkeypatch.setattr(ahead, "SecondProcess", lambda names: started.append(names) or names)
    for name in (ahead.FIRST, "flexmb.engine.newmark.method.advance"):
        monkeypatch.setattr(ahead.caches[name], "there", lambda: False)
    return started


def test_the_loop_is_compiled_in_a_second_process(empty):
    ahead.start(advance)
    ahead.start(advance)
    assert empty == [["flexmb.engine.newmark.method.advance"]]


@pytest.mark.parametrize("place", [ahead.FIRST, "flexmb.engine.newmark.method.advance"])
def test_not_where_it_is_compiled_already(empty, monkeypatch, place):
    monkeypatch.setattr(ahead.caches[place], "there", lambda: True)
    ahead.start(advance)
    assert empty == []


def test_not_on_one_core(empty, monkeypatch):
    monkeypatch.setattr(ahead, "cores", lambda: 1)
    ahead.start(advance)
    assert empty == []


def test_not_in_a_worker(empty, monkeypatch):
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: 1)
    ahead.start(advance)
    assert empty == []


def test_not_in_an_application_that_embeds_python(empty, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/opt/blender/blender")
    ahead.start(advance)
    assert empty == []


@pytest.mark.slow
def test_a_first_run_reads_its_loop_from_the_cache(tmp_path):
    code = (
        "import flexmb as fm\n"
        "from flexmb.engine.newmark.method import advance\n"
        "sol = fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-3)\n"
        "print(sol.ok, sum(advance.stats.cache_hits.values()), sum(advance.stats.cache_misses.values()))"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["True", "1", "0"]
