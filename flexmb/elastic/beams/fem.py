"""Element matrices of a beam, from weak forms with scikit-fem; its shape and section forces from the poses of its ends.

Axial     stiffness  1 / int dx/(E A)      mass  int rho A u v dx     linear elements, order (u1, u2)
Bending   stiffness  int E I w'' v'' dx    mass  int rho A w v dx     cubic Hermite elements,
          rotary inertia, on request       int rho I w' v' dx         order (w1, theta1, w2, theta2), theta = w'

w is positive to the left of the direction of the beam, so theta is counter-clockwise.  Shear is condensed.  The axial
stiffness is exact for tapered bars under end loads; with the linear displacement alone, int E A u' v' dx, they would be
too stiff.  The elements of all beams of a model are assembled in one mesh, never inside the time loop.

(N, V, M) are the forces of the part beyond a section on the part before it: N along the chord, V to its left, M
counter-clockwise; M > 0 bends the beam to the left, as the curvature kappa > 0.  With kb, dk = uk - uk0, gk = de/duk:

    N = ka e,   M(0) = -(b11 d1 + b12 d2 + N g1),   M(L) = b12 d1 + b22 d2 + N g2,   V = (M(0) - M(L))/l

and from these weight and inertia of the element are taken (see `beams.stress`).  They are forces without damping.
Equations (2.7), (2.13) to (2.16) and (2.20) to (2.22) of docs/theory/beam.md.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from skfem import Basis, BilinearForm, ElementLineHermite, ElementLineP1, Functional, MeshLine

from flexmb.elastic.beams.corotational import BOW11, GRAVITY_X
from flexmb.elastic.beams.section import Section, shear_factors
from flexmb.elastic.beams.stress import SECTION_FORCES, fill_section_forces
from flexmb.errors import InputError
from flexmb.model.law import Material
from flexmb.model.shape import BeamShape
from flexmb.planar import Array

BOW = (2.0, 1.0, 2.0)  # shortening of the chord by bending without shear: L/30 (2 u1^2 - u1 u2 + 2 u2^2)


def with_shear(lengths: Array, axial: Array, cubics: tuple[Array, Array, Array], flexibility: Array) -> list[Array]:
    """Matrices of bending with the shear angle condensed: stiffness, mass, rotary part; shares of shear, bow."""
    # Lengths (n,) [m], axial stiffness ka (n,) [N/m], flexibility (n,) int ds/(ks G A) [m/N], 0: rigid in shear;
    # `cubics` are without shear: stiffness, mass of the axis and of the rotation of sections alone, (n, 4, 4) each.
    ends, rigid = cubics[0][:, 1::2, 1::2], flexibility == 0.0
    angle = np.where(rigid, np.inf, lengths**2 / np.where(rigid, 1.0, flexibility))  # K
    shares = ends.sum(axis=1) / (ends.sum(axis=(1, 2)) + angle)[:, None]
    both = shares.sum(axis=1) / lengths
    # sigma of the nodal displacements; 0 for rigid motions
    sigma = np.stack([both, shares[:, 0], -both, shares[:, 1]], axis=1)
    one, zero = np.ones_like(lengths), np.zeros_like(lengths)
    turns = ([zero, -one, zero, -one], [zero, zero, lengths, zero])
    axis, section = (np.eye(4) + np.stack(turn, axis=1)[:, :, None] * sigma[:, None, :] for turn in turns)
    stiffness = _carried(cubics[0], axis)
    stiffness += np.where(rigid, 0.0, angle)[:, None, None] * (sigma[:, :, None] * sigma[:, None, :])
    # Shortening of the chord by the slopes uk - sigma, less L sigma^2/2, and share of the shear force in N: Reissner
    # measures the axial strain along the normal of the section, (1 + e) cos(sigma) - 1. To second order of the strains
    # his energy is that of the elongation in equation (2.16), whose last term is K sigma^2/(L ka).
    first, second = shares.T
    k = 12.0 - np.where(rigid, 0.0, 30.0 / (np.where(rigid, 1.0, flexibility) * axial))
    bow1, bow2 = BOW[0] - 3.0 * first - k * first**2, BOW[2] - 3.0 * second - k * second**2
    bow = np.stack([bow1, BOW[1] + 3.0 * (first + second) + 2.0 * k * first * second, bow2], axis=1)
    return [stiffness, _carried(cubics[1], axis), _carried(cubics[2], section), shares, bow]


def _carried(matrices: Array, change: Array) -> Array:
    """change^T matrix change, symmetric to the last bit."""
    product: Array = change.transpose(0, 2, 1) @ matrices @ change
    return np.asarray(0.5 * (product + product.transpose(0, 2, 1)))


# Degree [1] up to which polynomials are integrated exactly.
# Linearly tapered dimensions need it: cubic x cubic x A of degree 2, and slope x slope x I of degree 4.
QUADRATURE_ORDER = 8


@dataclass(frozen=True, eq=False)
class BeamMatrices:
    """Matrices of the n elements of one straight beam; read-only arrays."""

    lengths: Array  # (n,) lengths of the elements [m]
    axial_stiffness: Array  # (n, 2, 2) in the order u1, u2 [N/m]
    axial_mass: Array  # (n, 2, 2) [kg]
    bending_stiffness: Array  # (n, 4, 4) in the order w1, theta1, w2, theta2 [N/m, N, N m]
    bending_mass: Array  # (n, 4, 4), rotary inertia included [kg, kg m, kg m^2]
    rotary_mass: Array  # (n, 4, 4) the part of rotary inertia alone; zeros without
    # (n, 2) shear angle over the end rotations against the chord, sign changed [1]; zeros without shear
    shear_shares: Array
    bow: Array  # (n, 3) shortening of the chord: L/30 (bow1 u1^2 - bow2 u1 u2 + bow3 u2^2)
    ea: Array  # (n, 2) axial rigidity E A at both ends of each element [N]
    ei: Array  # (n, 2) bending rigidity E I at both ends of each element [N m^2]

    def __post_init__(self) -> None:
        for field in fields(self):
            getattr(self, field.name).setflags(write=False)

    @cached_property
    def inertia_integrals(self) -> Array:
        """(n, 16) m11 m12 m22 g11 g12 g21 g22 h11 h12 h22 J j1 j2 k11 k12 k22, in the order of `corotational`."""
        # 1 - xi and xi are the cubics (1, -1/L, 0, -1/L) and (0, 1/L, 1, 1/L) of the order w1, theta1, w2, theta2; a
        # turn of all sections by 1 is (0, 1, L, 1). Equations (3.8) and (3.9) of docs/theory/inertia.md.
        n, L = len(self.lengths), self.lengths
        basis = np.zeros((n, 4, 4))
        basis[:, 0, 0] = basis[:, 1, 2] = basis[:, 2, 1] = basis[:, 3, 3] = 1.0
        basis[:, 0, 1] = basis[:, 0, 3] = -1.0 / L
        basis[:, 1, 1] = basis[:, 1, 3] = 1.0 / L
        m = basis @ (self.bending_mass - self.rotary_mass) @ basis.transpose(0, 2, 1)
        basis = np.zeros((n, 3, 4))
        basis[:, 0, 1] = basis[:, 0, 3] = basis[:, 1, 1] = basis[:, 2, 3] = 1.0
        basis[:, 0, 2] = L
        turned = basis @ self.rotary_mass @ basis.transpose(0, 2, 1)
        pairs = ((0, 0), (0, 1), (1, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3))
        upper = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        return np.stack([*(m[:, i, j] for i, j in pairs), *(turned[:, i, j] for i, j in upper)], axis=1)

    @cached_property
    def parameters(self) -> tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]:
        """L and ka kb11 kb12 kb22 in the chord frame; integrals of inertia and the bow; of each element."""
        ka, kb = self.axial_stiffness[:, 1, 1], self.bending_stiffness
        heads = np.stack([self.lengths, ka, kb[:, 1, 1], kb[:, 1, 3], kb[:, 3, 3]], axis=1).tolist()
        tails = np.concatenate([self.inertia_integrals, self.bow], axis=1).tolist()
        return tuple(zip(map(tuple, heads), map(tuple, tails), strict=True))

    @cached_property
    def straight(self) -> tuple[tuple[float, float, float], ...]:
        """l0, u10 and u20 of straight elements; see `flexmb.elastic.beams.corotational`."""
        return tuple((length, 0.0, 0.0) for length in self.lengths.tolist())


@dataclass(frozen=True, eq=False)
class BeamData:
    """Data of one straight beam that its matrices depend on."""

    # Exact for linearly tapered dimensions (see `QUADRATURE_ORDER`). Without shear not for thick beams: length over
    # height should exceed about 10. Source of the weak forms: R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt,
    # Concepts and Applications of Finite Element Analysis, 4th ed., Wiley 2002, sections 2.3 and 11.3.
    stations: Array  # (n + 1,) increasing [m]
    section: Section
    material: Material
    rotary_inertia: bool | float = False  # of the rotation of sections (Rayleigh): True for rho I, or a number [kg m]
    shear: bool | float = False  # deformation (Timoshenko): True for the shear factor of the section, or the factor [1]


def assembled(beams: Sequence[BeamData]) -> list[BeamMatrices]:
    """Matrices of several beams, all their elements in one mesh."""
    if not beams:
        return []
    counts = [beam.stations.size - 1 for beam in beams]
    begin, end = (np.concatenate([beam.stations[part] for beam in beams]) for part in (slice(-1), slice(1, None)))
    origin = np.repeat([beam.stations[0] for beam in beams], counts)[:, None]
    size = np.repeat([beam.stations[-1] - beam.stations[0] for beam in beams], counts)[:, None]
    # separate elements: scikit-fem inverts a Vandermonde matrix of 1, x, x^2, x^3 for Hermite elements; far from the
    # origin that loses digits, 1e-5 in the stiffness of the last of 2000 elements; beginning at 0, all digits stay
    ends = np.stack([np.zeros_like(end), end - begin], axis=1)
    mesh = MeshLine(ends.reshape(1, -1), np.ascontiguousarray(np.arange(ends.size).reshape(-1, 2).T))
    axial = Basis(mesh, ElementLineP1(), intorder=QUADRATURE_ORDER)
    bending = Basis(mesh, ElementLineHermite(), intorder=QUADRATURE_ORDER)
    E = np.repeat([beam.material.young for beam in beams], counts)[:, None]
    rho = np.repeat([beam.material.density for beam in beams], counts)[:, None]
    inside = (begin[:, None] - origin + np.asarray(axial.global_coordinates())[0]) / size
    A, I = _dimensions(beams, counts, inside)
    A_ends, I_ends = _dimensions(beams, counts, (np.stack([begin, end], axis=1) - origin) / size, least=0.0)
    given = [math.nan if beam.rotary_inertia is True else float(beam.rotary_inertia) for beam in beams]
    turning = np.repeat(given, counts)[:, None]
    flexibility: Array = _INVERSE.elemental(axial, weight=E * A)
    about = _local(_SLOPES, bending, np.where(np.isnan(turning), rho * I, turning))
    cubics, n = (_local(_CURVATURES, bending, E * I), _local(_PRODUCT, bending, rho * A), about), len(begin)
    bent = [*cubics, np.zeros((n, 2)), np.tile(BOW, (n, 1))]
    if any(beam.shear for beam in beams):
        rigidities = np.full_like(inside, np.inf)  # ks G A [N]; infinite for beams without shear
        for beam, last, count in zip(beams, np.cumsum(counts), counts, strict=True):
            if beam.shear:
                own, G = slice(last - count, last), beam.material.shear_modulus
                ks = shear_factors(beam.section, beam.shear, beam.material.poisson, inside[own])
                rigidities[own] = ks * G * A[own]
        bent = with_shear(end - begin, 1.0 / flexibility, cubics, _INVERSE.elemental(axial, weight=rigidities))
    bent[1] = bent[1] + bent[2]
    along = np.array([[1.0, -1.0], [-1.0, 1.0]]) / flexibility[:, None, None], _local(_PRODUCT, axial, rho * A)
    whole = (end - begin, *along, *bent, E * A_ends, E * I_ends)
    return [BeamMatrices(*(array[i:j] for array in whole)) for i, j in pairwise(np.cumsum([0, *counts]).tolist())]


_INVERSE = Functional(lambda w: 1.0 / w.weight)
_PRODUCT = BilinearForm(lambda u, v, w: w.weight * u * v)
_SLOPES = BilinearForm(lambda u, v, w: w.weight * u.grad[0] * v.grad[0])
_CURVATURES = BilinearForm(lambda u, v, w: w.weight * u.hess[0, 0] * v.hess[0, 0])


def _local(form: BilinearForm, basis: Basis, weight: Array) -> Array:
    """Matrix of `form` of every element, (n, k, k); weight (n, quadrature points)."""
    matrices: Array = np.ascontiguousarray(form.coo_data(basis, weight=weight).tolocal())
    # symmetric to the last bit, which products in another order are not
    return np.asarray(0.5 * (matrices + matrices.transpose(0, 2, 1)))


def _dimensions(
    beams: Sequence[BeamData], counts: Sequence[int], s: Array, least: float | None = None
) -> tuple[Array, Array]:
    """Area and second moment of all beams at s (elements, places); each section is asked once."""
    groups: dict[int, tuple[Section, list[int]]] = {}
    for k, beam in enumerate(beams):
        groups.setdefault(id(beam.section), (beam.section, []))[1].append(k)
    if len(groups) == 1:
        return _both(beams[0].section, s, least)
    A, I = np.empty_like(s), np.empty_like(s)
    ends = np.cumsum(counts)
    for section, members in groups.values():
        rows = np.concatenate([np.arange(ends[k] - counts[k], ends[k]) for k in members])
        A[rows], I[rows] = _both(section, s[rows], least)
    return A, I


def _both(section: Section, s: Array, least: float | None) -> tuple[Array, Array]:
    return _section_values(section, "area_at", s, least), _section_values(section, "second_moment_at", s, least)


def _section_values(section: Section, method: str, s: Array, least: float | None = None) -> Array:
    """Area or second moment at s, checked: > 0, or >= `least` at the ends, where a wedge may run out to zero."""
    values = np.asarray(getattr(section, method)(s), dtype=float)
    owner = f"{type(section).__name__}.{method}"
    if values.shape != s.shape:
        raise InputError(f"{owner}: the result has shape {values.shape} for s of shape {s.shape}; keep the shape of s.")
    good = np.isfinite(values) & (values > 0.0 if least is None else values >= least)
    if not np.all(good):
        k = np.unravel_index(int(np.argmin(good)), s.shape)
        raise InputError(f"{owner}: the value at s = {s[k]:.4g} is {values[k]:g}; it must be finite and > 0.")
    return values


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
    ends = ((np.cos(a), np.sin(a)) for a in (start[:, 2] + beam.start_angle, end[:, 2] + beam.end_angle))
    # less the direction of the chord, in (-pi, pi]
    return Deformation(l, c, s, *(np.arctan2(st * c - ct * s, ct * c + st * s) for ct, st in ends))


def element_shape(pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape, xi: np.ndarray) -> np.ndarray:
    """Points of the deformed axis, (n, m, 2) [m]; the points at xi = 0 and xi = 1 are the nodes, to the last bit."""
    # Poses are x, y, theta of the end nodes, (n, 3) or (3,) [m, rad]; xi (m,) are fractions of the length.
    start, end = np.atleast_2d(pose_start)[:, None, :2], np.atleast_2d(pose_end)[:, None, :2]
    d = deformation(pose_start, pose_end, beam)
    w, normal = beam.length * _blend(d, beam, xi, 0), np.stack([-d.s, d.c], axis=-1)[:, None, :]
    along = np.asarray(xi, dtype=float)[None, :, None]
    return np.asarray((1.0 - along) * start + along * end + w[:, :, None] * normal)


def curvature(pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape, xi: np.ndarray) -> np.ndarray:
    """Curvature w'' of the axis, less that of the unstressed one, (n, m) [1/m]; arguments as for `element_shape`."""
    d, (_, free1, free2) = deformation(pose_start, pose_end, beam), beam.free
    return np.asarray(_blend(d._replace(u1=d.u1 - free1, u2=d.u2 - free2), beam, xi, 2) / beam.length)


def section_forces(
    pose_start: np.ndarray, pose_end: np.ndarray, beam: BeamShape, xi: np.ndarray, motion: Sequence[Array] | None = None
) -> SectionForces:
    """Axial force [N], bending moment [N m] and shear force [N], each (n, m); arguments as for `element_shape`."""
    # With the velocities and accelerations (n, 6) of both ends they are in balance with weight and inertia, else those
    # of elasticity alone. The forces at the ends are in balance with the nodes whatever the section does in between,
    # also for tapered beams.
    q = np.concatenate([np.atleast_2d(pose_start), np.atleast_2d(pose_end)], axis=1)
    v, a = (np.zeros_like(q),) * 2 if motion is None else map(np.ascontiguousarray, motion)
    mass = beam.mass if beam.mass and motion is not None else (0.0,) * (BOW11 - GRAVITY_X)
    stiffness = beam.length, beam.axial, *beam.bending, beam.start_angle, beam.end_angle, 0.0
    found = np.zeros((len(q), SECTION_FORCES))
    fill_section_forces(np.array((*stiffness, *mass, *beam.bow, *beam.free)), q, v, a, found)
    N1, N2, N, V1, V2, V, M1, M2, d1, d2 = found.T[..., None]
    x = np.asarray(xi, dtype=float)
    y, bow = 1.0 - x, 6.0 * x * (1.0 - x)
    N, V = (y * f1 + x * f2 + bow * (f - 0.5 * (f1 + f2)) for f1, f2, f in ((N1, N2, N), (V1, V2, V)))
    return SectionForces(N, y * M1 + x * M2 + x * y * (y * d1 - x * d2), V)


def bending_stiffness(beam: BeamShape, xi: np.ndarray) -> np.ndarray:
    """E I of the section, (m,) [N m2], linear between the ends."""
    return np.asarray(np.interp(xi, (0.0, 1.0), beam.ei))


def _blend(d: Deformation, beam: BeamShape, xi: np.ndarray, derivative: int) -> np.ndarray:
    """The cubic of the axis, or its second derivative, on an element of unit length; (n, m)."""
    x = np.asarray(xi, dtype=float)
    h1, h2 = (6.0 * x - 4.0, 6.0 * x - 2.0) if derivative else (x * (1.0 - x) ** 2, x * x * (x - 1.0))
    sheared = beam.shear[0] * d.u1 + beam.shear[1] * d.u2
    return np.asarray((d.u1 - sheared)[:, None] * h1 + (d.u2 - sheared)[:, None] * h2)
