"""Natural frequencies of plane bodies against exact ones and published models."""

from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jv, jvp, yv, yvp

from flexmb.elastic.meshes.outlines import link_with_eyes, rectangle, ring
from flexmb.elastic.planes.cells import PlaneMatrices, matrices
from flexmb.elastic.planes.pins import Interface, Tie, tie
from flexmb.elastic.planes.plane_body import vibrations
from flexmb.errors import InputError
from flexmb.model.law import Material

E, NU, RHO, INNER, OUTER = 2.1e11, 0.3, 7850.0, 0.05, 0.2
STEEL = Material(young=E, density=RHO, poisson=NU)


def ring_determinant(n: int, inner: str, frequency: float) -> float:
    """Frequency equation of in-plane vibrations of a ring in plane stress with n waves around.

    u = grad phi + curl psi, phi = (A J_n + B Y_n)(h r) cos, psi = (C J_n + D Y_n)(k r) sin; outer edge free, inner edge
    "free" or "held".  A. W. Leissa, M. S. Qatu, Vibrations of Continuous Systems, McGraw-Hill 2011.
    """
    w = 2 * np.pi * frequency
    stiff, shear = E / (1 - NU**2), E / (2 * (1 + NU))
    columns = []
    for speed, is_curl in ((np.sqrt(stiff / RHO), False), (np.sqrt(shear / RHO), True)):
        k = w / speed
        for value, slope in ((jv, jvp), (yv, yvp)):
            column = []
            for r, edge in ((INNER, inner), (OUTER, "free")):
                f, f1, f2 = value(n, k * r), k * slope(n, k * r), k**2 * slope(n, k * r, 2)
                if is_curl:
                    u, u1, v, v1 = n * f / r, n * (f1 / r - f / r**2), -f1, -f2
                else:
                    u, u1, v, v1 = f1, f2, -n * f / r, -n * (f1 / r - f / r**2)
                radial = stiff * (u1 + NU * (u + n * v) / r) / E
                sheared = shear * (v1 - (v + n * u) / r) / E
                column += [u, v] if edge == "held" else [radial * r, sheared * r]
            columns.append(np.array(column) / np.linalg.norm(column))
    return float(np.linalg.det(np.array(columns)))


def exact(n: int, inner: str, near: float) -> float:
    """Root of the frequency equation near a frequency [Hz]."""
    return brentq(partial(ring_determinant, n, inner), 0.998 * near, 1.002 * near, xtol=1e-7, rtol=1e-12)


FREE = ((2, 4335.185703), (2, 4335.185703), (1, 7179.83932), (1, 7179.83932), (0, 7355.14624))
HELD = ((0, 1955.765099), (1, 4320.180086), (1, 4320.180086))


def ring_errors(kind: str, size: float) -> np.ndarray:
    """Relative errors of the lowest frequencies of the free ring, then of the ring held at its hub."""
    mesh = ring(INNER, OUTER, size, kind)
    body = matrices(mesh, STEEL, 0.01)
    hub = tie([Interface("hub", mesh.sets["inner"], (0.0, 0.0))], mesh)
    free, _ = vibrations(body, 5)
    held, _ = vibrations(body, 3, hub, ["hub"])
    wanted = [exact(n, "free", f) for n, f in FREE] + [exact(n, "held", f) for n, f in HELD]
    return np.concatenate([free, held]) / wanted - 1


