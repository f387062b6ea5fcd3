"""Matrices and loads of plane bodies from weak forms with scikit-fem.

Stiffness             int eps(v)^T D eps(u) t dA        eps = (u_x,x; u_y,y; u_x,y + u_y,x)
Mass                  int rho u v t dA                  the same for x and y
Geometric stiffness   int (sx + sy) w(u) w(v) t dA      w = (u_y,x - u_x,y)/2

Displacements are ordered x0, y0, x1, y1, ...  Each form gives local matrices, which are summed here with the node
numbers of the mesh, so that numbers of scikit-fem do not matter.
Equations (11.3) and (11.5) of docs/theory/plane_bodies.md.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array, kron
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from skfem import Basis, BilinearForm

from flexmb.elastic.meshes.mesh import STRESS, Materials, PlaneMesh, Thickness, densities, elasticity, numbers_of_cells
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
