"""Contributions of a plane body with all nodes of its mesh: cells, pins, and rotations that mesh nodes do not have.

The nodes of the body are its pins (x, y, theta), then the nodes of the mesh that lie on no rigid pin; a constraint
holds theta of each of these at 0, as that of a particle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmb import planar
from flexmb.bodies.inertia import node_mass
from flexmb.bodies.point_mass import held_rotation_kernel
from flexmb.model.contributions import (
    ConstraintContribution,
    Contribution,
    Node,
    SignalContribution,
    node_coordinates,
)
from flexmb.planes.averaged_pin import averaged_pin
from flexmb.planes.cells import Cells, Pin, cell_contributions
from flexmb.planes.mass_damping import damping_contributions, far_node
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.peak_stress import peak_stress_signal

PIN_SHARE = 1e-7
"""Mass of an averaged pin over that of its body: it keeps the equations of motion regular.

Its nodes have as much less, so that no rigid motion of the body has another inertia.  Frequencies of motions that
deform the hole change by less than this share.  With a hundredth of it steps find the pins without mass."""


@dataclass(frozen=True, eq=False)
class MeshPin:
    """A pin of a body: name of its node, place in the mesh [m], numbers of the mesh's nodes that it holds.

    weights : (n,) of an averaged pin, with the sum 1; None: a rigid pin.
    """

    name: str
    place: tuple[float, float]
    nodes: np.ndarray
    weights: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class FullBody:
    """A plane body with all nodes of its mesh.

    Parameters
    ----------
    cells : cells, in the axes of the mesh.
    origin : the mesh's origin in the world [m].
    angle : direction of the mesh's x-axis in the world [rad].
    damping : stiffness-proportional damping time [s].
    mass_damping : mass-proportional damping rate [1/s].
    """

    part: str
    cells: Cells
    pins: Sequence[MeshPin]
    origin: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0
    damping: float = 0.0
    mass_damping: float = 0.0

    @cached_property
    def on_pins(self) -> dict[int, Pin]:
        """Rigid pins by the numbers of their nodes."""
        rigid = [pin for pin in self.pins if pin.weights is None]
        return {int(k): Pin(pin.name, pin.place) for pin in rigid for k in pin.nodes}

    @cached_property
    def names(self) -> dict[int, str]:
        """Names of the nodes that lie on no rigid pin, by number."""
        return {k: f"node{k}" for k in range(len(self.cells.points)) if k not in self.on_pins}

    def nodes(self) -> tuple[Node, ...]:
        """Pins, then nodes of the mesh, in the reference configuration."""
        pins = [Node(pin.name, *self._world(pin.place), self.angle) for pin in self.pins]
        points = self.cells.points.tolist()
        return (*pins, *(Node(name, *self._world(points[k]), 0.0, turns=False) for k, name in self.names.items()))

    def _world(self, point: Sequence[float]) -> tuple[float, float]:
        return planar.from_frame(self.origin, self.angle, (point[0], point[1]))

    def contributions(self, gravity: tuple[float, float]) -> list[Contribution]:
        """Cells, averaged pins, held rotations."""
        found: list[Contribution] = []
        found += cell_contributions(self.part, self.cells, self.names, self.on_pins, self.damping, gravity)
        if self.mass_damping:
            zeta = self.mass_damping
            found += damping_contributions(self.part, self.cells, self.names, self.on_pins, zeta, self._axis())
        inertia = self.cells.mass * float(np.ptp(self.cells.points, axis=0).max()) ** 2
        for name in self.names.values():  # any moment of inertia will do
            theta = node_coordinates(self.part, name)[2:]
            found.append(node_mass(self.part, name, 0.0, inertia / len(self.names), (0.0, 0.0)))
            found.append(ConstraintContribution(self.part, held_rotation_kernel, theta, (), 1, is_drive=True))
        for pin in self.pins:
            if pin.weights is not None:
                found += self._averaged(pin, pin.weights, gravity)
        return found

    def _axis(self) -> tuple[str, str]:
        """Nodes of the frame of mass-proportional damping: the first two pins, or one and the farthest node."""
        if len(self.pins) > 1:
            return self.pins[0].name, self.pins[1].name
        return self.pins[0].name, self.names[far_node(self.cells.points, self.pins[0].place)]

    def carriers(self) -> tuple[tuple[int, float, float], ...]:
        """Number of the node that carries each point of the mesh, in the order of `nodes`, and its place there [m]."""
        pins = [pin.name for pin in self.pins]
        number = {name: len(pins) + k for k, name in enumerate(self.names.values())}
        found = []
        for k, (x, y) in enumerate(self.cells.points.tolist()):
            pin = self.on_pins.get(k)
            if pin is None:
                found.append((number[self.names[k]], 0.0, 0.0))
            else:
                found.append((pins.index(pin.node), x - pin.place[0], y - pin.place[1]))
        return tuple(found)

    def stress_signal(self, mesh: PlaneMesh, materials: np.ndarray) -> SignalContribution:
        """Signal of the largest von Mises stress, with its node.

        `materials` (m, 4) are d11, d12, d33 [Pa] of each cell, and sz over sx + sy.
        """
        pins = [pin.name for pin in self.pins]
        coordinates = [c for name in pins for c in node_coordinates(self.part, name)]
        ties = np.zeros((len(mesh.points), 4))
        for k, place in enumerate(mesh.points):
            pin = self.on_pins.get(k)
            if pin is None:
                ties[k, 0] = len(coordinates)
                coordinates += node_coordinates(self.part, self.names[k])[:2]
            else:
                ties[k] = 3.0 * pins.index(pin.node), 1.0, *(place - pin.place)
        return peak_stress_signal(self.part, tuple(coordinates), ties, mesh.points, mesh.cells, mesh.kind, materials)

    def _averaged(self, pin: MeshPin, weights: np.ndarray, gravity: tuple[float, float]) -> list[Contribution]:
        """Constraint and small mass of an averaged pin, taken from its nodes."""
        own = [node_coordinates(self.part, self.names[int(k)])[:2] for k in pin.nodes]
        coordinates = (*node_coordinates(self.part, pin.name), *(c for pair in own for c in pair))
        arms = self.cells.points[pin.nodes] - np.array(pin.place)
        mass = PIN_SHARE * self.cells.mass
        inertia = mass * float(weights @ (arms**2).sum(axis=1))
        shares = zip((self.names[int(k)] for k in pin.nodes), weights.tolist(), strict=True)
        return [
            averaged_pin(self.part, coordinates, arms, weights),
            node_mass(self.part, pin.name, mass, inertia, gravity),
            *(node_mass(self.part, name, -mass * w, 0.0, gravity) for name, w in shares),
        ]
