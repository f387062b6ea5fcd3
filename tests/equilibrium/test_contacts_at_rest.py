"""Cables, stops and journals that carry: stiffness in modes and buckling, forces in inverse dynamics."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.errors import InputError

G = 9.81
DOWN = (0.0, -G)


def block(*parts, mass=10.0):
    """A block on a vertical guide."""
    body = fm.RigidBody("block", (0.0, -1.0), mass=mass, inertia=1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(0.0, 1.0))
    return fm.Mechanism("block", [body, guide, *(part(body) for part in parts)], gravity=DOWN)


def rope(body):
    return fm.couplings.Cable("rope", fm.GROUND, body, (0.0, 0.0), (0.0, -1.0), normal=fm.KelvinVoigt(5e4, 20.0))


def test_a_weight_on_a_cable():
    """sqrt(k/m)/2 pi = 11.25 Hz; the rope was left out, and the weight called rigid."""
    hung = block(rope)
    found = fm.modes(hung, at=fm.static_equilibrium(hung))
    assert found.kinds == ("elastic",)
    assert found.frequencies[0] == pytest.approx(math.sqrt(5e4 / 10.0) / (2 * math.pi), rel=1e-9)
    assert not found.left_out
    damped = fm.modes(hung, at=fm.static_equilibrium(hung), damped=True)
    assert damped.damping[0] == pytest.approx(20.0 / (2.0 * math.sqrt(5e4 * 10.0)), rel=1e-6)


def test_a_weight_pressed_on_a_stop():
    """The equilibrium was refused as none.  Hertz: N = k d^1.5, dN/dd = 1.5 N/d with N = m g."""
    pressed = block(lambda body: fm.Stop("stop", "guide", below=0.0, above=1.0, normal=fm.contact.Hertz(stiffness=1e8)))
    at = fm.static_equilibrium(pressed)
    depth = (10.0 * G / 1e8) ** (2.0 / 3.0)
    assert at["block.y"] == pytest.approx(-1.0 - depth, abs=1e-12)
    found = fm.modes(pressed, at=at)
    assert found.frequencies[0] == pytest.approx(math.sqrt(1.5 * G / depth) / (2 * math.pi), rel=1e-9)
    assert found.left_out == ("stop.above",)
    assert str(found).endswith("of a pose in which they carry.")


def test_about_the_reference_configuration_contacts_are_named():
    found = fm.modes(block(rope))
    assert found.kinds[0].startswith("rigid")
    assert found.left_out == ("rope",)
    assert "Without stiffness here, since they do not carry: rope. Give at=" in str(found)
    assert "do not carry: rope" in found._repr_html_()
    assert not fm.modes(fm.Mechanism("free", [fm.RigidBody("b", (0.0, 0.0), mass=1.0, inertia=1.0)])).left_out


def test_a_journal_under_load():
    """Along the load k, across it N/e: a pendulum as long as clearance and penetration."""
    body = fm.RigidBody("pan", (0.0, 0.0), mass=2.0, inertia=1.0)
    play = fm.RevoluteClearance(
        "pin", fm.GROUND, body, at=(0.0, 0.0), clearance=1e-3, bearing_radius=0.01, normal=fm.KelvinVoigt(1e6, 0.0)
    )
    spring = fm.TorsionSpring("turn", fm.GROUND, body, stiffness=9.0)
    hung = fm.Mechanism("pan", [body, play, spring], gravity=DOWN)
    at = fm.static_equilibrium(hung)
    assert at["pan.y"] == pytest.approx(-1e-3 - 2.0 * G / 1e6, abs=1e-12)
    found = fm.modes(hung, at=at)
    expected = np.array([3.0, math.sqrt(G / (1e-3 + 2.0 * G / 1e6)), math.sqrt(1e6 / 2.0)]) / (2 * math.pi)
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-8)
    ideal = fm.static_equilibrium(hung.with_part(fm.Revolute("pin", fm.GROUND, body, at=(0.0, 0.0))))
    np.testing.assert_allclose(fm.modes(hung, at=ideal).frequencies, expected[:1], rtol=1e-8)


LENGTH, EI, LINE = 2.0, 3.0, 0.4
MATERIAL = fm.Material(young=1e9, density=LINE / 0.1)
SECTION = fm.GeneralSection(area=0.1, second_moment=EI / 1e9)
STIFF, TENSION, REACH = 1e3, 2.0, 2.0
ROPE = math.hypot(LENGTH, REACH)


def guys(body, *, tension=TENSION):
    """Two guys from the top of a column to the ground."""
    law = fm.KelvinVoigt(STIFF, 0.0)
    return [
        fm.couplings.Cable(name, fm.GROUND, body, foot, (0.0, LENGTH), free_length=ROPE - tension / STIFF, normal=law)
        for name, foot in (("west", (-REACH, 0.0)), ("east", (REACH, 0.0)))
    ]


def guyed(*, tension=TENSION, load=1.0, elements=12):
    beam = fm.FlexibleLink("beam", (0, 0), (0, LENGTH), section=SECTION, material=MATERIAL, elements=elements)
    parts = [beam, fm.Fixed("foot", fm.GROUND, beam, at=(0, 0)), *guys(beam, tension=tension)]
    push = [fm.Force("P", beam, (0.0, LENGTH), (0.0, -load))] if load else []
    return fm.Mechanism("guyed", [*parts, *push])


def guy_stiffness(tension):
    """Of both guys at the top across the column: 2 (k sin^2 + T/l cos^2)."""
    return 2.0 * (STIFF * (REACH / ROPE) ** 2 + tension / ROPE * (LENGTH / ROPE) ** 2)


def test_a_guyed_column_buckles_as_one_with_a_spring_at_its_top():
    """tan x/x = 1 - P/(c L), x^2 = P L^2/EI, clamped at the foot.

    Without the guys 2.47 EI/L^2; a stiff spring makes it 20.19.  The pretension is part of P.
    """
    c = guy_stiffness(TENSION)
    x = brentq(lambda x: math.tan(x) / x - 1.0 + EI * x**2 / (c * LENGTH**3), 3.3, 4.65)
    found = fm.buckling(guyed(), count=1)
    assert found.factors[0] == pytest.approx(x**2 * EI / LENGTH**2 - 2.0 * TENSION * LENGTH / ROPE, rel=1e-4)
    assert found.factors[0] > 0.75 * 20.19 - 2.0 * TENSION
    assert not found.notes
    assert not found.left_out
    assert found.from_half == pytest.approx(found.factors[0], rel=0.02)


def test_slack_guys_of_a_column_are_named():
    found = fm.buckling(guyed(tension=0.0), count=1)
    assert found.factors[0] == pytest.approx(math.pi**2 / 4.0 * EI / LENGTH**2, rel=1e-4)
    assert found.left_out == ("west", "east")
    assert str(found).endswith("do not carry: west, east. Give them pretension if they are to count.")


def test_the_frequency_of_a_guyed_column():
    """EI w'''' + N w'' = m omega^2 w, clamped; EI w'' = 0 and EI w''' + N w' = c w at the top."""
    N, c = 2.0 * TENSION * LENGTH / ROPE, guy_stiffness(TENSION)

    def equation(omega):
        half = N / (2.0 * EI)
        root = math.sqrt(half**2 + LINE * omega**2 / EI)
        a, b = math.sqrt(root + half), math.sqrt(root - half)
        s, k, sh, ch = math.sin(a * LENGTH), math.cos(a * LENGTH), math.sinh(b * LENGTH), math.cosh(b * LENGTH)
        # w = A (sin ax - a/b sinh bx) + B (cos ax - cosh bx)
        w = np.array([s - a / b * sh, k - ch])
        slope = np.array([a * (k - ch), -a * s - b * sh])
        bend = np.array([-a * a * s - a * b * sh, -a * a * k - b * b * ch])
        third = np.array([-(a**3) * k - a * b * b * ch, a**3 * s - b**3 * sh])
        return float(np.linalg.det([bend, EI * third + N * slope - c * w]))

    free = guyed(load=0.0)
    omega = brentq(equation, 9.0, 12.0)
    found = fm.modes(free, count=1, at=fm.static_equilibrium(free))
    assert found.frequencies[0] == pytest.approx(omega / (2 * math.pi), rel=1e-4)
    alone = 1.8751**2 * math.sqrt(EI / LINE) / LENGTH**2
    assert omega > 3.9 * alone


