"""Stiffness and mass of an elastic body by displacements of its pins and of its inside."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from flexmb import planar
from flexmb.model.contributions import Node
from flexmb.model.shape import MeshShape

Array = npt.NDArray[np.float64]
Sparse: TypeAlias = Any
"""Sparse matrix of scipy, which has no types."""


@dataclass(frozen=True, eq=False)
class ElasticModel:
    """Small displacements of an elastic body.

    Parameters
    ----------
    label : class and name of the body, for messages.
    pins : (P) nodes where other parts are attached; the first 3 P displacements are x, y and rotation of these.
    stiffness : (N, N) symmetric, 0 for rigid motions [N/m].
    points : (S, 2) reference positions of the points whose displacements carry the mass [m].
    shape : (2 S, N) displacements x0, y0, x1, y1, ... of the points.
    mass : (S, S) symmetric; kinetic energy = 1/2 v_x mass v_x + 1/2 v_y mass v_y [kg].
    turn_shape : (R, N) rotations that carry moments of inertia.
    turn_inertia : (R, R) symmetric [kg m^2].
    stress_stiffness : (N,) displacements -> (N, N) geometric stiffness of the stress of these displacements [N/m].
    damping : stiffness-proportional damping time [s].
    origin, direction : where the axes of the model lie in the reference configuration [m, rad].
    drawn : mesh that shows the body, with places in the axes of the model, without what moves it.
    drawn_by : (2 points, N) displacements of its points.
    stresses : (N, n) displacements -> (nodes, 4, n) sx, sy, txy, sz at the nodes [Pa]; None: unknown.
    mass_damping : mass-proportional damping rate [1/s].
    """

    label: str
    pins: tuple[Node, ...]
    stiffness: Sparse
    points: Array
    shape: Sparse
    mass: Sparse
    turn_shape: Sparse
    turn_inertia: Sparse
    stress_stiffness: Callable[[Array], Sparse]
    damping: float = 0.0
    origin: tuple[float, float] = (0.0, 0.0)
    direction: float = 0.0
    drawn: MeshShape | None = None
    drawn_by: Sparse | None = None
    stresses: Callable[[Array], Array] | None = None
    mass_damping: float = 0.0

    def placed(self, nodes: Sequence[Node]) -> tuple[Node, ...]:
        """Nodes, given in the axes of the model, in the reference configuration."""
        turn = self.direction
        return tuple(Node(n.name, *planar.from_frame(self.origin, turn, (n.x, n.y)), n.theta + turn) for n in nodes)

    @property
    def count(self) -> int:
        """Number of the displacements of pins."""
        return 3 * len(self.pins)

    def mass_matrix(self) -> Sparse:
        """Consistent mass (N, N) [kg, kg m, kg m^2]."""
        x, y = self.shape[0::2], self.shape[1::2]
        turns = self.turn_shape.T @ self.turn_inertia @ self.turn_shape
        return (x.T @ self.mass @ x + y.T @ self.mass @ y + turns).tocsc()

    def force_of(self, field: Array) -> Array:
        """Forces (N,) of an acceleration field -field (S, 2) of all points [N]."""
        loads = np.empty(self.shape.shape[0])
        loads[0::2], loads[1::2] = self.mass @ field[:, 0], self.mass @ field[:, 1]
        force: Array = self.shape.T @ loads
        return force
