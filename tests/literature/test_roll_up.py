"""A clamped beam that an end moment rolls up: M = 2 pi EI/L closes it to a circle.

The curvature is M/EI everywhere, so the point s is at
    theta = s M/EI,  x = EI/M sin(theta),  y = EI/M (1 - cos(theta)).
Source of the test: K. J. Bathe, S. Bolourchi, Large displacement analysis of three-dimensional beam structures,
International Journal for Numerical Methods in Engineering 14 (1979) 961-986.
"""

import math

import numpy as np
from record import Curve, Problem, Value

import flexmb as fm
from flexmb.mechanisms.cantilever import cantilever

LENGTH, WIDTH, HEIGHT, YOUNG = 1.0, 0.01, 0.005, 2.0e11
EI = YOUNG * WIDTH * HEIGHT**3 / 12.0

PROBLEM = Problem(
    title="Roll-up of a cantilever",
    source="K. J. Bathe, S. Bolourchi, Int. J. Numerical Methods in Engineering 14 (1979) 961-986.",
    kind="exact",
    about="""A moment on the tip of a clamped beam bends it to an arc; 2 pi EI/L closes the circle, twice that rolls the
    beam up two turns. The rotations are exact with any number of elements, and so is the closing, because the nodes
    form a regular polygon. What converges is the size of that polygon.""",
)


def rolled(turns: float, elements: int) -> np.ndarray:
    """(elements + 1, 3) places [m] and rotations [rad] of the nodes."""
    section, material = fm.Rectangle(width=WIDTH, height=HEIGHT), fm.Material(young=YOUNG, density=7850.0)
    mech = cantilever(LENGTH, section, material, elements=elements, moment=2.0 * math.pi * turns * EI / LENGTH)
    found = fm.static_equilibrium(mech, load_steps=max(10, math.ceil(20 * turns)))
    return np.array([[found[f"beam.node{i}.{c}"] for c in ("x", "y", "theta")] for i in range(elements + 1)])


def circle(turns: float, s: np.ndarray) -> np.ndarray:
    """The same, exact, at the points s [m]."""
    radius = LENGTH / (2.0 * math.pi * turns)
    theta = s / radius
    return np.column_stack([radius * np.sin(theta), radius * (1.0 - np.cos(theta)), theta])


def distance(turns: float, elements: int) -> float:
    """Largest distance of a node from its exact place [m]."""
    gap = rolled(turns, elements) - circle(turns, np.linspace(0.0, LENGTH, elements + 1))
    return float(np.hypot(gap[:, 0], gap[:, 1]).max())


@PROBLEM.case("16 elements")
def sixteen():
    x, y, theta = rolled(1.0, 16)[-1]
    yield Value("closed circle: distance of tip and clamp over L", 0.0, math.hypot(x, y) / LENGTH, 1e-3, scale=1.0)
    yield Value("closed circle: angle of the tip [rad]", 2.0 * math.pi, theta, 1e-10, scale=1.0)
    # the chord of an arc of angle a is shorter than an element by (a/2)^4/120 of itself: 1.2e-5 of the radius' 1/pi
    yield Value("closed circle: largest distance of a node from it over L", 0.0, distance(1.0, 16) / LENGTH, 1e-5, 1.0)
    for turns in (0.125, 0.25, 0.5, 0.75):
        exact = circle(turns, np.array([LENGTH]))[0]
        tip = rolled(turns, 16)[-1]
        for k, name in enumerate("xy"):
            yield Value(
                f"{turns:g} turns: {name} of the tip over L", exact[k] / LENGTH, tip[k] / LENGTH, 1e-3, scale=1.0
            )
        yield Value(f"{turns:g} turns: angle of the tip [rad]", exact[2], tip[2], 1e-10, scale=1.0)


@PROBLEM.case("32 elements", slow=True)
def two_turns():
    x, y, theta = rolled(2.0, 32)[-1]
    yield Value("two turns: distance of tip and clamp over L", 0.0, math.hypot(x, y) / LENGTH, 1e-3, scale=1.0)
    yield Value("two turns: angle of the tip [rad]", 4.0 * math.pi, theta, 1e-10, scale=1.0)


@PROBLEM.convergence(
    "roll_up", "Roll-up: largest distance of a node from the circle.", "element length / L", "distance / L", slow=True
)
def elements():
    counts = (8, 16, 32, 64)
    for turns in (0.25, 0.5, 1.0):
        errors = [distance(turns, n) / LENGTH for n in counts]
        yield Curve(f"{turns:g} turns", [1.0 / n for n in counts], errors, order=4.0)


@PROBLEM.picture("roll_up_shapes", "Roll-up with 16 elements (dots: nodes); thin lines: exact arcs.")
def shapes(figure):
    ax = figure.add_subplot(aspect="equal")
    for turns in (0.125, 0.25, 0.5, 0.75, 1.0):
        x, y, _ = rolled(turns, 16).T
        (line,) = ax.plot(x, y, ".", markersize=7, label=f"{turns:g} turns")
        x, y, _ = circle(turns, np.linspace(0.0, LENGTH, 200)).T
        ax.plot(x, y, color=line.get_color(), linewidth=0.8)
    ax.set(xlabel="x / L", ylabel="y / L")
    ax.legend()


test_case, test_curves = PROBLEM.tests()
