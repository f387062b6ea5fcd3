"""Plane cells: matrices of bodies from weak forms with scikit-fem; numbers and kernels of elasticity, damping and mass.

Stiffness             int eps(v)^T D eps(u) t dA        eps = (u_x,x; u_y,y; u_x,y + u_y,x)
Mass                  int rho u v t dA                  the same for x and y
Geometric stiffness   int (sx + sy) w(u) w(v) t dA      w = (u_y,x - u_x,y)/2

Displacements are ordered x0, y0, x1, y1, ...  Each form gives local matrices, which are summed here with the node
numbers of the mesh, so that numbers of scikit-fem do not matter.
Equations (11.3) and (11.5) of docs/theory/plane_bodies.md.

The coordinates of a cell are (x, y) of its nodes in the world, or those of `pinned` where nodes lie on pins.  The mass
matrix is constant: accelerations of the nodes are absolute, so no centrifugal or Coriolis force is left out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array, kron
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from skfem import Basis, BilinearForm

from flexmb.elastic.meshes.mesh import STRESS, Materials, PlaneMesh, Thickness, densities, elasticity, numbers_of_cells
from flexmb.elastic.planes import elements
from flexmb.elastic.planes.pins import Interface
from flexmb.engine.compiled.arrays import matrix_view
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel, tangent_kernel
from flexmb.model.contributions import Coordinate, ElementContribution
from flexmb.planar import Array

_PRODUCT = BilinearForm(lambda u, v, w: w.weight * u * v)
_SLOPES = BilinearForm(lambda u, v, w: w.x_x * u.grad[0] * v.grad[0] + w.y_y * u.grad[1] * v.grad[1])
_CROSSED = BilinearForm(lambda u, v, w: w.bulk * u.grad[1] * v.grad[0] + w.shear * u.grad[0] * v.grad[1])


@dataclass(frozen=True, eq=False)
class PlaneMatrices:
    """Stiffness and mass of a plane body."""

    mesh: PlaneMesh
    stiffness: csr_array  # (2n, 2n) sparse [N/m], displacements ordered x0, y0, x1, y1, ...
    scalar_mass: csr_array  # (n, n) sparse [kg], for x and for y; the mass matrix is that times the unit matrix of two

    @cached_property
    def mass(self) -> csr_array:
        """(2n, 2n) mass matrix [kg] in the order of `stiffness`."""
        return csr_array(kron(self.scalar_mass, np.eye(2), format="csr"))

    @cached_property
    def rigid_properties(self) -> tuple[float, tuple[float, float], float]:
        """Mass [kg], centre of mass [m], and moment of inertia about it [kg m^2], in the axes of the mesh."""
        # Equation (11.4) of docs/theory/plane_bodies.md.
        X = self.mesh.points
        weights = self.scalar_mass @ np.ones(len(X))
        mass = float(weights.sum())
        centre = weights @ X / mass
        off = X - centre
        return mass, (float(centre[0]), float(centre[1])), float(np.sum(off * (self.scalar_mass @ off)))


def matrices(mesh: PlaneMesh, material: Materials, thickness: Thickness, state: str = STRESS) -> PlaneMatrices:
    """Sparse stiffness and consistent mass of a plane body of a thickness [m]; the state is "stress" or "strain"."""
    same, cross = _stiffness_blocks(mesh, material, thickness, state)
    blocks = np.empty((2, 2), dtype=object)
    blocks[0, 0], blocks[1, 1] = (assembled(mesh, local) for local in same)
    blocks[0, 1], blocks[1, 0] = assembled(mesh, cross), assembled(mesh, cross.transpose(0, 2, 1))
    pattern = blocks[0, 0]
    data = np.empty((pattern.nnz, 2, 2))
    for i, j in np.ndindex(2, 2):
        data[:, i, j] = blocks[i, j].data
    n = 2 * len(mesh.points)
    stiffness = bsr_array((data, pattern.indices, pattern.indptr), shape=(n, n)).tocsr()
    return PlaneMatrices(mesh, csr_array(stiffness), assembled(mesh, cell_masses(mesh, material, thickness)))


def cell_stiffness(mesh: PlaneMesh, material: Materials, thickness: Thickness, state: str = STRESS) -> Array:
    """Stiffness (m, 2k, 2k) [N/m] of every cell; parameters as of `matrices`."""
    return _interleaved(*_stiffness_blocks(mesh, material, thickness, state))


def _interleaved(same: tuple[Array, Array], cross: Array) -> Array:
    """(m, 2k, 2k) of blocks (m, k, k): x on x and y on y, and x (rows) on y."""
    m, k, _ = cross.shape
    local = np.empty((m, 2 * k, 2 * k))
    local[:, 0::2, 0::2], local[:, 1::2, 1::2] = same
    local[:, 0::2, 1::2], local[:, 1::2, 0::2] = cross, cross.transpose(0, 2, 1)
    return local


def geometric_stiffness(mesh: PlaneMesh, stress: Array, thickness: Thickness) -> csr_array:
    """Sparse geometric stiffness (2n, 2n) [N/m] of stresses in the body, by the rotations that displacements have."""
    # Stresses (m, q, 3) sx, sy, txy [Pa] are those at the points of `stress_at_quadrature`; the thickness is in m.
    basis = stiffness_basis(mesh)
    quarter = 0.25 * numbers_of_cells(mesh, "thickness", thickness, "m")[:, None] * (stress[:, :, 0] + stress[:, :, 1])
    none = np.zeros_like(quarter)
    same = _local(_SLOPES, basis, x_x=none, y_y=quarter), _local(_SLOPES, basis, x_x=quarter, y_y=none)
    local = _interleaved(same, _local(_CROSSED, basis, symmetric=False, bulk=none, shear=-quarter))
    m, k = mesh.cells.shape
    places = (2 * mesh.cells.astype(np.int32)[:, :, None] + np.arange(2, dtype=np.int32)).reshape(m, 2 * k)
    rows, columns = np.repeat(places, 2 * k, axis=1).ravel(), np.tile(places, 2 * k).ravel()
    n = 2 * len(mesh.points)
    return csr_array(coo_array((local.ravel(), (rows, columns)), shape=(n, n)).tocsr())


def stiffness_basis(mesh: PlaneMesh) -> Basis:
    """Shape functions of scikit-fem at the points where stiffness and stress are integrated."""
    return Basis(mesh.skfem(), mesh.cell_kind.element(), intorder=mesh.cell_kind.stiffness_order)


def mass_basis(mesh: PlaneMesh) -> Basis:
    """Shape functions of scikit-fem at the points where the mass is integrated."""
    return Basis(mesh.skfem(), mesh.cell_kind.element(), intorder=mesh.cell_kind.mass_order)


def stress_at_quadrature(mesh: PlaneMesh, material: Materials, u: Array, state: str = STRESS) -> Array:
    """Stresses sx, sy, txy [Pa] (m, q, 3) at quadrature points by displacements u (2n,) x0, y0, x1, ... [m]."""
    basis, own = stiffness_basis(mesh), np.asarray(u, dtype=float).reshape(-1, 2)[mesh.cells]
    slopes = np.zeros((2, 2, *basis.dx.shape))  # component, direction
    for k, (field, *_) in enumerate(basis.basis):
        slopes += np.einsum("ma,bmq->abmq", own[:, k], field.grad)
    d11, d12, d33 = elasticity(mesh, material, state).T[:, :, None]
    ex, ey, gxy = slopes[0, 0], slopes[1, 1], slopes[0, 1] + slopes[1, 0]
    return np.stack([d11 * ex + d12 * ey, d12 * ex + d11 * ey, d33 * gxy], axis=2)


def _stiffness_blocks(
    mesh: PlaneMesh, material: Materials, thickness: Thickness, state: str
) -> tuple[tuple[Array, Array], Array]:
    """Local stiffness (m, k, k) of x on x and y on y, and of x (rows) on y."""
    basis, t = stiffness_basis(mesh), numbers_of_cells(mesh, "thickness", thickness, "m")
    d11, d12, d33 = (t * elasticity(mesh, material, state).T)[:, :, None]
    same = _local(_SLOPES, basis, x_x=d11, y_y=d33), _local(_SLOPES, basis, x_x=d33, y_y=d11)
    # rows are test functions: sx against v_,x holds D12 u_y,y, txy against v_,y holds D33 u_y,x
    return same, _local(_CROSSED, basis, symmetric=False, bulk=d12, shear=d33)


def cell_masses(mesh: PlaneMesh, material: Materials, thickness: Thickness) -> Array:
    """Mass (m, k, k) [kg] of every cell, for x and for y."""
    weight = densities(mesh, material) * numbers_of_cells(mesh, "thickness", thickness, "m")
    return _local(_PRODUCT, mass_basis(mesh), weight=weight[:, None])


def _local(form: BilinearForm, basis: Basis, symmetric: bool = True, **weights: Array) -> Array:
    """Matrix (m, k, k) of a form in every cell: rows test functions, columns trial functions."""
    found: Any = form.coo_data(basis, **weights).tolocal().transpose(0, 2, 1)  # scikit-fem: rows trial functions
    if symmetric:  # to the last bit, which products in another order are not
        found = 0.5 * (found + found.transpose(0, 2, 1))
    return np.asarray(found)


def assembled(mesh: PlaneMesh, local: Array) -> csr_array:
    """Sparse matrix (n, n) of local matrices (m, k, k); its pattern depends on the mesh alone."""
    cells, (n, k) = mesh.cells.astype(np.int32), (len(mesh.points), mesh.cells.shape[1])
    rows, columns = np.repeat(cells, k, axis=1).ravel(), np.tile(cells, k).ravel()
    return csr_array(coo_array((local.ravel(), (rows, columns)), shape=(n, n)).tocsr())


def factored(K: Any) -> Any:
    """Factors of a sparse symmetric matrix."""
    return splu(K.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def lowest(
    K: Any, M: Any, count: int, shift: float = 0.0, solve: Callable[[Array], Array] | None = None
) -> tuple[Array, Array]:
    """Lowest eigenvalues (count,) of K x = w^2 M x, vectors (n, count); `solve`: (K - shift M)^-1, if it is known."""
    inverse = LinearOperator(K.shape, matvec=solve or factored(K - shift * M).solve, dtype=float)
    start = np.sin(1.0 + 7.3 * np.arange(K.shape[0]))  # the same in every run
    values, vectors = eigsh(K, count, M, sigma=shift, OPinv=inverse, v0=start)
    order = np.argsort(values)
    return values[order], vectors[:, order]


nodal = elements.nodal  # scratch vector of the displacements of a cell


@fast
def add_mass_times(p, a, gx, gy, r):
    """r += M (a - g), (2 m,)."""
    m, at = int(p[elements.NODES]), elements.mass_at(p)
    for k in range(m):
        x, y = 0.0, 0.0
        for l in range(m):
            mass = p[at + k * m + l]
            x += mass * (a[2 * l] - gx)
            y += mass * (a[2 * l + 1] - gy)
        r[2 * k] += x
        r[2 * k + 1] += y


@fast
def node_forces(p, x, v, a, r):
    """Forces r (2 m,) on the nodes."""
    if p[elements.FORMULATION] == elements.COROTATED:
        elements.corotated_force(p, x, v, r)
    else:
        elements.lagrange_force(p, x, v, r)
    add_mass_times(p, a, p[elements.GRAVITY_X], p[elements.GRAVITY_Y], r)


@fast
def node_tangent(p, x, v, a, kq, kv, ka, r, A):
    """Forces r (2 m,) on the nodes and A = kq K + kv C + ka M (2 m, 2 m)."""
    if p[elements.FORMULATION] == elements.COROTATED:
        elements.corotated_tangent(p, x, v, kq, kv, r, A)
    else:
        elements.lagrange_tangent(p, x, v, kq, kv, r, A)
    add_mass_times(p, a, p[elements.GRAVITY_X], p[elements.GRAVITY_Y], r)
    m, at = int(p[elements.NODES]), elements.mass_at(p)
    for k in range(m):
        for l in range(m):
            mass = ka * p[at + k * m + l]
            A[2 * k, 2 * l] += mass
            A[2 * k + 1, 2 * l + 1] += mass


@fast
def cell_forces(p, q, v, a, r):
    """Forces r (n,) on the coordinates."""
    if p[elements.PINS] == 0.0:
        node_forces(p, q, v, a, r)
        return
    arms, x, u, w, f = nodal(), nodal(), nodal(), nodal(), nodal()
    elements.turned_arms(p, q, arms)
    elements.node_places(p, q, arms, x)
    elements.node_rates(p, v, arms, u)
    elements.node_accelerations(p, v, a, arms, w)
    node_forces(p, x, u, w, f)
    r[:] = 0.0
    elements.on_coordinates(p, arms, f, r)


@fast
def cell_tangents(p, q, v, a, kq, kv, ka, r, A):
    """Forces r (n,) and A = kq K + kv C + ka M (n, n)."""
    if p[elements.PINS] == 0.0:
        node_tangent(p, q, v, a, kq, kv, ka, r, A)
        return
    n = 2 * int(p[elements.NODES])
    arms, x, u, w, f = nodal(), nodal(), nodal(), nodal(), nodal()
    B = matrix_view(elements.square(), n, n)
    elements.turned_arms(p, q, arms)
    elements.node_places(p, q, arms, x)
    elements.node_rates(p, v, arms, u)
    elements.node_accelerations(p, v, a, arms, w)
    node_tangent(p, x, u, w, kq, kv, ka, f, B)
    r[:], A[:, :] = 0.0, 0.0
    elements.on_coordinates(p, arms, f, r)
    elements.matrix_on_coordinates(p, arms, B, A)
    for pin in range(int(p[elements.PINS])):
        # Tangent of the arms of a turning pin, by forces f, damping and inertia. The latter are linear functions of
        # velocities and accelerations: what they add to forces at rest.
        n, theta = 2 * int(p[elements.NODES]), 3 * pin + 2
        own, change, gain, moving, still = nodal(), nodal(), nodal(), nodal(), nodal()
        elements.arms_of_pin(p, pin, arms, own)
        along, across = -kq * a[theta] - 2.0 * kv * v[theta], -kq * v[theta] * v[theta]
        for i in range(0, n, 2):
            change[i], change[i + 1] = -kq * v[theta] * own[i], -kq * v[theta] * own[i + 1]
            gain[i], gain[i + 1] = along * own[i] - across * own[i + 1], along * own[i + 1] + across * own[i]
        node_forces(p, x, change, gain, moving)
        change[:], gain[:] = 0.0, 0.0
        node_forces(p, x, change, gain, still)
        for i in range(n):
            A[theta, theta] -= kq * own[i] * f[i]
            moving[i] -= still[i]
        column = elements.on_every_coordinate()
        column[:] = 0.0
        elements.on_coordinates(p, arms, moving, column)
        for i in range(A.shape[0]):
            A[i, theta] += column[i]


@fast
def node_energies(p, x, v):
    """Strain energy, potential of gravity [J], power of damping [W]."""
    if p[elements.FORMULATION] == elements.COROTATED:
        strain, power = elements.corotated_energy(p, x, v)
    else:
        strain, power = elements.lagrange_energy(p, x, v)
    m, at = int(p[elements.NODES]), elements.mass_at(p)
    gravity = 0.0
    for k in range(m):
        mass = 0.0
        for l in range(m):
            mass += p[at + k * m + l]
        gravity -= mass * (p[elements.GRAVITY_X] * x[2 * k] + p[elements.GRAVITY_Y] * x[2 * k + 1])
    return strain, gravity, power


@fast
def cell_energies(p, q, v):
    """`node_energies` from the coordinates."""
    if p[elements.PINS] == 0.0:
        return node_energies(p, q, v)
    arms, x, u = nodal(), nodal(), nodal()
    elements.turned_arms(p, q, arms)
    elements.node_places(p, q, arms, x)
    elements.node_rates(p, v, arms, u)
    return node_energies(p, x, u)


@fast
def cell_mass_times(p, q, v, Mv):
    """Mv = M v (n,)."""
    Mv[:] = 0.0
    if p[elements.PINS] == 0.0:
        add_mass_times(p, v, 0.0, 0.0, Mv)
        return
    arms, u, f = nodal(), nodal(), nodal()
    f[:] = 0.0
    elements.turned_arms(p, q, arms)
    elements.node_rates(p, v, arms, u)
    add_mass_times(p, u, 0.0, 0.0, f)
    elements.on_coordinates(p, arms, f, Mv)


@element_kernel
def cell_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Plane cell of tri3, tri6, quad4 or quad9; q, r (n,), K, C, M (n, n)."""
    for X, kq, kv, ka in ((K, 1.0, 0.0, 0.0), (C, 0.0, 1.0, 0.0), (M, 0.0, 0.0, 1.0)):
        cell_tangents(p, q, v, a, kq, kv, ka, r, X)


