"""Mass-proportional damping: no rigid motion is damped, forces balance, powers and ratios are the exact ones."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import flexmb as fm
from flexmb.elastic.beams.mass_damping import mass_damping_kernel
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.run.run import Run
from flexmb.statics.start.consistent import Start, accelerations

LENGTH, WIDTH, HEIGHT, YOUNG, DENSITY = 0.8, 0.02, 0.008, 2.0e11, 7850.0
SECTION, STEEL = fm.Rectangle(width=WIDTH, height=HEIGHT), fm.Material(young=YOUNG, density=DENSITY)
RHO_A, EI = DENSITY * WIDTH * HEIGHT, YOUNG * WIDTH * HEIGHT**3 / 12.0
ZETA1 = 7.0
ANGLE = 0.7


def link(elements=4, angle=0.0, **options):
    end = (LENGTH * math.cos(angle), LENGTH * math.sin(angle))
    given = {"section": SECTION, "material": STEEL, "elements": elements, "mass_damping": ZETA1, **options}
    return fm.FlexibleLink("beam", (0.0, 0.0), end, **given)


def frame(**options):
    """An angle: an arm along X of the frame, a post of 0.5 m along Y, both turned by ANGLE."""
    c, s = math.cos(ANGLE), math.sin(ANGLE)
    given = {"section": SECTION, "material": STEEL, "elements": 3, "mass_damping": ZETA1, **options}
    return fm.FlexibleFrame("angle", ((0.0, 0.0), (0.4 * c, 0.4 * s), (-0.5 * s, 0.5 * c)), ((0, 1), (0, 2)), **given)


def triangle():
    points = ((0.0, 0.0), (0.4, 0.05), (0.1, 0.3))
    given = {"section": SECTION, "material": STEEL, "elements": 2, "mass": 4.0, "inertia": 0.105, "mass_damping": ZETA1}
    return fm.FlexibleFrame("triangle", points, ((0, 1), (1, 2), (2, 0)), **given)


BODIES = {
    "link": link(3, ANGLE, mass=2.0, inertia=0.24, pivot_inertia=1e-3),
    "one element": link(1, ANGLE),
    "angle": frame(),
    "triangle": triangle(),
}


def damping_pieces(body):
    contributions = body.contributions(fm.Mechanism("alone", (body,)))
    return [
        contribution for contribution in contributions if getattr(contribution, "kernel", None) is mass_damping_kernel
    ]


def drawn(body):
    return np.array([(n.x, n.y, n.theta) for n in body.nodes()])


def evaluate(body, q, v):
    """Force (nodes, 3) of all damping, its power by the kernel of energy, size of the forces that add up."""
    row = {n.name: 3 * i for i, n in enumerate(body.nodes())}
    force, power, size = np.zeros(q.size), 0.0, 0.0
    for contribution in damping_pieces(body):
        dofs = [row[node] + axis for _, node, axis in contribution.coordinates]
        n = len(dofs)
        r, matrices, empty = np.zeros(n), [np.zeros((n, n)) for _ in "KCM"], np.zeros(0)
        p = np.array(contribution.p)
        x, x_dot = q.ravel()[dofs], v.ravel()[dofs]
        mass_damping_kernel.python(p, 0.0, 0.0, x, x_dot, np.zeros(n), empty, r, *matrices, empty)
        np.add.at(force, dofs, r)
        size = max(size, float((np.abs(matrices[1]) @ np.abs(x_dot)).max()))
        strain, gravity, watts = contribution.energy.python(p, 0.0, x, x_dot)
        assert strain == gravity == 0.0
        power += watts
    return force.reshape(-1, 3), power, size


def turning(q, vx, vy, omega):
    """Velocities of a rigid motion of the body as it is."""
    return np.stack([vx - omega * q[:, 1], vy + omega * q[:, 0], np.full(len(q), omega)], axis=1)


def bent(body, seed):
    """A strongly deformed, turned and shifted body."""
    random = np.random.default_rng(seed)
    q = drawn(body) + 0.1 * random.uniform(-1.0, 1.0, drawn(body).shape)
    angle = random.uniform(-3.0, 3.0)
    c, s = math.cos(angle), math.sin(angle)
    q[:, :2] = q[:, :2] @ np.array([[c, s], [-s, c]]) + random.uniform(-1.0, 1.0, 2)
    q[:, 2] += angle
    return q, random


@pytest.mark.parametrize("kind", BODIES)
def test_rigid_motion_of_a_bent_body_is_not_damped(kind):
    for seed in range(5):
        q, random = bent(BODIES[kind], seed)
        force, power, size = evaluate(BODIES[kind], q, turning(q, *random.uniform(-20.0, 20.0, 3)))
        assert np.abs(force).max() < 1e-12 * size
        assert abs(power) < 1e-12 * size * 20.0


@pytest.mark.parametrize("kind", BODIES)
def test_forces_and_moments_balance_and_take_the_power_of_the_account(kind):
    for seed in range(5):
        q, random = bent(BODIES[kind], seed)
        v = random.uniform(-5.0, 5.0, q.shape)
        force, power, size = evaluate(BODIES[kind], q, v)
        moments = q[:, 0] * force[:, 1] - q[:, 1] * force[:, 0] + force[:, 2]
        assert np.abs(force).max() > 1e-3 * size
        assert np.abs(force[:, :2].sum(axis=0)).max() < 1e-12 * size
        assert abs(moments.sum()) < 1e-12 * size
        assert power > 0.0
        assert np.sum(force * v) == pytest.approx(power, rel=1e-12)


def moved(q, along, across, turn, angle):
    """The body's rates (along, across, turn), in axes at `angle`, on top of a rigid motion."""
    c, s = math.cos(angle), math.sin(angle)
    return turning(q, 3.0, -4.0, 11.0) + np.stack([c * along - s * across, s * along + c * across, turn], axis=1)


