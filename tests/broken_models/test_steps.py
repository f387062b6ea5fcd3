"""Fixed steps that are too long are told before the run, as a run would tell them after it."""

import math
from dataclasses import replace

import pytest
from broken import slider_crank, two_masses, worn

import flexmb as fm


def test_a_step_that_is_too_long_for_a_rod():
    """The step of a run whose remark is held against a finer run in `test_vibrations.py`."""
    crank = fm.mechanisms.slider_crank(flexible=True)
    (finding,) = fm.check(crank, step=0.012 / 50).of("coarse-step")
    assert "periods of the vibration of 6753 Hz (mostly rod." in finding.text
    assert finding.numbers["period"] == pytest.approx(1.0 / fm.modes(crank).frequencies[1], rel=1e-3)
    assert not fm.check(crank, step=0.012 / 5000).of("coarse-step")


def test_a_vibration_that_nothing_excites_is_left_alone():
    """Masses on springs, without weight and with it."""
    masses = two_masses(1e6, 1e6)
    assert not fm.check(replace(masses, gravity=(0.0, 0.0)), step=1.0).of("coarse-step")
    (finding,) = fm.check(masses, step=1e-2).of("coarse-step")
    slow = math.sqrt(1e6 * (3.0 - math.sqrt(5.0)) / 2.0)
    assert finding.numbers["period"] == pytest.approx(2.0 * math.pi / slow, rel=1e-6)


def test_a_step_that_is_too_long_for_a_contact():
    """A linear contact: half a period of crank or rod against the other, pi sqrt(m/k)."""
    joint = worn("A", normal=fm.KelvinVoigt(1e8, 0.0))
    (finding,) = fm.check(joint, step=1e-3).of("coarse-step")
    assert finding.parts == ("A",)
    assert finding.numbers["contact_time"] == pytest.approx(math.pi * math.sqrt(0.2 / 1e8), rel=1e-3)
    coarse = fm.simulate(joint, t_end=0.05, step=1e-3)
    assert not coarse.ok
    assert any("contacts of 'A' last less than 4 of the fixed steps" in text for text in (coarse.status, *coarse.notes))


def test_no_step_no_finding():
    assert not fm.check(worn("A")).of("coarse-step")
    with pytest.raises(fm.errors.InputError, match="check: step is -1 s; it must be > 0"):
        fm.check(slider_crank(), step=-1.0)
