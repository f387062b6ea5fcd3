"""Circular arcs and rings: a quarter ring, a pinched ring, the frequencies of a ring.

Quarter ring of radius R, clamped at one end, a small force P on the other one towards the centre: by Castigliano's
theorem the displacement along P is
    pi/4 P R^3/EI + pi/4 P R (1/EA + 1/(ks G A)),
that across it is P R^3/(2 EI) + P R/2 (1/(ks G A) - 1/EA), the rotation P R^2/EI.
Ring pulled apart by two forces P: it grows by (pi/4 - 2/pi) P R^3/EI along them and shrinks by (2/pi - 1/2) P R^3/EI
across.  Source of both: S. P. Timoshenko, Strength of Materials, part 1, 3rd ed., Van Nostrand 1955, sections 78 to 80.
Frequencies of a thin ring that does not stretch: omega sqrt(rho A R^4/EI) = n (n^2 - 1)/sqrt(n^2 + 1); source: R.
Hoppe, Vibrationen eines Ringes in seiner Ebene, Journal fuer die reine und angewandte Mathematik 73 (1871) 158-170.
"""

import math
from functools import cache

import numpy as np
from record import Curve, Problem, Value

import flexmb as fm

YOUNG, POISSON, DENSITY, FACTOR, WIDTH, RADIUS = 2.1e11, 0.3, 7850.0, 5.0 / 6.0, 0.1, 1.0
STEEL = fm.Material(young=YOUNG, density=DENSITY, poisson=POISSON)
RIGHT, TOP, LEFT, BOTTOM = CORNERS = ((RADIUS, 0.0), (0.0, RADIUS), (-RADIUS, 0.0), (0.0, -RADIUS))
GROWS, SHRINKS = 0.1487783910, 0.1366197724
RING = (2.68328157, 7.58946638, 14.55213750, 23.53393622)
THICK, THIN = 0.2, 1e-3
SMALL = 1e-5

PROBLEM = Problem(
    title="Arcs and rings",
    source="Timoshenko, Strength of Materials 1, 1955, sections 78 to 80; Hoppe 1871 (frequencies of a ring)",
    kind="exact",
    about="""Elements that are arcs in their unstressed shape. Thin arcs converge with the fourth power of the element
    length; what stretching and shear add, with the second. Forces are small, and displacements are half the difference
    of both signs. A ring is a frame of four arcs; it must move as a rigid body in three ways and be as stiff in every
    direction, so that its frequencies come in pairs.""",
)


def rigidities(height: float) -> tuple[float, float, float]:
    """EI [N m^2], EA [N], ks G A [N]."""
    area = WIDTH * height
    return YOUNG * area * height**2 / 12.0, YOUNG * area, FACTOR * YOUNG / (2.0 * (1.0 + POISSON)) * area


def quarter(height: float, elements: int) -> np.ndarray:
    """Displacements and rotation of the end over P: (along P, across, rotation)."""
    arc = fm.FlexibleLink(
        "arc", RIGHT, TOP, section=fm.Rectangle(WIDTH, height), material=STEEL, elements=elements, turn=0.5 * math.pi,
        shear=FACTOR,
    )  # fmt: skip
    clamp = fm.Fixed("clamp", fm.GROUND, arc, at=RIGHT)
    load = SMALL * rigidities(height)[0] / RADIUS**2

    def answer(sign):
        force = fm.Force("P", arc, at=TOP, force=(0.0, -sign * load))
        found = fm.static_equilibrium(fm.Mechanism("quarter", [arc, clamp, force]), load_steps=1)
        return np.array([-found["arc.end.y"], -found["arc.end.x"], found["arc.end.theta"]])

    return (answer(1.0) - answer(-1.0)) / (2.0 * load)


def quarter_exact(height: float) -> np.ndarray:
    """The same by Castigliano's theorem."""
    ei, ea, ga = rigidities(height)
    R = RADIUS
    along = 0.25 * math.pi * (R**3 / ei + R / ea + R / ga)
    return np.array([along, 0.5 * R**3 / ei + 0.5 * R * (1.0 / ga - 1.0 / ea), R**2 / ei])


