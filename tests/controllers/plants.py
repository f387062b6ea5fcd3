"""Mechanisms to be controlled, with equations that are written by hand."""

import numpy as np
from scipy.linalg import expm

import flexmb as fm

J, R, L, K, N = 2e-3, 2.0, 5e-3, 0.05, 3.0
"""Inertia [kg m^2], resistance [ohm], inductance [H], motor constant [N m/A], gear ratio of the motor with a rotor."""

ARM_INERTIA, WEIGHT, ARM = 1.0 / 48.0 + 0.25**2, 9.81, 0.25
"""Inertia about the hinge [kg m^2], weight [N], and distance of the centre of mass [m] of the arm."""


def arm(*parts, gravity=(0.0, -9.81)):
    """An arm of 1 kg and 0.5 m on a hinge, with a marker at its tip and an actuator of 1 N m."""
    link = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=1.0 / 48.0)
    hinge = fm.Revolute("hinge", fm.GROUND, link, at=(0.0, 0.0))
    tip = fm.Marker("tip", link, at=(0.5, 0.0))
    return fm.Mechanism("robot", [link, hinge, tip, fm.Torque("actuator", link, 1.0), *parts], gravity=gravity)


def rotor(*parts, inertia=J, omega=0.0):
    """A rotor on a fixed axis, with a shaft on which 1 N m acts."""
    body = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=inertia, velocity=(0.0, 0.0, omega))
    axis = fm.Revolute("axis", fm.GROUND, body, at=(0.0, 0.0))
    return fm.Mechanism("rotor", [body, axis, fm.Torque("shaft", body, 1.0), *parts])


def motor(voltage, **changes):
    """The motor on the shaft of the rotor."""
    given = {"resistance": R, "inductance": L, "torque_constant": K, "gear_ratio": N, **changes}
    return fm.controllers.DCMotor("motor", "rotor.omega", "shaft", voltage=voltage, **given)


MOTOR = np.array([[-R / L, -K * N / L], [K * N / J, 0.0]])
"""Matrix A of (current, speed)' = A (current, speed) + (V / L, 0)."""


def linear(A, b, x0, t):
    """Solution of x' = A x + b, by the matrix exponential of the system with the constant input as a state."""
    n = len(b)
    whole = expm(np.block([[A, np.reshape(b, (n, 1))], [np.zeros((1, n + 1))]]) * t)
    return whole[:n, :n] @ x0 + whole[:n, n]


def last(sol, *names):
    """Last values of some signals."""
    return np.array([float(sol[name][-1]) for name in names])


def cut_and_continued(mechanism, t_end, share=0.5, **options):
    """Final states by name of a run, and of one that is cut after a share of its steps and goes on."""
    whole = fm.simulate(mechanism, t_end=t_end, **options)
    cut = fm.simulate(mechanism, t_end=t_end, max_steps=int(share * whole.stats.steps), **options)
    assert 0.0 < float(cut.time[-1]) < t_end
    return whole.restart, fm.simulate(mechanism, t_end=t_end, restart=cut.restart, **options).restart


def different(first, second):
    """Names of arrays in which two final states differ in any bit."""
    return [name for name in first if not np.array_equal(first[name], second[name])]
