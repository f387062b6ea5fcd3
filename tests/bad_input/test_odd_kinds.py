"""Values of kinds that nobody expects: bytes, masked numbers, arrays without dimensions, other objects."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import FlexmbError


@pytest.fixture(scope="module")
def mechanism():
    return fm.mechanisms.slider_crank(clearance=5e-4)


@pytest.fixture(scope="module")
def sol(mechanism):
    return fm.simulate(mechanism, periods=0.02, save=20)


SOLUTIONS = {
    "plot": lambda sol: fm.plot(sol, "slider.x"),
    "plot_energies": fm.plots.plot_energies,
    "plot_journal": lambda sol: fm.plots.plot_journal(sol, "B"),
    "plot_contact_force": lambda sol: fm.plots.plot_contact_force(sol, "B"),
    "render": fm.render,
}


@pytest.mark.parametrize("name", SOLUTIONS)
def test_what_is_no_solution(name, mechanism):
    for odd in (None, "slider.x", np.array([1, 2]), mechanism, range(3)):
        with pytest.raises(FlexmbError, match=rf"{name}: sol is .*; it must be a solution"):
            SOLUTIONS[name](odd)


@pytest.mark.parametrize("odd", [b"x", range(3), np.array([1, 2]), [3], [[3]], {"a": 1}, [b"x"]], ids=repr)
def test_names_of_signals(odd, sol):
    with pytest.raises(FlexmbError, match=r"plot: names\[0\] is .*; it must be a list|has no signal"):
        fm.plot(sol, odd)


@pytest.mark.parametrize("odd", [np.ma.masked, np.array(3), np.array("rod"), 3, "rod", None], ids=repr)
def test_parts_of_a_mechanism(odd):
    with pytest.raises(FlexmbError, match=r"Mechanism 'm': parts is .*; it must be a list of parts"):
        fm.Mechanism("m", odd)


UNHASHABLE = [np.array([1, 2]), np.array("crank"), np.ma.masked, {}, [], bytearray(b"crank"), slice(3), np.zeros(0)]


@pytest.mark.parametrize("odd", UNHASHABLE, ids=repr)
def test_names_of_parts(odd, mechanism):
    with pytest.raises(FlexmbError, match="has no part"):
        mechanism[odd]


@pytest.mark.parametrize("odd", [0, "", [], np.zeros(0), np.array([1, 2]), False], ids=repr)
def test_methods(odd, mechanism):
    """Those that count as false were taken for the default."""
    with pytest.raises(FlexmbError, match=r"method is .*; it must be"):
        fm.simulate(mechanism, periods=0.01, method=odd)


def test_instants_speeds_and_drives(sol, mechanism):
    masked = np.ma.masked
    with pytest.raises(FlexmbError, match=r"render: times is .*; it must be a list of instants"):
        fm.render(sol, masked)
    for odd in (None, masked, 3):
        with pytest.raises(FlexmbError, match=r"plot_campbell: speeds is .*; it must be a list of speeds"):
            fm.plots.plot_campbell(mechanism, odd)
    with pytest.raises(FlexmbError, match=r"plot_campbell: speeds\[0\] is .*; it must be a number"):
        fm.plots.plot_campbell(mechanism, np.array(["a", "b"]))
    for odd in (b"x", np.array([1, 2]), 3):
        with pytest.raises(FlexmbError, match=r"assemble 'slider-crank': drives is .*; it must be a dictionary"):
            fm.assemble(mechanism, odd)


def test_what_is_no_mechanism():
    for odd in (None, 3, "slider", np.array([1, 2])):
        for call in (fm.simulate, fm.assemble, fm.chaos.MechanismFlow, lambda one: next(iter(fm.steps(one)))):
            with pytest.raises(FlexmbError):
                call(odd)


def test_numbers_of_mechanisms_and_signals():
    for odd in (None, "fast", b"x"):
        with pytest.raises(FlexmbError, match=r"nine_bar: speed is .*; it must be a number"):
            fm.mechanisms.nine_bar(odd)
    with pytest.raises(FlexmbError, match="power_spectrum"):
        fm.chaos.power_spectrum(10**400, 1.0)


@pytest.mark.parametrize("odd", [None, 3, str, np.array([1, 2])], ids=repr)
def test_kernels(odd):
    with pytest.raises(FlexmbError, match=r"The normal kernel is .*; it must be a function"):
        fm.normal_law(odd)
