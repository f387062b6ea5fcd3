"""Cylinder laws and the law of Kelvin and Voigt: printed forms, published relations, impacts."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import flexmb as fm
from flexmb.errors import InputError

drops = runpy.run_path(str(Path(__file__).with_name("drops.py")))
thrown, returned = drops["thrown"], drops["returned"]

STEEL = fm.Material(207e9, 7850.0, 0.3)
BRASS = fm.Material(100e9, 8500.0, 0.35)
L, R1, R2 = 0.02, 10e-3, 9.5e-3
CYLINDERS = (
    fm.contact.Johnson,
    fm.contact.Radzimovsky,
    fm.contact.Goldsmith,
    fm.contact.DubowskyFreudenstein,
    fm.contact.ESDU78035,
)
E_STAR = 1.0 / ((1.0 - 0.3**2) / 207e9 + (1.0 - 0.35**2) / 100e9)


def printed(kind, F):
    """The depth as the sources print it, with the force F [N] and the letters of the source."""
    dR, h = R1 - R2, ((1.0 - 0.3**2) / 207e9 + (1.0 - 0.35**2) / 100e9) / math.pi
    if kind is fm.contact.Johnson:
        return F / (math.pi * E_STAR * L) * (math.log(4.0 * math.pi * E_STAR * dR * L / F) - 1.0)
    if kind is fm.contact.Radzimovsky:
        b = 1.60 * math.sqrt(F / L * (2 * R1 * 2 * R2 / (2 * R1 - 2 * R2)) / E_STAR)
        return F / (math.pi * E_STAR * L) * (2.0 / 3.0 + math.log(4.0 * R1 / b) + math.log(4.0 * R2 / b))
    if kind is fm.contact.Goldsmith:
        return F * h / L * (math.log(L**1 / (F * h * R1 * R2 / dR)) + 1.0)
    if kind is fm.contact.DubowskyFreudenstein:
        return F * h / L * (math.log(L**3 * dR / (F * R1 * R2 * h)) + 1.0)
    return F * h / L * (math.log(4.0 * L * dR / (F * h)) + 1.0)


def law_of(kind, length=L, **numbers):
    return kind(length, (STEEL, BRASS), **numbers).for_radii(R1, R2)


def force(law, depth, rate=0.0, approach=1.0):
    history = np.array((approach, -depth, -rate, *law.history()[3:]))
    return law.kernel(law.parameters(), 1e-6, -depth, -rate, history, np.zeros(len(history)))


@pytest.mark.parametrize("kind", CYLINDERS)
@pytest.mark.parametrize("F", [1e-3, 1.0, 1e3, 1e5])
def test_depth_as_printed(kind, F):
    assert law_of(kind).depth(F) == pytest.approx(printed(kind, F), rel=1e-13)


@given(kind=st.sampled_from(CYLINDERS), exponent=st.floats(-12.0, 9.0))
def test_force_of_the_depth_of_a_force(kind, exponent):
    """Also beyond the end of use, where both follow the tangent."""
    law, F = law_of(kind), float(10.0**exponent)
    found, slope, _ = force(law, law.depth(F))
    assert found == pytest.approx(F, rel=1e-12)
    step = 1e-4 * F
    stiffness = 2.0 * step / (law.depth(F + step) - law.depth(F - step))
    assert -slope == pytest.approx(stiffness, rel=1e-5)


def test_depths_beside_each_other():
    """ESDU 78035 is Johnson's law with +1 for -1; Goldsmith and Dubowsky-Freudenstein agree for L = 1 m."""
    F = 1000.0
    depth = {kind: law_of(kind).depth(F) for kind in CYLINDERS}
    unit = F / (math.pi * E_STAR * L)
    assert depth[fm.contact.ESDU78035] - depth[fm.contact.Johnson] == pytest.approx(2.0 * unit, rel=1e-10)
    # ln(16 R1 R2/width^2) = ln(pi E* (R1 - R2) L/F) with the width of Hertz, for which 1.60 stands
    exact_width = 2.0 / 3.0 + 1.0 - math.log(4.0)
    assert (depth[fm.contact.Radzimovsky] - depth[fm.contact.Johnson]) / unit == pytest.approx(exact_width, abs=6e-3)
    assert law_of(fm.contact.Goldsmith, 1.0).depth(F) == pytest.approx(
        law_of(fm.contact.DubowskyFreudenstein, 1.0).depth(F), rel=1e-13
    )
    assert (
        depth[fm.contact.Johnson]
        < depth[fm.contact.Radzimovsky]
        < depth[fm.contact.ESDU78035]
        < depth[fm.contact.Goldsmith]
    )


def test_johnson_is_both_halves_of_a_cylinder_pressed_on_a_plane():
    """Johnson 1985, eq. (5.57): each half-cylinder of radius R gives (1 - nu^2) f/(pi E) [2 ln(4 R/a) - 1].

    With both radii replaced by sqrt(R1 R2), as the relative radius of the strip a^2 = 4 f R/(pi E*) demands, its two
    halves add up to the law in the radius difference.
    """
    F = 2500.0
    a = math.sqrt(4.0 * F / L * R1 * R2 / (R1 - R2) / (math.pi * E_STAR))
    halves = sum((1.0 - m.poisson**2) / (math.pi * m.young) for m in (STEEL, BRASS)) * F / L
    assert law_of(fm.contact.Johnson).depth(F) == pytest.approx(
        halves * (2.0 * math.log(4.0 * math.sqrt(R1 * R2) / a) - 1.0)
    )


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", CYLINDERS)
def test_restitution_of_a_cylinder(kind):
    laws = [kind(L, (STEEL, STEEL), restitution=e) for e in (0.3, 0.6, 0.9, 1.0)]
    sol = thrown(laws, t_end=5.5e-4, step=2e-8)
    assert returned(sol, 4) == pytest.approx([0.3, 0.6, 0.9, 1.0], abs=2e-5)
    assert laws[0].delivered_restitution() == pytest.approx(0.3, abs=1e-13)


