"""Stresses of plane bodies at their nodes, and the largest von Mises stress.

In every cell, displacements are those against its own axes, which turn with its mean deformation gradient.  Stresses
are taken at the points where they are most exact, carried to the nodes by the functions that fit these points, turned
into world axes, and averaged over the cells of a node with their areas as weights: as by `stress`, at any rotation.
Source: E. Hinton, J. S. Campbell, Local and global smoothing of discontinuous finite element functions using a least
squares method, Int. J. Numer. Meth. Engng 8 (1974) 461-480; J. Barlow, Optimal stress locations in finite element
models, Int. J. Numer. Meth. Engng 10 (1976) 243-251.
Stresses of modes superpose; von Mises stresses do not, so they come last.
Equation (11.10) of docs/theory/plane_bodies.md.
"""

import math

import numpy as np
from scipy.sparse import bsr_array, csr_array
from skfem.quadrature import get_quadrature

from flexmb.elastic.meshes.mesh import KINDS, STRAIN, STRESS, Materials, PlaneMesh, cell_values, elasticity
from flexmb.elastic.planes.cells import assembled
from flexmb.elastic.planes.elements import deformation_by, nodal, node_places, turned_arms
from flexmb.engine.compiled.arrays import stack_space
from flexmb.kernels import extremum_kernel, fast
from flexmb.model.contributions import Coordinate, SignalContribution
from flexmb.model.shape import MeshShape
from flexmb.planar import Array, Indices


def mesh_shape(part: str, mesh: PlaneMesh, material: Materials, state: str) -> MeshShape:
    """Mesh of a body in the reference configuration, without its carriers; the state is "stress" or "strain"."""
    rows, number = np.unique(cell_materials(mesh, material, state), axis=0, return_inverse=True)
    materials = [(d11, d12, d33, across) for d11, d12, d33, across in rows.tolist()]
    points, cells = (tuple(map(tuple, rows.tolist())) for rows in (mesh.points, mesh.cells))
    loops, one = tuple(tuple(loop.tolist()) for loop in mesh.loops), len(materials) == 1
    of = () if one else tuple(number.ravel().tolist())
    return MeshShape(part, mesh.kind, points, cells, loops, (), materials=tuple(materials), material_of=of)


def cell_materials(mesh: PlaneMesh, material: Materials, state: str) -> np.ndarray:
    """(m, 4) d11, d12, d33 [Pa] of each cell, and sz over sx + sy: Poisson's ratio in plane strain, else 0."""
    across = np.zeros((len(mesh.cells), 1))
    if state == STRAIN:
        for item, cells in cell_values(mesh, "material", material):
            across[cells] = item.poisson
    return np.hstack([elasticity(mesh, material, state), across])


# Stresses at the nodes of a mesh from the places of its nodes, at any rotation

GAUSS = 0.5 / math.sqrt(3.0)  # distance of the two Gauss points of the unit interval from its middle
FOUR = tuple((0.5 + a * GAUSS, 0.5 + b * GAUSS) for b in (-1, 1) for a in (-1, 1))  # 2 x 2 Gauss points of the square

SAMPLES = {  # points of the reference cell where stresses are most exact (Barlow), by kind
    "tri3": ((1.0 / 3.0, 1.0 / 3.0),),
    "tri6": ((1.0 / 6.0, 1.0 / 6.0), (2.0 / 3.0, 1.0 / 6.0), (1.0 / 6.0, 2.0 / 3.0)),
    "quad4": FOUR,
    "quad9": FOUR,
}


def gradients_at_nodes(points: np.ndarray, cells: np.ndarray, kind: str) -> np.ndarray:
    """(cells, nodes, nodes, 2): gradients [1/m] that give the recovered strain at a node (second axis) of a cell."""
    gradients = gradients_at(points, cells, kind, np.array(SAMPLES[kind], dtype=float).T)[1]
    # Values at the nodes of functions of the values at the samples
    samples, nodes = np.array(SAMPLES[kind], dtype=float), KINDS[kind].reference_nodes.T

    def terms(places: np.ndarray) -> np.ndarray:
        x, y = places.T
        return np.stack([np.ones_like(x), x, y, x * y], axis=1)[:, : len(samples)]

    return np.asarray(np.einsum("kp,cpnx->cknx", np.asarray(terms(nodes) @ np.linalg.inv(terms(samples))), gradients))


