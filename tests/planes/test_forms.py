"""Matrices of plane bodies: scikit-fem's own assembly, patch tests, rigid motions, published and exact solutions."""

import subprocess
import sys

import numpy as np
import pytest
from mesh_pressures import edge_pressure
from scipy.sparse.linalg import spsolve
from skfem import Basis, BilinearForm, ElementVector
from skfem.helpers import ddot, dot, sym_grad, trace

from flexmb.elastic.meshes.mesh import PlaneMesh, elasticity
from flexmb.elastic.meshes.outlines import joined, link_with_eyes, rectangle, ring, ruled, sampled, segment
from flexmb.elastic.planes.cells import (
    cell_masses,
    cell_stiffness,
    geometric_stiffness,
    matrices,
    stiffness_basis,
    stress_at_quadrature,
)
from flexmb.elastic.planes.loads import body_force, edge_load
from flexmb.errors import InputError
from flexmb.model.law import Material

KINDS = ("tri3", "tri6", "quad4", "quad9")
STEEL = Material(young=2.1e11, density=7850.0, poisson=0.3)


def skewed(kind: str, n: int = 3) -> PlaneMesh:
    """A quadrilateral of irregular cells; the diagonals of its triangles are slightly curved."""
    mesh = rectangle(1.0, 0.6, n, n, kind)
    x, y = mesh.points.T
    points = np.stack([x + 0.3 * x * y, y + 0.25 * x * y], axis=1)
    return PlaneMesh(points, mesh.cells, kind, mesh.sets)


def linear(points: np.ndarray) -> np.ndarray:
    """Displacements x0, y0, x1, ... of a constant strain with a rotation."""
    return (points @ np.array([[1e-3, 4e-4], [-7e-4, 2e-3]]) + np.array([0.1, -0.2])).ravel()


