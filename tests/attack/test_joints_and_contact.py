"""Contact, friction and imperfect joints, as one would try to break them."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

LAW = fm.contact.ExactRestitution(stiffness=1e8, restitution=0.7)


@pytest.fixture(scope="module")
def rattling():
    """A slider that is thrown about in its guide, saved at instants inside the steps and at all steps."""
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=1e-3, velocity=(0.5, 0.2, 3.0))
    sizes = {"clearance": 1e-3, "half_length": 0.05, "half_height": 0.02}
    guide = fm.PrismaticClearance(
        "G", fm.GROUND, block, normal=LAW, friction=fm.friction.SmoothCoulomb(0.2, 1e-2), **sizes
    )
    mech = fm.Mechanism("rattling", [block, guide], gravity=(0.0, -9.81))
    return [fm.simulate(mech, t_end=0.05, step=1e-5, save=save) for save in (3333, "steps")]


def test_a_mode_is_a_whole_number_at_every_saved_instant(rattling):
    """Between free (0) and a corner that touches (1) lies nothing, so nothing is interpolated."""
    between, steps = (set(np.unique(sol.array("G.mode"))) for sol in rattling)
    assert between == steps
    assert steps == {0.0, 1.0}


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("at", lambda pair: fm.RevoluteClearance(
            "J", fm.GROUND, fm.RigidBody("b", (0.0, 0.0), 1.0, 1.0), at=pair, clearance=1e-3, bearing_radius=0.01,
            normal=LAW,
        )),
        ("along", lambda pair: fm.Bushing(
            "J", fm.GROUND, fm.RigidBody("b", (0.0, 0.0), 1.0, 1.0), at=(0.0, 0.0), stiffness=1e5, along=pair
        )),
    ],
)  # fmt: skip
def test_an_array_without_dimensions_is_no_pair(name, make):
    with pytest.raises(InputError, match=rf"{name} is array\(0.002\); it must be a pair"):
        make(np.array(0.002))


@fm.friction_law
def plain_kernel(p, h, slip, N, z, z_new):
    u = slip / p[0]
    return -N * math.tanh(u)


def named_inside(p, h, slip, N, z, z_new):
    """The same force as `plain_kernel`; u gets its value inside the condition."""
    if (u := slip / p[0]) > 0.0:
        return -N * math.tanh(u)
    return N * math.tanh(-u)


def one_or_the_other(p, h, slip, N, z, z_new):
    """The same; what `and` hands back is slip/v0 unless the slip is 0."""
    u = slip and slip / p[0]
    return -N * math.tanh(u)


@pytest.mark.parametrize("function", [named_inside, one_or_the_other])
def test_no_way_of_writing_a_law_loses_its_derivative(function):
    """tanh(u) has the slope N/v0 at rest; a law that says 0 there lets no Newton iteration converge."""
    slope = plain_kernel.python(np.array([0.05]), 0.0, 0.0, 7.0, (), ())[1]
    assert slope == pytest.approx(-7.0 / 0.05, rel=1e-9)
    assert fm.friction_law(function).python(np.array([0.05]), 0.0, 0.0, 7.0, (), ())[1] == pytest.approx(
        slope, rel=1e-9
    )


def test_conditions_may_join_numbers_that_move():
    @fm.friction_law
    def guarded(p, h, slip, N, z, z_new):
        pressed = N > 0.0 and slip != 0.0
        if pressed or (slip and N):
            return -N * math.tanh(slip / p[0])
        return 0.0

    force, by_slip, by_load = guarded.python(np.array([0.05]), 0.0, 0.02, 7.0, (), ())
    assert force == pytest.approx(-7.0 * math.tanh(0.4), rel=1e-14)
    assert by_slip == pytest.approx(-7.0 / 0.05 / math.cosh(0.4) ** 2, rel=1e-9)
    assert by_load == pytest.approx(-math.tanh(0.4), rel=1e-9)


def test_a_slot_without_length_is_a_round_bearing():
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1e-3, velocity=(0.5, 0.2, 3.0))
    given = {"at": (0.0, 0.0), "clearance": 1e-3, "normal": LAW, "friction": fm.friction.SmoothCoulomb(0.3, 1e-2)}
    slot = fm.PinSlotClearance("J", fm.GROUND, pin, pin_radius=0.009, length=0.0, **given)
    bearing = fm.RevoluteClearance("J", fm.GROUND, pin, bearing_radius=0.01, **given)
    one, other = (fm.simulate(fm.Mechanism("m", [pin, j]), t_end=0.02, step=2e-6) for j in (slot, bearing))
    assert len(one.episodes("J")) == len(other.episodes("J")) > 2
    for name in ("pin.x", "pin.y", "pin.omega", "J.ex", "J.vey", "J.normal_force", "J.friction_force"):
        want = other.array(name)
        np.testing.assert_allclose(one.array(name), want, rtol=0, atol=1e-9 * np.abs(want).max())


def test_a_drive_works_against_the_friction_of_its_own_joint():
    """s = t/2 + 3 t^2/2: force m 3 + mu (m g + preload); a guide that is held beside the weight adds 2 m g d/l."""
    mass, mu, preload, length, aside = 2.0, 0.25, 7.0, 0.2, 0.3
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=mass, inertia=1e-2)
    law = fm.friction.SmoothCoulomb(mu, 1e-6)
    drive = fm.Drive("motor", "P", fm.drives.Polynomial((0.0, 0.5, 1.5)))
    for d, load in ((0.0, mass * 9.81), (aside, 2.0 * mass * 9.81 * aside / length)):
        guide = fm.Prismatic("P", fm.GROUND, block, at=(d, 0.0), friction=law, length=length, preload=preload)
        mech = fm.Mechanism("pushed", [block, guide, drive], gravity=(0.0, -9.81))
        sol = fm.simulate(mech, t_end=0.2, step=1e-4)
        force = 3.0 * mass + mu * (load + preload)
        np.testing.assert_allclose(sol.array("motor.force")[5:], force, rtol=1e-9)
        way = 0.5 * 0.2 + 1.5 * 0.2**2
        assert sol.array("energy.dissipated_friction")[-1] == pytest.approx(mu * (load + preload) * way, rel=1e-6)
