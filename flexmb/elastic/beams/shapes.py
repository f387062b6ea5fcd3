"""Deformed shape, curvature and section forces of a corotational beam element, from the poses of its ends.

In the axes of the chord (length l; L unstressed), with end rotations u1, u2 against the chord and s = xi L:

    w(s)   = cubic with w(0) = w(L) = 0, w'(0) = u1 - sigma, w'(L) = u2 - sigma,   sigma = c1 u1 + c2 u2 with shear
    kappa  = w'' less that of the unstressed element
    e      = l - l0 + L/30 (bow1 u1^2 - bow2 u1 u2 + bow3 u2^2)
    N      = axial e
    M(0)   = -(b11 d1 + b12 d2 + N g1),   M(L) = b12 d1 + b22 d2 + N g2,   dk = uk - uk0,   gk = de/duk, linear between
    V      = (M(0) - M(L)) / l

(N, V, M) are the forces of the part beyond a section on the part before it: N along the chord, V to its left, M
counter-clockwise; M > 0 bends the beam to the left, as kappa > 0.  These are the elastic forces, without damping.
The cubics come from scikit-fem.  Source of N and M: `flexmb.elastic.beams.corotational`.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from skfem import CellBasis, ElementLineHermite, MeshLine

from flexmb.model.shape import BeamShape


class Deformation(NamedTuple):
    """An element in the axes of its chord, at every instant; all (n,)."""

    l: np.ndarray  # length of the chord [m]
    c: np.ndarray  # cosine of its direction
    s: np.ndarray  # sine of its direction
    u1: np.ndarray  # rotation of the start against the chord [rad]
    u2: np.ndarray  # rotation of the end against the chord [rad]


class SectionForces(NamedTuple):
    """Elastic section forces at n instants and m points; all (n, m)."""

    N: np.ndarray  # axial force, tension positive [N]
    M: np.ndarray  # bending moment [N m]
    V: np.ndarray  # shear force [N]


def deformation(pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape) -> Deformation:
    """Chord and end rotations; poses (n, 3) or (3,) as x, y, theta [m, rad]."""
    start, end = np.atleast_2d(pose_start), np.atleast_2d(pose_end)
    dx, dy = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
    l = np.hypot(dx, dy)
    c, s = dx / l, dy / l
    u1 = _rotation(start[:, 2] + beam.start_angle, c, s)
    u2 = _rotation(end[:, 2] + beam.end_angle, c, s)
    return Deformation(l, c, s, u1, u2)


def element_shape(pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape, xi: np.ndarray) -> np.ndarray:
    """Points of the deformed axis, (n, m, 2) [m]; the points at xi = 0 and xi = 1 are the nodes, to the last bit."""
    # Poses are x, y, theta of the end nodes, (n, 3) or (3,) [m, rad]; xi (m,) are fractions of the length.
    start, end = np.atleast_2d(pose_start)[:, None, :2], np.atleast_2d(pose_end)[:, None, :2]
    d = deformation(pose_start, pose_end, beam)
    w = beam.length * _blend(d, beam, xi, 0)
    normal = np.stack([-d.s, d.c], axis=-1)[:, None, :]
    along = np.asarray(xi, dtype=float)[None, :, None]
    return np.asarray((1.0 - along) * start + along * end + w[:, :, None] * normal)


def curvature(pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape, xi: np.ndarray) -> np.ndarray:
    """Curvature w'' of the axis, less that of the unstressed one, (n, m) [1/m]; arguments as for `element_shape`."""
    d, (_, free1, free2) = deformation(pose_start, pose_end, beam), beam.free
    return np.asarray(_blend(d._replace(u1=d.u1 - free1, u2=d.u2 - free2), beam, xi, 2) / beam.length)


def section_forces(pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape, xi: np.ndarray) -> SectionForces:
    """Axial force [N], bending moment [N m] and shear force [N], each (n, m); arguments as for `element_shape`."""
    # The moments at the ends are in balance with the nodes whatever the section does in between, also for tapered
    # beams.
    d = deformation(pose_start, pose_end, beam)
    L, (b11, b12, b22), (p, q, r), (free, free1, free2) = beam.length, beam.bending, beam.bow, beam.free
    e = d.l - free + L / 30.0 * (p * d.u1**2 - q * d.u1 * d.u2 + r * d.u2**2)
    N, u1, u2 = beam.axial * e, d.u1 - free1, d.u2 - free2
    first = -(b11 * u1 + b12 * u2 + N * L / 30.0 * (2.0 * p * d.u1 - q * d.u2))
    last = b12 * u1 + b22 * u2 + N * L / 30.0 * (2.0 * r * d.u2 - q * d.u1)
    along = np.asarray(xi, dtype=float)[None, :]
    M = (1.0 - along) * first[:, None] + along * last[:, None]
    V = (first - last) / d.l
    return SectionForces(*(np.broadcast_to(f[:, None], M.shape) if f.ndim == 1 else f for f in (N, M, V)))


def bending_stiffness(beam: BeamShape, xi: np.ndarray) -> np.ndarray:
    """E I of the section, (m,) [N m2], linear between the ends."""
    return np.asarray(np.interp(xi, (0.0, 1.0), beam.ei))


def _rotation(theta: np.ndarray, c: np.ndarray, s: np.ndarray) -> np.ndarray:
    """theta less the direction of the chord, in (-pi, pi]."""
    ct, st = np.cos(theta), np.sin(theta)
    return np.asarray(np.arctan2(st * c - ct * s, ct * c + st * s))


def _blend(d: Deformation, beam: BeamShape, xi: np.ndarray, derivative: int) -> np.ndarray:
    """The cubic of the axis, or its second derivative, on an element of unit length; (n, m)."""
    h1, h2 = _cubics(tuple(np.asarray(xi, dtype=float).tolist()))[derivative]
    sheared = beam.shear[0] * d.u1 + beam.shear[1] * d.u2
    return np.asarray((d.u1 - sheared)[:, None] * h1 + (d.u2 - sheared)[:, None] * h2)


@lru_cache(maxsize=64)
def _cubics(xi: tuple[float, ...]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The cubics with unit slope at the start and at the end, and their second derivatives, at the points xi."""
    points = np.array(xi)
    unit = MeshLine(np.array([[0.0, 1.0]]))
    basis = CellBasis(unit, ElementLineHermite(), quadrature=(points[None, :], np.ones(len(points))))
    fields = [basis.basis[i][0] for i in (1, 3)]
    # roundoff of scikit-fem's inverted matrix must not move the nodes
    inner = np.where((points == 0.0) | (points == 1.0), 0.0, 1.0)
    values = tuple(inner * np.asarray(f)[0] for f in fields)
    return {0: values, 2: tuple(f.hess[0, 0, 0] for f in fields)}
