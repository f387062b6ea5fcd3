"""Bodies with shear and arcs: rigid motion, momenta and energy in flight, buckling with shear, tapered thick beams."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError

SOFT = fm.Material(young=2e8, density=2000.0, poisson=0.3)
STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
TAPER = fm.Tapered(fm.Rectangle(0.02, 0.08), fm.Rectangle(0.02, 0.04))
O, X = (0.0, 0.0), (1.0, 0.0)


def link(**options):
    return fm.FlexibleLink("arm", O, X, **{"section": TAPER, "material": SOFT, "elements": 4, **options})


def hook(**options):
    """A frame of a straight beam, an arc and a corner."""
    points, edges = ((0.0, 0.0), (0.5, 0.0), (0.7, 0.2), (0.4, 0.4)), ((0, 1), (1, 2), (2, 3))
    return fm.FlexibleFrame(
        "arm", points, edges, section=TAPER, material=SOFT, elements=2, turns=(0.0, 0.5 * math.pi, -1.0), **options
    )


BODIES = {
    "shear": link(shear=True), "arc": link(turn=1.5), "arc with shear": link(turn=-1.5, shear=5.0 / 6.0),
    "damped": link(turn=1.5, shear=True, damping=1e-3, mass_damping=3.0), "frame": hook(shear=True),
}  # fmt: skip


@pytest.mark.parametrize("name", BODIES)
def test_a_body_turned_hundreds_of_times_has_no_internal_force(name):
    system = StateEvaluation(fm.compile(fm.Mechanism("free", (BODIES[name],))))
    drawn = system.program.reference.q.reshape(-1, 3)
    for turn in np.linspace(0.0, 2.0 * math.pi * 300, 301) + 0.1:
        c, s = math.cos(turn), math.sin(turn)
        moved = drawn @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + np.array([5.0, -4.0, turn])
        assert np.abs(system.at(moved.ravel()).force).max() < 1e-9 * 2e8 * 1.6e-3


@pytest.mark.parametrize("name", BODIES)
def test_rigid_properties_are_those_of_the_mass_matrix(name):
    """Mass, centre and inertia of the declaration against rigid motions in the mass matrix."""
    body = BODIES[name]
    system = StateEvaluation(fm.compile(fm.Mechanism("free", (body,))))
    q = np.array(system.program.reference.q)
    M, found = system.mass(q), body.properties()
    x, y, spin = np.zeros_like(q), np.zeros_like(q), np.ones_like(q)
    x[0::3], y[1::3] = 1.0, 1.0
    spin[0::3], spin[1::3] = -q[1::3], q[0::3]
    assert x @ M @ x == pytest.approx(found.mass, rel=1e-12)
    assert -(x @ M @ spin) / found.mass == pytest.approx(found.centre[1], rel=1e-10, abs=1e-12)
    assert y @ M @ spin / found.mass == pytest.approx(found.centre[0], rel=1e-10)
    about_origin = found.inertia + found.mass * (found.centre[0] ** 2 + found.centre[1] ** 2)
    assert spin @ M @ spin == pytest.approx(about_origin, rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in BODIES if name != "damped"])
def test_energy_of_a_swinging_body_is_kept(name):
    """Radau's method at 1e-9: what is lost of kinetic, strain and potential energy; the bodies bend by a tenth."""
    body = BODIES[name]
    pin = fm.Revolute("O", fm.GROUND, body, at=O)
    sol = fm.simulate(
        fm.Mechanism("pendulum", [body, pin], gravity=(0.0, -60.0)),
        t_end=0.4,
        method=fm.RadauIIA(),
        step=fm.Adaptive(rtol=1e-9),
    )
    assert sol.ok
    kinetic, strain, potential = (sol[f"energy.{kind}"] for kind in ("kinetic", "strain", "gravity"))
    total = kinetic + strain + potential
    assert strain.max() > 1e-3 * kinetic.max()
    assert np.abs(total - total[0]).max() < 1e-7 * kinetic.max()


def test_damping_takes_what_the_energies_lose():
    pin = fm.Revolute("O", fm.GROUND, BODIES["damped"], at=O)
    mech = fm.Mechanism("pendulum", [BODIES["damped"], pin], gravity=(0.0, -60.0))
    sol = fm.simulate(mech, t_end=0.4, method=fm.RadauIIA(), step=fm.Adaptive(rtol=1e-8))
    total = sum(sol[f"energy.{kind}"] for kind in ("kinetic", "strain", "gravity"))
    lost = float(total[0] - total[-1])
    assert lost > 1e-3 * sol["energy.kinetic"].max()
    assert float(sol["energy.dissipated_damping"][-1]) == pytest.approx(lost, rel=1e-4)


