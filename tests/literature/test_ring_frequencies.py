"""Vibrations of a ring in its plane, meshed with each kind of cell: order of convergence in the size of the cells."""

from functools import lru_cache

from record import Curve, Problem, Value

import flexmb as fm
from flexmb.elastic.planes.cells import matrices
from flexmb.elastic.planes.pins import Interface, tie
from flexmb.elastic.planes.plane_body import vibrations

INNER, OUTER = 0.05, 0.2
STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
FREE, HELD = 4335.185703, 1955.765099
"""Lowest frequency of the free ring (two waves), and of the ring held at its hole (torsion) [Hz]."""

ORDERS = {"tri3": 2.0, "quad4": 2.0, "tri6": 4.0, "quad9": 4.0}

PROBLEM = Problem(
    title="Frequencies of a ring in its plane",
    source="A. W. Leissa, M. S. Qatu, Vibrations of Continuous Systems, McGraw-Hill 2011",
    kind=(
        "exact: roots of the determinant of Bessel functions for plane stress, found to ten digits in "
        "`tests/planes/test_vibrations.py`"
    ),
    about=(
        "A steel ring with radii of 50 and 200 mm, free, or with its hole held by a rigid pin. Cells of second order "
        "have curved edges, and converge with the fourth power of their size; linear ones with the square."
    ),
)


@lru_cache(maxsize=16)
def frequencies(kind, size):
    """Lowest frequencies of the free and of the held ring [Hz], and the number of nodes."""
    mesh = fm.meshes.ring(INNER, OUTER, size, kind)
    body = matrices(mesh, STEEL, 0.01)
    hub = tie([Interface("hub", mesh.sets["inner"], (0.0, 0.0))], mesh)
    return vibrations(body, 1)[0][0], vibrations(body, 1, hub, ["hub"])[0][0], len(mesh.points)


def values(kind, size, band):
    free, held, _ = frequencies(kind, size)
    return [Value("free, two waves [Hz]", FREE, free, band), Value("hole held, torsion [Hz]", HELD, held, band)]


@PROBLEM.case("quad9, 10 mm")
def quad9():
    return values("quad9", 0.01, 5e-5)


@PROBLEM.case("tri6, 10 mm")
def tri6():
    return values("tri6", 0.01, 8e-5)


@PROBLEM.case("quad9, 5 mm, 30,744 nodes", slow=True)
def fine_quad9():
    return values("quad9", 0.005, 4e-6)


@PROBLEM.convergence("ring", "Lowest frequency of the free ring against the exact one", "size of a cell [m]",
                     "relative error [1]", slow=True)  # fmt: skip
def sizes():
    curves = []
    for kind, order in ORDERS.items():
        used = (0.01, 0.007, 0.005)
        errors = [frequencies(kind, size)[0] / FREE - 1.0 for size in used]
        curves.append(Curve(kind, used, errors, order, slack=0.25))
    return curves


test_case, test_curves = PROBLEM.tests()