def test_a_guyed_mast_on_a_hinge():
    """V'' = sum (k l'^2 + T l'') - m g L/2 with l' = a L/D, l'' = -(a L)^2/D^3; without guys it falls."""
    mast = fm.RigidLink("mast", (0.0, 0.0), (0.0, LENGTH), 5.0, 2.0)
    hinge = fm.Revolute("foot", fm.GROUND, mast, at=(0.0, 0.0))
    standing = fm.Mechanism("mast", [mast, hinge, *guys(mast, tension=50.0)], gravity=DOWN)
    found = fm.modes(standing, at=fm.static_equilibrium(standing))
    turn = (REACH * LENGTH) ** 2 / ROPE**2
    stiffness = 2.0 * turn * (STIFF - 50.0 / ROPE) - 5.0 * G * LENGTH / 2.0
    omega = math.sqrt(stiffness / (2.0 + 5.0 * (LENGTH / 2.0) ** 2))
    assert found.frequencies[0] == pytest.approx(omega / (2 * math.pi), rel=1e-8)


def test_an_equilibrium_with_other_joints_says_which_number_differs():
    """It said "has 6 coordinates, the model 6"."""
    two = fm.RigidBody("a", (0.0, 0.0), mass=1.0, inertia=1.0), fm.RigidBody("b", (1.0, 0.0), mass=1.0, inertia=1.0)
    held = [fm.Fixed(f"hold_{body.name}", fm.GROUND, body, at=(0.0, 0.0)) for body in two]
    at = fm.static_equilibrium(fm.Mechanism("held", [*two, *held]))
    pinned = fm.Mechanism("pinned", [*two, *(fm.Revolute(f"pin_{b.name}", fm.GROUND, b, at=(0.0, 0.0)) for b in two)])
    with pytest.raises(InputError, match=r"the equilibrium has 6 equations of joints, the model 4\. Use its own"):
        fm.modes(pinned, at=at)