@pytest.mark.parametrize("height", [pytest.param(0.05, marks=pytest.mark.slow), 0.1])
def test_a_column_with_shear_buckles_at_reissners_load(height):
    """P + P^2 (1/(ks G A) - 1/(E A)) = pi^2 EI/L^2 for pinned ends.

    Source: E. Reissner, Some remarks on the problem of column buckling, Ingenieur-Archiv 52 (1982) 115-119.  Engesser's
    formula P = P_E/(1 + P_E/(ks G A)) would be lower by the share of stretching, 2 EI pi^2/(EA L^2), and more.
    """
    area, section = height**2, fm.Rectangle(height, height)
    euler, shear = math.pi**2 * 2.1e11 * height**4 / 12.0, 13.0 / 15.3 * 2.1e11 / 2.6 * area
    column = fm.FlexibleLink("column", O, X, section=section, material=STEEL, elements=32, shear=True)
    head = fm.RigidBody("head", X, mass=1e-6, inertia=1e-6)
    joints = [
        fm.Revolute("foot", fm.GROUND, column, at=O),
        fm.Revolute("top", column, head, at=X),
        fm.Prismatic("guide", fm.GROUND, head, at=X, along=(1.0, 0.0)),
    ]

    def squared(share):
        push = fm.Force("P", head, at=X, force=(-share * euler, 0.0))
        mech = fm.Mechanism("column", [column, head, *joints, push])
        return fm.modes(mech, count=1, at=fm.static_equilibrium(mech, load_steps=1)).frequencies[0] ** 2

    a, b = 0.8, 0.9  # the square of the frequency is nearly linear in the load
    fa, fb = squared(a), squared(b)
    for _ in range(6):
        a, fa, b = b, fb, b - fb * (b - a) / (fb - fa)
        fb = squared(b)
        if abs(a - b) < 1e-10:
            break
    expected = brentq(lambda p: p + p**2 * euler * (1.0 / shear - 1.0 / (2.1e11 * area)) - 1.0, 0.5, 1.0)
    assert b == pytest.approx(expected, rel=2e-5)
    assert abs(b / (1.0 / (1.0 + euler / shear)) - 1.0) > 50.0 * abs(b / expected - 1.0)


def test_frequencies_of_a_tapered_thick_cantilever():
    """Against shooting on Timoshenko's equations with variable sections; second order, extrapolated."""
    section, G, rho = fm.Tapered(fm.Rectangle(0.1, 0.3), fm.Rectangle(0.1, 0.15)), 2.1e11 / 2.6, 7850.0

    def at_the_tip(frequency):
        omega = 2.0 * math.pi * frequency

        def slopes(x, y):
            w, psi, M, V = y[:4] + 0.0, y[4:8], y[8:12], y[12:]
            area, second = float(section.area_at(x)), float(section.second_moment_at(x))
            force = V / (5.0 / 6.0 * G * area)
            return np.concatenate(
                [psi + force, M / (2.1e11 * second), -V - rho * second * omega**2 * psi, -rho * area * omega**2 * w]
            )

        start = np.zeros((4, 4))
        start[2, 0], start[3, 1] = 2.1e11 * 1e-4, G * 1e-2
        end = solve_ivp(slopes, (0.0, 1.0), start.ravel(), method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
        M, V = end.reshape(4, 4)[2:, :2]
        return M[0] * V[1] - M[1] * V[0]

    def computed(elements):
        beam = fm.FlexibleLink("beam", O, X, section=section, material=STEEL, elements=elements, shear=5.0 / 6.0)
        clamp = fm.Fixed("clamp", fm.GROUND, beam, at=O)
        return np.array(fm.modes(fm.Mechanism("beam", [beam, clamp]), count=2).frequencies)

    coarse, middle, fine = (computed(n) for n in (16, 32, 64))
    found = (4.0 * fine - middle) / 3.0
    exact = [brentq(at_the_tip, 0.99 * f, 1.01 * f, xtol=1e-9) for f in found]
    np.testing.assert_allclose(found, exact, rtol=1e-7)
    orders = np.log2((coarse - exact) / (fine - exact)) / 2.0
    assert orders.min() > 1.9


@pytest.mark.parametrize("slenderness", [50.0, 100.0, 200.0, 400.0])
def test_thin_beams_vibrate_as_without_shear(slenderness):
    """f/f0 = 1 - c (h/L)^2: shear and rotary inertia fade with the square of the height; c as at 50 to 2 %."""

    def first(shear, height):
        beam = fm.FlexibleLink(
            "beam", O, X, section=fm.Rectangle(0.1, height), material=STEEL, elements=16, shear=shear
        )
        clamp = fm.Fixed("clamp", fm.GROUND, beam, at=O)
        return float(fm.modes(fm.Mechanism("beam", [beam, clamp]), count=1).frequencies[0])

    share = [(1.0 - first(True, 1.0 / s) / first(False, 1.0 / s)) * s**2 for s in (50.0, slenderness)]
    assert share[0] > 0.5
    assert share[1] == pytest.approx(share[0], rel=0.02)


def test_static_arcs_of_many_elements_have_no_force_at_rest():
    ring = fm.FlexibleFrame(
        "ring", ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)), ((0, 1), (1, 2), (2, 3), (3, 0)),
        section=fm.Rectangle(0.1, 0.02), material=STEEL, elements=50, turns=0.5 * math.pi, shear=True,
    )  # fmt: skip
    clamp = fm.Fixed("clamp", fm.GROUND, ring, at=(1.0, 0.0))
    found = fm.static_equilibrium(fm.Mechanism("ring", [ring, clamp]))
    nodes = {node.name: node for node in ring.nodes()}
    worst = max(abs(found[f"ring.{n}.{axis}"] - getattr(nodes[n], axis)) for n in nodes for axis in ("x", "y", "theta"))
    assert worst < 1e-12


def test_stubby_beams_with_shear_are_no_finding():
    for shear, codes in ((False, {"stubby-beam"}), (True, set())):
        block = fm.FlexibleLink("block", O, X, section=fm.Rectangle(0.1, 0.3), material=STEEL, shear=shear)
        report = fm.check(fm.Mechanism("block", [block, fm.Fixed("clamp", fm.GROUND, block, at=O)]))
        assert {finding.code for finding in report.findings} & {"stubby-beam"} == codes


def test_a_general_section_without_shear_factor_names_the_frame():
    section = fm.GeneralSection(area=1e-2, second_moment=1e-5)
    with pytest.raises(
        InputError, match="FlexibleFrame 'frame': shear is True, and GeneralSection: shear_factor is None"
    ):
        fm.FlexibleFrame("frame", (O, X), ((0, 1),), section=(section,), material=STEEL, shear=True)
