"""Derivatives of equilibria and natural frequencies beside closed forms and differences."""

import numpy as np
import pytest
from designs import CENTRAL

import flexmb as fm
from flexmb.design.orbits import static_sensitivity
from flexmb.errors import InputError, SolveError
from flexmb.parts.joints.stop import Stop


def cantilever(length: float, force: float, height: float, young: float, density: float) -> fm.Mechanism:
    section, stuff = fm.Rectangle(0.01, height), fm.Material(young, density, 0.3)
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (length, 0.0), section=section, material=stuff, elements=8)
    wall = fm.Fixed("wall", fm.GROUND, beam, at=(0.0, 0.0))
    return fm.Mechanism("cantilever", [beam, wall, fm.Force("F", beam, (length, 0.0), (0.0, -force))])


def springy(rate: float, mass: float, length: float, gravity: float) -> fm.Mechanism:
    """A bar on a torsion spring, which gravity turns far."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (length, 0.0), mass, mass * length**2 / 12.0)
    spring = fm.loads.TorsionSpring("spring", fm.GROUND, bar, stiffness=rate)
    pin = fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))
    return fm.Mechanism("springy", [bar, pin, spring], (0.0, -gravity))


def on_table(mass: float, stiffness: float, gravity: float) -> fm.Mechanism:
    """A mass that lies on a table whose force grows with the power 1.5 of the approach."""
    body = fm.RigidBody("body", (0.0, 0.0), mass, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(0.0, 1.0))
    law = fm.contact.Hertz(stiffness=stiffness)
    return fm.Mechanism("table", [body, guide, Stop("table", guide, below=0.0, normal=law)], (0.0, -gravity))


def plane_oscillator(kx: float, ky: float, mass: float) -> fm.Mechanism:
    """A mass between springs along x and y; it cannot turn."""
    body = fm.RigidBody("body", (0.0, 0.0), mass, 1.0)
    held = fm.loads.TorsionSpring("held", fm.GROUND, body, stiffness=1e6)
    along = fm.loads.SpringDamper("x", fm.GROUND, body, at=(-1.0, 0.0), to=(0.0, 0.0), stiffness=kx)
    across = fm.loads.SpringDamper("y", fm.GROUND, body, at=(0.0, -1.0), to=(0.0, 0.0), stiffness=ky)
    return fm.Mechanism("oscillator", [body, held, along, across])


def relative(found, measure: str) -> np.ndarray:
    return found.measures.relative.sel(measure=measure).values


def test_cantilever_has_the_powers_of_its_formulas():
    """Deflection F l^3 / (3 E I), frequencies proportional to h / l^2 sqrt(E / density)."""
    given = {"length": 0.5, "force": 0.1, "height": 0.01, "young": 2e11, "density": 7800.0}
    found = static_sensitivity(cantilever, given, of=["beam.end.y", "wall.moment"], frequencies=3)
    np.testing.assert_allclose(relative(found, "beam.end.y"), [3.0, 1.0, -3.0, -1.0, 0.0], atol=2e-6)
    np.testing.assert_allclose(relative(found, "wall.moment"), [1.0, 1.0, 0.0, 0.0, 0.0], atol=2e-6)
    for k in range(3):
        powers = [-2.0, 0.0, 1.0, 0.5, -0.5]
        np.testing.assert_allclose(relative(found, f"frequency {k + 1}"), powers, atol=2e-6)


def test_equal_frequencies_split():
    """sqrt(kx / m) and sqrt(ky / m): kx moves one of them, the mass both."""
    found = static_sensitivity(plane_oscillator, {"kx": 100.0, "ky": 100.0, "mass": 2.0}, frequencies=2)
    np.testing.assert_allclose(relative(found, "frequency 1"), [0.0, 0.0, -0.5], atol=1e-8)
    np.testing.assert_allclose(relative(found, "frequency 2"), [0.5, 0.5, -0.5], atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "given", "of"),
    [
        (springy, {"rate": 3.0, "mass": 2.0, "length": 0.5, "gravity": 9.81}, ["bar.theta", "bar.y", "O.force"]),
        pytest.param(
            on_table,
            {"mass": 2.0, "stiffness": 1e8, "gravity": 9.81},
            ["body.y", "table.normal_force"],
            marks=pytest.mark.slow,
        ),
    ],
    ids=["large turn", "contact"],
)
def test_equilibria_far_from_the_start_agree_with_differences(model, given, of):
    found = static_sensitivity(model, given, of=of, frequencies=1)
    coordinates = [name for name in of if name.rpartition(".")[2] in ("x", "y", "theta")]
    for name, value in given.items():
        h, expected = 1e-3 * value, 0.0
        for place, weight in CENTRAL:
            mechanism = model(**given | {name: value + place * h})
            rest = fm.static_equilibrium(mechanism)
            lowest = fm.modes(mechanism, 1, at=rest).frequencies[0]
            expected = expected + weight / h * np.array([*(rest[one] for one in coordinates), lowest])
        own = found.measures.derivative.sel(parameter=name)
        np.testing.assert_allclose(own.sel(measure=[*coordinates, "frequency 1"]).values, expected, rtol=1e-6)


def test_force_of_a_table_is_the_weight():
    found = static_sensitivity(on_table, {"mass": 2.0, "stiffness": 1e8, "gravity": 9.81}, of=["table.normal_force"])
    np.testing.assert_allclose(relative(found, "table.normal_force"), [1.0, 0.0, 1.0], atol=1e-7)


def test_what_has_no_derivative_at_rest_is_refused():
    given = {"rate": 3.0, "mass": 2.0, "length": 0.5, "gravity": 9.81}
    with pytest.raises(InputError, match="give names of signals"):
        static_sensitivity(springy, given)
    with pytest.raises(InputError, match="no signal is called"):
        static_sensitivity(springy, given, of=["bar.z"])
    free = fm.Mechanism("free", [fm.RigidBody("body", (0.0, 0.0), 1.0, 1.0)])
    with pytest.raises(SolveError, match="no static equilibrium"):
        static_sensitivity(free, ["body.mass"], frequencies=1)


def test_table_and_tornado_show_what_was_asked_for():
    given = {"rate": 3.0, "mass": 2.0, "length": 0.5, "gravity": 9.81}
    found = static_sensitivity(springy, given, of=["bar.theta"], frequencies=1)
    assert "frequency 1" in repr(found)
    assert len(found.table()) == 8
    figure = fm.plots.plot_tornado(found, "bar.theta")
    assert len(figure.axes[0].patches) == 4


def test_a_load_that_swings_is_taken_at_its_start():
    """It was refused for the steps of a run that takes none."""

    def swung(force: float) -> fm.Mechanism:
        found = cantilever(0.5, 0.0, 0.01, 2e11, 7800.0)
        swing = fm.drives.Harmonic(1.0, frequency=50.0, phase=0.5 * np.pi)
        return fm.Mechanism(
            "swung", [*found.parts[:2], fm.Force("F", found["beam"], (0.5, 0.0), (0.0, -force), history=swing)]
        )

    rate = -(0.5**3) / (3.0 * 2e11 * 0.01**4 / 12.0)
    assert static_sensitivity(swung, {"force": 0.1}, of=["beam.end.y"]).measures.derivative.item() == pytest.approx(
        rate
    )


def test_frequencies_of_a_plate_by_its_thickness():
    """They do not depend on it, and go with the root of Young's modulus."""

    def plate(thickness: float, young: float) -> fm.Mechanism:
        mesh, stuff = fm.meshes.rectangle(0.6, 0.02, 12, 1), fm.Material(young, 7850.0, 0.3)
        kind = {"thickness": thickness, "material": stuff, "pins": ("left", "right")}
        body = fm.PlaneBody("plate", mesh, at=(0.0, 0.0), **kind)
        return fm.Mechanism("m", [body, fm.Fixed("wall", fm.GROUND, body, at=(0.0, 0.01))])

    found = static_sensitivity(plate, {"thickness": 0.01, "young": 2.1e11}, frequencies=1)
    np.testing.assert_allclose(relative(found, "frequency 1"), [0.0, 0.5], atol=1e-4)
