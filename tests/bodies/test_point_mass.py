"""Particles: pendulum, bead on a turning wire, flight; two degrees of freedom; parts that would turn a particle."""

import math

import numpy as np
import pytest
from scipy.special import ellipk

import flexmb as fm
from flexmb.errors import InputError, ModelError

O, P = (0.0, 0.0), (0.6, 0.0)
PointMass = fm.bodies.PointMass


def pendulum(*more, first=O):
    bob = PointMass("bob", at=P, mass=2.0)
    rod = fm.couplings.Distance("rod", fm.GROUND, bob, at=first, to=P)
    return fm.Mechanism("pendulum", [bob, rod, *more], gravity=(0.0, -9.81))


def test_a_wide_pendulum():
    """Released at 90 degrees: period 4 sqrt(l/g) K(1/2), tension 3 m g at the bottom."""
    period = 4.0 * math.sqrt(0.6 / 9.81) * ellipk(0.5)
    sol = fm.simulate(pendulum(), t_end=1.25 * period, step=fm.Adaptive(rtol=1e-7))
    assert sol.ok, sol.status
    assert sol["bob.x"].values[np.searchsorted(sol.time, period)] == pytest.approx(0.6, abs=1e-5)
    assert sol["bob.y"].values[-1] == pytest.approx(-0.6, abs=1e-5)
    assert sol["rod.force"].values[-1] == pytest.approx(3.0 * 2.0 * 9.81, rel=1e-4)
    assert np.all(sol["bob.theta"].values == 0.0)
    assert fm.check(pendulum()).freedom == 1


def test_a_flight_has_two_freedoms():
    stone = PointMass("stone", at=P, mass=0.3, velocity=(1.0, 4.0))
    mech = fm.Mechanism("flight", [stone], gravity=(0.0, -9.81))
    sol = fm.simulate(mech, t_end=0.7)
    assert sol["stone.x"].values == pytest.approx(0.6 + sol.time, abs=1e-12)
    assert sol["stone.y"].values == pytest.approx(4.0 * sol.time - 0.5 * 9.81 * sol.time**2, abs=1e-9)
    assert fm.check(mech).freedom == 2


def test_a_bead_on_a_turning_wire():
    """r = r0 cosh(w t) from rest on the wire, pressed with 2 m w r'."""
    w, m = 4.0, 0.2
    wire = fm.RigidLink("wire", O, (1.0, 0.0), mass=1.0, inertia=0.1)
    bead = PointMass("bead", at=(0.1, 0.0), mass=m)
    mech = fm.Mechanism("wire", [
        wire, bead, fm.Revolute("O", fm.GROUND, wire, at=O), fm.PinSlot("slot", wire, bead, at=(0.1, 0.0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(w)),
    ])  # fmt: skip
    sol = fm.simulate(mech, t_end=0.5, step=fm.Adaptive(rtol=1e-7))
    assert sol.ok, sol.status
    r = np.hypot(sol["bead.x"].values, sol["bead.y"].values)
    assert r == pytest.approx(0.1 * np.cosh(w * sol.time), rel=1e-5)
    pressed = 2.0 * m * w * 0.1 * w * np.sinh(w * sol.time)
    assert sol["slot.force"].values == pytest.approx(pressed, abs=1e-4 * pressed.max())


def test_modes_have_no_rotation():
    """Two masses and three springs in line: (k/m) and 3 (k/m), twice the frequency 0 across: no further mode."""
    one, two = PointMass("one", at=(1.0, 0.0), mass=2.0), PointMass("two", at=(2.0, 0.0), mass=2.0)

    def spring(name, first, second, at, to):
        return fm.SpringDamper(name, first, second, at=at, to=to, stiffness=800.0)

    wires = [fm.PinSlot(f"wire{k}", fm.GROUND, body, at=body.at) for k, body in enumerate((one, two))]
    mech = fm.Mechanism("chain", [
        one, two, *wires, spring("a", fm.GROUND, one, O, one.at), spring("b", one, two, one.at, two.at),
        spring("c", two, fm.GROUND, two.at, (3.0, 0.0)),
    ])  # fmt: skip
    found = fm.modes(mech)
    assert found.frequencies == pytest.approx(np.sqrt([400.0, 1200.0]) / (2.0 * math.pi), rel=1e-9)


BODY = fm.RigidBody("body", at=O, mass=1.0, inertia=1.0)
BOB = PointMass("bob", at=P, mass=2.0)
PIN = fm.Revolute("pin", BODY, BOB, at=P)


@pytest.mark.parametrize(
    ("parts", "label"),
    [
        ([fm.Fixed("weld", BODY, BOB, at=P)], "Fixed 'weld'"),
        ([fm.Prismatic("slide", BODY, BOB)], "Prismatic 'slide'"),
        ([fm.PinSlot("slot", BOB, BODY, at=P, along=(1.0, 2.0))], "PinSlot 'slot'"),
        ([fm.Torque("load", BOB, 1.0)], "Torque 'load'"),
        ([fm.TorsionSpring("spring", BODY, BOB, stiffness=1.0)], "TorsionSpring 'spring'"),
        ([fm.Gear("mesh", BODY, BOB, teeth=(20, 30))], "Gear 'mesh'"),
        ([PIN, fm.Drive("motor", "pin", fm.ConstantSpeed(1.0))], "Drive 'motor'"),
        (
            [fm.Revolute("pin", BODY, BOB, at=P, friction=fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-2), radius=0.01)],
            "Revolute",
        ),
        ([PIN, fm.Stop("end", "pin", above=1.0, normal=fm.KelvinVoigt(1e4, 0.0))], "Stop 'end'"),
    ],
)
def test_parts_that_turn_a_particle_are_refused(parts, label):
    with pytest.raises(ModelError, match=f"{label}.* needs the rotation of PointMass 'bob', which has none"):
        fm.Mechanism("bad", [BODY, BOB, *parts])


def test_parts_that_hold_the_point_are_taken():
    cable = fm.couplings.Cable("rope", BODY, BOB, at=O, to=P, normal=fm.KelvinVoigt(1e4, 0.0))
    rest = [fm.Force("push", BOB, at=P, force=(1.0, 0.0)), fm.Marker("tip", BOB, at=P), cable]
    bush = fm.Bushing("rubber", BODY, fm.RigidBody("other", at=P, mass=1.0, inertia=1.0), at=P, stiffness=1e3)
    mech = fm.Mechanism("good", [BODY, BOB, bush.second, bush, *rest])
    assert fm.simulate(mech, t_end=0.01).ok


def test_wrong_particles_are_refused():
    with pytest.raises(InputError, match="mass is 0 kg; it must be > 0"):
        PointMass("bob", at=O, mass=0.0)
    with pytest.raises(InputError, match=r"velocity is \(1, 2, 3\); it must be a pair"):
        PointMass("bob", at=O, mass=1.0, velocity=(1, 2, 3))
    with pytest.raises(InputError, match=r"the point \(0.7, 0\) lies 0.1 m beside PointMass 'bob'"):
        fm.simulate(fm.Mechanism("beside", [BOB, fm.Revolute("pin", fm.GROUND, BOB, at=(0.7, 0.0))]), t_end=1.0)