@pytest.mark.parametrize("elements", [1, 4])
def test_power_of_bending_is_that_of_the_integral(elements):
    """w_dot = k x (L - x): zeta1 rho A k^2 L^5/30, and zeta1 J (k L)^2 of a moment of inertia at the start."""
    k, J = 2.0, 3e-3
    body = link(elements, ANGLE, pivot_inertia=J)
    q = drawn(body)
    x = np.linspace(0.0, LENGTH, len(q))
    v = moved(q, 0.0 * x, k * x * (LENGTH - x), k * (LENGTH - 2.0 * x), ANGLE)
    exact = ZETA1 * (RHO_A * k**2 * LENGTH**5 / 30.0 + J * (k * LENGTH) ** 2)
    assert evaluate(body, q, v)[1] == pytest.approx(exact, rel=1e-12)


def test_power_of_stretching_is_that_of_the_integral_and_the_boss():
    """u_dot = k x: zeta1 k^2 (rho A L^3/3 + m L^2), where m is half of the mass that the beam lacks."""
    k, lacking = 2.0, 0.6
    body = link(3, ANGLE, mass=RHO_A * LENGTH + lacking)
    q = drawn(body)
    x = np.linspace(0.0, LENGTH, len(q))
    exact = ZETA1 * k**2 * (RHO_A * LENGTH**3 / 3.0 + 0.5 * lacking * LENGTH**2)
    assert evaluate(body, q, moved(q, k * x, 0.0 * x, 0.0 * x, ANGLE))[1] == pytest.approx(exact, rel=1e-12)


def test_power_of_a_frame_is_that_of_the_integral():
    """The post, seen from the arm, is sheared with u_dot = k y^2: zeta1 rho A k^2 b^5/5; its theta falls by 2 k y."""
    k = 2.0
    body = frame()
    q = drawn(body)
    y = np.cos(ANGLE) * q[:, 1] - np.sin(ANGLE) * q[:, 0]
    v = moved(q, k * y**2, 0.0 * y, -2.0 * k * y, ANGLE)
    assert evaluate(body, q, v)[1] == pytest.approx(ZETA1 * RHO_A * k**2 * 0.5**5 / 5.0, rel=1e-12)


# -- damping ratios of modes ------------------------------------------------------------------------------------------


def pinned(elements=8, **options):
    """Pinned at the start, on a roller at the end."""
    body = link(elements, **options)
    roller = fm.RigidBody("roller", (LENGTH, 0.0), mass=1e-9, inertia=1e-9)
    joints = (
        fm.Revolute("A", fm.GROUND, body, (0.0, 0.0)),
        fm.Revolute("B", body, roller, (LENGTH, 0.0)),
        fm.Prismatic("guide", fm.GROUND, roller),
    )
    return fm.Mechanism("pinned", (body, roller, *joints))


