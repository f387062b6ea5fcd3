"""Remarks of contact laws at the end of a run, and their way into files and summaries."""

import html
import math
import runpy
from dataclasses import replace
from pathlib import Path

import pytest

import flexmb as fm
from flexmb.cli import run as summary

thrown = runpy.run_path(str(Path(__file__).with_name("drops.py")))["thrown"]

STEEL = fm.Material(207e9, 7850.0, 0.3)
LOVE = 1e-5 * math.sqrt(207e9 / 7850.0)


def run(law, **numbers):
    given = {"t_end": 1e-3, "step": 1e-6, **numbers}
    return thrown([law], **given)


def hertz(yield_stress=None):
    metal = replace(STEEL, yield_stress=yield_stress)
    return fm.contact.ExactRestitution.from_materials(metal, metal, restitution=0.9)


def test_slow_and_shallow_impacts_go_without_remark():
    sol = run(hertz(yield_stress=1e9), speed=0.9 * LOVE, mass=1e-3, t_end=6e-3)
    assert sol.peak("J0.normal_force").value > 0.0
    assert sol.notes == ()


def test_fast_impacts():
    (note,) = run(hertz(), speed=1.2 * LOVE, mass=1e-3, t_end=6e-3, step=2e-7).notes
    assert note.startswith(f"J0 (ExactRestitution): the surfaces met with up to {1.2 * LOVE:.3g} m/s, above {LOVE:.3g}")


def test_yield_begins_where_johnson_says():
    """Point contact: N_Y = pi^3 R^2 (p0)_Y^3/(6 E*^2), Johnson 1985, eq. (6.10), with (p0)_Y = 1.60 Y."""
    sol = run(hertz(), speed=0.9 * LOVE, mass=1.0, t_end=9e-3)
    N = sol.peak("J0.normal_force").value
    R, E = 1e-2 * 9.8e-3 / 2e-4, 207e9 / (2.0 * (1.0 - 0.3**2))
    Y = (6.0 * N * E * E / (math.pi**3 * R * R)) ** (1.0 / 3.0) / 1.60
    assert run(hertz(1.01 * Y), speed=0.9 * LOVE, mass=1.0, t_end=9e-3).notes == ()
    (note,) = run(hertz(0.99 * Y), speed=0.9 * LOVE, mass=1.0, t_end=9e-3).notes
    assert "they yield and keep dents" in note


def test_yield_of_a_line():
    """f_Y = pi R (p0)_Y^2/E*, Johnson 1985, eq. (6.6), with (p0)_Y = 1.79 Y."""
    numbers = {"speed": 0.9 * LOVE, "mass": 0.01, "t_end": 6e-3}
    law = fm.contact.Johnson(0.02, (STEEL, STEEL))
    f = run(law, **numbers).peak("J0.normal_force").value / 0.02
    R, E = 1e-2 * 9.8e-3 / 2e-4, 207e9 / (2.0 * (1.0 - 0.3**2))
    Y = math.sqrt(f * E / (math.pi * R)) / 1.79
    for factor, said in ((1.01, False), (0.99, True)):
        metal = replace(STEEL, yield_stress=factor * Y)
        notes = run(fm.contact.Johnson(0.02, (metal, metal)), **numbers).notes
        assert any("they yield" in text for text in notes) == said


def test_too_close_a_fit():
    """a = sqrt(R depth) of Hertz grows with the fit; the same impact in a wide hollow goes without the remark."""
    close = run(hertz(), speed=0.9 * LOVE, mass=1.0, play=1e-5, t_end=2e-3)
    depth = close.peak("J0.penetration").value
    assert math.sqrt(1e-2 * 9.99e-3 / 1e-5 * depth) > 0.3 * 9.99e-3
    assert any("half-width" in text for text in close.notes)
    assert not any("half-width" in text for text in run(hertz(), speed=0.9 * LOVE, mass=1.0, t_end=9e-3).notes)


