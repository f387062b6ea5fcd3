"""Mass-proportional damping of plane bodies and of reduced ones: ratios, decay, rigid motions, energy, tangents."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.results.positions import momentum

LENGTH, RATE, TIME = 0.12, 60.0, 2e-6
SOFT = fm.Material(young=2e9, density=2000.0, poisson=0.3)
MESH = fm.meshes.rectangle(LENGTH, 0.02, 6, 1)


def bar(mesh=MESH, **changes):
    """A soft bar with its ends as pins."""
    values = {"at": (0.0, 0.0), "thickness": 0.01, "material": SOFT, "pins": ("left", "right"), "mass_damping": RATE}
    return fm.PlaneBody("bar", mesh, **{**values, **changes})


def held(body, **changes):
    """The bar with both ends clamped."""
    clamps = [fm.Fixed(name, fm.GROUND, body, at=(x, 0.01)) for name, x in (("L", 0.0), ("R", LENGTH))]
    return fm.Mechanism("held", [body, *clamps], gravity=(0.0, 0.0), **changes)


BODIES = {
    "rigid pins": lambda: bar(damping=TIME),
    "averaged pins": lambda: bar(damping=TIME, interface="averaged"),
    "total Lagrange": lambda: bar(damping=TIME, formulation="total-lagrange"),
    "reduced": lambda: fm.Reduced(bar(damping=TIME), modes=6),
    "reduced with its own": lambda: fm.Reduced(bar(mass_damping=0.0), modes=6, damping=TIME, mass_damping=RATE),
    "reduced beams": lambda: fm.Reduced(beams(), modes=6),
}


def beams():
    """A link of beams between the same clamps."""
    section = fm.Rectangle(width=0.01, height=0.02)
    ends = (0.0, 0.01), (LENGTH, 0.01)
    return fm.FlexibleLink("bar", *ends, section=section, material=SOFT, elements=6, damping=TIME, mass_damping=RATE)


@pytest.mark.parametrize("name", BODIES)
def test_ratios_of_a_held_body_are_those_of_rayleigh(name):
    """(zeta1/omega + zeta2 omega)/2 of every vibration, since the frame stands still."""
    found = fm.modes(held(BODIES[name]()), count=4, damped=True)
    omega = np.abs(found.eigenvalues)
    np.testing.assert_allclose(found.damping, 0.5 * (RATE / omega + TIME * omega), rtol=1e-6)


def test_a_free_vibration_decays_with_half_the_rate():
    """Energy of a clamped body in its first mode falls as exp(-zeta1 t)."""
    still = fm.modes(held(bar(mass_damping=0.0)), count=1)
    period = 1.0 / still.frequencies[0]
    shape = 1e-5 * still.shapes[:, 0] / np.abs(still.shapes[:, 0]).max()
    field = tuple((x, y, 0.0) for x, y, _ in shape.reshape(-1, 3))
    sol = fm.simulate(held(bar(displacement=field)), t_end=20.0 * period, step=period / 100.0)
    assert sol.ok, sol.status
    energy = sol.array("energy.kinetic") + sol.array("energy.strain")
    whole = np.searchsorted(sol.time, np.arange(1, 20) * period)  # at equal phases
    rate = -np.polyfit(sol.time[whole], np.log(energy[whole]), 1)[0]
    assert rate == pytest.approx(RATE, rel=2e-3)


@pytest.mark.parametrize(
    "make",
    [pytest.param(bar, marks=pytest.mark.slow), lambda **c: fm.Reduced(bar(**c), modes=3)],
    ids=["full", "reduced"],
)
def test_flight_and_rotation_are_not_damped(make):
    """A thrown body keeps its momenta; what damping takes is a small part of what vibrates."""
    mechanism = fm.Mechanism("thrown", [make(velocity=(1.0, 2.0, 20.0))], gravity=(0.0, 0.0))
    sol = fm.simulate(mechanism, t_end=0.1, step=1e-4)
    found = momentum(mechanism, sol)
    assert np.ptp(found.linear, axis=0).max() < 1e-5 * np.abs(found.linear).max()
    assert np.ptp(found.angular) < 1e-4 * np.abs(found.angular).max()
    kinetic = sol.array("energy.kinetic")
    assert kinetic[-1] == pytest.approx(kinetic[0], rel=1e-4)
    assert 0.0 < sol.array("energy.dissipated_damping")[-1] < 1e-4 * kinetic[0]
    assert sol.peak("energy.residual").value < 1e-6 * kinetic[0]


@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("pins", [pytest.param(("left", "right"), marks=pytest.mark.slow), ("left",)])
def test_kernels_agree_with_differences(pins):
    cells = fm.meshes.rectangle(LENGTH, 0.02, 2, 1)
    fm.testing.check_part(fm.Mechanism("free", [bar(cells, pins=pins)]), "bar")


def test_a_negative_rate_is_refused():
    for make in (bar, lambda **c: fm.Reduced(bar(), **c)):
        with pytest.raises(fm.errors.InputError, match="mass_damping is -1 1/s; it must be >= 0"):
            make(mass_damping=-1.0)
