"""Forces on the nodes of a mesh, and the contributions of a load to a body with all nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flexmb.kernels import Kernel
from flexmb.model.contributions import (
    MULTIPLIES,
    Contribution,
    Coordinate,
    ElementContribution,
    node_coordinates,
    signal_contributions,
)
from flexmb.model.law import Motion
from flexmb.planes.cells import Pin, ties_of
from flexmb.planes.load_kernels import SIGNALS, edge_force_kernel, mesh_load_signal, node_force_kernel

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FollowedEdges:
    """Edges that a load follows.

    Parameters
    ----------
    nodes : (b, k) nodes of each edge.
    normal, along : (b, k, k) products of the pressure and of the shear [N/m].
    """

    nodes: npt.NDArray[np.int64]
    normal: Array
    along: Array


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """A load on the nodes of a mesh, in the axes of the mesh.

    Parameters
    ----------
    forces : (n, 2) forces on the undeformed body [N].
    nodes : numbers of the nodes on which it acts, though its values may be 0.
    follower : whether their directions turn with the first pin.
    edges : edges that it follows, in place of directions; None: no edges.
    """

    forces: Array
    nodes: npt.NDArray[np.int64]
    follower: bool = False
    edges: FollowedEdges | None = None


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A body with all nodes, as a load sees it.

    Parameters
    ----------
    points : (n, 2) nodes in the axes of the mesh [m].
    names : names of the nodes of the mechanism by number, of all nodes that lie on no rigid pin.
    pins : rigid pins by number of the mesh's nodes that lie on them.
    main : name of the first pin.
    direction : direction of the mesh's x-axis in the world [rad].
    """

    part: str
    points: Array
    names: Mapping[int, str]
    pins: Mapping[int, Pin]
    main: str
    direction: float

    def contributions(self, name: str, load: NodalLoad, history: Motion | None) -> list[Contribution]:
        """Elements and signals of a load, times the value of the motion `history`; None: constant."""
        kernel: Kernel = edge_force_kernel if load.edges else node_force_kernel
        parts = list(self._edges(load.edges) if load.edges else self._nodes(load))
        numbers, coordinates = [float(load.edges is not None)], list[Coordinate]()
        for place, p in parts:
            numbers += [float(len(place)), float(len(p)), *p]
            coordinates += place
        return [
            *(ElementContribution(name, kernel, place, p, factor=history) for place, p in parts),
            *signal_contributions(
                name, mesh_load_signal, SIGNALS, tuple(coordinates), tuple(numbers), use_of_factor=MULTIPLIES
            ),
        ]

    def _edges(self, edges: FollowedEdges) -> Iterator[tuple[tuple[Coordinate, ...], tuple[float, ...]]]:
        """Coordinates and numbers of each edge."""
        products = np.stack([edges.normal, edges.along], axis=3).reshape(len(edges.nodes), -1)
        for nodes, own in zip(edges.nodes.tolist(), products.tolist(), strict=True):
            coordinates, ties, held = ties_of(self.part, nodes, self.points, self.names, self.pins)
            yield coordinates, (float(len(nodes)), float(held), *own, *ties)

    def _nodes(self, load: NodalLoad) -> Iterator[tuple[tuple[Coordinate, ...], tuple[float, ...]]]:
        """Coordinates and numbers of each loaded node, then of each loaded pin."""
        turning = node_coordinates(self.part, self.main)[2]
        on_pins: dict[Pin, Array] = {}
        for k in load.nodes.tolist():
            fx, fy = load.forces[k].tolist()
            pin = self.pins.get(k)
            if pin is None:
                place = node_coordinates(self.part, self.names[k])[:2]
                yield self._force(load, (fx, fy, 0.0, 0.0), place, turning)
                continue
            ax, ay = (self.points[k] - pin.place).tolist()
            sums = on_pins.setdefault(pin, np.zeros(4))
            sums += (fx, fy, ax * fy - ay * fx, ax * fx + ay * fy)
        for pin, sums in on_pins.items():
            yield self._force(load, tuple(sums.tolist()), node_coordinates(self.part, pin.node), turning)

    def _force(
        self, load: NodalLoad, sums: tuple[float, ...], place: tuple[Coordinate, ...], turning: Coordinate
    ) -> tuple[tuple[Coordinate, ...], tuple[float, ...]]:
        """Coordinates and numbers of a force on the node at `place`, with its rotation if it has one."""
        own, at = (2 if len(place) == 3 else -1), -1
        if load.follower:
            if turning not in place:
                place = (*place, turning)
            at = place.index(turning)
        return place, (*sums, self.direction, float(own), float(at))