def cantilever(**options):
    body = link(8, **options)
    return fm.Mechanism("cantilever", (body, fm.Fixed("clamp", fm.GROUND, body, (0.0, 0.0))))


def free(**options):
    return fm.Mechanism("free", (link(8, **options),))


def ratios(mechanism, wanted):
    """omega [rad/s] and xi = x^T C x/(2 omega x^T M x) of the lowest modes that are no rigid motion."""
    found = fm.modes(mechanism, count=wanted + 3)
    program = fm.compile(mechanism)
    q = np.array(program.reference.q)
    C = StateEvaluation(program).at(q, weights=(0.0, 1.0, 0.0)).block()
    for mode in range(found.rigid, found.rigid + wanted):
        omega, x = 2.0 * math.pi * found.frequencies[mode], found.shapes[:, mode]
        yield omega, float(x @ C @ x) / (2.0 * omega)


def test_both_parts_of_rayleigh_damping_in_two_modes():
    """xi = zeta1/(2 omega) + zeta2 omega/2, omega = (n pi)^2 sqrt(EI/(rho A L^4)).

    R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, section 12-5; frequencies section 18-2.
    """
    omegas = [(n * math.pi) ** 2 * math.sqrt(EI / (RHO_A * LENGTH**4)) for n in (1, 2)]
    zeta2 = ZETA1 / (omegas[0] * omegas[1])  # both parts of like size in both modes
    for exact, (omega, xi) in zip(omegas, ratios(pinned(damping=zeta2), 2), strict=True):
        assert omega == pytest.approx(exact, rel=1e-3)
        assert xi == pytest.approx(ZETA1 / (2.0 * exact) + zeta2 * exact / 2.0, rel=1e-3)


def clamped_shape():
    """Root of cos x cosh x = -1 and the mode of a cantilever; Clough and Penzien, section 18-2."""
    x = brentq(lambda x: math.cos(x) * math.cosh(x) + 1.0, 1.5, 2.5)
    k = (math.cosh(x) + math.cos(x)) / (math.sinh(x) + math.sin(x))
    return lambda s: math.cosh(x * s) - math.cos(x * s) - k * (math.sinh(x * s) - math.sin(x * s))


def free_shape():
    """Root of cos x cosh x = 1 and the mode of a beam with free ends; Clough and Penzien, section 18-2."""
    x = brentq(lambda x: math.cos(x) * math.cosh(x) - 1.0, 4.0, 5.0)
    k = (math.cosh(x) - math.cos(x)) / (math.sinh(x) - math.sin(x))
    return lambda s: math.cosh(x * s) + math.cos(x * s) - k * (math.sinh(x * s) + math.sin(x * s))


@pytest.mark.parametrize(("mechanism", "shape", "low", "high"), [
    (cantilever(), clamped_shape(), 0.057, 0.059), (free(), free_shape(), 4.9, 5.1),
])  # fmt: skip
def test_what_moves_against_the_line_through_the_ends_is_damped(mechanism, shape, low, high):
    """xi = zeta1/(2 omega) int (w - chord)^2/int w^2: 0.058 with a clamp, 5 with free ends."""
    chord = [shape(0.0), shape(1.0)]
    share = quad(lambda s: (shape(s) - np.interp(s, [0.0, 1.0], chord)) ** 2, 0.0, 1.0)[0]
    share /= quad(lambda s: shape(s) ** 2, 0.0, 1.0)[0]
    assert low < share < high
    omega, xi = next(ratios(mechanism, 1))
    assert 2.0 * omega * xi / ZETA1 == pytest.approx(share, rel=1e-3)


# -- in motion --------------------------------------------------------------------------------------------------------


