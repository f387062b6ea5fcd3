"""Exponents of mechanisms from the tangent of the step: linear oscillators, a limit cycle, a conservative pendulum."""

import dataclasses
import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.dynamics.systems.dynamics import orthonormalise

models = runpy.run_path(str(Path(__file__).with_name("tangent_models.py")))
pendulum, fixed = models["pendulum"], models["fixed"]


def exponents(flow, count, interval, times):
    """Exponents [1/s] by QR, from `count` tangents over `times` intervals [s]."""
    W, total = flow.tangent_basis(count), np.zeros(count)
    for _ in range(times):
        assert flow.advance(interval, W), flow.status
        total += np.log(orthonormalise(W, flow.weights))
    return total / (times * interval)


def oscillator(damping, drive=False):
    """A mass of 2 kg on a guide, held by 50 N/m; natural frequency 5 rad/s."""
    mass = fm.RigidBody("mass", (1.0, 0.0), 2.0, 0.1, velocity=(0.3, 0.0, 0.0))
    parts = [mass, fm.Prismatic("guide", fm.GROUND, mass)]
    parts.append(fm.SpringDamper("S", fm.GROUND, mass, (0.0, 0.0), (1.0, 0.0), stiffness=50.0, damping=damping))
    if drive:
        parts.append(fm.Force("F", mass, (1.0, 0.0), (3.0, 0.0), history=fm.drives.Harmonic(1.0, 7.0)))
    return fm.Mechanism("oscillator", parts)


@pytest.mark.quick(1)
@pytest.mark.parametrize("drive", [False, True])
def test_exponents_of_a_linear_oscillator(drive):
    """Both are -d/(2 m) = -0.1 1/s where it vibrates; errors fall with the square of the step."""
    errors = []
    for per_turn in (50, 100, 200):
        turn = 2.0 * math.pi / math.sqrt(25.0 - 0.01)
        flow = fixed(oscillator(0.4, drive), turn / per_turn, period=turn)
        found = exponents(flow, 2, turn, 40)
        errors.append(abs(found.sum() + 0.2))
        assert np.abs(found + 0.1).max() < 3e-3  # directions within the period settle with 1/time
    assert errors[-1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.15)


def test_exponents_of_an_overdamped_oscillator():
    """Rates of the two real roots: m r^2 + d r + k = 0."""
    flow = fixed(oscillator(25.0), 1e-3)
    roots = np.sort(np.roots([2.0, 25.0, 50.0]).real)[::-1]
    W = flow.tangent_basis(2)
    for _ in range(10):  # the directions find themselves
        flow.advance(0.5, W)
        lengths = orthonormalise(W, flow.weights)
    np.testing.assert_allclose(np.log(lengths) / 0.5, roots, rtol=1e-5)


@fm.element_kernel
def van_der_pol_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """A spring, and a damper that drives where it is short: k x + mu (x^2 - 1) v."""
    k, mu = p
    r[0] += k * q[0] + mu * (q[0] * q[0] - 1.0) * v[0]
    K[0, 0] += k + 2.0 * mu * q[0] * v[0]
    C[0, 0] += mu * (q[0] * q[0] - 1.0)


@dataclasses.dataclass(frozen=True)
class VanDerPol(fm.Element):
    """The element of `van_der_pol_kernel`."""

    body: fm.Part
    stiffness: float
    strength: float

    kernel = van_der_pol_kernel
    coords = ("body.x",)


@pytest.mark.slow
def test_exponents_of_van_der_pol():
    """0 along the limit cycle; the other one is the mean of the divergence 1 - x^2 along it, by quadrature."""
    cycle = solve_ivp(
        lambda t, y: [y[1], (1.0 - y[0] ** 2) * y[1] - y[0], 1.0 - y[0] ** 2],
        (0.0, 20.0 * 6.663286859323),
        (2.00861986087, 0.0, 0.0),
        "DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    second = cycle.y[2, -1] / cycle.t[-1]
    mass = fm.RigidBody("mass", (0.0, 0.0), 1.0, 0.1, velocity=(2.0, 0.0, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, mass)
    errors = []
    for per_cycle in (200, 400):
        period = 6.663286859323
        flow = fixed(fm.Mechanism("cycle", (mass, guide, VanDerPol("V", mass, 1.0, 1.0))), period / per_cycle)
        flow.advance(10.0 * period)
        W, total = flow.tangent_basis(2), 0.0
        W[:, 0] = flow.velocity()
        orthonormalise(W, flow.weights)
        for _ in range(40):
            assert flow.advance(0.25 * period, W), flow.status
            total = total + np.log(orthonormalise(W, flow.weights))
        found = total / (10.0 * period)
        errors.append(np.abs(found - [0.0, second]))
    assert errors[1][0] < 1e-3
    assert errors[1][1] < 1e-3
    assert errors[0][1] / errors[1][1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "method",
    [
        pytest.param(fm.Newmark.trapezoidal(), marks=pytest.mark.slow),
        fm.Newmark.generalised_alpha(0.9),
        fm.Newmark.trapezoidal("velocity"),
    ],
    ids=["trapezoidal", "generalised-alpha", "velocities held"],
)
def test_exponents_of_a_conservative_double_pendulum_come_in_pairs(method):
    """Chaotic at this energy; the volume of phase space is kept, and the pairs add up to 0 in the mean."""
    flow = fixed(pendulum(), 2e-3, method=method, period=1.0)
    found = exponents(flow, 4, 0.5, 200)
    assert abs(found.sum()) < 0.02  # phase space is measured by lengths that change with the pose
    assert found[0] > 0.3
    assert found[0] + found[3] == pytest.approx(0.0, abs=0.02)
    assert found[1] + found[2] == pytest.approx(0.0, abs=0.02)
