"""Figures of several runs, energies, journals, contact forces and turning mechanisms."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, SolveError
from flexmb.model.signal import Signal

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
solution = handmade["solution"]
LENGTH, EI, RHO_A = 1.0, 2.0, 5.0


@pytest.fixture(scope="module")
def sol():
    """The solution by hand with a penetration: the journal circles at 1 mm in a clearance of 0.9 mm."""
    made = solution()
    signals = (*made.signals, Signal("P.penetration", "m"))
    depth = np.where(made.array("P.normal_force") > 1.0, 1e-4, 0.0)
    values = np.column_stack([made.values, depth])
    peaks = type(made.peaks)(np.abs(values).max(axis=0), np.zeros(values.shape[1]))
    return replace(made, signals=signals, values=values, peaks=peaks)


def test_runs_share_panels_and_differ_in_style(sol):
    other = solution(n=31, t_end=2.0)
    figure = fm.plots.plot_runs({"ideal": sol, "worn": other}, ["crank.ax", "arm.end.y"])
    first, second = figure.axes
    assert [ax.get_ylabel() for ax in (first, second)] == ["crank.ax\n[m/s²]", "arm.end.y\n[m]"]
    assert [text.get_text() for text in first.get_legend().get_texts()] == ["ideal", "worn"]
    assert first.get_xlim() == (0.0, 2.0)
    one, two = first.lines
    np.testing.assert_array_equal(two.get_ydata(), other.array("crank.ax"))
    assert one.get_color() != two.get_color()
    assert one.get_linestyle() != two.get_linestyle()


def test_energies_of_a_run():
    bead = fm.bodies.PointMass("bead", at=(0.2, 0.0), mass=0.1)
    spring = fm.SpringDamper(
        "spring", fm.GROUND, bead, at=(0.0, 0.0), to=bead.at, stiffness=30.0, damping=0.1, free_length=0.1
    )
    sol = fm.simulate(fm.Mechanism("bead", [bead, spring], gravity=(0.0, -9.81)), t_end=0.2, save=50)
    stored, works, residual = fm.plots.plot_energies(sol).axes
    names = [[text.get_text() for text in ax.get_legend().get_texts()] for ax in (stored, works)]
    assert names[0] == ["kinetic", "strain", "gravity, from the start"]
    assert "dissipated damping" in names[1]
    assert residual.get_ylabel() == "residual\n[nJ]"
    total = sum(np.asarray(line.get_ydata()) for line in stored.lines)
    np.testing.assert_array_equal(stored.lines[2].get_ydata()[0], 0.0)
    lost = sol.array("energy.dissipated_damping") + sol.array("energy.dissipated_algorithm")
    np.testing.assert_allclose(total + lost, total[0], atol=1e-6)
    some = fm.simulate(fm.Mechanism("bead", [bead, spring]), t_end=0.01, signals=["bead.*"])
    with pytest.raises(InputError, match="no energies were saved"):
        fm.plots.plot_energies(some)


def test_the_journal_runs_in_its_circle(sol):
    (ax,) = fm.plots.plot_journal(sol, "P", since=0.25).axes
    circle, orbit, contact = ax.lines
    np.testing.assert_allclose(np.hypot(*circle.get_data()), 0.9e-3, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(*orbit.get_data()), 1e-3, rtol=1e-9)
    assert len(orbit.get_xdata()) == 76
    assert len(contact.get_xdata()) == np.sum(sol.array("P.penetration")[25:] > 0.0)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("P.ex [mm]", "P.ey [mm]")
    (ax,) = fm.plots.plot_journal(sol, "P", clearance=2e-3).axes
    np.testing.assert_allclose(np.hypot(*ax.lines[0].get_data()), 2e-3)


def test_contact_forces_stand_in_the_direction_of_the_contact(sol):
    (ax,) = fm.plots.plot_contact_force(sol, "P").axes
    angle, force = ax.lines[0].get_data()
    rows = sol.array("P.normal_force") > 0.0
    np.testing.assert_array_equal(force, sol.array("P.normal_force")[rows])
    np.testing.assert_allclose(np.cos(angle), 1e3 * sol.array("P.ex")[rows], atol=1e-12)
    assert ax.name == "polar"
    assert "[N]" in ax.figure.get_suptitle()


def test_campbell_of_a_turning_beam():
    """At rest the frequencies of a cantilever; stiffened by rotation (a string's limit: Omega^2 n (2 n - 1))."""
    section = fm.GeneralSection(area=2e-5, second_moment=EI / 1e10)
    material = fm.Material(young=1e10, density=RHO_A / 2e-5)
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (LENGTH, 0.0), section=section, material=material, elements=6)
    mech = fm.Mechanism("turning", [beam, fm.Fixed("hub", fm.GROUND, beam, at=(0.0, 0.0))])
    figure = fm.plots.plot_campbell(mech, [0.0, 4.0, 8.0], count=2, orders=(1, 3))
    (ax,) = figure.axes
    once, thrice, first, second = ax.lines
    np.testing.assert_allclose(thrice.get_ydata(), 3.0 * np.array([0.0, 4.0, 8.0]) / (2.0 * np.pi))
    np.testing.assert_allclose(once.get_ydata()[-1], 8.0 / (2.0 * np.pi))
    scale = np.sqrt(EI / RHO_A) / (2.0 * np.pi * LENGTH**2)
    assert first.get_ydata()[0] == pytest.approx(1.8751041**2 * scale, rel=1e-3)
    assert second.get_ydata()[0] == pytest.approx(4.6940911**2 * scale, rel=1e-3)
    assert np.all(np.diff(second.get_ydata()) > 0.0)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed [rad/s]", "natural frequency [Hz]")


