"""Bodies of beams and plane bodies as their reduction sees them.

The unstressed element is straight or an arc.  With the chord, whose rotation is alpha, a point of the axis moves along
the chord by (1 - xi) x1 + xi x2 - w alpha and across it by (1 - xi) y1 + xi y2 + N2 u1 + N4 u2, where w is the bow of
the arc and uk the rotation of the end k against the chord.  It is what the element of
`flexmb.elastic.beams.corotational` becomes for small displacements.
"""

import math
from collections.abc import Hashable, Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from flexmb import planar
from flexmb.elastic.beams.corotational import chord_share
from flexmb.elastic.beams.fem import BeamMatrices
from flexmb.elastic.beams.stress import outer_fibres
from flexmb.elastic.planes.cells import geometric_stiffness, stress_at_quadrature
from flexmb.elastic.planes.pins import RIGID, tie
from flexmb.elastic.planes.plane_body import PlaneBody
from flexmb.elastic.planes.stress import mesh_shape, stress_operator
from flexmb.elastic.reduced.bases import ElasticModel, Sparse
from flexmb.errors import InputError
from flexmb.model.contributions import Node
from flexmb.model.shape import MeshShape
from flexmb.parts.bodies import flexible
from flexmb.parts.bodies.flexible_links import FlexibleBody
from flexmb.planar import Array

PLACES = np.linspace(0.0, 1.0, 4)  # places on an element whose displacements carry its mass: four of a cubic say all

P2, P3 = PLACES**2, PLACES**3
# (4, 4) displacements there by (w1, L theta1, w2, L theta2)
HERMITE = np.stack([1.0 - 3.0 * P2 + 2.0 * P3, PLACES - 2.0 * P2 + P3, 3.0 * P2 - 2.0 * P3, P3 - P2], axis=1)

# (4, 4) slopes there, times L
SLOPES = np.stack(
    [-6.0 * PLACES + 6.0 * P2, 1.0 - 4.0 * PLACES + 3.0 * P2, 6.0 * PLACES - 6.0 * P2, 3.0 * P2 - 2.0 * PLACES], axis=1
)


class Element(NamedTuple):
    """An element of a beam as it lies unstressed."""

    places: Array  # (6,) places of its displacements among all
    turn: Array  # (6, 6) displacements in the axes of its chord by those of the nodes
    start: Array  # first end [m]
    chord: float  # length of the chord [m]
    free: Array  # rotations (u1, u2) of its ends against the chord [rad]; 0 where it is straight
    beam: flexible.Beam
    data: BeamMatrices  # matrices of the beam
    k: int  # number of the element

    @property
    def length(self) -> float:
        """Length along the element [m]."""
        return float(self.data.lengths[self.k])

    @property
    def stations(self) -> Array:
        """Fractions of the beam's length at `PLACES`."""
        beam = self.beam
        return np.asarray((beam.stations[self.k] + PLACES * self.length) / beam.stations[-1])

    @property
    def rotation(self) -> Array:
        """(6,) rotation of the chord by the displacements in its axes."""
        return np.array([0.0, -1.0, 0.0, 0.0, 1.0, 0.0]) / self.chord

    @property
    def ends(self) -> Array:
        """(2, 6) rotations of both ends against the chord by these displacements."""
        return np.asarray(np.eye(6)[[2, 5]] - self.rotation)

    @property
    def bending(self) -> Array:
        """(4, 6) w1, theta1, w2, theta2 of a straight element that bends and turns like this one."""
        return np.stack([0.0 * self.rotation, np.eye(6)[2], self.length * self.rotation, np.eye(6)[5]])

    @property
    def elongation(self) -> Array:
        """(6,) elongation: of the chord, and of the arc that bends."""
        b1, b2, b3 = self.data.bow[self.k]
        u1, u2 = self.free
        bowed = np.array([2.0 * b1 * u1 - b2 * u2, 2.0 * b3 * u2 - b2 * u1])
        return np.asarray(np.eye(6)[3] - np.eye(6)[0] + self.length / 30.0 * bowed @ self.ends)

    @property
    def normal_force(self) -> Array:
        """(6,) normal force, constant along the element."""
        return np.asarray(self.data.axial_stiffness[self.k, 1, 1] * self.elongation)

    @property
    def cubic(self) -> Array:
        """(4, 4) displacements across the chord at `PLACES` by w1, theta1, w2, theta2."""
        length = self.length
        return np.asarray(HERMITE * np.array([1.0, length, 1.0, length]) @ _axis(self.data, self.k))

    @property
    def slopes(self) -> Array:
        """(4, 4) turns of the sections there against the chord's first direction."""
        length = self.length
        scaled = SLOPES * np.array([1.0, length, 1.0, length]) / length
        return np.asarray(scaled @ _axis(self.data, self.k) + _shear(self.data, self.k))

    def points(self) -> tuple[Array, Array]:
        """Points of the axis (4, 2) [m], and their displacements (8, 6) x0, y0, ... in the axes of the chord."""
        across = self.cubic[:, 1::2]
        bow, moved = across @ self.free, np.zeros((8, 6))
        for first in (0, 1):
            moved[first::2, first], moved[first::2, 3 + first] = 1.0 - PLACES, PLACES
        moved[0::2] -= np.outer(bow, self.rotation)
        moved[1::2] += across @ self.ends
        return self.start + np.stack([PLACES * self.chord, bow], axis=1) @ self.turn[:2, :2], moved

    def side(self, half: Array) -> tuple[Array, Array]:
        """Points beside the axis at distances `half` (4,), to the left > 0, and their displacements, as `points`."""
        points, moved = self.points()
        u1, u2 = self.free
        slope, turned = self.slopes @ np.array([0.0, u1, 0.0, u2]), self.slopes @ self.bending
        moved[0::2] -= (half * np.cos(slope))[:, None] * turned
        moved[1::2] -= (half * np.sin(slope))[:, None] * turned
        return points + half[:, None] * np.stack([-np.sin(slope), np.cos(slope)], axis=1) @ self.turn[:2, :2], moved

    def stiffness(self) -> Array:
        """(6, 6) in the axes of the chord."""
        bent = self.bending
        bending = bent.T @ self.data.bending_stiffness[self.k] @ bent
        return np.asarray(np.outer(self.elongation, self.normal_force) + bending)

    def string(self) -> Array:
        """(6, 6) geometric stiffness of a unit normal force: of an element that turns, and of its bow."""
        b1, b2, b3 = self.data.bow[self.k]
        bow = self.length / 30.0 * np.array([[2.0 * b1, -b2], [-b2, 2.0 * b3]])
        return np.asarray(self.chord * np.outer(self.rotation, self.rotation) + self.ends.T @ bow @ self.ends)


