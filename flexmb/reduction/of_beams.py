"""Bodies of beams as their reduction sees them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
import scipy.sparse as sp

from flexmb import planar
from flexmb.beams.arc import chord_share
from flexmb.beams.stress import outer_fibres
from flexmb.bodies.beam_stress import knows_stress
from flexmb.bodies.flexible import chord_directions, matrices, unstressed_shape
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.model.contributions import Node
from flexmb.model.shape import MeshShape
from flexmb.reduction.beam_element import PLACES, Element
from flexmb.reduction.elastic_model import ElasticModel, Sparse

Array = npt.NDArray[np.float64]

THIN = 2e-3
"""Half of the depth over the length with which beams of unknown depth are drawn."""


class BeamModel:
    """Assembles the matrices of the beams of a body over the displacements of its nodes, pins first.

    The axes are those of the first pin.

    Parameters
    ----------
    pins : names of its nodes where parts are attached.
    """

    def __init__(self, body: FlexibleBody, pins: Sequence[str]) -> None:
        self.body = body
        nodes = {node.name: node for node in body.nodes()}
        first = nodes[pins[0]]
        self.origin, self.direction = (first.x, first.y), first.theta
        own = {name: Node(name, *self._own((n.x, n.y)), n.theta - first.theta) for name, n in nodes.items()}
        self.pins = tuple(own.pop(name) for name in pins)
        self.nodes = (*self.pins, *own.values())
        self.place = {node.name: 3 * k for k, node in enumerate(self.nodes)}
        self.size = 3 * len(self.nodes)
        self.elements = tuple(self._elements())

    def _own(self, point: tuple[float, float]) -> tuple[float, float]:
        """A point in the axes of the first pin."""
        return planar.to_frame(self.origin, self.direction, point)

    def model(self) -> ElasticModel:
        """The elastic model."""
        points, shape, mass = self._samples()
        turn_shape, turn_inertia = self._turns()
        drawn, drawn_by = self._outline()
        return ElasticModel(
            self.body.label,
            self.pins,
            self._assembled(element.stiffness() for element in self.elements),
            points,
            shape,
            mass,
            turn_shape,
            turn_inertia,
            self._stress_stiffness,
            self.body.damping,
            self.origin,
            self.direction,
            drawn,
            drawn_by,
            self._stresses if all(knows_stress(beam.section) for beam in self.body.beams) else None,
            mass_damping=self.body.mass_damping,
        )

    def _elements(self) -> Iterator[Element]:
        """All elements."""
        for beam in self.body.beams:
            data, angles = matrices(beam), chord_directions(beam)
            unstressed = unstressed_shape(beam, data)
            starts = [self._own(point) for point in beam.points]
            for k, ends in enumerate(pairwise(beam.nodes)):
                c, s = math.cos(angles[k] - self.direction), math.sin(angles[k] - self.direction)
                turn = np.kron(np.eye(2), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
                places = np.concatenate([self.place[name] + np.arange(3) for name in ends])
                chord = float(data.lengths[k]) * chord_share(2.0 * unstressed[k, 2])
                yield Element(places, turn, np.array(starts[k]), chord, unstressed[k, 1:], beam, data, k)

    def _assembled(self, blocks: Iterable[Array]) -> Sparse:
        """Sum of element matrices (6, 6), each in the axes of its element."""
        found = sp.lil_matrix((self.size, self.size))
        for element, block in zip(self.elements, blocks, strict=True):
            found[np.ix_(element.places, element.places)] += element.turn.T @ block @ element.turn
        return found.tocsc()

    def _samples(self) -> tuple[Array, Sparse, Sparse]:
        """Points with mass, their displacements, and their mass matrix: elements, bosses, and the mass at the mean."""
        points, rows, blocks = [], [], []
        for element in self.elements:
            places, moved = element.points()
            points.append(places)
            rows.append(self._moved(element, moved))
            inverse = np.linalg.inv(element.cubic)
            of_axis = element.data.bending_mass[element.k] - element.data.rotary_mass[element.k]
            blocks.append(inverse.T @ of_axis @ inverse)
        corners = np.array([self._own(point) for point in self.body.corner_points])
        ends = [self.place[name] for name in self.body.corners]
        bosses = self.body._bosses
        for mass, point, place in zip(bosses.masses, corners, ends, strict=True):
            rows.append(self._spread(place + np.arange(3), np.eye(2, 3)))
            blocks.append(np.array([[mass]]))
            points.append(point[None])
        mean = np.concatenate([place + np.arange(2) for place in ends])
        rows.append(self._spread(mean, np.tile(np.eye(2), len(ends)) / len(ends)))
        blocks.append(np.array([[bosses.mean_mass]]))
        points.append(corners.mean(axis=0)[None])
        return np.concatenate(points), sp.vstack(rows).tocsr(), sp.csr_matrix(la.block_diag(*blocks))

    def _outline(self) -> tuple[MeshShape, Sparse]:
        """Strips along the elements with the depth of their sections, and the displacements of their corners."""
        points, rows = [], []
        cells: list[tuple[int, ...]] = []
        for element in self.elements:
            half = np.maximum(outer_fibres(element.beam.section, element.stations), THIN * element.beam.length)
            for side in (-1.0, 1.0):
                places, moved = element.side(side * half)
                points.append(places)
                rows.append(self._moved(element, moved))
            first = 4 * (len(points) - 2)
            cells += [(first + i, first + i + 1, first + i + 5, first + i + 4) for i in range(3)]
        corners = tuple((x, y) for x, y in np.concatenate(points).tolist())
        return MeshShape(self.body.name, "quad4", corners, tuple(cells), tuple(cells), ()), sp.vstack(rows).tocsr()

    def _stresses(self, z: Array) -> Array:
        """Stresses (points of the outline, 4, n) of displacements (N, n): normal stresses in the outer fibres alone.

        The axial force is constant in an element, the moment is linear between its ends.
        """
        found = []
        for element in self.elements:
            moved, s, section = element.turn @ z[element.places], element.stations, element.beam.section
            _, first, _, last = element.data.bending_stiffness[element.k] @ (element.bending @ moved)
            moment = (PLACES - 1.0)[:, None] * first + PLACES[:, None] * last
            fibre = np.asarray(section.outer_fibre_at(s) / section.second_moment_at(s))[:, None]
            axial = (element.normal_force @ moved) / np.asarray(section.area_at(s))[:, None]
            found += [axial - side * fibre * moment for side in (-1.0, 1.0)]
        normal = np.concatenate(found)
        return np.stack([normal, *[np.zeros_like(normal)] * 3], axis=1)

    def _turns(self) -> tuple[Sparse, Sparse]:
        """Rotations with moments of inertia: of sections, of bosses, of a pivot."""
        rows, blocks = [], []
        for element in self.elements:
            rotary = element.data.rotary_mass[element.k]
            if rotary.any():
                rows.append(self._spread(element.places, element.bending @ element.turn))
                blocks.append(rotary)
        inertia = dict.fromkeys(self.body.corners, self.body._bosses.inertia)
        first = self.body.corners[0]
        inertia[first] = inertia[first] + float(getattr(self.body, "pivot_inertia", 0.0))
        for name, value in inertia.items():
            rows.append(self._spread(self.place[name] + np.arange(3), np.eye(3)[2:]))
            blocks.append(np.array([[value]]))
        return sp.vstack(rows).tocsr(), sp.csr_matrix(la.block_diag(*blocks))

    def _moved(self, element: Element, rows: Array) -> Sparse:
        """Rows of displacements x0, y0, ... of an element in the axes of the body, over all displacements."""
        back = np.kron(np.eye(len(rows) // 2), element.turn[:2, :2].T)
        return self._spread(element.places, back @ rows @ element.turn)

    def _spread(self, places: Any, rows: Array) -> Sparse:
        """Rows over all displacements from rows over some of them."""
        entries = sp.lil_matrix((len(rows), self.size))
        entries[:, places] = rows
        return entries.tocsr()

    def _stress_stiffness(self, z: Array) -> Sparse:
        """Geometric stiffness of the normal forces of displacements z, which are constant along each element."""
        return self._assembled(
            (element.normal_force @ (element.turn @ z[element.places])) * element.string() for element in self.elements
        )


def model_of_beams(body: FlexibleBody, pins: Sequence[str]) -> ElasticModel:
    """Elastic model of a body of beams with pins, the names of its nodes where parts are attached."""
    return BeamModel(body, pins).model()


def pins_of_beams(body: FlexibleBody) -> tuple[Node, ...]:
    """Nodes at the corners of a body of beams."""
    nodes = {node.name: node for node in body.nodes()}
    return tuple(nodes[name] for name in body.corners)
