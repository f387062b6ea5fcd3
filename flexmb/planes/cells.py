"""Numbers p of the kernels of plane cells, from the mesh, the moduli and the pins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmb.model.contributions import Coordinate, ElementContribution
from flexmb.model.material import Material
from flexmb.planes.cell_kernels import cell_account, cell_energy, cell_force, cell_kernel, cell_tangent
from flexmb.planes.cell_numbers import COROTATED
from flexmb.planes.forms import cell_matrices, stiffness_basis
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.regions import ByRegion, elasticity, numbers_of_cells


@dataclass(frozen=True)
class Pin:
    """A rigid pin: name of its node, and the place [m] in the mesh from which its nodes are measured."""

    node: str
    place: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one body, with the numbers of their kernels.

    Parameters
    ----------
    points : (n, 2), places of the nodes in the axes of the mesh [m].
    cells : (m, k) numbers of the nodes.
    masses : (m, k, k), consistent mass matrices of one direction [kg].
    formulation : `COROTATED` or `TOTAL_LAGRANGE`.
    numbers : (m, ...), numbers of the formulation.
    """

    points: np.ndarray
    cells: np.ndarray
    masses: np.ndarray
    formulation: float
    numbers: np.ndarray

    @staticmethod
    def of(
        mesh: PlaneMesh, material: ByRegion[Material], thickness: ByRegion[float], state: str, formulation: float
    ) -> Cells:
        """Cells of a mesh; thickness [m], state "stress" or "strain", formulation `COROTATED` or `TOTAL_LAGRANGE`."""
        matrices = cell_matrices(mesh, material, thickness, state)
        m, basis = len(mesh.cells), stiffness_basis(mesh)
        gradients = np.stack([np.moveaxis(field.grad, 0, -1) for field, *_ in basis.basis], axis=2)  # (m, q, k, 2)
        if formulation == COROTATED:
            mean = np.einsum("cq,cqkx->ckx", basis.dx / basis.dx.sum(axis=1, keepdims=True), gradients)
            numbers = np.hstack([mean.reshape(m, -1), matrices.stiffness.reshape(m, -1)])
        else:
            d11, d12, d33 = elasticity(mesh, material, state).T
            head = np.stack([np.full(m, float(basis.dx.shape[1])), d11, d12, d11, d33], axis=1)
            volumes = basis.dx * numbers_of_cells(mesh, "thickness", thickness, "m")[:, None]
            at_points = np.concatenate([volumes[:, :, None], gradients.reshape(m, len(volumes[0]), -1)], axis=2)
            numbers = np.hstack([head, at_points.reshape(m, -1)])
        return Cells(mesh.points, mesh.cells, matrices.mass, formulation, numbers)

    @property
    def mass(self) -> float:
        """Mass of all cells [kg]."""
        return float(self.masses.sum())


def cell_contributions(
    part: str,
    cells: Cells,
    nodes: Mapping[int, str],
    pins: Mapping[int, Pin],
    damping: float,
    gravity: tuple[float, float],
) -> list[ElementContribution]:
    """Contributions of all cells, with a stiffness-proportional damping time [s] and gravity [m/s^2].

    `nodes` names the mechanism's nodes by number, of all nodes that lie on no pin; `pins` are the pins by number of the
    mesh's nodes that lie on them.
    """
    width = cells.cells.shape[1]
    masses = cells.masses.reshape(len(cells.cells), -1)
    places = cells.points[cells.cells].reshape(len(cells.cells), -1)
    bodies = np.hstack([places, masses, cells.numbers])
    found = []
    for numbers, body in zip(cells.cells.tolist(), bodies.tolist(), strict=True):
        coordinates, ties, held = ties_of(part, numbers, cells.points, nodes, pins)
        p = (float(width), float(held), cells.formulation, damping, *gravity, *body, *(ties if held else ()))
        found.append(_contribution(part, coordinates, p))
    return found


def _contribution(part: str, coordinates: tuple[Coordinate, ...], p: tuple[float, ...]) -> ElementContribution:
    return ElementContribution(
        part, cell_kernel, coordinates, p,
        energy=cell_energy, force=cell_force, tangent=cell_tangent, account=cell_account,
    )  # fmt: skip


def ties_of(
    part: str, numbers: list[int], points: np.ndarray, nodes: Mapping[int, str], pins: Mapping[int, Pin]
) -> tuple[tuple[Coordinate, ...], list[float], int]:
    """Coordinates of a cell, numbers of the ties of its nodes, and number of its pins.

    `numbers` are nodes of the cell, `points` (n, 2) places of all nodes [m]; `nodes` and `pins` as of
    `cell_contributions`.
    """
    on = list(dict.fromkeys(pins[k] for k in numbers if k in pins))
    coordinates = [(part, pin.node, axis) for pin in on for axis in (0, 1, 2)]
    ties: list[float] = []
    for k in numbers:
        pin = pins.get(k)
        if pin is not None:
            ties += [3.0 * on.index(pin), 1.0, points[k, 0] - pin.place[0], points[k, 1] - pin.place[1]]
        else:
            ties += [float(len(coordinates)), 0.0, 0.0, 0.0]
            coordinates += [(part, nodes[k], 0), (part, nodes[k], 1)]
    return tuple(coordinates), [float(x) for x in ties], len(on)
