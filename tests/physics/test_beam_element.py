"""The corotational element against mechanics: rigid motion, Lagrange's equations, tangents, weight, damping."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.beams.corotational import beam_energy, beam_kernel
from flexmb.engine.system.state_evaluation import StateEvaluation

LENGTH, TURNS = 1.3, 1000
UNIFORM = fm.Rectangle(width=0.02, height=0.03)
TAPERED = fm.Tapered(fm.Rectangle(width=0.02, height=0.05), fm.Rectangle(width=0.02, height=0.03))
STEEL = fm.Material(young=2.0e11, density=7850.0)
NO_INERTIA = fm.Material(young=2.0e11, density=1e-12)
NO_STIFFNESS = fm.Material(young=1e-12, density=7850.0)
VARIANTS = {
    "straight": {}, "shear": {"shear": True}, "arc": {"turn": 0.7},
    "arc with shear": {"turn": -0.7, "shear": 5.0 / 6.0},
}  # fmt: skip
DEEP = fm.Tapered(fm.Rectangle(width=0.02, height=0.9), fm.Rectangle(width=0.02, height=0.6))
"""So deep that shear is most of the bending: 12 EI/(ks G A L^2) = 0.9."""


def with_variant(variant, section=TAPERED):
    """Options of a variant, and the section that shows it."""
    return VARIANTS[variant], DEEP if "shear" in variant else section


def contribution(section=UNIFORM, material=STEEL, gravity=(0.0, 0.0), angle=0.4, **options):
    """The one element of a link of one element, drawn at an angle."""
    end = (LENGTH * math.cos(angle), LENGTH * math.sin(angle))
    link = fm.FlexibleLink("link", (0.0, 0.0), end, section=section, material=material, elements=1, **options)
    return link.contributions(fm.Mechanism("one", (link,), gravity=gravity))[0]


def call(element, q, v=None, a=None):
    """r, K, C, M of the element."""
    zero = np.zeros(6)
    v, a = zero if v is None else v, zero if a is None else a
    r, K, C, M = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
    arrays = (np.array(x, dtype=float) for x in (q, v, a))
    beam_kernel.dispatcher(np.array(element.p), 0.0, 0.0, *arrays, np.zeros(0), r, K, C, M, np.zeros(0))
    return r, K, C, M


def energies(element, q, v=None):
    """Strain energy, potential of gravity, power of damping."""
    return beam_energy(np.array(element.p), 0.0, np.array(q), np.zeros(6) if v is None else np.array(v))


def pose(angle, x=0.0, y=0.0, drawn=0.4):
    """The undeformed element turned to a direction `angle`, whose nodes are drawn at the angle `drawn`."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([x, y, angle, x + LENGTH * c, y + LENGTH * s, angle])


def state(seed):
    """A strongly deformed and turned element (rotations of 0.5 rad against the chord), fast and accelerated."""
    rng = np.random.default_rng(seed)
    q = pose(rng.uniform(-20.0, 20.0), *rng.uniform(-3.0, 3.0, 2))
    q += LENGTH * rng.uniform(-0.1, 0.1, 6) + np.array([0, 0, 1, 0, 0, 1]) * rng.uniform(-0.5, 0.5, 6)
    return q, rng.uniform(-30.0, 30.0, 6), rng.uniform(-2000.0, 2000.0, 6)


def slope(function, x, i, step=1e-5):
    """Derivative of `function` by x[i]: central differences of fourth order."""
    e = np.zeros(len(x))
    e[i] = step
    near, far = function(x + e) - function(x - e), function(x + 2 * e) - function(x - 2 * e)
    return (8.0 * near - far) / (12.0 * step)


def kinetic(element, q, v):
    return 0.5 * v @ call(element, q)[3] @ v


# Rigid motion


@pytest.mark.parametrize("angle", [0.4, -2.9, 3.0, 2 * math.pi * TURNS + 0.4, -2 * math.pi * TURNS + 1.1])
@pytest.mark.parametrize("section", [UNIFORM, TAPERED])
def test_a_rigid_pose_has_no_internal_force(angle, section):
    element = contribution(section, damping=1e-3)
    r, *_ = call(element, pose(angle, 12.0, -7.0))
    assert np.abs(r).max() < 1e-9 * 2.0e11 * float(section.area_at(0.5))


