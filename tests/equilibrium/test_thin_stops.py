"""Bodies that come to rest on thin stops: equilibria beyond them were found, without a word."""

import math

import numpy as np
import pytest

import flexmb as fm

LAW = fm.KelvinVoigt(1e6, 10.0)
RADIUS = 0.01


def box(middle, half, angle=0.0):
    """Outline of a rectangle with half lengths along and across an angle."""
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return fm.cams.Outline([tuple(map(float, middle + a * half[0] * along + b * half[1] * across)) for a, b in corners])


def pendulum(begin, plate):
    """A bob on a massless rod of 1 m that falls clockwise."""
    bob = math.cos(begin), math.sin(begin)
    body = fm.RigidBody("bob", bob, mass=1.0, inertia=0.01)
    pin = fm.Revolute("pin", fm.GROUND, body, at=(0.0, 0.0))
    circle = fm.cams.CircularCurve(bob, radius=RADIUS)
    touch = fm.cams.OutlineContact("touch", fm.GROUND, plate, body, circle, normal=LAW)
    return fm.Mechanism("pendulum", [body, pin, touch], gravity=(0.0, -9.81))


@pytest.mark.quick(1)
@pytest.mark.parametrize("half", [0.02, 1e-4])
@pytest.mark.parametrize("begin", [1.0, pytest.param(0.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("angle", [-0.4, pytest.param(-1.3, marks=pytest.mark.slow)])
def test_a_pendulum_falls_onto_a_plate(half, begin, angle):
    """It lies above the plate, m g x/k deep: k times the depth balances the weight across the rod."""
    middle = np.array([math.cos(angle), math.sin(angle)])
    found = fm.static_equilibrium(pendulum(begin, box(middle, (0.05, half), angle)))
    assert found.stable
    assert math.atan2(found["bob.y"], found["bob.x"]) == pytest.approx(angle + math.asin(half + RADIUS), abs=2e-5)
    assert found["bob.x"] * middle[1] - found["bob.y"] * middle[0] == pytest.approx(
        -(half + RADIUS) + 9.81 * found["bob.x"] / 1e6, rel=1e-6
    )


def test_a_pendulum_passes_a_plate_beside_its_way():
    found = fm.static_equilibrium(pendulum(0.0, box(np.array([0.8, -0.8]), (0.05, 1e-3), -0.8)))
    assert found["bob.x"] == pytest.approx(0.0, abs=1e-9)
    assert found["bob.y"] == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.quick(1)
@pytest.mark.parametrize("outline", [True, False])
@pytest.mark.parametrize("size", [pytest.param(0.01, marks=pytest.mark.slow), 1e-4])
def test_a_bar_falls_onto_a_stop(outline, size):
    """The bar, 10 mm thick, lies above a round or square stop."""
    bar = fm.RigidBody("bar", (0.5, 0.0), mass=1.0, inertia=0.1)
    side = box(np.array([0.49, 0.0]), (0.51, 0.005))
    if outline:
        stop = box(np.array([0.7, -0.3]), (size, size))
        touch = fm.cams.OutlineOnOutline("touch", bar, side, fm.GROUND, stop, normal=LAW)
        x, y, r = 0.7 + size, -0.3 + size, 0.0  # the corner on the right carries
    else:
        circle = fm.cams.CircularCurve((0.7, -0.3), radius=size)
        touch = fm.cams.OutlineContact("touch", bar, side, fm.GROUND, circle, normal=LAW)
        x, y, r = 0.7, -0.3, size
    pin = fm.Revolute("pin", fm.GROUND, bar, at=(0.0, 0.0))
    found = fm.static_equilibrium(fm.Mechanism("bar", [bar, pin, touch], gravity=(0.0, -9.81)))
    above = math.atan2(y, x) + math.asin((0.005 + r) / math.hypot(x, y))
    assert math.atan2(found["bar.y"], found["bar.x"]) == pytest.approx(above, abs=2e-5)


@pytest.mark.parametrize("half", [0.01, 1e-4])
def test_a_load_presses_a_block_on_springs_onto_a_plate(half):
    """A load step of 0.1 m led through the plate: k u + K (u - gap) = F holds above it."""
    block = fm.RigidBody("block", (0.0, 0.0), mass=1.0, inertia=1.0)
    circle = fm.cams.CircularCurve((0.0, 0.0), radius=RADIUS)
    plate = box(np.array([0.0, -0.05]), (0.1, half))
    parts = [
        block,
        fm.Prismatic("guide", fm.GROUND, block, along=(0.0, 1.0)),
        fm.SpringDamper("spring", fm.GROUND, block, (0.0, 1.0), (0.0, 0.0), stiffness=10.0),
        fm.cams.OutlineContact("touch", fm.GROUND, plate, block, circle, normal=LAW),
        fm.loads.Force("push", block, (0.0, 0.0), (0.0, -1.0)),
    ]
    found = fm.static_equilibrium(fm.Mechanism("press", parts))
    gap = 0.05 - half - RADIUS
    assert -found["block.y"] == pytest.approx((1.0 + 1e6 * gap) / (1e6 + 10.0), rel=1e-9)
