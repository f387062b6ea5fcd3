"""Names of places agree with the lengths of what they are places in, and with the signals that are reported."""

import numpy as np
import pytest
from element_matrices import beam_matrices

import flexmb as fm
from flexmb import places
from flexmb.elastic.beams import corotational as chord
from flexmb.elastic.beams import mass_damping
from flexmb.elastic.beams.mass_damping import mass_damping_kernel
from flexmb.elastic.beams.section import Rectangle
from flexmb.engine.state import flow
from flexmb.engine.system import outputs
from flexmb.kernels import GAP_SIZE, JOINT_FRICTION_SIZE
from flexmb.model.law import Material
from flexmb.program.numbering import CONTACT_PENETRATION, CONTACT_SIGNALS


def test_what_a_gap_kernel_writes_is_as_long_as_its_places():
    assert places.ARM2_Y_Q + 6 == GAP_SIZE
    assert places.NORMAL_X_Q == places.ECCENTRICITY_RATE_Y + 1
    assert (places.NORMAL_FORCE, places.FRICTION_FORCE) == (GAP_SIZE, GAP_SIZE + 1)


def test_output_of_a_joint_friction_kernel_is_as_long_as_its_places():
    assert (places.LOAD, places.LOAD_BY_LAM, places.SLIDING + 6, places.LOAD_BY_Q + 6) == (
        0,
        1,
        places.LOAD_BY_Q,
        JOINT_FRICTION_SIZE,
    )


def test_memory_of_a_contact_is_as_long_as_its_places():
    assert (flow.MEMORY_BY_NORMAL + 6, flow.MEMORY_BY_FRICTION + 6) == (
        flow.MEMORY_BY_FRICTION,
        flow.CONTACT_MEMORY_SIZE,
    )


def test_signals_are_written_in_the_order_of_their_names():
    names = (
        *("EX", "EY", "VEX", "VEY", "PENETRATION", "PENETRATION_RATE", "NORMAL_SIGNAL", "FRICTION_SIGNAL"),
        *("CONTACT_FX", "CONTACT_FY", "CONTACT_FORCE", "MODE"),
    )
    said = [name.lower().removeprefix("contact_").replace("_signal", "_force") for name in names]
    assert said == [name for name, _ in CONTACT_SIGNALS]
    assert [getattr(outputs, name) for name in names] == list(range(len(CONTACT_SIGNALS)))
    assert outputs.PENETRATION == CONTACT_PENETRATION


def test_numbers_are_packed_in_the_order_of_their_places():
    assert places.packed({2: 0.3, 0: 0.1, 1: 0.2}) == (0.1, 0.2, 0.3)
    with pytest.raises(KeyError):
        places.packed({0: 0.1, 2: 0.3})


def test_mass_of_damping_is_packed_as_the_kernel_reads_it():
    """A straight bar along its own frame: m of axial and of bending displacements, and the boss at each end."""
    section, steel = Rectangle(0.01, 0.02), Material(young=2e11, density=7800.0)
    given = {"section": section, "material": steel, "elements": 1, "mass": 3.0, "inertia": 0.6}
    bar = fm.FlexibleLink("bar", (0.0, 0.0), (1.0, 0.0), mass_damping=0.5, **given)
    contributions = bar.contributions(fm.Mechanism("bar", (bar,)))
    (element,) = (c for c in contributions if getattr(c, "kernel", None) is mass_damping_kernel)
    data, boss = beam_matrices([0.0, 1.0], section, steel), bar._bosses
    whole = np.diag([boss.masses[0], boss.masses[0], boss.inertia, boss.masses[1], boss.masses[1], boss.inertia])
    whole[np.ix_((0, 3), (0, 3))] += data.axial_mass[0]
    whole[np.ix_((1, 2, 4, 5), (1, 2, 4, 5))] += data.bending_mass[0]
    p = np.array(element.p)
    assert (p[mass_damping.ZETA], p[mass_damping.TURNING]) == (0.5, 2.0)
    np.testing.assert_allclose(p[mass_damping.MASSES :].reshape(6, 6), whole, rtol=1e-14, atol=1e-15)


def test_integrals_of_mass_are_packed_as_the_beam_reads_them():
    """A straight uniform rod of length L and mass m: int rho A of products of (1 - xi, xi) and of the cubics."""
    L, section = 2.0, Rectangle(0.01, 0.02)
    steel = Material(young=2e11, density=7800.0)
    p = np.zeros(chord.PARAMETERS)
    p[chord.M11 : chord.BOW11] = beam_matrices(np.array([0.0, L]), section, steel).inertia_integrals[0]
    m = 7800.0 * 0.01 * 0.02 * L
    expected = {"M11": m / 3, "M12": m / 6, "M22": m / 3, "G11": m * L / 20, "G12": -m * L / 30}
    expected |= {"G21": m * L / 30, "G22": -m * L / 20}
    expected |= {"H11": m * L**2 / 105, "H12": -m * L**2 / 140, "H22": m * L**2 / 105}
    for name, value in expected.items():
        assert p[getattr(chord, name)] == pytest.approx(value, rel=1e-9), name
