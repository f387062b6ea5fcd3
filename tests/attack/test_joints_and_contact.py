"""Contact, friction and imperfect joints, as one would try to break them."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

LAW = fm.ExactRestitution(stiffness=1e8, restitution=0.7)


@pytest.fixture(scope="module")
def rattling():
    """A slider that is thrown about in its guide, saved at instants inside the steps and at all steps."""
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=1e-3, velocity=(0.5, 0.2, 3.0))
    sizes = {"clearance": 1e-3, "half_length": 0.05, "half_height": 0.02}
    guide = fm.PrismaticClearance("G", fm.GROUND, block, normal=LAW, friction=fm.SmoothCoulomb(0.2, 1e-2), **sizes)
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


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (named_inside, r"'\(u := .*' stands inside an expression; give the variable a line of its own"),
        (one_or_the_other, "'slip and slip / p.*' has no derivative that is known"),
    ],
)
def test_a_law_whose_derivative_would_get_lost_is_refused(function, words):
    """tanh(u) has the slope N/v0 at rest; a law that says 0 there lets no Newton iteration converge."""
    slope = plain_kernel.python(np.array([0.05]), 0.0, 0.0, 7.0, (), ())[1]
    assert slope == pytest.approx(-7.0 / 0.05, rel=1e-14)
    with pytest.raises(fm.FlexmbError, match=words):
        _ = fm.friction_law(function).python  # it is made when it is first asked for


def test_conditions_may_join_numbers_that_move():
    @fm.friction_law
    def guarded(p, h, slip, N, z, z_new):
        pressed = N > 0.0 and slip != 0.0
        if pressed or (slip and N):
            return -N * math.tanh(slip / p[0])
        return 0.0

    T, by_slip, by_load = guarded.python(np.array([0.05]), 0.0, 0.02, 7.0, (), ())
    assert T == pytest.approx(-7.0 * math.tanh(0.4), rel=1e-14)
    assert by_slip == pytest.approx(-7.0 / 0.05 / math.cosh(0.4) ** 2, rel=1e-14)
    assert by_load == pytest.approx(-math.tanh(0.4), rel=1e-14)
