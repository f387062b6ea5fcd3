"""Strain and stress of beams, their section forces, and the largest stress.

sigma = N/A - f M in the outer fibres on the left (f = c/I) and on the right (f = -c/I; of arcs see `arc_factors`), with
the section forces along each element: those of elasticity less weight and inertia of the element, so that they are in
balance with the nodes and with what acts between them.  c is the distance of the outer fibre.  The shear stress is left
out: it is zero in the outer fibres of the sections, where the normal stress is largest.  Section forces are equations
(2.20) to (2.22) of docs/theory/beam.md.
"""

import math
from collections.abc import Sequence

import numpy as np

from flexmb.elastic.beams.corotational import LENGTH, PARAMETERS, J, forces, state
from flexmb.elastic.beams.section import Section
from flexmb.engine.compiled.arrays import part_of, stack_vector
from flexmb.errors import InputError
from flexmb.kernels import compiled, extremum_kernel, fast
from flexmb.planar import Array


def strains(
    poses: Sequence[Array], L: Array, offsets: Array, outer: Array, shear: Array, bow: Array, unstressed: Array
) -> Array:
    """Largest strain (instants, n) of the outer fibres of each element of a beam, axial and bending strain added."""
    # Equation (2.12) of docs/theory/beam.md, u1 and u2 less those of the unstressed element. Poses x, y, theta of the
    # nodes are (instants, n + 1) [m, rad]. L (n,) are the unstressed lengths [m], `offsets` (n + 1,) directions of the
    # unstressed beam less theta of its nodes [rad], `outer` (n,) largest distances of the outer fibre from the centroid
    # [m]; `shear` (2, n) shares of the end rotations in the shear angle [1], `bow` (3, n) shortening of the chords,
    # `unstressed` (3, n) l0 [m], u10 and u20 [rad], see `flexmb.elastic.beams.corotational`, which has the source.
    x, y, theta = poses
    dx, dy, turned = np.diff(x, axis=1), np.diff(y, axis=1), theta + offsets
    chord = np.arctan2(dy, dx)
    u1, u2 = wrapped(turned[:, :-1] - chord), wrapped(turned[:, 1:] - chord)
    free, free1, free2 = unstressed
    axial = (np.hypot(dx, dy) - free) / L + (bow[0] * u1 * u1 - bow[1] * u1 * u2 + bow[2] * u2 * u2) / 30.0
    u1, u2 = u1 - free1, u2 - free2
    sheared = shear[0] * u1 + shear[1] * u2
    u1, u2 = u1 - sheared, u2 - sheared
    bending = np.maximum(np.abs(4.0 * u1 + 2.0 * u2), np.abs(2.0 * u1 + 4.0 * u2)) / L
    return np.asarray(np.abs(axial) + bending * outer)


def wrapped(angle: np.ndarray) -> np.ndarray:
    """Angles in [-pi, pi]."""
    return angle - 2.0 * math.pi * np.round(angle / (2.0 * math.pi))


def outer_fibres(section: Section, stations: np.ndarray) -> np.ndarray:
    """Distance of the outer fibre from the centroid [m] at stations (n + 1,) of a beam; 0 where it is unknown."""
    try:
        fibres = np.asarray(section.outer_fibre_at(stations))
    except InputError:
        fibres = np.zeros_like(stations)
    return fibres


def arc_factors(section: Section, places: np.ndarray, turn: float, length: float) -> np.ndarray:
    """(..., 2) stress over -M in the outer fibres on the left and on the right of an arc [1/m^3]; NaN: no outline."""
    # Winkler and Bach: M (r_n - r)/(A e r), r_n = A / int dA/r, e = R - r_n, about the centroid, beside N/A. Source: S.
    # Timoshenko, Strength of Materials, part 2, 3rd ed., van Nostrand 1956, sections 77 to 80.
    # Equation (2.19) of docs/theory/beam.md.
    R, A, c = length / abs(turn), np.asarray(section.area_at(places)), np.asarray(section.outer_fibre_at(places))
    neutral = A / section.over_radius_at(places, R)
    inner, outer = (neutral / r - 1.0 for r in (R - c, R + c))
    sides = (inner, outer) if turn > 0.0 else (-outer, -inner)
    return np.asarray(np.stack(sides, axis=-1) / (A * (R - neutral))[..., None])


# Number of section forces of an element: at its start, at its end and in the mean N, then V; at both ends M, and its
# slope by xi less that of the line between both. In the axes of the chord, as of `fem`.
SECTION_FORCES = 10


@fast
def section_forces(p, q, v, a):
    """Elastic section forces that are in balance with weight and inertia of the element; p without damping."""
    u, x, motion = state(p, q, v, a)
    i, _, _, _, u1, u2 = u
    (x1, y1, m1, x2, y2, m2), _, mean = forces(p, u, x, motion)
    # dM/dx = N dw/dx - V + rho I alpha along the chord: a cubic, exact where weight and inertia are linear
    turn1, turn2, between = p[J] * a[2], p[J] * a[5], m1 + m2
    first, last = y1 / i - x1 * p[LENGTH] * u1 + turn1 - between, x2 * p[LENGTH] * u2 - y2 / i + turn2 - between
    return -x1, x2, mean, -y1, y2, (0.5 * (turn1 + turn2) - between) * i, -m1, m2, first, last