@pytest.mark.parametrize("state", ["stress", "strain"])
@pytest.mark.parametrize("kind", KINDS)
def test_stiffness_and_mass_are_those_of_scikit_fem(kind, state):
    """Energies of a nodal field against scikit-fem's vector element with its own node numbers."""
    mesh = ring(0.05, 0.2, 0.05, kind)
    own = matrices(mesh, STEEL, 0.01, state)
    E, nu = STEEL.young, STEEL.poisson
    lam = E * nu / (1 - nu**2) if state == "stress" else E * nu / ((1 + nu) * (1 - 2 * nu))
    mu = 0.5 * E / (1 + nu)
    basis = Basis(mesh.skfem(), ElementVector(mesh.cell_kind.element()), intorder=mesh.cell_kind.stiffness_order)

    @BilinearForm
    def elastic(u, v, w):
        e, d = sym_grad(u), sym_grad(v)
        return 0.01 * (lam * trace(e) * trace(d) + 2 * mu * ddot(e, d))

    def field(x):
        return np.stack([np.sin(7 * x[0]) * x[1], np.cos(5 * x[1]) - x[0] * x[1]])

    u = np.zeros(basis.N)
    for component in (0, 1):
        dofs = basis.split_indices()[component]
        u[dofs] = field(basis.doflocs[:, dofs])[component]
    mine = field(mesh.points.T).T.ravel()
    energy = u @ elastic.assemble(basis) @ u
    assert mine @ own.stiffness @ mine == pytest.approx(energy, rel=1e-12)
    order = mesh.cell_kind.mass_order
    vector = Basis(mesh.skfem(), ElementVector(mesh.cell_kind.element()), intorder=order)
    mass = BilinearForm(lambda u, v, w: 78.5 * dot(u, v)).assemble(vector)
    assert mine @ own.mass @ mine == pytest.approx(u @ mass @ u, rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_patch_test_of_constant_stress(kind):
    """Nodes inside stay where a constant strain puts them, and the stress is the exact one everywhere."""
    mesh = skewed(kind)
    K = matrices(mesh, STEEL, 0.02).stiffness
    exact = linear(mesh.points)
    edge = np.unique(mesh.edges.boundary)
    held = (2 * edge[:, None] + np.arange(2)).ravel()
    free = np.setdiff1d(np.arange(len(exact)), held)
    u = np.where(np.isin(np.arange(len(exact)), held), exact, 0.0)
    u[free] = spsolve(K[free][:, free].tocsc(), -(K @ u)[free])
    np.testing.assert_allclose(u, exact, atol=1e-13)
    stress = stress_at_quadrature(mesh, STEEL, u)
    ex, ey, gxy = 1e-3, 2e-3, 4e-4 - 7e-4
    D = STEEL.young / (1 - 0.09) * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    np.testing.assert_allclose(stress, np.broadcast_to(D @ [ex, ey, gxy], stress.shape), rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_motions_have_no_forces_and_no_stress(kind):
    mesh = ring(0.05, 0.2, 0.04, kind)
    K = matrices(mesh, STEEL, 0.01).stiffness
    x, y = mesh.points.T
    for motion in ((1.0 + 0 * x, 0 * x), (0 * x, 1.0 + 0 * x), (-y, x)):
        u = np.stack(motion, axis=1).ravel()
        assert np.abs(K @ u).max() < 1e-13 * np.abs(K).max()
        assert np.abs(stress_at_quadrature(mesh, STEEL, u)).max() < 1e-12 * STEEL.young / 0.05
    assert abs(K - K.T).max() == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_matrices_of_cells_add_up_to_those_of_the_body(kind):
    mesh = skewed(kind)
    whole, of_cells = matrices(mesh, STEEL, 0.01), (cell_stiffness(mesh, STEEL, 0.01), cell_masses(mesh, STEEL, 0.01))
    dofs = (2 * mesh.cells[:, :, None] + np.arange(2)).reshape(len(mesh.cells), -1)
    K, M = np.zeros(whole.stiffness.shape), np.zeros(whole.scalar_mass.shape)
    for numbers, nodes, stiffness, mass in zip(dofs, mesh.cells, *of_cells, strict=True):
        K[np.ix_(numbers, numbers)] += stiffness
        M[np.ix_(nodes, nodes)] += mass
    np.testing.assert_allclose(whole.stiffness.toarray(), K, rtol=1e-12, atol=1e-14 * K.max())
    np.testing.assert_allclose(whole.scalar_mass.toarray(), M, rtol=1e-12, atol=1e-18)


def test_mass_and_moment_of_inertia_of_a_ring_and_a_rectangle():
    mass, centre, inertia = matrices(rectangle(0.3, 0.1, 4, 2), STEEL, 0.02).rigid_properties
    assert mass == pytest.approx(7850 * 0.02 * 0.03, rel=1e-13)
    assert centre == pytest.approx((0.15, 0.05), rel=1e-13)
    assert inertia == pytest.approx(mass * (0.3**2 + 0.1**2) / 12, rel=1e-12)
    errors = []
    for size in (0.04, 0.02):
        mass, _, inertia = matrices(ring(0.05, 0.2, size), STEEL, 0.01).rigid_properties
        exact = 7850 * 0.01 * np.pi * (0.2**2 - 0.05**2)
        errors.append((mass / exact - 1, inertia / (0.5 * exact * (0.2**2 + 0.05**2)) - 1))
    assert np.abs(errors[1]).max() < 1e-6
    assert np.log2(np.divide(*errors)).min() > 3.9  # quadratic arcs: fourth order


@pytest.mark.parametrize("kind", ["quad4", "quad9", "tri6"])
def test_scalar_mass_is_exact_where_cells_are_curved(kind):
    """Mass from the boundary integral of the same mesh."""
    mesh = ring(0.05, 0.2, 0.06, kind)
    assert matrices(mesh, STEEL, 0.01).rigid_properties[0] == pytest.approx(78.5 * mesh.area, rel=1e-13)


def cook(kind: str, n: int) -> PlaneMesh:
    """Cook's membrane."""
    sides = [sampled([segment(*ends)], [n]) for ends in (((0, 0), (0, 44)), ((48, 44), (48, 60)))]
    mesh = joined([ruled(*sides, n)], kind, "Cook")
    x = mesh.points[:, 0]
    sets = {"left": np.flatnonzero(x < 1e-9), "right": np.flatnonzero(x > 48 - 1e-9)}
    return PlaneMesh(mesh.points, mesh.cells, kind, sets)


def deflection_of_cook(mesh: PlaneMesh) -> float:
    """Upward displacement of the middle of the right edge under a uniform shear of 1 in all."""
    K = matrices(mesh, Material(1.0, 1.0, 1 / 3), 1.0).stiffness
    load = edge_load(mesh, "right", (0.0, 1 / 16), 1.0)
    left = mesh.sets["left"]
    free = np.setdiff1d(np.arange(len(load)), [2 * left, 2 * left + 1])
    u = np.zeros(len(load))
    u[free] = spsolve(K[free][:, free].tocsc(), load[free])
    return u[2 * np.argmin(np.hypot(*(mesh.points - [48, 52]).T)) + 1]


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("kind", "values"),
    [
        # 2 x 2 Gauss points: 11.845 and 18.299 are the textbook values of the bilinear quadrilateral
        ("quad4", {2: 11.8452, 4: 18.2992, 8: 22.0792, 16: 23.4304, 32: 23.8176}),
        ("quad9", {2: 23.2887, 4: 23.8397, 8: 23.9254, 16: 23.9494, 32: 23.9608}),
    ],
)
def test_cooks_membrane(kind, values):
    """R. D. Cook, J. Struct. Div. ASCE 100 (1974) 1851; limit 23.96 to 23.97."""
    found = {n: deflection_of_cook(cook(kind, n)) for n in values}
    assert found == pytest.approx(values, abs=1e-4)
    assert abs(found[32] - 23.967) < (0.16 if kind == "quad4" else 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tri6", pytest.param("quad9", marks=pytest.mark.slow)])
def test_rotating_ring(kind):
    """Closed form of plane stress, a = 0.05 m, b = 0.2 m, 1000 rad/s; the displacement converges with order 4."""
    exact = {"inner": 6.249627976e-5, "outer": 6.775297619e-5}
    errors = []
    for size in (0.015, 0.0075):
        mesh = ring(0.05, 0.2, size, kind)
        u = settled(mesh, body_force(mesh, lambda x: 7850 * 1000**2 * x, 0.01))
        errors.append([radial(mesh, u, name) / value - 1 for name, value in exact.items()])
    assert np.abs(errors[1]).max() < 7e-6
    assert np.log2(np.divide(*errors)).min() > 3.4


@pytest.mark.slow
def test_ring_under_inner_pressure():
    """Lame's solution, 100 MPa inside."""
    mesh = ring(0.05, 0.2, 0.0075)
    u = settled(mesh, edge_pressure(mesh, "inner", 100e6, 0.01))
    assert radial(mesh, u, "inner") == pytest.approx(3.412698413e-5, rel=1e-5)
    assert radial(mesh, u, "outer") == pytest.approx(1.269841270e-5, rel=1e-5)


def test_ring_under_inner_pressure_in_plane_strain():
    """u(r) = (1 + nu) p a^2 / (E (b^2 - a^2)) ((1 - 2 nu) r + b^2 / r)."""
    mesh = ring(0.05, 0.2, 0.0075)
    u = settled(mesh, edge_pressure(mesh, "inner", 100e6, 0.01), "strain")
    factor = 1.3 * 1e8 * 0.05**2 / (2.1e11 * (0.2**2 - 0.05**2))
    for name, r in (("inner", 0.05), ("outer", 0.2)):
        assert radial(mesh, u, name) == pytest.approx(factor * (0.4 * r + 0.04 / r), rel=1e-5)


def settled(mesh: PlaneMesh, load: np.ndarray, state: str = "stress") -> np.ndarray:
    """Displacements of a ring under forces in balance; three displacements are held against rigid motions."""
    K = matrices(mesh, STEEL, 0.01, state).stiffness
    x, y = mesh.points.T
    held = [2 * np.argmax(x) + 1, 2 * np.argmin(x) + 1, 2 * np.argmax(y)]
    free = np.setdiff1d(np.arange(len(load)), held)
    u = np.zeros(len(load))
    u[free] = spsolve(K[free][:, free].tocsc(), load[free])
    return u


def radial(mesh: PlaneMesh, u: np.ndarray, name: str) -> float:
    """Mean radial displacement of a set [m]."""
    points = mesh.points[mesh.sets[name]]
    normal = points / np.linalg.norm(points, axis=1)[:, None]
    return float(np.sum(u.reshape(-1, 2)[mesh.sets[name]] * normal, axis=1).mean())


def test_cantilever_bends_between_timoshenko_and_its_clamp():
    """L = 1 m, h = 0.1 m: Timoshenko 1.91933e-8 m for 1 N/m; the clamp holds warping, so a little less."""
    mesh = rectangle(1.0, 0.1, 64, 8)
    K = matrices(mesh, STEEL, 1.0).stiffness
    shear = edge_load(mesh, "right", lambda x: np.stack([0 * x[:, 0], 6e3 * x[:, 1] * (0.1 - x[:, 1])], axis=1), 1.0)
    assert shear.sum() == pytest.approx(1.0, rel=1e-12)
    left = mesh.sets["left"]
    free = np.setdiff1d(np.arange(len(shear)), [2 * left, 2 * left + 1])
    u = np.zeros(len(shear))
    u[free] = spsolve(K[free][:, free].tocsc(), shear[free])
    assert u[1::2][mesh.sets["right"]].mean() == pytest.approx(1.9161e-8, rel=2e-4)


def test_geometric_stiffness_of_a_uniform_stress_is_that_of_a_string():
    """Kg of sx = s on a bent beam of thickness t and area A approximates int s A w_x^2 dx; a stretch needs nothing."""
    mesh = rectangle(1.0, 0.1, 20, 2)
    shape = (len(mesh.cells), 9, 3)
    stress = np.zeros(shape)
    stress[:, :, 0] = 5e6
    Kg = geometric_stiffness(mesh, stress, 0.01)
    x, y = mesh.points.T - [[0.0], [0.05]]
    bent, stretched, turned = np.zeros((3, 2 * len(x)))
    bent[0::2], bent[1::2] = -np.pi * y * np.cos(np.pi * x), np.sin(np.pi * x)
    stretched[0::2], stretched[1::2] = x, 0.3 * y
    turned[0::2], turned[1::2] = -y, x
    assert bent @ Kg @ bent == pytest.approx(5e6 * 0.01 * 0.1 * np.pi**2 / 2, rel=1e-4)
    assert turned @ Kg @ turned == pytest.approx(5e6 * 0.01 * 0.1, rel=1e-12)
    assert np.abs(Kg @ stretched).max() < 1e-9 * np.abs(Kg @ turned).max()


@pytest.mark.parametrize("kind", KINDS)
def test_geometric_stiffness_is_the_work_of_stresses_on_the_shortening_of_rotations(kind):
    """int (sx + sy) w^2 t dA, with the rotation w by the gradient of displacements at the points."""
    mesh = skewed(kind)
    rng = np.random.default_rng(1)
    u, w = rng.standard_normal((2, 2 * len(mesh.points)))
    stress = stress_at_quadrature(mesh, STEEL, u)
    Kg = geometric_stiffness(mesh, stress, 0.01)
    basis = stiffness_basis(mesh)
    gradients = np.zeros((2, 2, *basis.dx.shape))
    for k, (field, *_) in enumerate(basis.basis):
        gradients += np.einsum("ma,bmq->abmq", w.reshape(-1, 2)[mesh.cells][:, k], np.asarray(field.grad))
    sx, sy, _ = np.moveaxis(stress, -1, 0)
    turned = 0.5 * (gradients[1, 0] - gradients[0, 1])
    assert w @ Kg @ w == pytest.approx(np.sum(0.01 * basis.dx * (sx + sy) * turned**2), rel=1e-11)
    assert np.abs(Kg - Kg.T).max() < 1e-14 * np.abs(Kg).max()


def test_two_materials_in_series_stretch_like_two_springs():
    mesh = rectangle(2.0, 0.5, 4, 1)
    left = mesh.points[mesh.cells[:, :4]].mean(axis=1)[:, 0] < 1.0
    regions = {"soft": np.flatnonzero(left), "stiff": np.flatnonzero(~left)}
    mesh = PlaneMesh(mesh.points, mesh.cells, mesh.kind, mesh.sets, regions)
    soft, stiff = Material(1e9, 1000.0, 0.0), Material(4e9, 3000.0, 0.0)
    by_region = matrices(mesh, {"soft": soft, "stiff": stiff}, {"soft": 0.02, "stiff": 0.01})
    load = edge_load(mesh, "right", (1e6, 0.0), 0.01)
    held = np.concatenate([2 * mesh.sets["left"], 2 * mesh.sets["bottom"] + 1])
    free = np.setdiff1d(np.arange(len(load)), held)
    u = np.zeros(len(load))
    u[free] = spsolve(by_region.stiffness[free][:, free].tocsc(), load[free])
    force = 1e6 * 0.5 * 0.01
    stretch = force / (1e9 * 0.5 * 0.02) + force / (4e9 * 0.5 * 0.01)
    np.testing.assert_allclose(u[2 * mesh.sets["right"]], stretch, rtol=1e-11)
    mass = by_region.rigid_properties[0]
    assert mass == pytest.approx(0.5 * (1000 * 0.02 + 3000 * 0.01), rel=1e-13)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"material": {"a": STEEL}}, "no region 'a' for material. Did you mean"),
        ({"material": {"aa": STEEL}}, "2 cells are in no region of material"),
        ({"material": {"aa": STEEL, "all": STEEL}}, "2 cells are in several regions"),
        ({"material": "steel"}, "must be a Material"),
        ({"thickness": 0.0}, "thickness is 0 m; it must be > 0"),
        ({"thickness": {"aa": 1.0, "bb": -2.0}}, "thickness is -2 m"),
        ({"state": "plane"}, "state is 'plane'"),
    ],
)
def test_wrong_values_are_refused(arguments, words):
    mesh = rectangle(2.0, 1.0, 2, 2)
    regions = {"aa": [0, 1], "bb": [2, 3], "all": [0, 1, 2, 3]}
    mesh = PlaneMesh(mesh.points, mesh.cells, mesh.kind, mesh.sets, regions)
    with pytest.raises(InputError, match=words):
        matrices(mesh, **{"material": STEEL, "thickness": 0.01, **arguments})