@pytest.mark.parametrize("angle", [0.4, -2.9, 3.0, 2 * math.pi * TURNS + 0.4, -2 * math.pi * TURNS + 1.1])
@pytest.mark.parametrize("section", [UNIFORM, TAPERED])
@pytest.mark.parametrize("variant", [name for name in VARIANTS if name != "straight"])
def test_a_rigid_pose_of_an_arc_or_with_shear_has_no_internal_force(variant, section, angle):
    turn = VARIANTS[variant].get("turn", 0.0)
    q = pose(angle, 12.0, -7.0) + 0.5 * turn * np.array([0, 0, -1, 0, 0, 1])
    r, *_ = call(contribution(section, damping=1e-3, **VARIANTS[variant]), q)
    assert np.abs(r).max() < 1e-9 * 2.0e11 * float(section.area_at(0.5))
    assert energies(contribution(section, **VARIANTS[variant]), q)[0] < 1e-18 * 2.0e11 * 6e-4


def test_a_whole_link_turned_a_thousand_times_has_no_internal_force():
    link = fm.FlexibleLink("link", (1.0, 2.0), (1.0, 3.3), section=UNIFORM, material=STEEL, elements=5, damping=1e-3)
    system = StateEvaluation(fm.compile(fm.Mechanism("free", (link,))))
    drawn = system.program.reference.q.reshape(-1, 3)
    for turn in np.linspace(0.0, 2 * math.pi * TURNS, 1001) + 0.1:
        c, s = math.cos(turn), math.sin(turn)
        moved = drawn @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + np.array([5.0, -4.0, turn])
        assert np.abs(system.at(moved.ravel()).force).max() < 1e-9 * 2.0e11 * 6e-4


def test_damping_does_nothing_to_rigid_motion():
    q, w = pose(1.9), 40.0
    v = np.array([3.0, -2.0, w, 3.0 - w * (q[4] - q[1]), -2.0 + w * (q[3] - q[0]), w])
    damped, free = (call(contribution(damping=d), q, v)[0] for d in (1e-3, 0.0))
    # scale: the damping force of a strain rate as large as the spin
    assert np.abs(damped - free).max() < 1e-12 * 2.0e11 * 6e-4 * 1e-3 * w
    assert energies(contribution(damping=1e-3), q, v)[2] < 1e-20 * 2.0e11 * 6e-4 * w * w


@pytest.mark.parametrize("angle", [0.4, 2.5])
def test_a_spinning_bar_has_the_kinetic_energy_of_a_rigid_one(angle):
    q, w = pose(angle), 17.0
    vx, vy = 2.0, -5.0
    v = np.array([vx, vy, w, vx - w * (q[4] - q[1]), vy + w * (q[3] - q[0]), w])
    mass = 7850.0 * 0.02 * 0.03 * LENGTH
    cx, cy = vx - 0.5 * w * (q[4] - q[1]), vy + 0.5 * w * (q[3] - q[0])
    exact = 0.5 * mass * (cx**2 + cy**2) + 0.5 * mass * LENGTH**2 / 12.0 * w**2
    assert kinetic(contribution(), q, v) == pytest.approx(exact, rel=1e-13)


def test_a_spinning_bar_needs_its_centripetal_force_only():
    """Sum of forces m a of the centre, moment about it zero: exact for a bar that turns evenly about its start."""
    q, w = pose(0.7), 25.0
    dx, dy = q[3] - q[0], q[4] - q[1]
    v = np.array([0, 0, w, -w * dy, w * dx, w])
    a = np.array([0, 0, 0, -w * w * dx, -w * w * dy, 0])
    r, *_ = call(contribution(), q, v, a)
    mass = 7850.0 * 0.02 * 0.03 * LENGTH
    force = -0.5 * mass * w * w * np.array([dx, dy])
    # the elastic part is round-off of EA: 1e-9 of it is the house's limit
    np.testing.assert_allclose(r[:2] + r[3:5], force, atol=1e-9 * mass * LENGTH * w * w)
    moment = r[2] + r[5] + dx * r[4] - dy * r[3]
    assert abs(moment) < 1e-9 * mass * LENGTH**2 * w * w


# Inertia


POINTS, WEIGHTS = np.polynomial.legendre.leggauss(10)
POINTS, WEIGHTS = 0.5 * (POINTS + 1.0), 0.5 * LENGTH * WEIGHTS
AREA = 0.02 * (0.05 - 0.02 * POINTS)  # of TAPERED
SECOND_MOMENT = 0.02 * (0.05 - 0.02 * POINTS) ** 3 / 12.0


