"""Plane cells against differences, rigid motions and scikit-fem; the mean of a pin against its definition."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.meshes.mesh import PlaneMesh
from flexmb.elastic.planes.cells import Cells, cell_contributions, cell_energy, cell_force, cell_kernel, matrices
from flexmb.elastic.planes.elements import COROTATED, TOTAL_LAGRANGE
from flexmb.elastic.planes.pins import Interface

SOFT = fm.Material(young=2e5, density=2000.0, poisson=0.3)
CORNERS = {"tri3": [(0, 0), (1, 0), (0, 1)], "quad4": [(0, 0), (1, 0), (1, 1), (0, 1)]}
KINDS = ("tri3", "tri6", "quad4", "quad9")
FORMULATIONS = {"corotated": COROTATED, "total-lagrange": TOTAL_LAGRANGE}
PLACES = {"p": (2.9, 4.05), "q": (3.0, 5.0)}
GRAVITY = (1.0, -9.0)


def skew_mesh(kind):
    """One cell of a skew shape; quadratic cells have bent sides."""
    linear = "tri3" if kind.startswith("tri") else "quad4"
    points = np.array(CORNERS[linear], dtype=float) @ [[1.2, 0.1], [-0.2, 0.9]] + [3.0, 4.0]
    mesh = PlaneMesh(points, [range(len(points))], linear)
    if kind == linear:
        return mesh
    mesh = mesh.to_quadratic()
    bent = mesh.points + 0.02 * np.random.default_rng(1).normal(size=mesh.points.shape)
    return PlaneMesh(bent, mesh.cells, kind)


def one_cell(kind, formulation=COROTATED, damping=0.0, held=(), gravity=GRAVITY):
    """Element of one cell whose first nodes lie on pins, and the mesh."""
    mesh = skew_mesh(kind)
    cells = Cells.of(mesh, SOFT, 0.1, "stress", formulation)
    made = {name: Interface(name, mesh.cells[0], PLACES[name]) for name in held}
    pins = {int(mesh.cells[0, k]): made[name] for k, name in enumerate(held)}
    free = {k: f"n{k}" for k in range(len(mesh.points)) if k not in pins}
    (element,) = cell_contributions("body", cells, free, pins, damping, gravity)
    return element, mesh


def rigid_pose(element, mesh, angle):
    """Coordinates of the element after a rotation about the origin, and velocities of a rotation with 1 rad/s."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    q, v = [], []
    for _, node, axis in element.coordinates:
        place = turn @ (PLACES[node] if node in PLACES else mesh.points[int(node[1:])])
        q.append(angle if axis == 2 else place[axis])
        v.append(1.0 if axis == 2 else (-place[1], place[0])[axis])
    return np.array(q), np.array(v)


def called(element, q, v, a):
    """r, K, C, M of an element."""
    n = len(q)
    r, matrices = np.zeros(n), [np.zeros((n, n)) for _ in range(3)]
    cell_kernel.dispatcher(np.array(element.p), 0.0, 0.0, q, v, a, np.zeros(0), r, *matrices, np.zeros(0))
    return r, *matrices


def slopes(function, x, h):
    """Derivatives of a function by differences of fourth order, a column for each entry of x."""
    columns = []
    for i in range(len(x)):
        d = np.zeros(len(x))
        d[i] = h
        columns.append((8.0 * (function(x + d) - function(x - d)) - function(x + 2 * d) + function(x - 2 * d)) / 12 / h)
    return np.array(columns).T


@pytest.mark.quick(10)
@pytest.mark.parametrize("held", [(), ("p", "p"), ("p", "q", "p")], ids=["free", "side on a pin", "two pins"])
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_tangents_and_energy_are_derivatives(kind, formulation, held):
    element, mesh = one_cell(kind, FORMULATIONS[formulation], 1e-2, held)
    q, _ = rigid_pose(element, mesh, 0.7)
    random = np.random.default_rng(3)
    q = q + 0.05 * random.normal(size=len(q))
    v, a = random.normal(size=len(q)), 50.0 * random.normal(size=len(q))
    _, K, C, M = called(element, q, v, a)
    assert np.abs(slopes(lambda x: called(element, x, v, a)[0], q, 1e-3) - K).max() < 1e-9 * np.abs(K).max()
    assert np.abs(slopes(lambda x: called(element, q, x, a)[0], v, 1e-3) - C).max() < 1e-9 * np.abs(C).max()
    assert np.abs(slopes(lambda x: called(element, q, v, x)[0], a, 1.0) - M).max() < 1e-9 * np.abs(M).max()
    p, still = np.array(element.p), np.zeros(len(q))
    potential = slopes(lambda x: np.array([sum(cell_energy.dispatcher(p, 0.0, x, v)[:2])]), q, 1e-4)[0]
    force = called(element, q, still, still)[0]
    assert np.abs(potential - force).max() < 1e-9 * np.abs(force).max()
    power = cell_energy.dispatcher(p, 0.0, q, v)[2]
    if not held:  # on pins, inertia depends on velocities, too
        assert power == pytest.approx(v @ (called(element, q, v, a)[0] - called(element, q, still, a)[0]), rel=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_large_rotation_makes_no_force_and_is_not_damped(kind, formulation):
    """After any number of turns, a rigid motion has no strain and no damping; a stretch of 1e-6 is seen."""
    element, mesh = one_cell(kind, FORMULATIONS[formulation], 1e-2, gravity=(0.0, 0.0))
    q, v = rigid_pose(element, mesh, 2000.0 * np.pi + 2.1)
    p, r = np.array(element.p), np.zeros(len(q))
    cell_force.dispatcher(p, 0.0, 0.0, q, v, 0.0 * q, np.zeros(0), r, np.zeros(0))
    stretched = np.zeros(len(q))
    cell_force.dispatcher(p, 0.0, 0.0, (1.0 + 1e-6) * q, 0.0 * v, 0.0 * q, np.zeros(0), stretched, np.zeros(0))
    assert np.abs(r).max() < 1e-7 * np.abs(stretched).max()
    strain, _, power = cell_energy.dispatcher(p, 0.0, q, v)
    assert max(strain, power) < 1e-20


@pytest.mark.parametrize("kind", KINDS)
def test_stiffness_at_rest_is_that_of_scikit_fem(kind):
    """Both formulations begin with the same stiffness and mass, those of the weak forms."""
    for formulation in FORMULATIONS.values():
        element, mesh = one_cell(kind, formulation)
        q, _ = rigid_pose(element, mesh, 0.0)
        _, K, _, M = called(element, q, 0.0 * q, 0.0 * q)
        expected = matrices(mesh, SOFT, 0.1)
        dofs = (2 * mesh.cells[0][:, None] + [0, 1]).ravel()
        k, m = expected.stiffness.toarray()[np.ix_(dofs, dofs)], expected.mass.toarray()[np.ix_(dofs, dofs)]
        assert np.abs(K - k).max() < 1e-9 * np.abs(k).max()
        assert np.abs(M - m).max() < 1e-12 * np.abs(m).max()