def test_first_mode_of_a_pinned_beam_decays_in_time():
    """From v = sin(pi x/L): the speed after n cycles is exp(-zeta1/2 t) of the first, t = 2 pi n/omega_d."""
    zeta1 = 10.0
    mechanism = pinned(6, mass_damping=zeta1)
    program = fm.compile(mechanism)
    omega = math.pi**2 * math.sqrt(EI / (RHO_A * LENGTH**4))
    period, cycles = 2.0 * math.pi / math.sqrt(omega**2 - 0.25 * zeta1**2), 8
    q, v = np.array(program.reference.q), np.zeros(program.n_q)
    s, speed = np.linspace(0.0, math.pi, 7), 1e-3
    v[1:21:3], v[2:21:3] = speed * np.sin(s), speed * math.pi / LENGTH * np.cos(s)
    v[-1] = 0.0
    run = Run(program, fm.Newmark.trapezoidal(), fm.FixedStep(period / 400), cycles * period, None)
    run.begin(Start(q, v, *accelerations(program, q, v, 0.0)))
    for n in (2, cycles):
        run.run_to(n * period, saving=None)
        rate = -math.log(run.flow.v[10] / speed) / (n * period)
        assert rate == pytest.approx(0.5 * zeta1, rel=0.01)
    assert run.flow.v[10] < 0.7 * speed


def momentum(system, q, v):
    """Momentum in x and y [kg m/s], angular momentum about the origin [kg m^2/s]."""
    p = (system.mass(q) @ v).reshape(-1, 3)
    x = q.reshape(-1, 3)
    return np.array([*p.sum(axis=0)[:2], np.sum(x[:, 0] * p[:, 1] - x[:, 1] * p[:, 0] + p[:, 2])])


@pytest.mark.slow
def test_a_spinning_rod_stops_vibrating_and_goes_on_spinning():
    """A bent rod is thrown, spinning: it keeps its momenta, and damping finds nothing more to take."""
    soft, spin, bend = fm.Material(young=2e9, density=DENSITY), 10.0, 0.2
    body = link(4, material=soft, section=fm.Rectangle(width=0.02, height=0.02), mass_damping=20.0)
    program = fm.compile(fm.Mechanism("rod", (body,)))
    system, n = StateEvaluation(program), program.n_q
    angle = bend * np.linspace(0.0, 1.0, 5)
    x = np.stack([np.sin(angle) * LENGTH / bend, (1.0 - np.cos(angle)) * LENGTH / bend, angle], axis=1)
    q, v = x.ravel(), turning(x, 30.0, -20.0, spin).ravel()
    run = Run(program, fm.RungeKutta4(), fm.FixedStep(2e-5), 0.5, None)
    run.begin(Start(q, v, *accelerations(program, q, v, 0.0)))
    start, powers = momentum(system, q, v), []
    for t in (0.01, 0.1, 0.5):
        run.run_to(t, saving=None)
        now, rates = run.flow.q[:n].copy(), run.flow.v[:n].copy()
        np.testing.assert_allclose(momentum(system, now, rates), start, rtol=0.0, atol=1e-9 * np.abs(start).max())
        powers.append(evaluate(body, now.reshape(-1, 3), rates.reshape(-1, 3))[1])
    assert powers[0] > 1.0  # [W]
    assert powers[2] < 1e-12 * powers[0]
    assert np.ptp(rates[2::3]) < 1e-6 * spin
    assert rates[2::3].mean() == pytest.approx(spin, rel=0.01)  # straight, it has a little more inertia than bent


def test_the_account_of_energies_closes():
    """A beam that falls into its weight: stored energy and what damping took stay together, to the second order."""
    mechanism, missing = replace(pinned(4, mass_damping=20.0), gravity=(0.0, -9.81)), []
    for step in (4e-5, 2e-5):
        sol = fm.simulate(mechanism, t_end=0.04, step=step, save="steps", method=fm.Newmark.trapezoidal())
        stored = sum(sol.array(f"energy.{kind}") for kind in ("kinetic", "strain", "gravity"))
        lost = sol.array("energy.dissipated_damping")
        assert lost[-1] > 0.2 * sol.array("energy.kinetic").max()
        missing.append(np.abs(stored + lost - stored[0]).max() / lost[-1])
    assert missing[0] < 1e-3
    assert math.log2(missing[0] / missing[1]) > 1.9


def test_nothing_is_added_without_mass_damping():
    for body in BODIES.values():
        assert damping_pieces(body)
        assert not damping_pieces(replace(body, mass_damping=0.0))
