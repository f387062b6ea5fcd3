"""Equilibrium and modes in a turning frame, against exact values and the time loop."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

LENGTH, EA, EI, RHO_A = 1.0, 2.0e5, 2.0, 5.0
MATERIAL = fm.Material(young=1e10, density=RHO_A * 1e10 / EA)
SECTION = fm.GeneralSection(area=EA / 1e10, second_moment=EI / 1e10)


def hub(x0=0.0, elements=8, drive=None, gravity=(0.0, 0.0), centre=(0.0, 0.0), **options):
    """A radial beam whose clamp is at distance x0 from the centre of rotation."""
    start = (centre[0] + x0, centre[1])
    end = (start[0] + LENGTH, start[1])
    beam = fm.FlexibleLink("beam", start, end, section=SECTION, material=MATERIAL, elements=elements, **options)
    if drive is None:
        joints = [fm.Fixed("hub", fm.GROUND, beam, at=start)]
    else:
        joints = [fm.Revolute("O", fm.GROUND, beam, at=start), fm.Drive("motor", "O", fm.ConstantSpeed(drive))]
    return fm.Mechanism("turning", [beam, *joints], gravity=gravity)


@pytest.mark.parametrize("drive", [None, 5.0])
def test_pull_at_the_hub(drive):
    """Half the mass times the mean centrifugal acceleration: m W^2 L^2/2, stretched by 1 + 2.1e-4."""
    found = fm.static_equilibrium(hub(drive=drive), spin=5.0)
    pull = RHO_A * 25.0 * LENGTH**2 / 2
    assert -found.force("O" if drive else "hub")[0] == pytest.approx(pull, rel=1e-3)
    assert found.spin == 5.0


def test_stretch_converges_to_the_exact_one():
    """Exact with stretch: u = tan(k L)/k - L, k = W sqrt(m/EA); second order in the element length.

    Each material point X moves to r(X) with EA r'' = -m W^2 r, r(0) = 0, r'(L) = 1.
    """
    k = 5.0 * math.sqrt(RHO_A / EA)
    exact = math.tan(k * LENGTH) / k - LENGTH
    errors = [fm.static_equilibrium(hub(elements=n), spin=5.0)["beam.end.x"] - LENGTH - exact for n in (4, 8, 16)]
    assert abs(errors[2]) < 1e-3 * exact
    assert math.log2(errors[1] / errors[2]) > 1.9


def test_the_centre_of_rotation_counts():
    """A clamp at 0.5 m from a centre anywhere: m W^2 ((x0 + L)^2 - x0^2)/2."""
    pull = RHO_A * 25.0 * (1.5**2 - 0.5**2) / 2
    found = fm.static_equilibrium(hub(x0=0.5, centre=(3.0, -2.0)), spin=5.0, about=(3.0, -2.0))
    assert -found.force("hub")[0] == pytest.approx(pull, rel=1e-3)


def test_a_turning_point_mass_on_springs():
    """Mass in two springs k (radial and across, far away, unstressed at radius R) seen from the turning frame.

    With two equal springs at right angles whose lengths are so large that they act along x and y only:
    x = R k/(k - m W^2) and s = i (w +- W), w = sqrt(k/m) (the motion is a harmonic one in the fixed frame).
    """
    k, m, W, far = 40.0, 2.0, 1.5, 1e6
    body = fm.RigidBody("mass", (0.0, 0.0), mass=m, inertia=1.0)
    springs = [
        fm.SpringDamper("kx", fm.GROUND, body, (-far, 0.0), (0.0, 0.0), stiffness=k),
        fm.SpringDamper("ky", fm.GROUND, body, (0.0, -far), (0.0, 0.0), stiffness=k),
        fm.TorsionSpring("kt", fm.GROUND, body, stiffness=1e3),
    ]
    mechanism = fm.Mechanism("mass", [body, *springs])
    state = fm.static_equilibrium(mechanism, spin=W)
    found = fm.modes(mechanism, at=state)
    w = math.sqrt(k / m)
    # the torsion spring: theta is an angle in the turning frame as well
    exact = sorted([w - W, w + W, math.sqrt(1e3)])
    np.testing.assert_allclose(2 * math.pi * found.frequencies, exact, rtol=1e-6)
    np.testing.assert_allclose(found.damping, 0.0, atol=1e-9)


def test_too_fast_a_shaft_with_damping_at_rest_in_the_turning_frame_is_unstable():
    """Jeffcott rotor with internal damping: unstable above W = w (1 + d_outer/d_inner), here above w.

    Source: J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956, section 7.4 (internal hysteresis).
    """
    k, m, d, far = 40.0, 2.0, 0.5, 1e6
    w = math.sqrt(k / m)
    body = fm.RigidBody("mass", (0.0, 0.0), mass=m, inertia=1.0)
    springs = [
        fm.SpringDamper("kx", fm.GROUND, body, (-far, 0.0), (0.0, 0.0), stiffness=k, damping=d),
        fm.SpringDamper("ky", fm.GROUND, body, (0.0, -far), (0.0, 0.0), stiffness=k, damping=d),
        fm.TorsionSpring("kt", fm.GROUND, body, stiffness=1e3),
    ]
    mechanism = fm.Mechanism("jeffcott", [body, *springs])
    for share, stable in ((0.9, True), (1.1, False)):
        found = fm.modes(mechanism, at=fm.static_equilibrium(mechanism, spin=share * w), damped=True)
        assert ("unstable" not in found.kinds) == stable
        # (s + i W)^2 m + d s + k = 0
        roots = np.roots([m, d + 2j * m * share * w, k - m * (share * w) ** 2])
        growth = max(s.real for s in roots)
        assert found.eigenvalues.real.max() == pytest.approx(max(growth, 0.0), rel=1e-5, abs=1e-7)


def test_small_vibration_in_the_time_loop():
    """The tip of a turning beam swings at the frequency that `modes` says: a chord of the time loop against it.

    Start: the beam of the drawn pose turns as a rigid body, so it is stretched suddenly; a small push across comes from
    a torque.  The in-plane angle of the tip against the hub is fitted by the two lowest modes.
    """
    W = 8.0
    mechanism = hub(drive=W, elements=4)
    state = fm.static_equilibrium(mechanism, spin=W)
    first = fm.modes(mechanism, count=1, at=state).frequencies[0]
    pushed = mechanism.with_part(fm.Torque("push", mechanism.find("beam"), 1e-3, at=(LENGTH, 0.0)))
    cycles = 8
    steps = 2400
    sol = fm.simulate(
        pushed, t_end=cycles / first, step=cycles / first / steps, save="steps", method=fm.Newmark.trapezoidal()
    )
    t = sol.time
    angle = np.arctan2(sol.array("beam.end.y"), sol.array("beam.end.x")) - W * t
    angle = np.unwrap(angle + math.pi) - math.pi

    def misfit(f):
        basis = np.column_stack([np.ones_like(t), np.cos(2 * math.pi * f * t), np.sin(2 * math.pi * f * t)])
        return float(np.linalg.lstsq(basis, angle, rcond=None)[1][0])

    trial = first * np.linspace(0.99, 1.01, 201)
    best = trial[int(np.argmin([misfit(f) for f in trial]))]
    assert best == pytest.approx(first, rel=2e-3)
    assert misfit(best) < 0.02 * float(((angle - angle.mean()) ** 2).sum())


def test_gravity_is_not_steady():
    with pytest.raises(
        InputError, match=r"static_equilibrium: gravity is \(0.0, -9.81\) and spin is 5 rad/s.*simulate"
    ):
        fm.static_equilibrium(hub(gravity=(0.0, -9.81)), spin=5.0)
    state = fm.static_equilibrium(hub(), spin=5.0)
    with pytest.raises(InputError, match=r"modes: gravity is"):
        fm.modes(hub(gravity=(0.0, -9.81)), at=state)


def test_a_drive_of_another_speed_is_not_steady():
    with pytest.raises(InputError, match=r"drive 'motor' moves at 3 and the frame turns at 5 rad/s"):
        fm.static_equilibrium(hub(drive=3.0), spin=5.0)


@pytest.mark.parametrize("spin", [float("nan"), "fast"])
def test_spin_is_a_number(spin):
    with pytest.raises(InputError, match="static_equilibrium: spin is"):
        fm.static_equilibrium(hub(), spin=spin)


@pytest.mark.parametrize(
    "law",
    [fm.contact.Hertz(stiffness=1e4), pytest.param(fm.HuntCrossley(1e4, restitution=0.9), marks=pytest.mark.slow)],
)
def test_link_is_pressed_on_its_stop_by_its_own_rotation(law):
    """A hinged link on a hub: moment of m W^2 r about the hinge against k x^1.5 of the stop, whatever its damping."""
    disc = fm.RigidBody("hub", at=(0.0, 0.0), mass=1.0, inertia=0.01)
    link = fm.RigidLink("link", (0.2, 0.0), (0.5, 0.05), mass=0.5, inertia=1e-3)
    parts = [fm.Revolute("O", fm.GROUND, disc, at=(0.0, 0.0)), fm.Revolute("A", disc, link, at=(0.2, 0.0))]
    motor, stop = fm.Drive("motor", "O", fm.ConstantSpeed(30.0)), fm.Stop("stop", "A", below=-0.05, normal=law)
    found = fm.static_equilibrium(fm.Mechanism("pressed", [disc, link, *parts, motor, stop]), spin=30.0)
    turned = found["link.theta"] - math.atan2(0.05, 0.3)  # of the joint; the stop acts below -0.05 rad
    x, y = found["link.x"], found["link.y"]
    moment = 0.5 * 30.0**2 * ((x - 0.2) * y - y * x)
    assert moment + 1e4 * (-0.05 - turned) ** 1.5 == pytest.approx(0.0, abs=1e-8 * abs(moment))
    assert found.stable
