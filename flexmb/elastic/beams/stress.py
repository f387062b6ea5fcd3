"""Strain and stress of beams, and the largest one.

sigma = |N|/A + |M| c/I at both ends of every element, with the elastic axial force and end moments of the corotational
element, which are in balance with its nodes; c is the distance of the outer fibre.  The shear stress is left out: it is
zero in the outer fibres of the sections, where the normal stress is largest.
"""

import math
from dataclasses import dataclass

import numpy as np

from flexmb.elastic.beams.corotational import PARAMETERS, deformation, elastic
from flexmb.elastic.beams.section import Section
from flexmb.engine.compiled.arrays import part_of, stack_vector
from flexmb.errors import InputError
from flexmb.kernels import extremum_kernel, fast


@dataclass(frozen=True)
class BeamElements:
    """The elements of one beam, for strains."""

    lengths: np.ndarray  # (n,) unstressed lengths [m]
    # (2, n) direction of the unstressed beam less the angle of the nodes at both ends of each element [rad]
    offsets: np.ndarray
    outer: np.ndarray  # (n,) largest distance of the outer fibre from the centroid along each element [m]
    shear: np.ndarray  # (2, n) shares of the end rotations in the shear angle [1]
    bow: np.ndarray  # (3, n) shortening of the chords
    unstressed: np.ndarray  # (3, n) l0 [m], u10 and u20 [rad]; see `flexmb.elastic.beams.corotational`

    def strains(self, x: np.ndarray, y: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Largest strain (instants, n) of the outer fibres of each element, axial and bending strain added."""
        # Equation (2.12) of docs/theory/beam.md, u1 and u2 less those of the unstressed element. Poses x, y, theta of
        # the nodes are (instants, n + 1) [m, rad]. Source: as of `beams.corotational`.
        dx, dy, L = np.diff(x, axis=1), np.diff(y, axis=1), self.lengths
        chord = np.arctan2(dy, dx)
        u1 = wrapped(theta[:, :-1] + self.offsets[0] - chord)
        u2 = wrapped(theta[:, 1:] + self.offsets[1] - chord)
        b1, b2, b3 = self.bow
        free, free1, free2 = self.unstressed
        axial = (np.hypot(dx, dy) - free) / L + (b1 * u1 * u1 - b2 * u1 * u2 + b3 * u2 * u2) / 30.0
        u1, u2 = u1 - free1, u2 - free2
        sheared = self.shear[0] * u1 + self.shear[1] * u2
        u1, u2 = u1 - sheared, u2 - sheared
        bending = np.maximum(np.abs(4.0 * u1 + 2.0 * u2), np.abs(2.0 * u1 + 4.0 * u2)) / L
        return np.asarray(np.abs(axial) + bending * self.outer)


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


# Largest normal stress in the outer fibres of beams, and the node where it acts

COUNT, HEAD = range(2)
# Parameters p: number of elements. At HEAD, of each element: first coordinates of its ends, numbers of its nodes, 1/A
# and c/I at its start and end, and the parameters of the element.
START, END, START_NODE, END_NODE, START_AREA, START_MODULUS, END_AREA, END_MODULUS, OWN = range(9)
SIZE = OWN + PARAMETERS  # numbers of an element
six = stack_vector(6)


@fast
def end_stresses(p, at, q):
    """Largest normal stresses in the sections at the start and at the end of one element [Pa]."""
    first, last, ends = int(p[at + START]), int(p[at + END]), six()
    at_start, at_end = part_of(ends, 0, 3), part_of(ends, 3, 6)
    for i in range(3):
        at_start[i], at_end[i] = q[first + i], q[last + i]
    own = part_of(p, at + OWN, at + SIZE)
    _, _, _, e, u1, u2 = deformation(own, ends)
    N, m1, m2 = elastic(own, e, u1, u2, 0.0, 0.0, 0.0)
    first = abs(N) * p[at + START_AREA] + abs(m1) * p[at + START_MODULUS]
    return first, abs(N) * p[at + END_AREA] + abs(m2) * p[at + END_MODULUS]


@extremum_kernel
def beam_stress_kernel(p, t, q, v, a, least):
    """Largest normal stress of all elements [Pa], and the number of its node."""
    largest, where = -1.0, 0.0
    for k in range(int(p[COUNT])):
        at = HEAD + SIZE * k
        first, last = end_stresses(p, at, q)
        if not first <= largest:  # also what is not a number
            largest, where = first, p[at + START_NODE]
        if not last <= largest:
            largest, where = last, p[at + END_NODE]
    return largest, where