def axis(q, phi=0.0):
    """Points of the deformed axis and angles of the sections (m, 3), against the drawn pose: cubics on the chord.

    phi = 12 EI/(ks G A L^2): axis and sections lean against each other by (u1 + u2) phi/(2 (1 + phi)).
    """
    x, chord = POINTS, q[3:5] - q[:2]
    alpha = math.atan2(chord[1], chord[0])
    u1, u2 = ((theta - alpha + math.pi) % (2.0 * math.pi) - math.pi for theta in (q[2], q[5]))
    lean = 0.5 * (u1 + u2) * phi / (1.0 + phi)
    u1, u2, alpha_of_sections = u1 - lean, u2 - lean, alpha + lean
    w = LENGTH * (u1 * (x - 2 * x**2 + x**3) + u2 * (x**3 - x**2))
    turn = u1 * (1 - 4 * x + 3 * x**2) + u2 * (3 * x**2 - 2 * x)
    normal = np.array([-math.sin(alpha), math.cos(alpha)])
    return np.column_stack([q[:2] + np.outer(x, chord) + np.outer(w, normal), alpha_of_sections + turn])


def velocities(q, v, phi=0.0):
    """Rates of `axis`, by differences."""
    return slope(lambda t: axis(q + v * t[0], phi), np.zeros(1), 0, 1e-5)


@pytest.mark.parametrize("rotary", [False, True, 3.0])
def test_kinetic_energy_is_that_of_the_moving_axis(rotary):
    """Half the integral of rho A |velocity|^2 and of rho I (turning)^2, the axis itself differenced in time."""
    q, v, _ = state(3)
    rates = velocities(q, v)
    exact = 0.5 * (WEIGHTS * 7850.0 * AREA) @ (rates[:, :2] ** 2).sum(axis=1)
    if rotary:
        exact += 0.5 * (WEIGHTS * (7850.0 * SECOND_MOMENT if rotary is True else rotary)) @ rates[:, 2] ** 2
    assert kinetic(contribution(TAPERED, rotary_inertia=rotary), q, v) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("rotary", [False, True, 3.0])
def test_kinetic_energy_with_shear_is_that_of_the_moving_axis_and_sections(rotary):
    """The same for a uniform deep section, shapes in closed form."""
    q, v, _ = state(3)
    section, G = fm.Rectangle(width=0.02, height=0.6), 2.0e11 / 2.6
    phi = 12.0 * 2.0e11 * 0.02 * 0.6**3 / 12.0 / (0.8 * G * 0.012 * LENGTH**2)
    rates = velocities(q, v, phi)
    exact = 0.5 * 7850.0 * 0.012 * WEIGHTS @ (rates[:, :2] ** 2).sum(axis=1)
    rho_i = 7850.0 * 0.02 * 0.6**3 / 12.0
    exact += 0.5 * {True: rho_i, False: 0.0}.get(rotary, rotary) * WEIGHTS @ rates[:, 2] ** 2
    assert kinetic(contribution(section, rotary_inertia=rotary, shear=0.8), q, v) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_inertia_forces_add_up_to_the_rates_of_the_momenta(seed):
    """Sum and moment of the inertia forces against second differences of the integrals over the axis."""
    q, v, a = state(seed)
    r, *_ = call(contribution(TAPERED, NO_STIFFNESS, rotary_inertia=3.0), q, v, a)

    def momentum(t):
        now, rate = q + v * t[0] + 0.5 * a * t[0] ** 2, v + a * t[0]
        (x, y, _), (vx, vy, turning) = axis(now).T, velocities(now, rate).T
        density = WEIGHTS * 7850.0 * AREA
        return np.array([density @ vx, density @ vy, density @ (x * vy - y * vx) + 3.0 * WEIGHTS @ turning])

    expected = slope(momentum, np.zeros(1), 0, 1e-4)
    moment = r[2] + r[5] + q[0] * r[1] - q[1] * r[0] + q[3] * r[4] - q[4] * r[3]
    found = np.array([r[0] + r[3], r[1] + r[4], moment])
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