def turning_mass(stiffness):
    """A mass of 2 kg, 1 mm off the centre, on springs and dampers that turn with it."""
    mass = fm.RigidBody("mass", (1e-3, 0.0), mass=2.0, inertia=0.1)
    held = fm.Bushing("shaft", fm.GROUND, mass, at=(1e-3, 0.0), stiffness=stiffness, torsion=500.0, damping=(30.0, 1.0))
    return fm.Mechanism("rotor", [mass, held])


def curves_of(figure):
    return {line.get_label(): line.get_xydata() for line in figure.axes[0].lines}


def test_campbell_without_damping_and_with_it():
    """At 2.525 rad/s 1.8210 Hz, with dampers 1.8395 (roots of the quartic); at rest 1.9492 and 1.9488 Hz."""
    for damped, expected in ((False, [1.9492, 1.8210]), (True, [1.9488, 1.8395])):
        figure = fm.plots.plot_campbell(turning_mass((800.0, 300.0)), [0.0, 2.525], count=1, damped=damped)
        np.testing.assert_allclose(curves_of(figure)["mode 1"][:, 1], expected, atol=5e-5)


@pytest.mark.slow
def test_campbell_with_a_critical_speed():
    """The curve has a gap where k = m W^2 leaves no equilibrium, and a cross there."""
    mechanism, speeds = turning_mass((800.0, 300.0)), [0.0, 5.0, 20.0, 25.0]
    curves = curves_of(fm.plots.plot_campbell(mechanism, speeds, count=1))
    assert np.isnan(curves["mode 1"][:, 1]).tolist() == [False, False, True, False]
    np.testing.assert_allclose(curves["failed"], [[20.0, 0.015]])
    assert "failed" not in curves_of(fm.plots.plot_campbell(mechanism, speeds[:2], count=1))
    with pytest.raises(SolveError, match="no static equilibrium"):
        fm.plots.plot_campbell(turning_mass((200.0, 800.0)), [10.0, 20.0])


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda s: fm.plots.plot_runs({}, "crank.x"), "runs or names are empty"),
        (lambda s: fm.plots.plot_runs({"a": 3}, "crank.x"), "it must be a solution"),
        (lambda s: fm.plots.plot_runs({"a": s}, "crank.xx"), "Did you mean 'crank.x'"),
        (lambda s: fm.plots.plot_journal(s, "O"), "joint is 'O'"),
        (lambda s: fm.plots.plot_journal(s, "P", since=2.0), "after the end"),
        (lambda s: fm.plots.plot_contact_force(s, "arm"), "joint is 'arm'"),
        (lambda s: fm.plots.plot_campbell(None, [1.0]), "must be two or more"),
        (lambda s: fm.plots.plot_campbell(None, [2.0, 1.0]), "increasing"),
    ],
)
def test_what_is_refused(sol, draw, words):
    with pytest.raises(InputError, match=words):
        draw(sol)
