"""Natural frequencies of thick beams: shear and rotary inertia (Timoshenko).

w'' = V'/(ks G A) + psi',  with M = EI psi', V = ks G A (w' - psi), V' = -rho A omega^2 w, M' = -V - rho I omega^2 psi.
L = 1 m, E = 210 GPa, nu = 0.3, rho = 7850 kg/m^3, a square section of height h, ks = 5/6.
Source of the equations: S. P. Timoshenko, On the correction for shear of the differential equation for transverse
vibrations of prismatic bars, Philosophical Magazine 41 (1921) 744-746.  The frequencies are the roots of the exact
frequency equation, computed by an independent script; here they are held against the equation by the matrix exponential
of the four first-order equations.
"""

import math

import numpy as np
from record import Curve, Problem, Value
from scipy.linalg import expm
from scipy.optimize import brentq

import flexmb as fm

YOUNG, POISSON, DENSITY, FACTOR = 2.1e11, 0.3, 7850.0, 5.0 / 6.0
STEEL = fm.Material(young=YOUNG, density=DENSITY, poisson=POISSON)
CANTILEVER = {
    0.1: (82.89436269, 496.81453161, 1306.69807299, 2370.30840574),
    0.2: (162.05449578, 872.75950166, 2077.33247029, 3448.84397909),
}
FREE = {0.1: (513.48605606, 1335.67592773, 2436.33263598)}
ENDS = {"clamped-free": CANTILEVER, "free-free": FREE}
ELEMENTS = 2048

PROBLEM = Problem(
    title="Frequencies of thick beams (Timoshenko)",
    source="exact frequency equation of S. P. Timoshenko, Philosophical Magazine 41 (1921) 744-746",
    kind="exact; roots computed by an independent script",
    about="""Beams of length over height 10 and 5. In an element the shear force is constant, so the error of a
    frequency omega falls with the square of the element length l as soon as l is below the height:
    rho (omega l)^2/(24 ks G) of it, from above, less the share of rotary inertia in the kinetic energy (up to 9 %
    here).  Two meshes and Richardson's extrapolation leave 1e-7 and less.""",
)


def beam(ends: str, height: float, elements: int) -> fm.Mechanism:
    """The beam with shear and rotary inertia."""
    section = fm.Rectangle(width=height, height=height)
    link = fm.FlexibleLink(
        "beam", (0.0, 0.0), (1.0, 0.0), section=section, material=STEEL, elements=elements, shear=FACTOR
    )
    clamp = [fm.Fixed("clamp", fm.GROUND, link, at=(0.0, 0.0))] if ends == "clamped-free" else []
    return fm.Mechanism("beam", [link, *clamp])


def computed(ends: str, height: float, elements: int) -> np.ndarray:
    """The bending frequencies [Hz]; those of stretching, (2k - 1) c/4 or k c/2 with c = sqrt(E/rho), are left out."""
    wanted = len(ENDS[ends][height])
    modes = fm.modes(beam(ends, height, elements), count=wanted + 5)
    node = f"beam.node{elements}."
    across = [abs(modes.shape(k, node + "y")) > abs(modes.shape(k, node + "x")) for k in range(len(modes.frequencies))]
    found = np.array([f for f, bends in zip(modes.frequencies, across, strict=True) if bends and f > 1.0])
    return found[:wanted]


def equation(frequency: float, ends: str, height: float) -> float:
    """Determinant that vanishes at a natural frequency [Hz]: two forces (or w and psi) of the end by the start."""
    omega, area, second = 2.0 * math.pi * frequency, height**2, height**4 / 12.0
    shear, bending = FACTOR * YOUNG / (2.0 * (1.0 + POISSON)) * area, YOUNG * second
    slopes = np.zeros((4, 4))  # of w, psi, M, V
    slopes[0, 1], slopes[0, 3], slopes[1, 2] = 1.0, 1.0 / shear, 1.0 / bending
    slopes[2, 1], slopes[2, 3], slopes[3, 0] = -DENSITY * second * omega**2, -1.0, -DENSITY * area * omega**2
    start = [2, 3] if ends == "clamped-free" else [0, 1]
    scale = np.diag([1.0, 1.0, 1.0 / bending, 1.0 / bending])
    return float(np.linalg.det((scale @ expm(slopes) @ np.linalg.inv(scale))[np.ix_([2, 3], start)]))


def cases():
    return [(ends, height) for ends, heights in ENDS.items() for height in heights]


@PROBLEM.case("the digits in the frequency equation")
def digits():
    for ends, height in cases():
        for k, reference in enumerate(ENDS[ends][height], 1):
            root = brentq(equation, 0.9999 * reference, 1.0001 * reference, (ends, height), xtol=1e-12, rtol=1e-14)
            yield Value(f"{ends}, h = {height:g} m: f{k} [Hz]", reference, root, 1e-9)


@PROBLEM.case("2048 elements", slow=True)
def refined():
    for ends, height in cases():
        found = computed(ends, height, ELEMENTS)
        for k, (reference, ours) in enumerate(zip(ENDS[ends][height], found, strict=True), 1):
            yield Value(f"{ends}, h = {height:g} m: f{k} [Hz]", reference, ours, 1e-6)


@PROBLEM.case("64 and 128 elements, extrapolated")
def extrapolated():
    for ends, height in cases():
        coarse, fine = (computed(ends, height, n) for n in (64, 128))
        for k, reference in enumerate(ENDS[ends][height], 1):
            ours = (4.0 * fine[k - 1] - coarse[k - 1]) / 3.0
            yield Value(f"{ends}, h = {height:g} m: f{k} [Hz]", reference, ours, 1e-7)


@PROBLEM.case("error of the elements, 64 elements")
def predicted():
    """rho (omega l)^2/(24 ks G), as `about` says."""
    for ends, height in cases():
        found = computed(ends, height, 64)
        for k, (reference, ours) in enumerate(zip(ENDS[ends][height], found, strict=True), 1):
            wave = 2.0 * math.pi * reference / 64.0
            expected = DENSITY * wave**2 * 2.0 * (1.0 + POISSON) / (24.0 * FACTOR * YOUNG)
            yield Value(f"{ends}, h = {height:g} m: error of f{k}", expected, ours / reference - 1.0, 0.1)


@PROBLEM.convergence(
    "timoshenko", "Thick cantilevers: error of the frequencies.", "element length / L", "relative error"
)
def elements():
    counts = (16, 32, 64, 128)
    for height, references in CANTILEVER.items():
        found = np.array([computed("clamped-free", height, n) for n in counts])
        for k, reference in enumerate(references):
            errors = np.abs(found[:, k] / reference - 1.0)
            yield Curve(f"h = {height:g} m, f{k + 1}", [1.0 / n for n in counts], list(errors), order=2.0)


test_case, test_curves = PROBLEM.tests()
