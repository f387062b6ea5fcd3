"""Springs whose rest length or rest angle moves: base excitation in closed form, works of the actuator."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

M, K, A, F, L = 2.0, 800.0, 0.01, 2.0, 0.3
FINE = {"method": fm.RadauIIA(), "step": fm.Adaptive(rtol=1e-8)}


def oscillator(free_length):
    """A mass on a guide, held by a spring to the ground."""
    mass = fm.RigidBody("mass", at=(L, 0.0), mass=M, inertia=1e-3)
    spring = fm.SpringDamper(
        "spring", fm.GROUND, mass, at=(0.0, 0.0), to=(L, 0.0), stiffness=K, free_length=free_length
    )
    return fm.Mechanism("base", [mass, spring, fm.Prismatic("guide", fm.GROUND, mass, along=(1.0, 0.0))])


def test_base_excitation():
    """x'' + W^2 x = W^2 A sin(w t) from rest: x = A W^2/(W^2 - w^2) (sin w t - (w/W) sin W t)."""
    sol = fm.simulate(oscillator(fm.drives.Harmonic(A, F, mean=L)), t_end=1.5, **FINE)
    assert sol.ok, sol.status
    t, w, W = sol.time, 2.0 * math.pi * F, math.sqrt(K / M)
    shape = A * W * W / (W * W - w * w)
    x = shape * (np.sin(w * t) - w / W * np.sin(W * t))
    v = shape * w * (np.cos(w * t) - np.cos(W * t))
    assert sol["mass.x"].values - L == pytest.approx(x, abs=1e-6 * shape + 1e-9)
    # the actuator's work is the integral of spring force times speed of the rest length; the ledger keeps its sum
    moved = A * np.sin(w * t)
    held = 0.5 * K * (x - moved) ** 2
    work = sol["energy.load_work"].values + held - sol["energy.strain"].values
    power = -K * (x - moved) * A * w * np.cos(w * t)
    booked = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (power[1:] + power[:-1]))])
    size = float(np.abs(booked).max())
    assert work == pytest.approx(booked, abs=1e-4 * size)
    assert work == pytest.approx(0.5 * M * v * v + held, abs=1e-4 * size)
    assert np.abs(sol["energy.residual"].values).max() < 1e-5 * size


def test_a_turned_rest_angle():
    """A rotor on a torsion spring whose far end turns at constant speed w: angle = w t - (w/W) sin W t."""
    rotor = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=0.05)
    spring = fm.TorsionSpring("spring", fm.GROUND, rotor, stiffness=20.0, free_angle=fm.ConstantSpeed(3.0))
    pin = fm.Revolute("pin", fm.GROUND, rotor, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("wound", [rotor, spring, pin]), t_end=1.0, **FINE)
    W = math.sqrt(20.0 / 0.05)
    assert sol["rotor.theta"].values == pytest.approx(3.0 * sol.time - 3.0 / W * np.sin(W * sol.time), abs=1e-6)
    assert np.abs(sol["energy.residual"].values).max() < 1e-6


def test_a_motion_that_stands_is_a_number():
    still = fm.simulate(oscillator(fm.drives.Polynomial((0.25,))), t_end=0.4)
    number = fm.simulate(oscillator(0.25), t_end=0.4)
    assert still["mass.x"].values == pytest.approx(number["mass.x"].values, abs=1e-12)
    assert fm.static_equilibrium(oscillator(fm.drives.Harmonic(A, F, math.pi / 2.0, 0.25)))["mass.x"] == pytest.approx(
        0.25 + A, abs=1e-10
    )


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ("0.2", r"free_length is '0.2'; it must be a number in m, or a motion whose value it is"),
        (True, "free_length is True"),
        (-0.2, "free_length is -0.2 m; it must be >= 0"),
        (fm.drives.Polynomial((-0.1, 1.0)), "free_length is -0.1 m; it must be >= 0"),
    ],
)
def test_wrong_rest_lengths_are_refused(rest, words):
    with pytest.raises(InputError, match=words):
        oscillator(rest)


def test_a_wrong_rest_angle_is_refused():
    rotor = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=0.05)
    with pytest.raises(InputError, match="free_angle is None; it must be a number in rad"):
        fm.TorsionSpring("spring", fm.GROUND, rotor, stiffness=20.0, free_angle=None)


def test_signals_of_springs_whose_rest_moves():
    """The force of the spring alone moves the mass, and the torque the wheel."""
    mass = fm.RigidBody("mass", (0.5, 0.0), 2.0, 1e-3)
    rest = fm.drives.Harmonic(0.05, frequency=2.0, mean=0.4)
    spring = fm.SpringDamper(
        "spring", fm.GROUND, mass, (0.0, 0.0), (0.5, 0.0), stiffness=80.0, damping=1.0, free_length=rest
    )
    sol = fm.simulate(
        fm.Mechanism("pulled", [mass, fm.Prismatic("guide", fm.GROUND, mass), spring]), t_end=1.0, step=1e-3
    )
    assert np.abs(sol.array("spring.force") + 2.0 * sol.array("mass.ax")).max() < 1e-5
    assert "spring.energy" not in sol
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 1.0, 0.02)
    coil = fm.TorsionSpring("coil", fm.GROUND, wheel, stiffness=0.5, damping=0.01, free_angle=rest)
    axle = fm.Revolute("axle", fm.GROUND, wheel, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("turned", [wheel, axle, coil]), t_end=1.0, step=1e-3)
    assert np.abs(sol.array("coil.torque") - 0.02 * sol.array("wheel.alpha")).max() < 1e-6
