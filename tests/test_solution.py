"""The record of a run: names, aliases, units, peaks, immutability, messages."""

import pickle
import runpy
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmb.errors import InputError
from flexmb.model import shape
from flexmb.model.signal import Signal
from flexmb.results.drawing import nearest_instants
from flexmb.results.solution import Peaks, Stats, UnknownSignalError

handmade = runpy.run_path(str(Path(__file__).with_name("handmade.py")))
solution = handmade["solution"]


@pytest.fixture(scope="module")
def sol():
    return solution()


@pytest.mark.parametrize(("name", "near"), [("crank.zz", None), ("crank.az", "crank.ax"), ("arm.end.xx", "arm.end.x")])
def test_hints_compare_the_own_names_of_signals(sol, name, near):
    """All signals of a part begin alike, which makes none of them near."""
    with pytest.raises(UnknownSignalError) as said:
        sol[name]
    assert (f"Did you mean {near!r}?" in str(said.value)) if near else ("Did you mean" not in str(said.value))
    assert "Known: " in str(said.value)


def test_a_signal_is_a_labelled_array(sol):
    x = sol["crank.x"]
    assert isinstance(x, xr.DataArray)
    assert x.dims == ("time",)
    assert x.attrs == {"units": "m", "long_name": "coordinate x of crank", "name": "crank.x"}
    assert x.name == "crank.x"
    assert float(x.sel(time=0.5)) == pytest.approx(-0.1, abs=1e-15)
    assert x.time.attrs["units"] == "s"


@pytest.mark.parametrize(
    ("alias", "name"),
    [
        ("arm.x", "arm.node1.x"),
        ("arm.start.y", "arm.node0.y"),
        ("arm.end.theta", "arm.node2.theta"),
        ("arm.node2.x", "arm.node2.x"),
    ],
)
def test_aliases_of_nodes(sol, alias, name):
    np.testing.assert_array_equal(sol[alias].values, sol[name].values)
    assert alias in sol
    assert sol[alias].name == alias
    assert sol.peak(alias) == sol.peak(name)
    assert sol.units(alias) == sol.units(name)


def test_a_signal_of_its_own_is_not_renamed_by_an_alias():
    base = solution()
    values = np.column_stack([base.values, np.full(len(base.time), 7.0)])
    peaks = Peaks(np.append(base.peaks.values, 7.0), np.append(base.peaks.times, 0.0))
    signals = (*base.signals, Signal("arm.deflection", "m"))
    sol = solution(values=values, peaks=peaks, signals=signals)
    assert float(sol["arm.deflection"][0]) == 7.0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("crank.xx", ["'crank.xx'", "Did you mean 'crank.x'?"]),
        ("crnk.ax", ["Did you mean 'crank.ax'?"]),
        ("arm.end.thet", ["Did you mean 'arm.end.theta'?"]),
        ("slider", ["'handmade'", "Known:"]),
    ],
)
def test_unknown_signals(sol, name, words):
    with pytest.raises(UnknownSignalError) as error:
        sol[name]
    assert isinstance(error.value, KeyError)
    assert isinstance(error.value, InputError)
    assert all(word in str(error.value) for word in words), str(error.value)
    assert name not in sol
    for call in (sol.peak, sol.array, sol.units):
        with pytest.raises(KeyError):
            call(name)


def test_a_number_is_no_name(sol):
    with pytest.raises(KeyError, match="no signal 0"):
        sol[0]
    assert 0 not in sol


def test_peak_is_that_of_all_steps_and_not_of_the_saved_ones():
    base = solution()
    k = base.names.index("P.normal_force")
    largest, when = base.peaks.values.copy(), base.peaks.times.copy()
    largest[k], when[k] = 1234.5, 0.12345
    peak = solution(peaks=(largest, when)).peak("P.normal_force")
    assert peak.value == 1234.5
    assert peak.time == 0.12345


def test_dataset_holds_every_signal(sol):
    assert tuple(sol.dataset.data_vars) == sol.names == tuple(sol)
    assert sol.dataset["P.normal_force"].attrs["units"] == "N"
    assert sol.dataset.attrs["status"] == "Reached t = 1 s."


def test_nothing_can_be_changed(sol):
    with pytest.raises(AttributeError):
        sol.ok = False
    for array in (sol.time, sol.values, sol.array("crank.x"), sol.peaks.values, sol.restart["q"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_the_callers_arrays_stay_the_callers():
    time = np.linspace(0.0, 1.0, 101)
    sol = solution(time=time)
    time[0] = -1.0
    assert sol.time[0] == 0.0


def test_it_can_be_pickled(sol):
    sol["crank.x"]
    back = pickle.loads(pickle.dumps(sol))  # noqa: S301 - written in this line
    np.testing.assert_array_equal(back.values, sol.values)
    assert back.shapes == sol.shapes
    assert not back.values.flags.writeable
    assert back.peak("crank.x") == sol.peak("crank.x")


def test_repr_says_what_one_wants_to_know(sol):
    text = repr(sol)
    for word in ("'handmade'", "Reached t = 1 s.", "101 instants, 0 to 1 s", "17 signals of 3 parts", "2000 steps"):
        assert word in text
    assert "P.normal_force 100 N" in text
    assert len(text.splitlines()) == 3


def test_repr_of_a_run_without_instants():
    assert "0 instants" in repr(solution(n=0, peaks=Peaks(np.zeros(17), np.zeros(17))))


def test_stats_are_one_line():
    text = str(Stats(steps=10, rejected=2, newton_iterations=31, smallest_step=1e-6, largest_step=1e-3))
    assert "\n" not in text
    assert text.startswith("10 steps of 1e-06 to 0.001 s (2 rejected: 2 for the error), 31 Newton iterations")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"time": np.zeros((3, 1))}, "time has shape"),
        ({"time": np.zeros(7)}, "values has shape"),
        ({"time": np.linspace(1.0, 0.0, 101)}, "time decreases"),
        ({"peaks": (np.zeros(3), np.zeros(17))}, "peaks.values has shape"),
        ({"signals": (Signal("crank.x", "m"),) * 17}, "'crank.x' appears more than once"),
    ],
)
def test_what_does_not_fit_together(changes, words):
    with pytest.raises(InputError, match=words):
        solution(**changes)


def test_shapes_come_back_from_json(sol):
    assert shape.from_json(shape.to_json(sol.shapes)) == sol.shapes
    assert shape.from_json(shape.to_json(())) == ()


@pytest.mark.parametrize("text", ["", "3", "[3]", "[{}]", '[{"shape": "cube"}]', '[{"shape": "point", "size": 1}]'])
def test_json_that_holds_no_shapes(text):
    with pytest.raises(InputError, match="no list of drawing records"):
        shape.from_json(text)


def test_nearest_instants():
    sol = solution(n=11)  # saved every 0.1 s
    np.testing.assert_array_equal(nearest_instants(sol, np.array([0.0, 0.04, 0.06, 0.55, 0.96, 1.0])), [0, 1, 5, 10])
    np.testing.assert_array_equal(nearest_instants(solution(n=1), np.array([0.0, 1.0])), [0])


def test_arrays_that_can_be_written_to_are_copied_and_others_taken_as_they_are():
    """Also a view of an array that somebody else can write to is copied."""
    base = solution()
    mine = np.array(base.values)
    view = mine[:]
    view.setflags(write=False)
    for values in (mine, view):
        sol = solution(values=values)
        assert not np.shares_memory(sol.values, mine)
        assert not sol.values.flags.writeable
    fixed = np.array(base.values)
    fixed.setflags(write=False)
    assert solution(values=fixed).values is fixed
