"""Follower forces: Beck's column and the cantilever whose transverse end force turns with its tip.

Column: a cantilever under a thrust P that stays tangential to its tip.  It has no other equilibrium than the straight
one, whatever P; it is lost to flutter where two frequencies of the loaded column meet, at P L^2/(EI) = 20.05.  The
matrices K, M of the compressed column come from `StateEvaluation` (`engine/system/state_evaluation.py`); K is not
symmetric.

Cantilever: a force P that stays normal to the tip.  The elastica EI theta'' = -P cos(theta_L - theta) in the arc
length is a pendulum equation whose values at the tip are known (theta = theta_L, theta' = 0), so it is integrated from
there without iteration, here with an explicit method of order 8 at 1e-12.
"""

import math

import numpy as np
import scipy.linalg as la
from record import Curve, Problem, Value
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation

LENGTH = 1.0  # [m]
BAR = fm.Rectangle(width=0.01, height=0.0003)  # so slender that its shortening is below 2e-7 of the length
MATERIAL = fm.Material(young=2e11, density=8000.0)
EI = 2e11 * 0.01 * 0.0003**3 / 12.0  # [N m^2]
LINE_MASS = 8000.0 * 0.01 * 0.0003  # [kg/m]

PROBLEM = Problem(
    title="Follower forces: Beck's column, cantilever with a force normal to its tip",
    source=(
        "M. Beck, Die Knicklast des einseitig eingespannten, tangential gedrueckten Stabes, ZAMP 3 (1952) 225-228; "
        "the cantilever is a problem of J. H. Argyris, Sp. Symeonidis, Nonlinear finite element analysis of elastic "
        "systems under nonconservative loading, Comp. Meth. Appl. Mech. 26 (1981) 75-123; the reference is the elastica"
    ),
    kind="published (20.05), exact (frequency equation, elastica)",
    about=(
        "The load of flutter of a column under a tangential thrust tests the non-symmetric tangent and the geometric "
        "stiffness together with the mass; the cantilever tests large rotations, its tip turning by up to 170 degrees."
    ),
)


def cantilever(force, elements):
    """A beam along x, clamped at the origin, with a follower force on its tip."""
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (LENGTH, 0.0), section=BAR, material=MATERIAL, elements=elements)
    clamp = fm.Fixed("clamp", fm.GROUND, beam, at=(0.0, 0.0))
    load = fm.Force("thrust", beam, at=(LENGTH, 0.0), force=force, follower=True)
    return fm.Mechanism("cantilever", [beam, clamp, load], gravity=(0.0, 0.0))


def squares(load, elements):
    """The two lowest omega^2 over EI/(m L^4), complex beyond flutter, of the column under load EI/L^2."""
    mechanism = cantilever((-load * EI / LENGTH**2, 0.0), elements)
    found = fm.static_equilibrium(mechanism, load_steps=1)
    system = StateEvaluation(fm.compile(mechanism))
    M = system.mass(found.q).toarray()
    K = system.at(found.q, lam=found.lam, weights=(1.0, 0.0, 0.0)).block().toarray()
    free = la.null_space(system.jacobian.toarray())
    values = la.eigvals(free.T @ K @ free, free.T @ M @ free)
    return np.sort_complex(values)[:2] * LINE_MASS * LENGTH**4 / EI


def flutter(elements):
    """The load over EI/L^2 at which the two lowest frequencies meet: their discriminant changes its sign."""

    def discriminant(load):
        one, other = squares(load, elements)
        return float(((one - other) ** 2).real)

    return brentq(discriminant, 15.0, 25.0, xtol=1e-10, rtol=1e-12)


def frequency_equation(load, w):
    """Beck's determinant for w = omega L^2 sqrt(m/EI); it vanishes at the natural frequencies."""
    root = math.sqrt(load**2 / 4.0 + w**2)
    a, b = math.sqrt(root - load / 2.0), math.sqrt(root + load / 2.0)
    both = load * w * math.sinh(a) * math.sin(b)
    return load**2 + 2.0 * w**2 + both + 2.0 * w**2 * math.cosh(a) * math.cos(b)


def exact_flutter():
    """The load at which two roots of the frequency equation meet: its least value over w between them is zero."""

    def least(load):
        w = np.linspace(8.0, 14.0, 4001)
        k = int(np.argmin([frequency_equation(load, x) for x in w]))
        a, b, c = (frequency_equation(load, x) for x in w[k - 1 : k + 2])
        return b - (c - a) ** 2 / (8.0 * (a - 2.0 * b + c))  # vertex of the parabola through three points

    return brentq(least, 19.0, 21.0, xtol=1e-10)


@PROBLEM.case("Beck's column, 12 elements")
def beck():
    load = flutter(12)
    yield Value("flutter load P L^2/EI, published", 20.05, load, 2.5e-4)
    yield Value("flutter load P L^2/EI, frequency equation", exact_flutter(), load, 5e-5)
    below, above = squares(0.99 * load, 12), squares(1.01 * load, 12)
    yield Value("growth below [1]", 0.0, float(np.abs(below.imag).max()), 1e-6, scale=1.0)
    yield Value("frequencies that meet [1]", float(above[0].real), float(above[1].real), 1e-9)


@PROBLEM.convergence(
    "beck", "Beck's column: error of the flutter load over the length of an element.", x="L_e/L", y="relative error"
)
def beck_curve():
    exact, counts = exact_flutter(), (4, 6, 8, 12, 16)
    yield Curve("flutter load", [1.0 / n for n in counts], [abs(flutter(n) / exact - 1.0) for n in counts], 4.0, 0.2)


def elastica(load):
    """Tip (x, y) [m] and its direction [rad] under load EI/L^2 normal to the tip, exactly."""

    def along(s, state):
        """From the tip inwards, in the axes of the tip: x, y, theta, curvature."""
        _, _, theta, curvature = state
        return [-math.cos(theta), -math.sin(theta), -curvature, load * math.cos(theta)]

    end = solve_ivp(along, (0.0, LENGTH), (0.0, 0.0, 0.0, 0.0), "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    x, y, theta, _ = end  # of the clamp
    c, s = math.cos(-theta), math.sin(-theta)
    return -c * x + s * y, -s * x - c * y, -theta


@PROBLEM.case("force normal to the tip, 32 elements")
def normal_force():
    for load in (2.0, 5.0, 10.0, 20.0, 40.0):
        found = fm.static_equilibrium(cantilever((0.0, load * EI / LENGTH**2), 32))
        x, y, theta = elastica(load)
        yield Value(f"x of the tip [m], P = {load:g} EI/L^2", x, found["beam.end.x"], 5e-6, scale=LENGTH)
        yield Value(f"y of the tip [m], P = {load:g} EI/L^2", y, found["beam.end.y"], 5e-6, scale=LENGTH)
        yield Value(f"rotation of the tip [rad], P = {load:g} EI/L^2", theta, found["beam.end.theta"], 5e-6)


@PROBLEM.picture("follower", "Cantilever under a force normal to its tip, P L^2/EI = 0, 2, 5, 10, 20, 40.")
def draw(figure):
    axes = figure.subplots()
    for load in (0.0, 2.0, 5.0, 10.0, 20.0, 40.0):
        found = fm.static_equilibrium(cantilever((0.0, load * EI / LENGTH**2), 32))
        nodes = [(found[f"beam.node{k}.x"], found[f"beam.node{k}.y"]) for k in range(33)]
        axes.plot(*np.transpose(nodes), label=f"{load:g}")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.legend(title="P L^2/EI")


test_case, test_curves = PROBLEM.tests()