def test_inverse_dynamics_feels_a_taut_cable():
    """The torque that holds a crank is that of the rope: k (l - l0) times its lever arm; the rope was left out."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.5, 0.0), 1.0, 0.1)
    law = fm.KelvinVoigt(2e3, 0.0)
    parts = [
        crank,
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Drive("motor", "O", fm.drives.ConstantSpeed(3.0)),
        fm.couplings.Cable("rope", fm.GROUND, crank, (1.0, 0.0), (0.5, 0.0), free_length=0.6, normal=law),
    ]
    times = np.array([0.0, 0.1, 0.4, 0.7])
    found = fm.inverse_dynamics(fm.Mechanism("crank", parts), times)
    angle = 3.0 * times
    far = np.sqrt(1.25 - np.cos(angle))
    pull = 2e3 * np.maximum(far - 0.6, 0.0)
    np.testing.assert_allclose(found.torque("motor"), pull * 0.5 * np.sin(angle) / far, rtol=1e-9, atol=1e-9)
    assert found.torque("motor")[2] > 100.0


@pytest.mark.quick(7)
@pytest.mark.parametrize("load_steps", [1, 4, 10, 16])
@pytest.mark.parametrize(("gap", "side"), [(0.005, 1.0), (0.01, -1.0), (0.04, 1.0)])
@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e8])
def test_a_stop_that_begins_to_carry_is_no_snap_through(stiffness, gap, side, load_steps):
    """x = (F + k_s gap)/(k + k_s); stops 100 times stiffer than the spring were refused unless a load step met them."""
    body = fm.RigidBody("body", (0, 0), mass=1.0, inertia=1.0)
    limit = {"above": gap} if side > 0.0 else {"below": -gap}
    pressed = fm.Mechanism("pressed", [
        body, fm.Prismatic("guide", fm.GROUND, body, along=(1, 0)),
        fm.SpringDamper("spring", fm.GROUND, body, at=(-1, 0), to=(0, 0), stiffness=1e4, free_length=1.0),
        fm.Stop("stop", "guide", normal=fm.KelvinVoigt(stiffness, 0.0), **limit),
        fm.Force("push", body, (0, 0), (side * 500.0, 0.0)),
    ])  # fmt: skip
    at = fm.static_equilibrium(pressed, load_steps=load_steps)
    assert side * at["body.x"] == pytest.approx((500.0 + stiffness * gap) / (1e4 + stiffness), rel=1e-9)