def test_beyond_the_end_it_goes_on_and_says_so():
    law = fm.contact.Johnson(1e-3, (STEEL, STEEL))
    end = law.for_radii(1e-2, 9.99e-3)
    sol = thrown([law], t_end=2e-5, step=5e-9, play=1e-5, mass=2.0, speed=2.0)
    assert sol.ok
    assert any("the formula of this law holds up to" in text for text in sol.notes)
    # ln(A/f) = 2 with A = 4 dR/(sigma e): depth = 2 sigma A/e^2
    assert sol.peak("J0.penetration").value > 8.0 * 1e-5 / math.e**3
    assert end.depth(1e6) > 0.0


@pytest.mark.parametrize("kind", CYLINDERS)
def test_bad_numbers_of_a_cylinder(kind):
    name = kind.__name__
    with pytest.raises(InputError, match=f"{name}: length is 0 m; it must be > 0"):
        kind(0.0, (STEEL, STEEL))
    with pytest.raises(InputError, match=f"{name}: materials are .*two Material"):
        kind(L, (STEEL,))
    with pytest.raises(InputError, match=f"{name}: restitution is 1.5"):
        kind(L, (STEEL, STEEL), restitution=1.5)
    with pytest.raises(InputError, match=f"{name}: the stiffness depends on radii"):
        kind(L, (STEEL, STEEL)).parameters()
    with pytest.raises(InputError, match=f"{name}: journal_radius is 0.02 m; it must be smaller"):
        kind(L, (STEEL, STEEL)).for_radii(0.02, 0.02)


# -- Kelvin and Voigt ------------------------------------------------------------------------------------------------


@pytest.mark.quick(2)
@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.3, 0.9, 1.0, 1.7])
def test_kelvin_voigt_in_motion(zeta):
    """On paper and by a method that needs no Newton iteration, which the jump at the touch would stop."""
    K, m = 1e9, 0.8
    law = fm.KelvinVoigt(K, 2.0 * zeta * math.sqrt(K * m))
    sol = thrown([law], t_end=6e-4, step=1e-8, mass=m, method=fm.RungeKutta4())
    assert returned(sol, 1)[0] == pytest.approx(law.delivered_restitution(m), abs=2e-4)


def test_kelvin_voigt_on_paper():
    """Critical damping returns exp(-2); little damping exp(-pi zeta)."""
    assert fm.KelvinVoigt(4.0, 4.0).delivered_restitution(1.0) == pytest.approx(math.exp(-2.0), rel=1e-12)
    assert fm.KelvinVoigt(4.0, 4.0 * (1 + 1e-9)).delivered_restitution(1.0) == pytest.approx(math.exp(-2.0), rel=1e-6)
    zeta = 1e-4
    assert fm.KelvinVoigt(1.0, 2.0 * zeta).delivered_restitution(1.0) == pytest.approx(
        math.exp(-math.pi * zeta), abs=3e-8
    )


@pytest.mark.parametrize("e", [0.01, 0.1353, 0.5, 0.9, 1.0])
def test_kelvin_voigt_for_a_restitution(e):
    law = fm.KelvinVoigt.for_restitution(1e7, e, mass=0.3)
    assert law.delivered_restitution(0.3) == pytest.approx(e, rel=1e-12)


def test_a_ramp_takes_the_jump_away():
    """A fixed step of generalised-alpha gets through with a ramp of some steps; the restitution hardly changes."""
    K, m = 1e9, 1.0
    law = fm.KelvinVoigt(K, 2.0 * 0.2 * math.sqrt(K * m), ramp=1e-6)
    sol = thrown([law], t_end=5e-4, step=5e-8, mass=m)
    assert returned(sol, 1)[0] == pytest.approx(fm.KelvinVoigt(K, law.damping).delivered_restitution(m), abs=0.02)
    inside = np.flatnonzero(sol.array("J0.normal_force") > 0.0)
    rise = np.diff(sol.array("J0.normal_force"))[inside[0] - 1]
    assert rise < 0.2 * law.damping  # of the jump C v, v = 1 m/s
    with pytest.raises(InputError, match="with a ramp the restitution depends on the speed"):
        law.delivered_restitution(m)


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ({"stiffness": 0.0, "damping": 1.0}, "stiffness is 0 N/m; it must be > 0"),
        ({"stiffness": 1.0, "damping": -1.0}, "damping is -1 N s/m; it must be >= 0"),
        ({"stiffness": 1.0, "damping": 1.0, "ramp": -1e-6}, "ramp is -1e-06 m; it must be >= 0"),
    ],
)
def test_bad_numbers_of_kelvin_voigt(numbers, text):
    with pytest.raises(InputError, match=f"KelvinVoigt: {text}"):
        fm.KelvinVoigt(**numbers)


def test_bad_numbers_for_a_restitution():
    with pytest.raises(InputError, match=r"KelvinVoigt.for_restitution: restitution is 0; it must be > 0"):
        fm.KelvinVoigt.for_restitution(1.0, 0.0, 1.0)
    with pytest.raises(InputError, match=r"KelvinVoigt.for_restitution: mass is 0 kg; it must be > 0"):
        fm.KelvinVoigt.for_restitution(1.0, 0.5, 0.0)
