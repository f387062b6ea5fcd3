"""Shear of a beam element (Timoshenko): matrices of the cubics with a condensed shear angle.

In an element the shear force V is constant, and so is the mean angle -sigma between the axis and the normals of the
sections; the axis is the cubic of Hermite with the slopes uk - sigma at its ends, sections turn by psi = w' + sigma:

    strain energy   1/2 int E I (w'')^2 ds + 1/2 K sigma^2,     K = L^2 / int ds/(ks G A)
    least energy    sigma = c1 u1 + c2 u2,   ck = sum_j (kb)jk / (sum_ij (kb)ij + K),   kb of the cubics

For a uniform section c1 = c2 = Phi/(2 (1 + Phi)) with Phi = 12 E I/(ks G A L^2), and the matrices are those of
J. S. Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968, sections 5.6 and 11.6: exact for forces and
moments on the ends, without locking of thin beams.  For tapered sections V is constant as in the weak form of Hellinger
and Reissner, like the axial force of `fem`.
Equations (2.13) to (2.16) of docs/theory/beam.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

BOW = (2.0, 1.0, 2.0)
"""Shortening of the chord by bending without shear: L/30 (2 u1^2 - u1 u2 + 2 u2^2)."""


class Bending(NamedTuple):
    """Matrices of n elements in the order w1, theta1, w2, theta2, and the influence of shear on their shape.

    Attributes
    ----------
    stiffness : (n, 4, 4) [N/m, N, N m].
    mass : (n, 4, 4) of the axis alone [kg, kg m, kg m^2].
    rotary : (n, 4, 4) of the rotation of sections alone [kg, kg m, kg m^2].
    shares : (n, 2) c1, c2: shear angle over the end rotations against the chord, sign changed [1]; 0 without shear.
    bow : (n, 3) shortening of the chord: L/30 (bow1 u1^2 - bow2 u1 u2 + bow3 u2^2).
    """

    stiffness: Array
    mass: Array
    rotary: Array
    shares: Array
    bow: Array


def without_shear(stiffness: Array, mass: Array, rotary: Array) -> Bending:
    """Matrices of the cubics as they are."""
    n = len(stiffness)
    return Bending(stiffness, mass, rotary, np.zeros((n, 2)), np.tile(BOW, (n, 1)))


def with_shear(lengths: Array, axial: Array, cubics: Bending, flexibility: Array) -> Bending:
    """Matrices with the shear angle condensed.

    Lengths (n,) [m], axial stiffness ka (n,) [N/m], flexibility (n,) int ds/(ks G A) [m/N], 0: rigid in shear; `cubics`
    are without shear.
    """
    ends = cubics.stiffness[:, 1::2, 1::2]
    rigid = flexibility == 0.0
    angle = np.where(rigid, np.inf, lengths**2 / np.where(rigid, 1.0, flexibility))  # K
    shares = ends.sum(axis=1) / (ends.sum(axis=(1, 2)) + angle)[:, None]
    both = shares.sum(axis=1) / lengths
    # sigma of the nodal displacements; 0 for rigid motions
    sigma = np.stack([both, shares[:, 0], -both, shares[:, 1]], axis=1)
    one, zero = np.ones_like(lengths), np.zeros_like(lengths)
    axis, section = (
        np.eye(4) + turned[:, :, None] * sigma[:, None, :]
        for turned in (np.stack([zero, -one, zero, -one], axis=1), np.stack([zero, zero, lengths, zero], axis=1))
    )
    stiffness = _carried(cubics.stiffness, axis)
    stiffness += np.where(rigid, 0.0, angle)[:, None, None] * (sigma[:, :, None] * sigma[:, None, :])
    rotary = _carried(cubics.rotary, section)
    return Bending(stiffness, _carried(cubics.mass, axis), rotary, shares, _bow(lengths, axial, shares, flexibility))


def _carried(matrices: Array, change: Array) -> Array:
    """change^T matrix change, symmetric to the last bit."""
    product: Array = change.transpose(0, 2, 1) @ matrices @ change
    symmetric: Array = 0.5 * (product + product.transpose(0, 2, 1))
    return symmetric


def _bow(lengths: Array, axial: Array, shares: Array, flexibility: Array) -> Array:
    """Shortening of the chord by the slopes uk - sigma, less L sigma^2/2, and the share of the shear force in N.

    Reissner measures the axial strain along the normal of the section: (1 + e) cos(sigma) - 1.  To second order of the
    strains his energy is that of the elongation in equation (2.16), whose last term is K sigma^2/(L ka).
    """
    first, second = shares.T
    rigid = flexibility == 0.0
    k = 12.0 - np.where(rigid, 0.0, 30.0 / (np.where(rigid, 1.0, flexibility) * axial))
    return np.stack(
        [
            BOW[0] - 3.0 * first - k * first**2,
            BOW[1] + 3.0 * (first + second) + 2.0 * k * first * second,
            BOW[2] - 3.0 * second - k * second**2,
        ],
        axis=1,
    )