@pytest.mark.parametrize(
    ("n", "inner", "value"), [*((n, "free", f) for n, f in FREE[1:4]), *((n, "held", f) for n, f in HELD)]
)
def test_the_frequency_equation_has_the_known_roots(n, inner, value):
    assert exact(n, inner, value) == pytest.approx(value, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tri6", pytest.param("quad9", marks=pytest.mark.slow)])
def test_ring_frequencies_converge_with_order_four(kind):
    errors = ring_errors(kind, 0.02), ring_errors(kind, 0.01)
    assert (errors[1] > 0).all()
    assert errors[1].max() < 8e-5
    order = np.log2(errors[0] / errors[1])
    assert order.min() > 3.1
    assert np.median(order) > 3.4


def test_cantilever_frequencies():
    """L = 1 m, h = 0.1 m, clamped at x = 0; Timoshenko with 5/6: 82.894, 496.81, 2370.3 Hz."""
    mesh = rectangle(1.0, 0.1, 64, 8)
    clamp = tie([Interface("clamp", mesh.sets["left"], (0.0, 0.05))], mesh)
    found, _ = vibrations(matrices(mesh, STEEL, 1.0), 5, clamp, ["clamp"])
    np.testing.assert_allclose(found, [82.994, 497.88, 1294.54, 1311.4, 2383.2], rtol=1e-4)


def link(size: float, kind: str = "quad9", interface: str = "rigid") -> tuple[PlaneMatrices, Tie]:
    """Link of 120 mm with eyes of 20 mm, holes of 10 mm, a shank of 20 mm."""
    mesh = link_with_eyes(0.12, 0.02, 0.01, 0.02, size, kind)
    pins = [Interface(name, mesh.sets[name], mesh.centre_of(name), interface) for name in ("start", "end")]
    return matrices(mesh, STEEL, 0.01), tie(pins, mesh)


@pytest.mark.parametrize(
    ("size", "free", "held"),
    [
        (0.0025, [3447.0, 8286.6, 12972.0], [913.936, 5327.25, 9488.96, 13851.8]),
        pytest.param(0.00125, [3445.7, 8277.3, 12963.0], [913.379, 5324.14, 9487.65, 13841.6], marks=pytest.mark.slow),
    ],
)
def test_link_with_eyes(size, free, held):
    """Against quadratic triangles of another generator on meshes of about this size; corners at the shank converge
    slowly, 4e-4 from the first size to the second one."""
    body, pins = link(size)
    np.testing.assert_allclose(vibrations(body, 3)[0], free, rtol=6e-5)
    np.testing.assert_allclose(vibrations(body, 4, pins, ["start"])[0], held, rtol=4e-5)


@pytest.mark.slow
def test_triangles_and_quadrilaterals_approach_each_other():
    """Measured 4.0e-3 and 1.4e-3: the corners at the shank."""
    apart = []
    for size in (0.005, 0.0025):
        triangles, squares = (vibrations(link(size, kind)[0], 3)[0] for kind in ("tri6", "quad9"))
        assert (triangles > squares).all()
        apart.append((triangles / squares - 1).max())
    assert apart[1] < 1.5e-3
    assert apart[0] > 2.5 * apart[1]


def test_an_averaged_pin_is_softer_than_a_rigid_one():
    """The eye may become oval: the frequencies of the held link are lower."""
    soft, stiff = (vibrations(body, 4, pins, ["start"])[0] for body, pins in (link(0.005, interface=i) for i in
                   ("averaged", "rigid")))  # fmt: skip
    assert (soft < stiff).all()
    free = [vibrations(body, 3, pins)[0] for body, pins in (link(0.005), link(0.005, interface="averaged"))]
    bare = vibrations(link(0.005)[0], 3)[0]
    assert (free[0] > bare).all()
    np.testing.assert_allclose(free[1], bare, rtol=1e-9)  # the pin of a free body takes nothing away


def test_shapes_are_orthonormal_and_solve_the_problem():
    body, pins = link(0.005)
    frequencies, shapes = vibrations(body, 4, pins, ["start"])
    np.testing.assert_allclose(shapes.T @ body.mass @ shapes, np.eye(4), atol=1e-9)
    squared = (2 * np.pi * frequencies) ** 2
    np.testing.assert_allclose(shapes.T @ body.stiffness @ shapes, np.diag(squared), atol=1e-8 * squared[-1])
    nodes = pins.pins.index("start")
    assert nodes == 0
    mesh = body.mesh
    assert np.abs(shapes.reshape(-1, 2, 4)[mesh.sets["start"]]).max() == 0.0


def test_wrong_questions_are_refused():
    body, pins = link(0.01)
    with pytest.raises(InputError, match=r"held pin is 'strat'\. Did you mean 'start'"):
        vibrations(body, 3, pins, ["strat"])
    with pytest.raises(InputError, match="count is 100000"):
        vibrations(body, 100000)
    with pytest.raises(InputError, match="count is 0"):
        vibrations(body, 0)