def gradients_at(points: np.ndarray, cells: np.ndarray, kind: str, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Jacobian determinants (m, q) [m^2] and gradients (m, q, k, 2) [1/m] at places (2, q) of the reference cell."""
    slopes = KINDS[kind].shape_functions(places)[1]
    jacobian = np.einsum("rnp,cnx->cpxr", slopes, points[cells])
    gradients: np.ndarray = np.einsum("rnp,cprx->cpnx", slopes, np.linalg.inv(jacobian))
    return np.linalg.det(jacobian), gradients


def areas_and_means(points: np.ndarray, cells: np.ndarray, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Areas (m,) of the cells [m^2], and means (m, k, 2) of the gradients over them [1/m]."""
    cell = KINDS[kind]
    places, weights = get_quadrature(cell.element.refdom, cell.stiffness_order)
    area, gradients = gradients_at(points, cells, kind, places)
    area = area * weights
    whole = area.sum(axis=1)
    return whole, np.einsum("cp,cpnx->cnx", area / whole[:, None], gradients)


def around_nodes(cells: np.ndarray, areas: np.ndarray, count: int) -> np.ndarray:
    """Area (count,) of all cells of each node [m^2]."""
    return np.asarray(np.bincount(cells.ravel(), np.repeat(areas, cells.shape[1]), minlength=count))


def nodal_stresses(points: Array, cells: Indices, kind: str, materials: Array, x: Array) -> Array:
    """Stresses (n, nodes, 4) sx, sy, txy in world axes and sz [Pa] at n instants."""
    # `points` (nodes, 2) are places without stress, `x` (n, nodes, 2) places [m]; cells are (m, k), `materials` (m, 4)
    # d11, d12, d33 [Pa] of each cell, and sz over sx + sy.
    (areas, mean), own, X = areas_and_means(points, cells, kind), gradients_at_nodes(points, cells, kind), points[cells]
    found = np.zeros((len(x), len(points), 4))
    for places, sums in zip(x, found, strict=True):
        now = places[cells]
        F = np.einsum("cna,cnx->cax", now - now[:, :1], mean)
        a, b = F[:, 0, 0] + F[:, 1, 1], F[:, 1, 0] - F[:, 0, 1]
        size = np.hypot(a, b)
        c, s = a / size, b / size
        R = np.stack([np.stack([c, -s], axis=1), np.stack([s, c], axis=1)], axis=1)
        d = np.einsum("cab,cna->cnb", R, now - now[:, :1]) - (X - X[:, :1])
        S = _elastic(np.einsum("cna,cknx->ckax", d, own), materials)
        np.add.at(sums, cells, areas[:, None, None] * _listed(np.einsum("cai,ckij,cbj->ckab", R, S, R), materials))
    found /= around_nodes(cells, areas, len(points))[:, None]
    return found


def linear_stresses(points: Array, cells: Indices, kind: str, materials: Array, u: Array) -> Array:
    """Stresses (n, nodes, 4) sx, sy, txy, sz [Pa] of n small displacements u (n, nodes, 2) [m], no rotations."""
    areas, own = areas_and_means(points, cells, kind)[0], gradients_at_nodes(points, cells, kind)
    found = np.zeros((len(u), len(points), 4))
    for now, sums in zip(u, found, strict=True):
        S = _elastic(np.einsum("cna,cknx->ckax", now[cells], own), materials)
        np.add.at(sums, cells, areas[:, None, None] * _listed(S, materials))
    found /= around_nodes(cells, areas, len(points))[:, None]
    return found


def _elastic(H: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Stresses (m, k, 2, 2) in the plane of displacement gradients (m, k, 2, 2)."""
    d11, d12, d33, _ = materials.T[:, :, None]
    ex, ey, shear = H[..., 0, 0], H[..., 1, 1], H[..., 0, 1] + H[..., 1, 0]
    S = np.empty_like(H)
    S[..., 0, 0], S[..., 1, 1] = d11 * ex + d12 * ey, d12 * ex + d11 * ey
    S[..., 0, 1] = S[..., 1, 0] = d33 * shear
    return S


def _listed(S: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Stresses (m, k, 4) sx, sy, txy, sz."""
    sx, sy = S[..., 0, 0], S[..., 1, 1]
    return np.stack([sx, sy, S[..., 0, 1], materials[:, 3, None] * (sx + sy)], axis=-1)


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises stress [Pa] of stresses (..., 4) sx, sy, txy, sz."""
    sx, sy, txy, sz = np.moveaxis(stress, -1, 0)
    return np.asarray(np.sqrt(0.5 * ((sx - sy) ** 2 + (sy - sz) ** 2 + (sz - sx) ** 2) + 3.0 * txy**2))


# Stresses at the nodes of plane bodies as a linear function of small displacements; principal stresses


def stress_operator(mesh: PlaneMesh, material: Materials, state: str = STRESS) -> csr_array:
    """Sparse matrix (4n, 2n) [Pa/m] from displacements x0, y0, x1, ... to stresses sx, sy, txy, sz of every node."""
    # A node between two regions has the mean of both materials; the state is "stress" or "strain".
    areas, _ = areas_and_means(mesh.points, mesh.cells, mesh.kind)
    shares = areas[:, None] / around_nodes(mesh.cells, areas, len(mesh.points))[mesh.cells]
    slopes = gradients_at_nodes(mesh.points, mesh.cells, mesh.kind) * shares[:, :, None, None]
    x, y = slopes[..., 0], slopes[..., 1]
    d11, d12, d33, across = cell_materials(mesh, material, state).T[:, :, None, None]
    both = across * (d11 + d12)
    blocks = [[d11 * x, d12 * y], [d12 * x, d11 * y], [d33 * y, d33 * x], [both * x, both * y]]
    whole = [[assembled(mesh, local) for local in row] for row in blocks]
    pattern, n = whole[0][0], len(mesh.points)
    data = np.stack([np.stack([part.data for part in row], axis=-1) for row in whole], axis=-2)
    return csr_array(bsr_array((data, pattern.indices, pattern.indptr), shape=(4 * n, 2 * n)).tocsr())


def principal(stress: Array) -> tuple[Array, Array, Array]:
    """Larger and smaller principal stress in the plane [Pa], and direction of the larger [rad], of (..., 3 or 4)."""
    sx, sy, txy = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)[:3]
    mean, radius = 0.5 * (sx + sy), np.hypot(0.5 * (sx - sy), txy)
    return mean + radius, mean - radius, 0.5 * np.arctan2(2.0 * txy, sx - sy)


# Largest von Mises stress of a plane body with all nodes of its mesh, and the node where it acts

# Parameters p: number of nodes, nodes of a cell, cells. At HEAD: 1 / area of the cells of each node; (cells, ...)
# nodes, places X, mean gradients, gradients at the nodes, d11, d12, d33 times area, sz over sx + sy; then the ties of
# the nodes, as of a cell (`flexmb.elastic.planes.elements`).
NODES, WIDTH, CELLS, HEAD = range(4)
D11, D12, D33, ACROSS = range(4)  # numbers of the material of a cell
XX, YY, XY, ZZ, PARTS = range(5)  # components of a stress; PARTS is their count


@fast
def add_stresses(p, x, cell, m, S):
    """Add the shares of one cell to the stresses S (4 n,) of its nodes: sx, sy, txy in world axes, sz."""
    d, places = nodal(), nodal()
    for j in range(m):
        first = 2 * int(p[cell + j])
        places[2 * j], places[2 * j + 1] = x[first], x[first + 1]
    c, s, _ = deformation_by(p, m, cell + m, cell + 3 * m, places, d)
    cc, ss, cs = c * c, s * s, c * s
    own, at = cell + 5 * m, cell + 5 * m + 2 * m * m
    for k in range(m):
        xx, yy, shear = 0.0, 0.0, 0.0
        for j in range(m):
            gx, gy = p[own + 2 * j], p[own + 2 * j + 1]
            xx += gx * d[2 * j]
            yy += gy * d[2 * j + 1]
            shear += gy * d[2 * j] + gx * d[2 * j + 1]
        own += 2 * m
        node = int(p[cell + k])
        share = p[HEAD + node]
        sx, sy = share * (p[at + D11] * xx + p[at + D12] * yy), share * (p[at + D12] * xx + p[at + D11] * yy)
        t = share * p[at + D33] * shear
        S[PARTS * node + XX] += cc * sx + ss * sy - 2.0 * cs * t
        S[PARTS * node + YY] += ss * sx + cc * sy + 2.0 * cs * t
        S[PARTS * node + XY] += cs * (sx - sy) + (cc - ss) * t
        S[PARTS * node + ZZ] += p[at + ACROSS] * (sx + sy)


@fast
def von_mises_square(sx, sy, t, sz):
    """Square of the von Mises stress."""
    a, b, c = sx - sy, sy - sz, sz - sx
    return 0.5 * (a * a + b * b + c * c) + 3.0 * t * t


@extremum_kernel
def peak_stress_kernel(p, t, q, v, a, least):
    """Largest nodal von Mises stress [Pa], and the number of its node."""
    n, m = int(p[NODES]), int(p[WIDTH])
    x, S = stack_space(2 * n), stack_space(PARTS * n)
    turned_arms(p, q, S)
    node_places(p, q, S, x)
    for i in range(PARTS * n):
        S[i] = 0.0
    size = 5 * m + 2 * m * m + 4
    for k in range(int(p[CELLS])):
        add_stresses(p, x, HEAD + n + size * k, m, S)
    largest, where = -1.0, 0
    for k in range(n):
        at = PARTS * k
        found = von_mises_square(S[at + XX], S[at + YY], S[at + XY], S[at + ZZ])
        if not found <= largest:  # also what is not a number
            largest, where = found, k
    return math.sqrt(largest), float(where)


def peak_stress_signal(
    part: str, coordinates: tuple[Coordinate, ...], ties: list[float], mesh: PlaneMesh, materials: np.ndarray
) -> SignalContribution:
    """Signals `von_mises` and `von_mises_node`, by the mesh without stress, ties of all nodes, materials (m, 4)."""
    points, cells, (m, k) = mesh.points, mesh.cells, mesh.cells.shape
    areas, mean = areas_and_means(points, cells, mesh.kind)
    weighted = materials * np.column_stack([areas, areas, areas, np.ones(m)])
    own = (
        cells, points[cells].reshape(m, -1), mean.reshape(m, -1),
        gradients_at_nodes(points, cells, mesh.kind).reshape(m, -1), weighted,
    )  # fmt: skip
    shares = 1.0 / around_nodes(cells, areas, len(points))
    numbers = np.concatenate([(len(points), k, m), shares, np.hstack(own).ravel(), ties]).tolist()
    place, numbers = "von_mises_node", tuple(numbers)
    return SignalContribution(part, "von_mises", "Pa", peak_stress_kernel, coordinates, numbers, place=place)
