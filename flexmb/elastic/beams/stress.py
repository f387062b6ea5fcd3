"""Largest stress of beams, and the node where it acts.

sigma = |N|/A + |M| c/I at both ends of every element, with the elastic axial force and end moments of the corotational
element, which are in balance with its nodes; c is the distance of the outer fibre.  The shear stress is left out: it is
zero in the outer fibres of the sections, where the normal stress is largest.
"""

from __future__ import annotations

import numpy as np

from flexmb.elastic.beams.corotational import PARAMETERS, deformation, elastic
from flexmb.elastic.beams.section import Section
from flexmb.engine.compiled.arrays import part_of, stack_vector
from flexmb.errors import InputError
from flexmb.kernels import extremum_kernel, fast


def outer_fibres(section: Section, stations: np.ndarray) -> np.ndarray:
    """Distance of the outer fibre from the centroid [m] at stations (n + 1,) along a beam, fractions of its length.

    0 where a section does not know its outer fibre: strains are then those of the axis.
    """
    try:
        fibres = np.asarray(section.outer_fibre_at(stations))
    except InputError:
        fibres = np.zeros_like(stations)
    return fibres


COUNT, HEAD = range(2)
START, END, START_NODE, END_NODE, START_AREA, START_MODULUS, END_AREA, END_MODULUS, OWN = range(9)
"""Parameters p: number of elements.  At HEAD, of each element: first coordinates of its ends, numbers of its nodes, 1/A
and c/I at its start and end, and the parameters of the element."""

SIZE = OWN + PARAMETERS
"""Numbers of an element."""

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
    return (
        abs(N) * p[at + START_AREA] + abs(m1) * p[at + START_MODULUS],
        abs(N) * p[at + END_AREA] + abs(m2) * p[at + END_MODULUS],
    )


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
