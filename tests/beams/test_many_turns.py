"""Rotations against the chord after many turns, held against the same pose with whole turns taken away exactly."""

import math
from fractions import Fraction

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.beams.corotational import beam_energy, beam_force, beam_kernel, direction

TURN = 2 * Fraction("3.14159265358979323846264338327950288419716939937510582097")  # 2 pi to 56 digits
STEEL = fm.Material(young=2.0e11, density=7850.0)
CHORDS = (0.4, 2.2, 3.1, -3.1, -1.0)


def element():
    """p of one steel element of 1.3 m, drawn along x."""
    section = fm.Rectangle(width=0.02, height=0.03)
    link = fm.FlexibleLink("link", (0.0, 0.0), (1.3, 0.0), section=section, material=STEEL, elements=1)
    return np.array(link.contributions(fm.Mechanism("one", (link,)))[0].p)


def force(p, q):
    r = np.zeros(6)
    beam_force.dispatcher(p, 0.0, 0.0, q, np.zeros(6), np.zeros(6), np.zeros(0), r, np.zeros(0))
    return r


@pytest.mark.parametrize("chord", CHORDS)
@pytest.mark.parametrize("turns", [1, -1, 7, 1000, -1000, 123456])
def test_a_crank_that_has_turned_often_is_bent_as_at_its_start(turns, chord):
    """Nothing is lost but what the angles themselves cannot hold: their exact remainder gives the same force.

    The whole turns may add a thousandth of the spacing of such angles.
    """
    p = element()
    q = np.array([0.1, -0.2, 0.0, 0.1 + 1.3 * np.cos(chord), -0.2 + 1.3 * np.sin(chord), 0.0])
    far, near = q.copy(), q.copy()
    for i, bend in ((2, 0.02), (5, -0.03)):
        far[i] = chord + bend + turns * 2.0 * np.pi
        near[i] = float(Fraction(far[i]) - turns * TURN)
    # round-off of a rotation of 0.03 rad found as a difference of angles up to 3.1 rad, times the bending stiffness
    bending = p[2] * (4e-15 + 1e-3 * np.spacing(abs(far[2])))
    np.testing.assert_allclose(force(p, far), force(p, near), rtol=0.0, atol=bending)


@pytest.mark.parametrize("chord", CHORDS)
@pytest.mark.parametrize("ends", [(3.0, -3.0), (0.5, 3.1), (-2.0, -3.1)])
def test_rotations_stay_within_half_a_turn(chord, ends):
    """Bent by u1 and u2 up to almost half a turn: the energy is that of these rotations, wherever the chord points."""
    p = element()
    q = np.array([0.0, 0.0, chord + ends[0], 1.3 * np.cos(chord), 1.3 * np.sin(chord), chord + ends[1]])
    u1, u2 = ends
    bowing = 1.3 / 30.0 * (2.0 * u1**2 - u1 * u2 + 2.0 * u2**2)
    EI, EA = 2.0e11 * 0.02 * 0.03**3 / 12.0, 2.0e11 * 0.02 * 0.03
    exact = 0.5 * EA / 1.3 * bowing**2 + 2.0 * EI / 1.3 * (u1**2 + u1 * u2 + u2**2)
    assert beam_energy(p, 0.0, q, np.zeros(6))[0] == pytest.approx(exact, rel=1e-13)


def test_what_is_not_a_number_stays_visible():
    """No flag of the compiler may take NaN or infinity for impossible."""
    p = element()
    sound = np.array([0.0, 0.0, 0.0, 1.3, 0.0, 0.0])
    for i in range(6):
        for bad in (np.nan, np.inf, -np.inf):
            q = sound.copy()
            q[i] = bad
            assert not np.all(np.isfinite(force(p, q)))
            r, (K, C, M) = np.zeros(6), np.zeros((3, 6, 6))
            states = (q, np.zeros(6), np.zeros(6), np.zeros(0))
            beam_kernel.dispatcher(p, 0.0, 0.0, *states, r, K, C, M, np.zeros(0))
            assert not np.all(np.isfinite(r))
    assert not np.all(np.isfinite(force(p, np.zeros(6))))  # an element without length


def test_directions_of_chords_are_those_of_the_library_of_mathematics():
    for angle in np.linspace(-3.1415, 3.1415, 2003).tolist():
        for length in (1e-9, 0.3, 1e7):
            x, y = length * math.cos(angle), length * math.sin(angle)
            assert abs(direction(y, x) - math.atan2(y, x)) <= 7e-16
    assert [direction(y, x) for x, y in ((1.0, 0.0), (0.0, 2.0), (0.0, -2.0))] == [0.0, 0.5 * math.pi, -0.5 * math.pi]
    assert abs(direction(0.0, -1.0)) == math.pi
