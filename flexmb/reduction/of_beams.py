"""Bodies of beams as their reduction sees them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
import scipy.sparse as sp

from flexmb.beams.fem import BeamMatrices
from flexmb.beams.stress import outer_fibres
from flexmb.bodies.beam_stress import knows_stress
from flexmb.bodies.flexible import Beam, direction, matrices
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.model.contributions import Node
from flexmb.model.shape import MeshShape
from flexmb.reduction.elastic_model import ElasticModel, Sparse

Array = npt.NDArray[np.float64]

PLACES = np.linspace(0.0, 1.0, 4)
"""Places on an element whose displacements carry its mass: four values of a cubic say all."""

HERMITE = np.stack(
    [
        1.0 - 3.0 * PLACES**2 + 2.0 * PLACES**3,
        PLACES - 2.0 * PLACES**2 + PLACES**3,
        3.0 * PLACES**2 - 2.0 * PLACES**3,
        PLACES**3 - PLACES**2,
    ],
    axis=1,
)
"""(4, 4) displacements there by (w1, L theta1, w2, L theta2)."""

SLOPES = np.stack(
    [
        -6.0 * PLACES + 6.0 * PLACES**2,
        1.0 - 4.0 * PLACES + 3.0 * PLACES**2,
        6.0 * PLACES - 6.0 * PLACES**2,
        3.0 * PLACES**2 - 2.0 * PLACES,
    ],
    axis=1,
)
"""(4, 4) slopes there, times L."""

THIN = 2e-3
"""Half of the depth over the length with which beams of unknown depth are drawn."""


class BeamModel:
    """Assembles the matrices of the beams of a body over the displacements of its nodes, pins first.

    Parameters
    ----------
    body : the body.
    pins : names of its nodes where parts are attached.
    """

    def __init__(self, body: FlexibleBody, pins: Sequence[str]) -> None:
        self.body = body
        nodes = {node.name: node for node in body.nodes()}
        self.pins = tuple(nodes.pop(name) for name in pins)
        self.nodes = (*self.pins, *nodes.values())
        self.place = {node.name: 3 * k for k, node in enumerate(self.nodes)}
        self.size = 3 * len(self.nodes)

    def model(self) -> ElasticModel:
        """The elastic model."""
        points, shape, mass = self._samples()
        turn_shape, turn_inertia = self._turns()
        drawn, drawn_by = self._outline()
        stiffness = self._assembled(_stiffness(data, k) for _, _, _, data, k in self._elements())
        return ElasticModel(
            self.body.label,
            self.pins,
            stiffness,
            points,
            shape,
            mass,
            turn_shape,
            turn_inertia,
            self._stress_stiffness,
            self.body.damping,
            drawn=drawn,
            drawn_by=drawn_by,
            stresses=self._stresses if all(knows_stress(beam.section) for beam in self.body.beams) else None,
        )

    def _elements(self) -> Iterator[tuple[Array, Array, Beam, BeamMatrices, int]]:
        """Places of the six displacements, rotation to the axes of the element, beam, its matrices and the number."""
        for beam in self.body.beams:
            data, angle = matrices(beam), direction(beam)
            c, s = math.cos(angle), math.sin(angle)
            own = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
            turn = np.kron(np.eye(2), own)
            for k, ends in enumerate(pairwise(beam.nodes)):
                yield np.concatenate([self.place[name] + np.arange(3) for name in ends]), turn, beam, data, k

    def _assembled(self, blocks: Iterator[Array]) -> Sparse:
        """Sum of element matrices (6, 6), each in the axes of its element."""
        found = sp.lil_matrix((self.size, self.size))
        for (places, turn, *_), block in zip(self._elements(), blocks, strict=True):
            found[np.ix_(places, places)] += turn.T @ block @ turn
        return found.tocsc()

    def _samples(self) -> tuple[Array, Sparse, Sparse]:
        """Points with mass, their displacements, and their mass matrix: elements, bosses, and the mass at the mean."""
        points, rows, blocks = [], [], []
        for places, turn, beam, data, k in self._elements():
            local = np.zeros((8, 6))
            length = data.lengths[k]
            local[0::2, 0], local[0::2, 3] = 1.0 - PLACES, PLACES
            cubic = HERMITE * np.array([1.0, length, 1.0, length]) @ _axis(data, k)
            local[1::2, [1, 2, 4, 5]] = cubic
            back = np.kron(np.eye(4), turn[:2, :2].T)
            rows.append(self._spread(places, back @ local @ turn))
            inverse = np.linalg.inv(cubic)
            blocks.append(inverse.T @ (data.bending_mass[k] - data.rotary_mass[k]) @ inverse)
            start, end = np.array(beam.start), np.array(beam.end)
            s = (beam.stations[k] + PLACES * length) / beam.stations[-1]
            points.append(start + s[:, None] * (end - start))
        corners, ends = np.array(self.body.corner_points), [self.place[name] for name in self.body.corners]
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
        for places, turn, beam, data, k in self._elements():
            length, back = data.lengths[k], turn[:2, :2].T
            s = (beam.stations[k] + PLACES * length) / beam.stations[-1]
            half = np.maximum(outer_fibres(beam.section, s), THIN * beam.length)
            start, end = np.array(beam.start), np.array(beam.end)
            for side in (-1.0, 1.0):
                local = np.zeros((8, 6))
                local[0::2, 0], local[0::2, 3] = 1.0 - PLACES, PLACES
                scale, axis = np.array([1.0, length, 1.0, length]), _axis(data, k)
                local[1::2, [1, 2, 4, 5]] = HERMITE * scale @ axis
                local[0::2, [1, 2, 4, 5]] = -side * half[:, None] * (SLOPES * scale @ axis / length + _shear(data, k))
                rows.append(self._spread(places, np.kron(np.eye(4), back) @ local @ turn))
                points.append(start + s[:, None] * (end - start) + side * half[:, None] * back[:, 1])
            first = 4 * (len(points) - 2)
            cells += [(first + i, first + i + 1, first + i + 5, first + i + 4) for i in range(3)]
        corners = tuple((x, y) for x, y in np.concatenate(points).tolist())
        return MeshShape(self.body.name, "quad4", corners, tuple(cells), tuple(cells), ()), sp.vstack(rows).tocsr()

    def _stresses(self, z: Array) -> Array:
        """Stresses (points of the outline, 4, n) of displacements (N, n): normal stresses in the outer fibres alone.

        The axial force is constant in an element, the moment is linear between its ends.
        """
        found = []
        for places, turn, beam, data, k in self._elements():
            ends = turn @ z[places]
            force = data.axial_stiffness[k, 1, 1] * (ends[3] - ends[0])
            _, first, _, last = data.bending_stiffness[k] @ ends[[1, 2, 4, 5]]
            moment = (PLACES - 1.0)[:, None] * first + PLACES[:, None] * last
            s, section = (beam.stations[k] + PLACES * data.lengths[k]) / beam.stations[-1], beam.section
            fibre = np.asarray(section.outer_fibre_at(s) / section.second_moment_at(s))[:, None]
            axial = force / np.asarray(section.area_at(s))[:, None]
            found += [axial - side * fibre * moment for side in (-1.0, 1.0)]
        normal = np.concatenate(found)
        return np.stack([normal, *[np.zeros_like(normal)] * 3], axis=1)

    def _turns(self) -> tuple[Sparse, Sparse]:
        """Rotations with moments of inertia: of sections, of bosses, of a pivot."""
        rows, blocks = [], []
        for places, turn, _, data, k in self._elements():
            if data.rotary_mass[k].any():
                rows.append(self._spread(places, np.eye(6)[[1, 2, 4, 5]] @ turn))
                blocks.append(data.rotary_mass[k])
        inertia = dict.fromkeys(self.body.corners, self.body._bosses.inertia)
        first = self.body.corners[0]
        inertia[first] = inertia[first] + float(getattr(self.body, "pivot_inertia", 0.0))
        for name, value in inertia.items():
            rows.append(self._spread(self.place[name] + np.arange(3), np.eye(3)[2:]))
            blocks.append(np.array([[value]]))
        return sp.vstack(rows).tocsr(), sp.csr_matrix(la.block_diag(*blocks))

    def _spread(self, places: Any, rows: Array) -> Sparse:
        """Rows over all displacements from rows over some of them."""
        entries = sp.lil_matrix((len(rows), self.size))
        entries[:, places] = rows
        return entries.tocsr()

    def _stress_stiffness(self, z: Array) -> Sparse:
        """Geometric stiffness of the axial forces of displacements z, which are constant along each element."""

        def blocks() -> Iterator[Array]:
            for places, turn, _, data, k in self._elements():
                ends = turn @ z[places]
                force = data.axial_stiffness[k, 1, 1] * (ends[3] - ends[0])
                yield force * _string(data.lengths[k], _axis(data, k))

        return self._assembled(blocks())


def _stiffness(data: BeamMatrices, k: int) -> Array:
    """Stiffness (6, 6) of an element in its axes."""
    block = np.zeros((6, 6))
    block[np.ix_([0, 3], [0, 3])] = data.axial_stiffness[k]
    block[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = data.bending_stiffness[k]
    return block


def _shear(data: BeamMatrices, k: int) -> Array:
    """(4,) mean angle of the normals of the sections against the axis by w1, theta1, w2, theta2, sign of rotations."""
    (c1, c2), both = data.shear_shares[k], data.shear_shares[k].sum() / data.lengths[k]
    return np.array([both, c1, -both, c2])


def _axis(data: BeamMatrices, k: int) -> Array:
    """(4, 4) displacements and slopes of the axis at both ends by w1, theta1, w2, theta2."""
    shear = _shear(data, k)
    return np.asarray(np.eye(4) - np.outer([0.0, 1.0, 0.0, 1.0], shear))


def _string(L: float, axis: Array) -> Array:
    """Geometric stiffness (6, 6) of a unit axial force: int w'^2 with cubics."""
    block = np.zeros((6, 6))
    own = np.array(
        [
            [36.0, 3.0 * L, -36.0, 3.0 * L],
            [3.0 * L, 4.0 * L * L, -3.0 * L, -(L * L)],
            [-36.0, -3.0 * L, 36.0, -3.0 * L],
            [3.0 * L, -(L * L), -3.0 * L, 4.0 * L * L],
        ]
    ) / (30.0 * L)
    block[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = axis.T @ own @ axis
    return block


def model_of_beams(body: FlexibleBody, pins: Sequence[str]) -> ElasticModel:
    """Elastic model of a body of beams.

    Parameters
    ----------
    body : the body.
    pins : names of its nodes where parts are attached.
    """
    return BeamModel(body, pins).model()


def pins_of_beams(body: FlexibleBody) -> tuple[Node, ...]:
    """Nodes at the corners of a body of beams."""
    nodes = {node.name: node for node in body.nodes()}
    return tuple(nodes[name] for name in body.corners)