def test_tension_that_was_cut():
    """The law of Kelvin and Voigt has no force that pulls, by definition; others say in one line that one was cut."""
    assert run(fm.KelvinVoigt(1e9, 3e4), step=1e-7, method=fm.RungeKutta4()).notes == ()
    (note,) = hertz().remarks((*(0.0,) * 6, 900.0, 30.0, 0.0))
    assert note == "a pull of its damping of up to 30 N was cut (largest force 900 N)"
    (note,) = hertz().remarks((*(0.0,) * 6, 900.0, 30.0, 20.0))
    assert "let go, faster than they had met" in note


def test_a_rubber_buffer_is_no_wrong_unit():
    """A stop of 5 kN/m under a weight of 10 kg, as a straight guide and as a lever, gives way by design."""
    law, weight = fm.KelvinVoigt(5e3, 60.0), fm.RigidBody("weight", (0.0, 0.0), 10.0, 0.1)
    guide = fm.Prismatic("guide", fm.GROUND, weight, at=(0.0, 0.0), along=(0.0, 1.0))
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=1.0 / 48.0)
    hinge = fm.Revolute("hinge", fm.GROUND, arm, at=(0.0, 0.0))
    for parts in (
        [weight, guide, fm.Stop("buffer", joint="guide", below=-0.1, normal=law)],
        [arm, hinge, fm.Stop("buffer", joint="hinge", below=-1.0, normal=law, radius=0.05)],
    ):
        mechanism = fm.Mechanism("buffer", parts, gravity=(0.0, -9.81))
        sol = fm.simulate(mechanism, t_end=1.0)
        assert sol.ok
        assert sol.peak("buffer.normal_force").value > 50.0
        assert sol.notes == ()
        assert {finding.code for finding in fm.check(mechanism).findings} == {"free-motion"}


def test_a_run_that_goes_on_remembers():
    """The extremes belong to the state, so the impact before the cut is remembered after it."""
    law = hertz()
    first = run(law, speed=1.5 * LOVE, mass=1e-3, t_end=4e-3)
    assert len(first.notes) == 1
    later = run(law, speed=1.5 * LOVE, mass=1e-3, t_end=4.1e-3, restart=first.restart)
    assert later.notes == first.notes


def test_a_users_law_says_nothing():
    assert fm.NormalLaw.remarks(hertz(), (1e9,) * 7) == ()


def test_notes_in_files_and_summaries(tmp_path):
    sol = run(hertz(), speed=2.0 * LOVE, mass=1e-3, t_end=6e-3)
    assert len(sol.notes) == 1
    assert fm.load(sol.to_netcdf(tmp_path / "a.nc")).notes == sol.notes
    assert "1 note in sol.notes" in repr(sol)
    assert html.escape(sol.notes[0]) in sol._repr_html_()
    ball = fm.RigidBody("ball0", (0.0, 0.0), 1.0, 1.0)
    assert f"note                  {sol.notes[0]}" in summary.table(fm.Mechanism("thrown", [ball]), sol)


def test_yield_stress_out_of_range():
    with pytest.raises(fm.errors.InputError, match="Material: yield_stress is 0 Pa; it must be > 0"):
        fm.Material(207e9, 7850.0, yield_stress=0.0)


def test_the_least_approach_speed_is_no_approach():
    """Foam, whose limit lies below the least approach speed, touched slowly: the bound alone is no fast impact."""
    foam = fm.Material(1e6, 100.0 * 1e3, 0.3)
    law = fm.contact.ExactRestitution.from_materials(foam, foam, restitution=0.9, least_approach=1e-3)
    limit = 1e-5 * math.sqrt(1e6 / 1e5)
    sol = run(law, speed=0.5 * limit, mass=1e-6, play=1e-7, t_end=1e-2, step=1e-5)
    assert sol.peak("J0.normal_force").value > 0.0
    assert not any("met with" in text for text in sol.notes)
    assert any("met with" in text for text in run(law, speed=2e-3, mass=1e-6, play=1e-7, t_end=1e-2, step=1e-5).notes)