def _shear(data: BeamMatrices, k: int) -> Array:
    """(4,) mean angle of the normals of the sections against the axis by w1, theta1, w2, theta2, sign of rotations."""
    (c1, c2), both = data.shear_shares[k], data.shear_shares[k].sum() / data.lengths[k]
    return np.array([both, c1, -both, c2])


def _axis(data: BeamMatrices, k: int) -> Array:
    """(4, 4) displacements and slopes of the axis at both ends by w1, theta1, w2, theta2."""
    return np.asarray(np.eye(4) - np.outer([0.0, 1.0, 0.0, 1.0], _shear(data, k)))


THIN = 2e-3  # half of the depth over the length with which beams of unknown depth are drawn


class BeamModel:
    """Matrices of the beams of a body over the displacements of its nodes, pins first, in the axes of the first pin."""

    def __init__(self, body: FlexibleBody, pins: Sequence[str]) -> None:
        self.body, nodes = body, {node.name: node for node in body.nodes()}
        first = nodes[pins[0]]
        self.origin, self.direction = (first.x, first.y), first.theta
        own = {name: Node(name, *self._own((n.x, n.y)), n.theta - first.theta) for name, n in nodes.items()}
        self.pins = tuple(own.pop(name) for name in pins)
        self.nodes = (*self.pins, *own.values())
        self.place, self.size = {node.name: 3 * k for k, node in enumerate(self.nodes)}, 3 * len(self.nodes)
        self.elements: list[Element] = []
        for beam in body.beams:
            data, angles = flexible.matrices(beam), flexible.chord_directions(beam)
            unstressed = flexible.unstressed_shape(beam, data)
            starts = [self._own(point) for point in beam.points]
            for k, ends in enumerate(pairwise(beam.nodes)):
                c, s = math.cos(angles[k] - self.direction), math.sin(angles[k] - self.direction)
                turn = np.kron(np.eye(2), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
                places = np.concatenate([self.place[name] + np.arange(3) for name in ends])
                chord = float(data.lengths[k]) * chord_share(2.0 * unstressed[k, 2])
                own_shape = places, turn, np.array(starts[k]), chord, unstressed[k, 1:]
                self.elements.append(Element(*own_shape, beam, data, k))

    def _own(self, point: tuple[float, float]) -> tuple[float, float]:
        """A point in the axes of the first pin."""
        return planar.to_frame(self.origin, self.direction, point)

    def model(self) -> ElasticModel:
        """The elastic model."""
        body, stiffness = self.body, self._assembled(element.stiffness() for element in self.elements)
        stresses = self._stresses if all(flexible.knows_stress(beam.section) for beam in body.beams) else None
        return ElasticModel(
            body.label, self.pins, stiffness, *self._samples(), *self._turns(), self._stress_stiffness, body.damping,
            self.origin, self.direction, *self._outline(), stresses, body.mass_damping,
        )  # fmt: skip

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
        ends, bosses = [self.place[name] for name in self.body.corners], self.body._bosses
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
        """Normal stresses in outer fibres (points, 4, n) of displacements (N, n); moments follow the axis at rest."""
        found, factors = [], np.concatenate([flexible.section_factors(beam, PLACES) for beam in self.body.beams])
        for element, factor in zip(self.elements, factors, strict=True):
            moved, bow = element.turn @ z[element.places], element.cubic[:, 1::2] @ element.free
            normal, forces = element.normal_force @ moved, element.stiffness() @ moved
            moment = (PLACES - 1.0)[:, None] * forces[2] + PLACES[:, None] * forces[5] + np.outer(bow, normal)
            found += [factor[:, :1] * normal - factor[:, side, None] * moment for side in (2, 1)]
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
        inertia, first = dict.fromkeys(self.body.corners, self.body._bosses.inertia), self.body.corners[0]
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
        forces = ((one, one.normal_force @ (one.turn @ z[one.places])) for one in self.elements)
        return self._assembled(force * element.string() for element, force in forces)


# What a reduced body asks of the body with all its nodes, by its class

Reducible: TypeAlias = FlexibleBody | PlaneBody  # bodies that can be reduced


def model_of(body: Reducible, pins: Sequence[str]) -> ElasticModel:
    """Elastic model of a body with pins where parts are attached; its other pins are left out."""
    if not isinstance(body, PlaneBody):
        return BeamModel(body, pins).model()
    kept = [interface for interface in body.interfaces if interface.name in pins]
    if not kept:
        raise InputError(f"{body.label}: none of its pins is left. Keep at least one.")
    shape = sp.csr_matrix(body.tie.matrix if len(kept) == len(body.interfaces) else tie(kept, body.mesh).matrix)
    stiffness = sp.csr_matrix(body.matrices.stiffness)

    def stress_stiffness(z: Array) -> Sparse:
        moved = shape @ z
        stress = stress_at_quadrature(body.mesh, body.material, moved, body.state)
        turned = sp.csr_matrix(geometric_stiffness(body.mesh, stress, body.thickness))
        forces, turns = (stiffness @ moved).reshape(-1, 2), np.zeros(shape.shape[1])
        for k, interface in enumerate(kept):
            if interface.kind == RIGID:  # its nodes move by -theta^2/2 of their arms, and its forces do work on that
                turns[3 * k + 2] = -float((forces[interface.nodes] * interface.arms(body.mesh)).sum())
        return (shape.T @ turned @ shape + sp.diags_array(turns)).tocsc()

    def stresses(shapes: Array) -> Array:
        operator = stress_operator(body.mesh, body.material, body.state)
        return np.asarray(np.asarray(operator @ (shape @ shapes)).reshape(len(body.mesh.points), 4, -1))

    nodes, mass = tuple(Node(interface.name, *interface.point, 0.0) for interface in kept), body.matrices.scalar_mass
    inner, no_turns = (shape.T @ stiffness @ shape).tocsc(), (sp.csr_matrix((1, shape.shape[1])), sp.csr_matrix((1, 1)))
    drawn = mesh_shape(body.name, body.mesh, body.material, body.state)
    return ElasticModel(
        body.label, nodes, inner, body.mesh.points, shape, sp.csr_matrix(mass), *no_turns, stress_stiffness,
        body.damping, body.origin, body.direction, drawn, shape, stresses, body.mass_damping,
    )  # fmt: skip


def place_of(body: Reducible, pins: Sequence[str]) -> tuple[tuple[float, float], float]:
    """Origin [m] and direction [rad] of the axes of the elastic model."""
    if isinstance(body, PlaneBody):
        return body.origin, body.direction
    first = body.node(pins[0])
    return (first.x, first.y), first.theta


def key_of(body: Reducible, pins: Sequence[str]) -> Hashable:
    """All that the elastic model of a body with pins depends on, but its label, damping and place."""
    if isinstance(body, PlaneBody):
        kinds = tuple((interface.name, interface.kind) for interface in body.interfaces if interface.name in pins)
        return body.mesh, body.thickness, body.material, body.state, kinds
    pivot = float(getattr(body, "pivot_inertia", 0.0))
    return tuple(pins), body.nodes(), body.beams, (body.corners, body.corner_points), body._bosses, pivot