def test_uniform_flight_changes_no_force_and_no_tangent():
    q, v, a = state(2)
    element = contribution(TAPERED, NO_STIFFNESS, rotary_inertia=True)
    flight = np.array([70.0, -50.0, 0.0, 70.0, -50.0, 0.0])
    for still, flying in zip(call(element, q, v, a), call(element, q, v + flight, a), strict=True):
        np.testing.assert_allclose(flying, still, atol=1e-10 * np.abs(still).max())


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("rotary", [False, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_inertia_force_is_lagranges(seed, rotary, variant):
    """d/dt (dT/dv) - dT/dq along q + v t + a t^2/2, by differences of T alone."""
    options, section = with_variant(variant)
    element = contribution(section, NO_STIFFNESS, rotary_inertia=rotary, **options)
    q, v, a = state(seed)
    r, *_ = call(element, q, v, a)

    def momentum(t):
        return call(element, q + v * t[0] + 0.5 * a * t[0] ** 2)[3] @ (v + a * t[0])

    expected = slope(momentum, np.zeros(1), 0, 1e-5)
    expected = expected - np.array([slope(lambda x: kinetic(element, x, v), q, i, 1e-4) for i in range(6)])
    np.testing.assert_allclose(r, expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("seed", range(4))
def test_power_of_inertia_is_the_rate_of_kinetic_energy(seed, variant):
    options, section = with_variant(variant)
    element = contribution(section, NO_STIFFNESS, **options)
    q, v, _ = state(seed)
    rate = slope(lambda t: kinetic(element, q + v * t[0], v), np.zeros(1), 0, 1e-5)
    assert call(element, q, v)[0] @ v == pytest.approx(rate, rel=1e-8)


# Elasticity and weight


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("seed", range(4))
def test_elastic_force_is_the_slope_of_strain_energy(seed, variant):
    options, section = with_variant(variant)
    element = contribution(section, **options)
    q, _, _ = state(seed)
    expected = np.array([slope(lambda x: energies(element, x)[0], q, i, 1e-4) for i in range(6)])
    np.testing.assert_allclose(call(element, q)[0], expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("seed", range(4))
def test_damping_takes_the_power_it_reports(seed, variant):
    q, v, _ = state(seed)
    options, section = with_variant(variant)
    damped, free = (contribution(section, NO_INERTIA, damping=d, **options) for d in (2e-3, 0.0))
    power = (call(damped, q, v)[0] - call(free, q, v)[0]) @ v
    assert power > 0.0
    assert power == pytest.approx(energies(damped, q, v)[2], rel=1e-10)


@pytest.mark.parametrize("angle", [0.4, 2.2, -1.0])
def test_weight_and_its_moment(angle):
    """A tapered bar, A = b (h1 + (h2 - h1) s): mass and centre of mass by hand; forces about the start."""
    gx, gy = 1.7, -9.81
    q = pose(angle)
    r, *_ = call(contribution(TAPERED, gravity=(gx, gy)), q)
    mass = 7850.0 * 0.02 * LENGTH * 0.04
    centre = LENGTH * (0.05 / 2 - 0.02 / 3) / 0.04
    x, y = centre * math.cos(angle), centre * math.sin(angle)
    bare, *_ = call(contribution(TAPERED), q)
    load = bare - r
    np.testing.assert_allclose(load[:2] + load[3:5], [mass * gx, mass * gy], rtol=1e-12)
    moment = load[2] + load[5] + (q[3] - q[0]) * load[4] - (q[4] - q[1]) * load[3]
    assert moment == pytest.approx(mass * (x * gy - y * gx), rel=1e-12)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("seed", range(4))
def test_weight_is_the_slope_of_its_potential(seed, variant):
    options, section = with_variant(variant)
    element = contribution(section, NO_STIFFNESS, gravity=(1.7, -9.81), **options)
    q, _, _ = state(seed)
    expected = np.array([slope(lambda x: energies(element, x)[1], q, i, 1e-3) for i in range(6)])
    np.testing.assert_allclose(call(element, q)[0], expected, atol=1e-9 * np.abs(expected).max())


# Tangents

PHYSICS = {
    "elasticity": {"material": NO_INERTIA},
    "damping": {"material": NO_INERTIA, "damping": 2e-3},
    "inertia": {"material": NO_STIFFNESS},
    "rotary inertia": {"material": NO_STIFFNESS, "rotary_inertia": 5.0},
    "weight": {"material": NO_STIFFNESS, "gravity": (3000.0, -9000.0)},
    "all": {"material": fm.Material(young=2e7, density=7850.0), "damping": 1e-3, "gravity": (300.0, -900.0)},
}


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("physics", PHYSICS)
def test_tangents_are_the_slopes_of_the_force(physics, seed, variant):
    """Each physics alone, so that the stiff terms do not hide an error in the others."""
    options, section = with_variant(variant)
    element = contribution(section, **PHYSICS[physics], **options)
    point = state(seed) if physics != "weight" else (state(seed)[0], np.zeros(6), np.zeros(6))
    matrices = call(element, *point)[1:]
    for k, (matrix, name) in enumerate(zip(matrices, "KCM", strict=True)):

        def force(x, k=k):
            return call(element, *point[:k], x, *point[k + 1 :])[0]

        step = 1e-4 if k == 0 else 1e-2
        numeric = np.column_stack([slope(force, point[k], i, step) for i in range(6)])
        scale = np.abs(numeric).max()
        limit = 1e-6 * scale if scale > 1e-9 else 1e-9
        assert np.abs(matrix - numeric).max() < limit, name