@tangent_kernel
def cell_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """r (n,) and kq K + kv C + ka M (n, n)."""
    cell_tangents(p, q, v, a, kq, kv, ka, r, A)


@force_kernel
def cell_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (n,) alone."""
    cell_forces(p, q, v, a, r)


@energy_kernel
def cell_energy(p, t, q, v):
    """Strain energy, potential of gravity, power dissipated by damping."""
    return cell_energies(p, q, v)


@account_kernel
def cell_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (n,); energies as `cell_energy` gives them."""
    cell_forces(p, q, v, a, r)
    cell_mass_times(p, q, v, Mv)
    cell_mass_times(p, q, y, My)
    return cell_energies(p, q, v)


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one body, with the numbers of their kernels."""

    points: np.ndarray  # (n, 2), places of the nodes in the axes of the mesh [m]
    cells: np.ndarray  # (m, k) numbers of the nodes
    masses: np.ndarray  # (m, k, k), consistent mass matrices of one direction [kg]
    formulation: float  # `COROTATED` or `TOTAL_LAGRANGE`
    numbers: np.ndarray  # (m, ...), numbers of the formulation

    @staticmethod
    def of(mesh: PlaneMesh, material: Materials, thickness: Thickness, state: str, formulation: float) -> "Cells":
        """Cells of a mesh; thickness [m], state "stress" or "strain", formulation `COROTATED` or `TOTAL_LAGRANGE`."""
        stiffness, masses = cell_stiffness(mesh, material, thickness, state), cell_masses(mesh, material, thickness)
        m, basis = len(mesh.cells), stiffness_basis(mesh)
        gradients = np.stack([np.moveaxis(field.grad, 0, -1) for field, *_ in basis.basis], axis=2)  # (m, q, k, 2)
        if formulation == elements.COROTATED:
            mean = np.einsum("cq,cqkx->ckx", basis.dx / basis.dx.sum(axis=1, keepdims=True), gradients)
            numbers = np.hstack([mean.reshape(m, -1), stiffness.reshape(m, -1)])
        else:
            d11, d12, d33 = elasticity(mesh, material, state).T
            head = np.stack([np.full(m, float(basis.dx.shape[1])), d11, d12, d11, d33], axis=1)
            volumes = basis.dx * numbers_of_cells(mesh, "thickness", thickness, "m")[:, None]
            at_points = np.concatenate([volumes[:, :, None], gradients.reshape(m, len(volumes[0]), -1)], axis=2)
            numbers = np.hstack([head, at_points.reshape(m, -1)])
        return Cells(mesh.points, mesh.cells, masses, formulation, numbers)

    @property
    def mass(self) -> float:
        """Mass of all cells [kg]."""
        return float(self.masses.sum())


def cell_contributions(
    part: str, cells: Cells, nodes: Mapping[int, str], pins: Mapping[int, Interface], damping: float,
    gravity: tuple[float, float],
) -> list[ElementContribution]:  # fmt: skip
    """Contributions of all cells, with a stiffness-proportional damping time [s] and gravity [m/s^2]."""
    # `nodes` names the mechanism's nodes by number, of all nodes that lie on no pin; `pins` are the rigid pins by
    # number of the mesh's nodes that lie on them.
    width, masses = cells.cells.shape[1], cells.masses.reshape(len(cells.cells), -1)
    bodies = np.hstack([cells.points[cells.cells].reshape(len(cells.cells), -1), masses, cells.numbers])
    more: dict[str, Any] = {"energy": cell_energy, "force": cell_force, "tangent": cell_tangent}
    more["account"], found = cell_account, []
    for numbers, body in zip(cells.cells.tolist(), bodies.tolist(), strict=True):
        coordinates, ties, held = ties_of(part, numbers, cells.points, nodes, pins)
        p = (float(width), float(held), cells.formulation, damping, *gravity, *body, *(ties if held else ()))
        found.append(ElementContribution(part, cell_kernel, coordinates, p, **more))
    return found


def ties_of(
    part: str, numbers: list[int], points: np.ndarray, nodes: Mapping[int, str], pins: Mapping[int, Interface]
) -> tuple[tuple[Coordinate, ...], list[float], int]:
    """Coordinates of a cell, numbers of the ties of its nodes, and number of its pins."""
    # `numbers` are nodes of the cell, `points` (n, 2) places of all nodes [m]; `nodes` and `pins` as of
    # `cell_contributions`.
    on = list(dict.fromkeys(pins[k] for k in numbers if k in pins))
    coordinates = [(part, pin.name, axis) for pin in on for axis in (0, 1, 2)]
    ties: list[float] = []
    for k in numbers:
        pin = pins.get(k)
        if pin is not None:
            ties += [3.0 * on.index(pin), 1.0, points[k, 0] - pin.point[0], points[k, 1] - pin.point[1]]
        else:
            ties += [float(len(coordinates)), 0.0, 0.0, 0.0]
            coordinates += [(part, nodes[k], 0), (part, nodes[k], 1)]
    return tuple(coordinates), [float(x) for x in ties], len(on)


def tie_matrix(ties: list[float], count: int) -> np.ndarray:
    """T = dx/dq (nodes x 2, count) of the ties of a cell with `count` coordinates, in the mesh."""
    found = np.zeros((len(ties) // 2, count))
    for k, (first, on_pin, x, y) in enumerate(np.reshape(ties, (-1, elements.TIE)).tolist()):
        i = int(first)
        found[2 * k : 2 * k + 2, i : i + 2] = np.eye(2)
        if on_pin:
            found[2 * k : 2 * k + 2, i + 2] = -y, x
    return found