def test_elasticity_of_plane_strain_is_that_of_three_dimensions():
    D11, D12, D33 = elasticity(rectangle(1.0, 1.0, 1, 1), STEEL, "strain")[0]
    lam, mu = STEEL.young * 0.3 / (1.3 * 0.4), STEEL.young / 2.6
    assert pytest.approx((lam + 2 * mu, lam, mu), rel=1e-14) == (D11, D12, D33)


def test_loads_on_sets_without_edges_and_of_wrong_shape_are_refused():
    mesh = rectangle(1.0, 1.0, 2, 2)
    lonely = PlaneMesh(mesh.points, mesh.cells, mesh.kind, {"corner": mesh.sets["left"][:1]})
    with pytest.raises(InputError, match="the set 'corner' holds no edge"):
        edge_load(lonely, "corner", (1.0, 0.0), 0.01)
    with pytest.raises(InputError, match=r"function of points \(p, 2\)"):
        body_force(mesh, lambda x: x[:, 0], 0.01)


def test_the_link_with_eyes_has_the_area_of_its_outline():
    """Two discs of 20 mm with holes of 10 mm at a distance of 120 mm, a bar of 20 mm between: 0.276293817 kg."""
    mass, centre, inertia = matrices(link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.0025), STEEL, 0.01).rigid_properties
    assert mass == pytest.approx(0.27629382, rel=1e-6)
    assert centre == pytest.approx((0.06, 0.0), abs=1e-12)
    assert inertia == pytest.approx(6.45554289e-4, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tri6", "quad9"])
def test_two_hundred_thousand_nodes_are_assembled_in_seconds(kind):
    """Measured 4 s and 8 s with 0.9 GB in all; the matrices alone take 110 MB and 160 MB."""
    code = f"""
import time
from flexmb.model.law import STEEL
from flexmb.elastic.planes.cells import matrices
from flexmb.elastic.meshes.outlines import link_with_eyes
mesh = link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.00029, {kind!r})
begin = time.perf_counter()
matrices(mesh, STEEL, 0.01)
spent = time.perf_counter() - begin
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))  # getrusage knows the parent's, too
print(len(mesh.points), spent, int(peak.split()[1]) / 1e6)
"""
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    nodes, seconds, gigabytes = map(float, said.split())
    assert nodes > 200_000
    assert seconds < 40.0
    assert gigabytes < 1.3
