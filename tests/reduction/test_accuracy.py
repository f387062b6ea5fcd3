"""What a reduced body says of its own accuracy, beside closed forms and independent values."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
L, EI, PER_LENGTH = 1.0, 2.1e11 * 0.01 * 0.02**3 / 12.0, 7850.0 * 0.01 * 0.02


def beam(**options):
    section = fm.Rectangle(width=0.01, height=0.02)
    rod = fm.FlexibleLink("rod", (0.3, 0.1), (0.3, 1.1), section=section, material=STEEL, elements=16, stress=True)
    return fm.Reduced(rod, **options)


def eyes(**options):
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.0025)
    return fm.Reduced(fm.PlaneBody("rod", mesh, thickness=0.01, material=STEEL), **options)


@pytest.mark.slow
def test_frequencies_of_a_link_with_eyes():
    """Independent values with scikit-fem on a mesh of triangles (9,356 unknowns): all nodes, static shapes alone."""
    found = eyes().accuracy(held=("start",))
    assert found.held[:, 0] == pytest.approx([913.9364, 5327.25, 9488.96], rel=3e-5)
    assert found.held[:, 1] == pytest.approx([914.5488, 6021.07, 9779.30], rel=5e-5)
    assert found.held_errors == pytest.approx([7e-4, 0.130, 0.031], rel=0.05)
    assert found.free[:, 0] == pytest.approx(eyes().body.frequencies(3), rel=1e-9)
    assert found.held[:, 0] == pytest.approx(eyes().body.frequencies(3, held=("start",)), rel=1e-9)


def test_frequencies_of_beams():
    """Free and hinged beams of Euler and Bernoulli; the sixteen elements and the modes are above them."""
    found = beam(modes=6).accuracy(2)
    scale = math.sqrt(EI / PER_LENGTH) / (2.0 * math.pi * L**2)
    assert found.free[:, 0] == pytest.approx(np.array([4.7300407, 7.8532046]) ** 2 * scale, rel=1e-4)
    assert found.held[:, 0] == pytest.approx(np.array([math.pi, 2.0 * math.pi]) ** 2 * scale, rel=1e-4)
    assert np.all(found.free_errors > 0.0)
    assert np.all(found.held_errors > 0.0)


@pytest.mark.parametrize(("held", "deflection"), [(None, 5.0 / 384.0), (("start",), 1.0 / 8.0)])
def test_static_shapes_leave_out_the_deflection_between_held_pins(held, deflection):
    """Of a uniform load they miss q L^4/384 EI in the middle, whatever holds the pins."""
    load = beam().accuracy(held=held).loads["acceleration along y"]
    assert load.deflection == pytest.approx(deflection * PER_LENGTH * L**4 / EI, rel=1e-6)
    assert load.deflection_error == pytest.approx(1.0 / 384.0 / deflection, rel=1e-6)


def test_stresses_of_static_shapes_alone():
    """Of a hinged beam under a uniform load: moment q L^2/12 all along in place of q x (L - x)/2.

    Moments of elements of length h are those of straight lines through these, so they are off by q h^2/12 at nodes.
    """
    load = beam().accuracy().loads["acceleration along y"]
    fibre, off = 0.01 / (0.01 * 0.02**3 / 12.0), 1.0 / (12.0 * 16.0**2)
    assert load.stress == pytest.approx(PER_LENGTH * L**2 * (1.0 / 8.0 + off) * fibre, rel=1e-6)
    assert load.stress_error == pytest.approx((1.0 / 12.0 - off) / (1.0 / 8.0 + off), rel=1e-6)


@pytest.mark.quick(1)
@pytest.mark.parametrize("make", [beam, eyes])
def test_forces_at_pins_are_exact_and_modes_help_the_rest(make):
    few, more = (make(modes=modes).accuracy(held=("start",)) for modes in (3, 12))
    assert max(few.compliance_error, more.compliance_error) < 1e-9
    for name, load in few.loads.items():
        assert more.loads[name].deflection_error < load.deflection_error, name
    assert np.all(more.free_errors < few.free_errors)
    assert more.dropped_frequency > few.dropped_frequency


@pytest.mark.quick(1)
@pytest.mark.parametrize("make", [beam, eyes])
def test_shapes_of_inertia_are_exact_under_unit_accelerations(make):
    found = make(inertia_shapes=True).accuracy()
    for name in ("acceleration along x", "acceleration along y", "angular acceleration", "rotation"):
        assert max(found.loads[name].deflection_error, found.loads[name].stress_error) < 1e-9
    assert found.modes == 2  # beside four static shapes
    assert found.coordinates == 12


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("height", "modes"),
    [
        (0.005, 6),
        pytest.param(0.005, 9, marks=pytest.mark.slow),
        (0.01, 9),
        pytest.param(0.02, 9, marks=pytest.mark.slow),
        pytest.param(0.02, 18, marks=pytest.mark.slow),
        (0.05, 12),
    ],
)
def test_shapes_of_inertia_beside_many_modes(height, modes):
    """A shape of inertia that the vibrations of a slender rod hold is left out; the body was refused."""
    length, count = 0.5, 4 if height == 0.05 else 3
    mesh = fm.meshes.rectangle(length, height, 50, 1)
    plane = fm.PlaneBody("rod", mesh, at=(0.0, -0.5 * height), thickness=0.02, material=STEEL, pins=("left",))
    body = fm.Reduced(plane, modes=modes, inertia_shapes=True)
    found, basis = body.accuracy(3, held=("left",)), body.basis
    assert (basis.loaded, basis.vibrations % 3) == (count, -count % 3)
    assert basis.vibrations >= modes
    assert max(found.free_errors.max(), found.held_errors.max()) < 2e-5
    for name, load in found.loads.items():
        assert load.deflection_error < 2e-7, name
        assert load.stress_error < 5e-5, name
    first = 1.8751041**2 * math.sqrt(STEEL.young * height**2 / 12.0 / STEEL.density) / (2.0 * math.pi * length**2)
    assert found.held[0, 1] == pytest.approx(first, rel=1.3e-3 + 1.1 * (height / length) ** 2)  # shear, wide root
    sag = STEEL.density * length**4 * 12.0 / (8.0 * STEEL.young * height**2)
    assert found.loads["acceleration along y"].deflection == pytest.approx(sag, rel=2e-3 + 2.0 * (height / length) ** 2)
    inner = basis.shapes[:, 3:]
    mass = inner.T @ (body.model.mass_matrix() @ inner)
    scale = np.sqrt(np.diag(mass))
    assert np.linalg.cond(mass / np.outer(scale, scale)) < 1e8


def test_no_shape_of_rotation_where_it_is_none_of_its_own_or_has_no_room():
    """A rod of two elements has one axial displacement inside; three vibrations leave three shapes to an L of two."""
    lines = {"section": fm.Rectangle(width=0.01, height=0.02), "material": STEEL}
    whole, half = (fm.FlexibleLink("rod", (0.0, 0.0), (L, 0.0), elements=n, **lines) for n in (1, 2))
    bent = fm.FlexibleFrame("L", ((0.0, 0.0), (0.3, 0.0), (0.4, 0.2)), ((0, 1), (1, 2)), elements=1, **lines)
    start = {"pins": (bent.nodes()[0].name,)}
    cases = [(whole, {"pins": ("start",)}), (half, {}), (bent, {"modes": 3, **start}), (bent, start)]
    found = [fm.Reduced(body, inertia_shapes=True, **options).accuracy() for body, options in cases]
    assert [one.coordinates for one in found] == [6, 9, 9, 9]
    assert [one.modes for one in found] == [0, 0, 3, 2]
    assert max(load.stress_error for one in found for load in one.loads.values()) < 1e-9


def test_given_loads():
    """A field is an acceleration of gravity; forces act at the points of the model."""
    small = eyes(modes=3)
    points = small.model.points
    middle = np.hypot(*(points - (0.06, 0.0)).T).argmin()
    forces = np.zeros_like(points)
    forces[middle, 1] = 100.0
    found = small.accuracy(loads={"weight": lambda p: np.tile([0.0, -9.81], (len(p), 1)), "push": forces})
    weight, unit, push = (found.loads[name] for name in ("weight", "acceleration along y", "push"))
    assert weight.deflection == pytest.approx(9.81 * unit.deflection, rel=1e-9)
    assert weight.stress_error == pytest.approx(unit.stress_error, rel=1e-9)
    assert 0.0 < push.deflection_error < 0.2
    assert str(found).splitlines()[-1].startswith("push")


def test_the_table_shows_the_numbers():
    found = beam(modes=3).accuracy(1, held=("start",))
    lines = repr(found).splitlines()
    assert lines[0] == "FlexibleLink 'rod': 3 vibrations, 9 coordinates for 51"
    assert lines[4].split() == ["held", "(node0)", "1", "Hz", "16.7103", "16.7106", "1.5e-05"]
    assert lines[-4].split()[:3] == ["acceleration", "along", "x"]


REFUSED = {
    "an unknown pin": (lambda: beam().accuracy(held=("middle",)), "held pin.*'middle'"),
    "no pin": (lambda: beam().accuracy(held=()), "held is empty"),
    "a load of another shape": (lambda: beam().accuracy(loads={"push": np.zeros(3)}), "load 'push' has the shape"),
    "no frequency": (lambda: beam().accuracy(0), "count"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    make, message = REFUSED[case]
    with pytest.raises(InputError, match=message):
        make()
