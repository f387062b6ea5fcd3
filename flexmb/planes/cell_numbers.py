"""Places of the numbers p of a plane cell's kernels, in the order in which they lie.

Head (below); places X of the nodes (m, 2), axes of the mesh [m]; mass matrix (m, m) [kg]; numbers of the formulation;
for a cell with nodes on pins four numbers a node: its first coordinate, 1 if it lies on a pin, its arm from the pin.
"""

from flexmb.compiled.stack import stack_vector
from flexmb.kernels import fast

NODES, PINS, FORMULATION, ZETA, GRAVITY_X, GRAVITY_Y, PLACES = range(7)
"""Head: number of nodes m, number of pins, formulation, damping time [s], gravity [m/s^2]; PLACES begins the places."""

COROTATED, TOTAL_LAGRANGE = 0.0, 1.0
"""Formulations."""

MOST_NODES = 9
"""Nodes of the largest cell."""

MOST, MOST_COORDINATES = 2 * MOST_NODES, 3 * MOST_NODES
"""Displacements of the largest cell, and its coordinates if every node lies on its own pin."""

nodal, on_every_coordinate, square = stack_vector(MOST), stack_vector(MOST_COORDINATES), stack_vector(MOST * MOST)
"""Scratch vectors of the kernels: a number a displacement, a coordinate, a pair of displacements."""

FIRST, ON_PIN, ARM_X, ARM_Y, TIE = range(5)
"""Numbers of the tie of a node; TIE is their count."""


@fast
def mass_at(p):
    """Place of the mass matrix."""
    return PLACES + 2 * int(p[NODES])


@fast
def formulation_at(p):
    """Place of the numbers of the formulation."""
    m = int(p[NODES])
    return PLACES + 2 * m + m * m


@fast
def tie_at(p, k):
    """Place of the tie of node k of a cell with pins."""
    return p.shape[0] - TIE * (int(p[NODES]) - k)
