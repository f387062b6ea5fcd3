"""Plane cells in absolute coordinates: their numbers, and kernels of elasticity, damping and mass.

The coordinates are (x, y) of its nodes in the world, or those of `pinned` where nodes lie on pins.  The mass matrix is
constant: accelerations of the nodes are absolute, so no centrifugal or Coriolis force is left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.elastic.meshes.mesh import Materials, PlaneMesh, Thickness, elasticity, numbers_of_cells
from flexmb.elastic.planes import elements
from flexmb.elastic.planes.forms import cell_masses, cell_stiffness, stiffness_basis
from flexmb.elastic.planes.pins import Interface
from flexmb.engine.compiled.arrays import matrix_view
from flexmb.kernels import account_kernel, element_kernel, energy_kernel, fast, force_kernel, tangent_kernel
from flexmb.model.contributions import Coordinate, ElementContribution

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
