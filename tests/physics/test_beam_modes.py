"""Natural frequencies against the exact roots, and damping of a mode."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm

LENGTH, WIDTH, HEIGHT, YOUNG, DENSITY = 0.8, 0.02, 0.008, 2.0e11, 7850.0
EA, EI = YOUNG * WIDTH * HEIGHT, YOUNG * WIDTH * HEIGHT**3 / 12.0
RHO_A = DENSITY * WIDTH * HEIGHT


def beam(elements, damping=0.0, **more):
    section, material = fm.Rectangle(width=WIDTH, height=HEIGHT), fm.Material(young=YOUNG, density=DENSITY)
    options = {"section": section, "material": material, "elements": elements, "damping": damping, **more}
    return fm.FlexibleLink("beam", (0.0, 0.0), (LENGTH, 0.0), **options)


def cantilever(elements, damping=0.0, gravity=(0.0, 0.0)):
    link = beam(elements, damping)
    return fm.Mechanism("cantilever", (link, fm.Fixed("clamp", fm.GROUND, link, (0.0, 0.0))), gravity=gravity)


def pinned(elements, **more):
    """Pinned at the start, on a roller at the end (a rigid pin of hardly any mass in a guide)."""
    link = beam(elements, **more)
    roller = fm.RigidBody("roller", (LENGTH, 0.0), mass=1e-9, inertia=1e-9)
    joints = (
        fm.Revolute("A", fm.GROUND, link, (0.0, 0.0)),
        fm.Revolute("B", link, roller, (LENGTH, 0.0)),
        fm.Prismatic("guide", fm.GROUND, roller),
    )
    return fm.Mechanism("pinned", (link, roller, *joints))


def free(elements):
    return fm.Mechanism("free", (beam(elements),))


def cantilever_roots(n):
    """Roots of cos x cosh x = -1."""
    return [brentq(lambda x: math.cos(x) + 1 / math.cosh(x), k * math.pi, (k + 1) * math.pi) for k in range(n)]


def free_roots(n):
    """Roots of cos x cosh x = 1 above 0."""
    return [brentq(lambda x: math.cos(x) - 1 / math.cosh(x), (k + 1) * math.pi, (k + 2) * math.pi) for k in range(n)]


def pinned_roots(n):
    return [(k + 1) * math.pi for k in range(n)]


def bending(mechanism, wanted):
    """The bending frequencies [Hz]: modes that move nodes across the beam rather than along it, rigid ones left out."""
    found = fm.modes(mechanism, count=wanted + 6)
    shapes = np.abs(found.shapes[: 3 * mechanism.bodies[0].elements + 3])
    across = shapes[1::3].max(axis=0) > shapes[0::3].max(axis=0)
    return found.frequencies[across & (found.frequencies > 1.0)][:wanted]


CASES = {
    "cantilever": (cantilever, cantilever_roots, 8),
    "pinned": (pinned, pinned_roots, 8),
    "free": (free, free_roots, 16),  # its fifth mode has the waves of the others' sixth, too short for 8 elements
}


@pytest.mark.parametrize("case", CASES)
def test_first_five_bending_frequencies_converge_at_fourth_order(case):
    """omega = x^2 sqrt(EI/(rho A L^4)), x exact.  Finer meshes would show round-off in the lowest mode."""
    mechanism, roots, coarse = CASES[case]
    exact = np.array(roots(5)) ** 2 * math.sqrt(EI / (RHO_A * LENGTH**4)) / (2 * math.pi)
    errors = [np.abs(bending(mechanism(n), 5) / exact - 1.0) for n in (coarse, 2 * coarse)]
    order = np.log2(errors[0] / errors[1])
    assert order.min() > 3.8, order
    assert errors[1].max() < 1e-3


@pytest.mark.parametrize("rotary", [True, RHO_A * 1e-3])
def test_rotary_inertia_lowers_the_frequencies_as_rayleigh_says(rotary):
    """Pinned: omega^2 = k^4 EI/(rho A + rho I k^2), k = n pi/L, exact; with rho I of the section and a larger one."""
    k = np.array(pinned_roots(3)) / LENGTH
    inertia = DENSITY * WIDTH * HEIGHT**3 / 12.0 if rotary is True else rotary
    exact = np.sqrt(k**4 * EI / (RHO_A + inertia * k**2)) / (2 * math.pi)
    plain = k**2 * math.sqrt(EI / RHO_A) / (2 * math.pi)
    np.testing.assert_allclose(bending(pinned(32, rotary_inertia=rotary), 3), exact, rtol=1e-5)
    assert (1.0 - exact / plain).max() > 3e-4  # far above the error of the elements


def test_axial_frequency_of_a_cantilever():
    """c/(4 L), c = sqrt(E/rho); linear elements: the error of the consistent mass is (pi/2/n)^2/24, second order."""
    exact = math.sqrt(YOUNG / DENSITY) / (4 * LENGTH)
    errors = []
    for n in (8, 16):
        found = fm.modes(cantilever(n), count=3 * n)
        axial = np.abs(found.shapes[0::3]).max(axis=0) > np.abs(found.shapes[1::3]).max(axis=0)
        errors.append(found.frequencies[axial][0] / exact - 1.0)
    assert errors[1] == pytest.approx((math.pi / 2 / 16) ** 2 / 24, rel=0.05)
    assert math.log2(errors[0] / errors[1]) > 1.95


def test_damping_of_the_first_mode():
    """Stiffness-proportional damping: the amplitude decays with zeta2 omega^2/2 per time.

    The clamped beam falls into its own (weak) weight: it swings about its sagging, and after a few cycles nothing but
    the first mode is left, since the others are damped by the square of their frequencies.
    """
    omega = cantilever_roots(1)[0] ** 2 * math.sqrt(EI / (RHO_A * LENGTH**4))
    ratio = 0.01
    zeta2 = 2 * ratio / omega
    period = 2 * math.pi / (omega * math.sqrt(1 - ratio**2))
    mechanism = cantilever(6, damping=zeta2, gravity=(0.0, -1e-3))
    sol = fm.simulate(mechanism, t_end=13 * period, step=period / 800, save="steps", method=fm.Newmark.trapezoidal())
    sag = fm.static_equilibrium(mechanism)["beam.end.y"]
    swing = (sol.array("beam.end.y") - sag)[-10 * 800 :]
    inner = swing[1:-1]
    top = np.flatnonzero((inner > swing[:-2]) & (inner >= swing[2:])) + 1
    # a parabola through three points gives the height of each maximum
    rise = 0.5 * (swing[top + 1] - swing[top - 1])
    bend = swing[top + 1] - 2 * swing[top] + swing[top - 1]
    heights = swing[top] - rise**2 / (2 * bend)
    times = top - rise / bend
    rate = np.log(heights[0] / heights[-1]) / ((times[-1] - times[0]) * period / 800)
    assert len(top) >= 9
    assert rate == pytest.approx(zeta2 * omega**2 / 2, rel=1e-3)
    assert 2 * math.pi / np.diff(times).mean() * 800 / period == pytest.approx(
        omega * math.sqrt(1 - ratio**2), rel=1e-3
    )
