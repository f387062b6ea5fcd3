"""A beam element as the reduction of its body sees it: displacements of its axis and sides, stiffness, string.

The unstressed element is straight or an arc.  With the chord, whose rotation is alpha, a point of the axis moves along
the chord by (1 - xi) x1 + xi x2 - w alpha and across it by (1 - xi) y1 + xi y2 + N2 u1 + N4 u2, where w is the bow of
the arc and uk the rotation of the end k against the chord.  It is what the element of `flexmb.beams.corotational`
becomes for small displacements.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flexmb.beams.fem import BeamMatrices
from flexmb.bodies.flexible import Beam

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


class Element(NamedTuple):
    """An element of a beam as it lies unstressed.

    Parameters
    ----------
    places : (6,) places of its displacements among all.
    turn : (6, 6) displacements in the axes of its chord by those of the nodes.
    start : first end [m].
    chord : length of the chord [m].
    free : rotations (u1, u2) of its ends against the chord [rad]; 0 where it is straight.
    data : matrices of the beam.
    k : number of the element.
    """

    places: Array
    turn: Array
    start: Array
    chord: float
    free: Array
    beam: Beam
    data: BeamMatrices
    k: int

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
        bow = across @ self.free
        moved = np.zeros((8, 6))
        for first in (0, 1):
            moved[first::2, first], moved[first::2, 3 + first] = 1.0 - PLACES, PLACES
        moved[0::2] -= np.outer(bow, self.rotation)
        moved[1::2] += across @ self.ends
        return self.start + np.stack([PLACES * self.chord, bow], axis=1) @ self.turn[:2, :2], moved

    def side(self, half: Array) -> tuple[Array, Array]:
        """Points beside the axis at distances `half` (4,), to the left > 0, and their displacements, as `points`."""
        points, moved = self.points()
        u1, u2 = self.free
        slope = self.slopes @ np.array([0.0, u1, 0.0, u2])
        turned = self.slopes @ self.bending
        moved[0::2] -= (half * np.cos(slope))[:, None] * turned
        moved[1::2] -= (half * np.sin(slope))[:, None] * turned
        return points + half[:, None] * np.stack([-np.sin(slope), np.cos(slope)], axis=1) @ self.turn[:2, :2], moved

    def stiffness(self) -> Array:
        """(6, 6) in the axes of the chord."""
        bent = self.bending
        return np.asarray(
            np.outer(self.elongation, self.normal_force) + bent.T @ self.data.bending_stiffness[self.k] @ bent
        )

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
    shear = _shear(data, k)
    return np.asarray(np.eye(4) - np.outer([0.0, 1.0, 0.0, 1.0], shear))
