"""Modes seen from a turning frame, with dampers and without: closed forms, and the same models without dampers."""

import math

import numpy as np
import pytest

import flexmb as fm

MASS, STIFFNESS, DAMPING = 2.0, (800.0, 300.0), (30.0, 1.0)


def jeffcott(damping=DAMPING, stiffness=STIFFNESS):
    """A mass on springs and dampers along two axes that turn with it."""
    disc = fm.RigidBody("disc", (0.0, 0.0), mass=MASS, inertia=0.1)
    shaft = fm.Bushing("shaft", fm.GROUND, disc, at=(0.0, 0.0), stiffness=stiffness, torsion=500.0, damping=damping)
    return fm.Mechanism("jeffcott", [disc, shaft])


def exact(speed, damping):
    """Roots s with Im s >= 0 of |m (s^2 - W^2) + d s + k, -+ 2 m W s|, the lowest |s| first."""
    first, second = (np.array([MASS, d, k - MASS * speed**2]) for k, d in zip(STIFFNESS, damping, strict=True))
    roots = np.roots(np.polyadd(np.polymul(first, second), [(2.0 * MASS * speed) ** 2, 0.0, 0.0]))
    return sorted((s for s in roots if s.imag > -1e-9), key=abs)


@pytest.mark.parametrize("speed", [0.0, 0.01, 2.525, 15.0, 25.25])
@pytest.mark.parametrize("damped", [False, True])
def test_rotor_of_two_stiffnesses(speed, damped):
    """Without `damped` dampers count for nothing; at 2.525 rad/s 1.8210 and 3.3073 Hz (with them 1.8395 and 3.0599)."""
    mechanism = jeffcott()
    roots = np.array(exact(speed, DAMPING if damped else (0.0, 0.0)))
    found = fm.modes(mechanism, count=len(roots), at=fm.static_equilibrium(mechanism, spin=speed), damped=damped)
    np.testing.assert_allclose(found.eigenvalues, roots, rtol=1e-9, atol=1e-9 * abs(roots[-1]))
    # below 12.2 and beyond 20 rad/s nothing but a damper drives it; in between one axis has no stiffness left
    assert ("unstable" in found.kinds) == (speed == 15.0 or (damped and speed > 20.0))
    if not damped and speed == 2.525:
        np.testing.assert_allclose(found.frequencies, [1.8210, 3.3073], atol=5e-5)


@pytest.mark.parametrize("damping", [(0.0, 0.0), DAMPING])
def test_divergence_has_a_partner_that_is_not_overdamped(damping):
    """Without a damper, between the critical speeds 12.2 and 20 rad/s: exp(s t) and exp(-s t)."""
    mechanism = jeffcott(damping)
    found = fm.modes(mechanism, count=2, at=fm.static_equilibrium(mechanism, spin=15.0))
    assert sorted(found.kinds) == ["back to unstable", "unstable"]
    assert found.eigenvalues.sum() == pytest.approx(0.0, abs=1e-9)


def test_frequencies_begin_at_those_without_speed():
    mechanism = jeffcott()
    still, slow = (
        fm.modes(mechanism, count=3, at=fm.static_equilibrium(mechanism, spin=w)).frequencies for w in (0.0, 1e-4)
    )
    np.testing.assert_allclose(slow, still, rtol=1e-9)


def cantilever(elements, **damping):
    beam = fm.FlexibleLink(
        "beam", (0.1, 0.0), (1.1, 0.0), section=fm.Rectangle(0.02, 0.01), material=fm.STEEL, elements=elements,
        **damping,
    )  # fmt: skip
    return fm.Mechanism("blade", [beam, fm.Fixed("hub", fm.GROUND, beam, at=(0.1, 0.0))])


@pytest.mark.parametrize("elements", [4, pytest.param(64, marks=pytest.mark.slow)])
@pytest.mark.parametrize("speed", [3.0, 100.0])
def test_blade_with_damping_of_its_material(elements, speed):
    """Frequencies without `damped` are those of a blade without damping."""
    found = []
    for damping in ({}, {"damping": 1e-5, "mass_damping": 20.0}):
        blade = cantilever(elements, **damping)
        found.append(fm.modes(blade, count=4, at=fm.static_equilibrium(blade, spin=speed)))
    bare, plain = found
    np.testing.assert_allclose(plain.frequencies, bare.frequencies, rtol=1e-7)
    np.testing.assert_allclose(plain.damping, 0.0, atol=1e-7)
    assert plain.kinds == ("elastic",) * 4
    losing = fm.modes(blade, count=1, at=fm.static_equilibrium(blade, spin=speed), damped=True)
    assert losing.damping[0] > 1e-3


def test_dampers_within_a_rotor():
    """A disc on an arm of a driven hub, off the centre: springs and dampers between both turn with the frame."""
    speed, found = 12.0, []
    for d in (0.0, 3.0):
        hub = fm.RigidBody("hub", (0.0, 0.0), mass=1.0, inertia=0.1)
        disc = fm.RigidBody("disc", (0.3, 0.1), mass=MASS, inertia=0.02)
        parts = [
            fm.Revolute("O", fm.GROUND, hub, at=(0.0, 0.0)), fm.Drive("motor", "O", fm.ConstantSpeed(speed)),
            fm.Bushing("arm", hub, disc, at=(0.25, 0.12), stiffness=(2e3, 3e3), torsion=200.0, damping=(d, 2.0 * d)),
            fm.SpringDamper("guy", hub, disc, (-0.1, 0.2), (0.3, 0.2), stiffness=500.0, damping=4.0 * d),
            fm.TorsionSpring("twist", hub, disc, stiffness=50.0, damping=0.01 * d),
        ]  # fmt: skip
        rotor = fm.Mechanism("rotor", [hub, disc, *parts])
        state = fm.static_equilibrium(rotor, spin=speed)
        found.append(fm.modes(rotor, count=3, at=state))
    np.testing.assert_allclose(found[1].frequencies, found[0].frequencies, rtol=1e-9)
    np.testing.assert_allclose(found[1].damping, 0.0, atol=1e-9)
    damped = fm.modes(rotor, count=3, at=state, damped=True)
    assert np.all(damped.damping > 0.01)
    assert not math.isclose(damped.frequencies[0], found[0].frequencies[0], rel_tol=1e-6)