@compiled
def fill_section_forces(p, q, v, a, found):
    """Fill found (n, SECTION_FORCES) for n states (n, 6) of an element."""
    for k in range(found.shape[0]):
        N1, N2, N, V1, V2, V, M1, M2, first, last = section_forces(p, q[k], v[k], a[k])
        for j, force in enumerate((N1, N2, N, V1, V2, V, M1, M2, first, last)):
            found[k, j] = force


# Largest normal stress in the outer fibres of beams, and the place where it acts

COUNT, HEAD = range(2)
# Parameters p: number of elements. At HEAD, of each element: first coordinates of its ends; numbers of its nodes and of
# its middle; at four places 1/A and the factors of -M in the fibres on the left and on the right; its own parameters.
START, END, START_NODE, END_NODE, MIDDLE, FACTORS = range(6)
PLACES = np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])  # of the factors, fractions of an element
LEFT, RIGHT, OF_PLACE = range(1, 4)  # of the factors of a place, behind 1/A; their number
OWN = FACTORS + OF_PLACE * len(PLACES)
SIZE = OWN + PARAMETERS  # numbers of an element
NEAR_END = 0.75  # distance from an end, of three along an element, up to which a place counts as this end
CLEAR = 1.0 + 1e-9  # stress within an element over that at its ends, above which it is no round-off of it
NODE = 3  # coordinates of a node
six = stack_vector(2 * NODE)


@fast
def inner_extrema(s0, s1, s2, s3):
    """Largest absolute value of the cubic through four even places at its extrema between them, and where; or 0."""
    d1, d2, d3 = s1 - s0, s2 - 2.0 * s1 + s0, s3 - 3.0 * (s2 - s1) - s0
    a, b, c = 0.5 * d3, d2 - d3, d1 - 0.5 * d2 + d3 / 3.0  # its derivative a t^2 + b t + c, t = 3 xi
    square, largest, where = b * b - 4.0 * a * c, 0.0, 0.0
    if square >= 0.0:
        double = -b - math.copysign(math.sqrt(square), b)
        for t in (0.5 * double / a, 2.0 * c / double):
            if 0.0 < t < 3.0:
                value = abs(s0 + t * (d1 + (t - 1.0) * (0.5 * d2 + (t - 2.0) / 6.0 * d3)))
                if value > largest:
                    largest, where = value, t
    return largest, where


@fast
def fibre_stress(p, at, fibre, N1, N2, N, M1, M2, first, last):
    """Stresses of a fibre, LEFT or RIGHT, at the four places along an element."""
    at, third = at + FACTORS, 4.0 / 3.0 * (N - 0.5 * (N1 + N2))
    M_first, M_second = (2.0 * M1 + M2) / 3.0, (M1 + 2.0 * M2) / 3.0
    M_first, M_second = M_first + (4.0 * first - 2.0 * last) / 27.0, M_second + (2.0 * first - 4.0 * last) / 27.0
    s0 = N1 * p[at] - M1 * p[at + fibre]
    at += OF_PLACE
    s1 = ((2.0 * N1 + N2) / 3.0 + third) * p[at] - M_first * p[at + fibre]
    at += OF_PLACE
    s2 = ((N1 + 2.0 * N2) / 3.0 + third) * p[at] - M_second * p[at + fibre]
    at += OF_PLACE
    return s0, s1, s2, N2 * p[at] - M2 * p[at + fibre]


@fast
def element_stresses(p, at, q, v, a):
    """Largest normal stresses at the start, at the end and in between [Pa], and where, from 0 to 3."""
    first, last, x, y, z = int(p[at + START]), int(p[at + END]), six(), six(), six()
    for i in range(NODE):
        x[i], y[i], z[i] = q[first + i], v[first + i], a[first + i]
        x[NODE + i], y[NODE + i], z[NODE + i] = q[last + i], v[last + i], a[last + i]
    N1, N2, N, _, _, _, M1, M2, d1, d2 = section_forces(part_of(p, at + OWN, at + SIZE), x, y, z)
    at_start = at_end = between = where = 0.0
    for fibre in (LEFT, RIGHT):
        s0, s1, s2, s3 = fibre_stress(p, at, fibre, N1, N2, N, M1, M2, d1, d2)
        inner, place = inner_extrema(s0, s1, s2, s3)
        if inner > between:
            between, where = inner, place
        at_start, at_end = larger(abs(s0), at_start), larger(abs(s3), at_end)
    return at_start, at_end, between, where


@fast
def larger(x, y):
    """Maximum of two numbers, NaN of NaN."""
    return y if x <= y else x


@extremum_kernel
def beam_stress_kernel(p, t, q, v, a, least):
    """Largest normal stress of all elements [Pa], and the number of its node or of the middle of its element."""
    largest, where = -1.0, 0.0
    for k in range(int(p[COUNT])):
        at = HEAD + SIZE * k
        first, last, between, place = element_stresses(p, at, q, v, a)
        if not first <= largest:  # also what is not a number
            largest, where = first, p[at + START_NODE]
        if not last <= largest:
            largest, where = last, p[at + END_NODE]
        if between > largest * CLEAR:
            largest, where = between, p[at + MIDDLE]
            if place < NEAR_END:
                where = p[at + START_NODE]
            elif place > 3.0 - NEAR_END:
                where = p[at + END_NODE]
    return largest, where