def ring(height: float, elements: int) -> fm.FlexibleFrame:
    """A ring of four arcs."""
    edges = ((0, 1), (1, 2), (2, 3), (3, 0))
    section = fm.Rectangle(WIDTH, height)
    return fm.FlexibleFrame(
        "ring", CORNERS, edges, section=section, material=STEEL, elements=elements, turns=0.5 * math.pi
    )


def pulled(height: float, elements: int) -> tuple[float, float]:
    """Growth of the diameter along the forces and shrinking across them, over P R^3/EI."""
    body = ring(height, elements)
    held = fm.Fixed("held", fm.GROUND, body, at=BOTTOM)
    load = SMALL * rigidities(height)[0] / RADIUS**2

    def answer(sign):
        force = fm.Force("P", body, at=TOP, force=(0.0, sign * load))
        found = fm.static_equilibrium(fm.Mechanism("pulled", [body, held, force]), load_steps=1)
        return np.array([found["ring.node1.y"], found["ring.node2.x"] - found["ring.node0.x"]])

    along, across = (answer(1.0) - answer(-1.0)) / (2.0 * load) * rigidities(height)[0] / RADIUS**3
    return float(along), float(across)


@cache
def frequencies(elements: int) -> np.ndarray:
    """All frequencies of the thin ring but those of rigid motions, over sqrt(EI/(rho A R^4))."""
    modes = fm.modes(fm.Mechanism("ring", [ring(THIN, elements)]), count=11)
    ei, _, _ = rigidities(THIN)
    unit = math.sqrt(ei / (DENSITY * WIDTH * THIN * RADIUS**4)) / (2.0 * math.pi)
    assert [kind for kind in modes.frequencies[:3] if kind > 1e-3 * unit] == []
    return np.array(modes.frequencies[3:]) / unit


@PROBLEM.case("quarter ring, 32 elements")
def quarter_ring():
    names = ("displacement along P", "displacement across P", "rotation")
    for height, band in ((THIN, 1e-6), (THICK, 3e-6)):
        ei, _, _ = rigidities(height)
        units = (ei / RADIUS**3, ei / RADIUS**3, ei / RADIUS**2)
        for name, unit, reference, ours in zip(names, units, quarter_exact(height), quarter(height, 32), strict=True):
            yield Value(f"h/R = {height:g}: {name} over P R^{3 if name[0] == 'd' else 2}/EI", reference * unit,
                        ours * unit, band)  # fmt: skip


@PROBLEM.case("pulled ring, 4 x 16 elements")
def pulled_ring():
    along, across = pulled(THIN, 16)
    yield Value("growth along P over P R^3/EI", GROWS, along, 3e-6)
    yield Value("shrinking across P over P R^3/EI", SHRINKS, across, 3e-6)


@PROBLEM.case("thin ring, 4 x 32 elements")
def thin_ring():
    found = frequencies(32)
    for k, reference in enumerate(RING):
        for word, ours in zip(("first", "second"), found[2 * k : 2 * k + 2], strict=True):
            yield Value(f"omega sqrt(rho A R^4/EI), n = {k + 2}, {word} of a pair", reference, ours, 4e-6)


@PROBLEM.convergence("arcs", "Arcs and rings: relative error.", "turn of an element [rad]", "relative error", slow=True)
def elements():
    counts = (2, 4, 8, 16)
    turns = [0.5 * math.pi / n for n in counts]
    for height, order in ((THIN, 4.0), (THICK, 2.0)):
        errors = [abs(quarter(height, n)[0] / quarter_exact(height)[0] - 1.0) for n in counts]
        yield Curve(f"quarter ring, h/R = {height:g}", turns, errors, order)
    # of thinner rings; forces of 1e-5 EI/R^2 leave six digits
    yield Curve("pulled ring", turns, [abs(pulled(THIN, n)[0] / GROWS - 1.0) for n in counts], 4.0)
    for k in (0, 3):
        errors = [abs(frequencies(n)[2 * k] / RING[k] - 1.0) for n in (4, 8, 16)]
        yield Curve(f"ring, n = {k + 2}", [0.5 * math.pi / n for n in (4, 8, 16)], errors, 4.0, slack=0.15)


test_case, test_curves = PROBLEM.tests()
