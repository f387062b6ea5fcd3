"""A journal in its oil film as a part: coefficients, orbits, tangents, heat, limits, bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import slow_where
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.errors import InputError
from flexmb.mechanisms import slider_crank
from flexmb.parts.bearings import kernels
from flexmb.testing.bench import gradient

R, C, L, MU, G = 0.01, 5e-5, 0.012, 0.02, 9.81
S = MU * R * L**3 / C**2
"""Scale of the force of a short film [N s]."""

FILMS = {
    "short": fm.ShortBearing(viscosity=MU, width=L),
    "short, half": fm.ShortBearing(viscosity=MU, width=L, cavitation="half"),
    "long": fm.LongBearing(viscosity=MU, width=L),
    "long, all round": fm.LongBearing(viscosity=MU, width=L, cavitation="none"),
    "finite": fm.FiniteBearing(viscosity=MU, width=L),
    "finite, supplied everywhere": fm.FiniteBearing(viscosity=MU, width=L, supply="everywhere"),
}
WALL = fm.HuntCrossley(stiffness=1e9, restitution=0.8)
SHORT = FILMS["short"]


def bearing(film=SHORT, first=fm.GROUND, second=None, at=(0.0, 0.0), **more):
    second = journal() if second is None else second
    given = {"clearance": C, "bearing_radius": R, "normal": WALL, "film": film, **more}
    return fm.JournalBearing("B", first, second, at=at, **given)


def journal(mass=1.0, spin=0.0, velocity=(0.0, 0.0)):
    """A journal whose spin the film hardly changes."""
    return fm.RigidBody("journal", (0.0, 0.0), mass, 1e6, velocity=(*velocity, spin))


def rotor(film, omega, start, *, eps_load=0.7503810818, **more):
    """A rigid rotor under gravity at omega = spin sqrt(c/g); and its spin."""
    spin = omega * math.sqrt(G / C)
    shaft = journal(eps_load * S * spin / G, spin)
    parts = (shaft, bearing(film, second=shaft, start=(C * start[0], C * start[1]), **more))
    return fm.Mechanism("rotor", parts, gravity=(0.0, -G)), spin


WHIRL = {
    0.01: (2.763719, 0.500030, 1.909768), 0.1: (2.741279, 0.502938, 1.900798), 0.2: (2.681411, 0.510562, 1.874236),
    0.4: (2.544569, 0.523806, 1.776516), 0.5: (2.541731, 0.514640, 1.711065), 0.6: (2.700976, 0.473955, 1.638762),
}  # fmt: skip
"""Speed omega sqrt(c/g) at the limit of stability, whirl ratio, stiffness over W/c of a rigid rotor in short films."""


def ocvirk(eps):
    """Load of the short film over its scale and the spin (DuBois and Ocvirk 1953)."""
    return eps / (4.0 * (1.0 - eps**2) ** 2) * math.sqrt(16.0 * eps**2 + math.pi**2 * (1.0 - eps**2))


@pytest.mark.parametrize("eps", WHIRL)
@pytest.mark.parametrize("spin", [100.0, -300.0])
def test_whirl_of_a_rigid_rotor(eps, spin):
    load = ocvirk(eps) * S * abs(spin)
    found = bearing().equilibrium(load, spin)
    assert found.eccentricity == pytest.approx(eps, rel=1e-9)
    speed = math.sqrt(found.critical_mass * spin**2 * C / load)
    numbers = speed, found.whirl_ratio, found.equivalent_stiffness * C / load
    assert numbers == pytest.approx(WHIRL[eps], rel=1e-6)


@pytest.mark.parametrize(
    ("eps", "stiffness", "damping"),
    [
        (0.5, (2.92325, 3.976642, -0.857700, 2.209944), (6.61476, 2.244955, 2.244955, 3.053924)),
        (0.2, (1.497821, 5.763089, -4.520278, 2.484931), (10.979792, 2.491636, 2.491636, 9.586942)),
    ],
)
def test_coefficients(eps, stiffness, damping):
    spin = 100.0
    load = ocvirk(eps) * S * spin
    found = bearing().equilibrium(load, spin)
    assert (found.stiffness * C / load).ravel() == pytest.approx(stiffness, abs=2e-6)
    assert (found.damping * C * spin / load).ravel() == pytest.approx(damping, abs=1e-5)


def test_a_deep_journal_never_whirls():
    """Above the eccentricity 0.75603039 a rigid rotor in short films is stable at every speed."""
    for eps, whirls in ((0.756030, True), (0.756031, False)):
        found = bearing().equilibrium(ocvirk(eps) * S * 100.0, 100.0)
        assert (found.whirl_ratio > 0.0, math.isfinite(found.critical_mass)) == (whirls, whirls)


ORBIT = {
    1.0: (0.282753025, -0.066378821), 5.0: (0.370148495, -0.426645225), 10.0: (0.449244238, -0.160838863),
    20.0: (0.441246285, -0.216381739), 50.0: (0.417328634, -0.279750114),
}  # fmt: skip
"""Orbit at omega = 2 from (0.3, 0) at rest, over the clearance, by the angle of the spin [rad] (DOP853)."""


def test_orbit_of_a_journal():
    mech, spin = rotor(FILMS["short, half"], 2.0, (0.3, 0.0), roughness=1e-7)
    times = [tau / spin for tau in ORBIT]
    sol = fm.simulate(mech, t_end=times[-1], save=times, step=1.0 / spin / 400.0, method=fm.RungeKutta4())
    found = np.stack([sol.array("B.ex"), sol.array("B.ey")], axis=1) / C
    assert sol.ok
    assert np.abs(found - list(ORBIT.values())).max() < 1e-8


@pytest.mark.parametrize(("omega", "grows"), [(2.4, False), (2.7, True)])
def test_small_motions_die_out_below_the_limit_and_whirl_above(omega, grows):
    """Limit at 2.5417 for the eccentricity 0.5."""
    angle = math.radians(53.68020 - 90.0)
    place = 0.5 * math.cos(angle), 0.5 * math.sin(angle)
    mech, spin = rotor(SHORT, omega, (place[0] + 1e-3, place[1]))
    t_end = 40.0 * math.pi / spin
    sol = fm.simulate(mech, t_end=t_end, save=800, step=0.02 / spin)
    away = np.hypot(sol.array("B.ex") / C - place[0], sol.array("B.ey") / C - place[1])
    first, last = away[:200].max(), away[-200:].max()
    assert sol.ok
    assert last > 1.2 * first if grows else last < 0.8 * first


@pytest.mark.parametrize("name", ["short", "long", pytest.param("finite", marks=pytest.mark.slow)])
def test_full_whirl_stays_in_the_bearing(name):
    """A journal without load whirls at half of the spin, out to its roughness, since then no film is drawn in."""
    shaft = journal(0.5, 800.0)
    film = replace(FILMS[name], viscosity=2e-3)
    mech = fm.Mechanism("rotor", (shaft, bearing(film, second=shaft, start=(1e-6, 0.0))))
    sol = fm.simulate(mech, t_end=0.6, save_from=0.5, save=4000)
    turns = np.unwrap(np.arctan2(sol.array("B.ey"), sol.array("B.ex")))
    assert sol.ok, sol.status
    assert (turns[-1] - turns[0]) / (sol.time[-1] - sol.time[0]) == pytest.approx(400.0, rel=0.1)
    assert sol.array("B.film_thickness").min() > 0.0
    assert sol.array("B.film_thickness").max() < 0.2 * C


def states(seed, count, deepest=1.1):
    """Random states of both bodies with a journal at any depth of the film."""
    rng = np.random.default_rng(seed)
    p = bearing().numbers((0.1, 0.02), (-0.05, 0.03))
    for _ in range(count):
        q, v = rng.uniform(-1.0, 1.0, 6), rng.uniform(-1.0, 1.0, 6)
        arms = kernels.relative.py_func(np.array(p), q, v)
        angle, e = rng.uniform(-math.pi, math.pi), C * rng.uniform(0.0, deepest)
        q[3:5] += [e * math.cos(angle) - arms[4], e * math.sin(angle) - arms[5]]
        _, _, _, _, ex, ey, ux, uy, _ = kernels.relative.py_func(np.array(p), q, v)[:9]
        rate = C * rng.uniform(-50.0, 50.0, 2)
        v[[2, 5]] *= 20.0
        ux, uy = kernels.relative.py_func(np.array(p), q, v)[6:8]
        v[3:5] += rate - (ux, uy)
        yield q, v


@pytest.mark.quick(4)
@pytest.mark.parametrize("name", slow_where(lambda n: n == "finite, supplied everywhere", FILMS))
def test_tangents_within_the_film(name):
    p = np.array(bearing(FILMS[name]).numbers((0.1, 0.02), (-0.05, 0.03)))
    none = np.zeros(0)

    def force(q, v):
        r = np.zeros(6)
        kernels.JOURNAL_FILM.force.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, none)
        return r

    for q, v in states(1, 12):
        r, K, D, M = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        kernels.JOURNAL_FILM.element.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, K, D, M, none)
        steps = {"K": np.array([C, C, C / 0.1, C, C, C / 0.1]), "D": np.array([1e-2, 1e-2, 1e-1] * 2)}
        for found, function, x, scale in (
            (K, lambda q, v=v: force(q, v), q, 0.05 * steps["K"]),
            (D, lambda v, q=q: force(q, v), v, steps["D"] * C / 1e-3),
        ):
            expected, doubt = gradient(function, x, scale)
            size = np.abs(expected).max(axis=1, keepdims=True)
            assert (np.abs(found - expected) <= 1e-6 * size + doubt).all()
            assert (doubt <= 1e-4 * size).all()


@pytest.mark.quick(5)
@pytest.mark.parametrize("name", FILMS)
def test_a_film_never_gives_power(name):
    p = np.array(bearing(FILMS[name]).numbers((0.1, 0.02), (-0.05, 0.03)))
    for q, v in states(2, 100):
        _, _, power = kernels.JOURNAL_FILM.energy.dispatcher(p, 0.0, q, v)
        assert power > 0.0


@pytest.mark.parametrize("name", ["short", "long"])
def test_power_is_the_heat_of_the_oil(name):
    """Power of both bodies = heat of the flow by pressure where the film presses, and of the shear all round."""
    film = FILMS[name]
    p = np.array(bearing(film, roughness=1e-7).numbers((0.0, 0.0), (0.0, 0.0)))
    rng = np.random.default_rng(3)
    for _ in range(6):
        eps, a, b, w = rng.uniform(0.1, 0.9), *rng.uniform(-50.0, 50.0, 2), rng.uniform(-300.0, 300.0)
        k = 2.0 / (2.0 + eps**2) if name == "long" else 1.0
        alpha = math.atan2(a, k * b)
        theta, h = np.linspace(alpha, alpha + math.pi, 200001, retstep=True)
        H = 1.0 + eps * np.cos(theta)
        if name == "long":
            pressure = 6.0 * MU * (R / C) ** 2 * (1.0 + H) / H**2 * (k * b * np.sin(theta) - a * np.cos(theta))
            slope = np.gradient(pressure, h, edge_order=2) / R
            by_flow = np.trapezoid((C * H) ** 3 / (12.0 * MU) * slope**2 * R, dx=h) * L
        else:
            source = C * (a * np.cos(theta) - b * np.sin(theta))  # h^3/(12 mu) dp/dz = source z
            by_flow = np.trapezoid(12.0 * MU / (C * H) ** 3 * source**2 * R, dx=h) * L**3 / 12.0
        by_shear = MU * w**2 * R**3 * L / C * 2.0 * math.pi / math.sqrt(1.0 - eps**2)
        mean = 200.0 - 0.5 * w  # spin of the bearing, and of the journal
        speeds = mean, mean + w
        u = C * a, -C * b
        v = np.array([0.0, 0.0, speeds[0], u[0], u[1] + 0.5 * sum(speeds) * eps * C, speeds[1]])
        _, _, power = kernels.JOURNAL_FILM.energy.dispatcher(p, 0.0, np.array([0.0, 0.0, 0.0, eps * C, 0.0, 0.0]), v)
        assert power == pytest.approx(by_flow + by_shear, rel=1e-6)


def test_the_balance_of_energies_books_the_film():
    shaft = journal(0.3, 500.0)
    parts = (shaft, bearing(second=shaft), fm.Force("push", shaft, (0.0, 0.0), (5.0, 3.0)))
    sol = fm.simulate(fm.Mechanism("rotor", parts), t_end=0.02, save=4001, step=1e-6)
    heat = np.trapezoid(sol.array("B.power"), sol.time)
    assert sol.ok
    assert sol.array("energy.dissipated_damping")[-1] == pytest.approx(heat, rel=1e-5)
    assert np.abs(sol.array("energy.residual")).max() < 1e-4 * heat


@pytest.mark.parametrize("name", ["short", "long", "finite"])
def test_squeeze_against_integration_by_another_code(name):
    """A journal that is thrown against the wall, turning, beside DOP853 with the force of the law alone."""
    film = replace(FILMS[name], viscosity=MU * (0.05 if name == "long" else 1.0))
    mass, spin, velocity = 1.0, 900.0, (0.3, -0.2)
    shaft = journal(mass, spin, velocity)
    part = bearing(film, second=shaft, roughness=5e-7)
    t_end, method = 4e-4, fm.RungeKutta4()
    sol = fm.simulate(fm.Mechanism("thrown", (shaft, part)), t_end=t_end, save=40, step=1e-7, method=method)
    p, none = np.array(part.numbers((0.0, 0.0), (0.0, 0.0))), np.zeros(0)

    def rates(t, y):
        r, q, v = np.zeros(6), np.array([0, 0, 0, y[0], y[1], 0.0]), np.array([0, 0, 0, y[2], y[3], spin])
        kernels.JOURNAL_FILM.force.dispatcher(p, t, 0.0, q, v, np.zeros(6), none, r, none)
        return [y[2], y[3], -r[3] / mass, -r[4] / mass]

    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14, "t_eval": sol.time}
    exact = solve_ivp(rates, (0.0, t_end), [0.0, 0.0, *velocity], **options)
    found = np.stack([sol.array("B.ex"), sol.array("B.ey")])
    assert sol.ok
    assert np.abs(found - exact.y[:2]).max() < 1e-6 * C
    assert sol.array("B.film_thickness").min() < 0.5 * C


def test_mirrored_spin_mirrors_the_motion():
    rows = []
    for sign in (1.0, -1.0):
        shaft = journal(0.3, sign * 500.0)
        push = fm.Force("push", shaft, (0.0, 0.0), (20.0, 0.0))
        mech = fm.Mechanism("rotor", (shaft, bearing(second=shaft, friction=fm.ModifiedCoulomb(0.1)), push))
        sol = fm.simulate(mech, t_end=0.02, save=200, step=2e-6)
        assert sol.ok
        rows.append([sol.array(f"B.{name}") for name in ("ex", "film_fx", "power", "pressure", "flow")])
        rows[-1] += [sign * sol.array(f"B.{name}") for name in ("ey", "film_fy", "film_torque", "attitude")]
    for one, other in zip(*rows, strict=True):
        assert np.abs(one - other).max() <= 1e-9 * np.abs(one).max()


def crank(joint):
    """The slider-crank with the worn pin B as a joint of another kind."""
    dry = slider_crank(speed=100.0, clearance=C, friction="coulomb")
    normal = fm.LankaraniNikravesh(stiffness=5e9)
    given = {"at": (0.17, 0.0), "bearing_radius": R, "normal": normal, "friction": dry["B"].friction}
    return dry.with_part(joint("B", dry["rod"], dry["slider"], **given))


def test_without_oil_it_is_the_dry_joint():
    """The motion is that of a clearance less the roughness."""
    thin = fm.ShortBearing(viscosity=1e-22, width=L)
    wet = crank(lambda *a, **k: fm.JournalBearing(*a, **k, clearance=C, film=thin, roughness=1e-6))
    dry = crank(lambda *a, **k: fm.RevoluteClearance(*a, **k, clearance=C - 1e-6))
    sols = [fm.simulate(mech, t_end=0.02, save=50, step=1e-6) for mech in (wet, dry)]
    for name in ("B.ex", "B.normal_force", "B.friction_force", "slider.ax"):
        one, other = (sol.array(name) for sol in sols)
        assert np.abs(one - other).max() <= 1e-9 * np.abs(other).max()
    assert sols[1].peak("B.normal_force").value > 10.0


@pytest.mark.parametrize("name", ["short", "long", "finite"])
def test_film_and_roughness_carry_together(name):
    """A journal pressed through its film turns on its roughness; both forces together are the load."""
    shaft = journal(0.1, 50.0)
    load = 2000.0
    push = fm.Force("push", shaft, (0.0, 0.0), (0.0, -load))
    part = bearing(replace(FILMS[name], viscosity=0.005), second=shaft, normal=fm.KelvinVoigt(2e9, 2e4, ramp=1e-7))
    sol = fm.simulate(fm.Mechanism("pressed", (shaft, part, push)), t_end=0.1, save=20)
    assert sol.ok, sol.status
    film, wall = sol.array("B.film_fy")[-1], sol.array("B.fy")[-1]
    assert film + wall == pytest.approx(load, rel=1e-5)
    assert min(film, wall) > 0.01 * load
    assert 0.0 < sol.array("B.film_thickness")[-1] < 1e-6


def test_forces_have_no_step_where_the_surfaces_meet():
    part = bearing(roughness=1e-6)
    p = np.array(part.numbers((0.0, 0.0), (0.0, 0.0)))
    edge, small = C - 1e-6, 1e-13
    forces, slopes = [], []
    for e in (edge - small, edge + small):
        q, v, none = np.array([0, 0, 0, e, 0, 0.0]), np.array([0, 0, 0, 0.01, 0.02, 300.0]), np.zeros(0)
        r, K, D, M = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        kernels.JOURNAL_FILM.element.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, K, D, M, none)
        forces.append(r)
        slopes.append(K)
    assert np.abs(forces[0] - forces[1]).max() < 1e-5 * np.abs(forces[0]).max()
    assert np.abs(slopes[0] - slopes[1]).max() < 1e-5 * np.abs(slopes[0]).max()


def test_journal_at_rest_and_start_without_motion():
    shaft = journal(0.1)
    sol = fm.simulate(fm.Mechanism("rest", (shaft, bearing(second=shaft))), t_end=0.01, save=5)
    assert sol.ok
    assert sol.peak("B.ex").value == 0.0
    fall = fm.Mechanism("fall", (shaft, bearing(second=shaft)), gravity=(0.0, -G))
    sol = fm.simulate(fall, t_end=0.5, save=50)
    assert sol.ok
    assert (np.diff(sol.array("B.ey")) < 0.0).all()  # it sinks, ever slower
    assert sol.array("B.film_thickness")[-1] < 0.5 * C


def test_reversal_of_the_load():
    shaft = journal(0.2, 200.0)
    push = fm.Force("push", shaft, (0.0, 0.0), (300.0, 0.0), history=fm.drives.Harmonic(1.0, 400.0))
    sol = fm.simulate(fm.Mechanism("shaken", (shaft, bearing(second=shaft), push)), t_end=0.2, save=400)
    assert sol.ok, sol.status
    assert sol.array("B.ex").min() < -0.3 * C
    assert sol.array("B.ex").max() > 0.3 * C


def test_a_seated_journal_begins_on_its_roughness():
    shaft = journal(0.1)
    part = bearing(second=shaft, start="seated")
    sol = fm.simulate(fm.Mechanism("seated", (shaft, part), gravity=(0.0, -G)), t_end=1e-4, save=2)
    assert sol.array("B.ey")[0] == pytest.approx(-(C - 1e-6))


def test_findings_on_gap_and_reynolds_number():
    shaft = journal(0.1, 3000.0)
    wide = bearing(second=shaft, clearance=1.5e-4)
    mech = fm.Mechanism("wide", (shaft, wide), gravity=(0.0, -G))
    told = {one.code: one for one in fm.check(mech).findings}
    assert told["thick-film"].numbers["ratio"] == pytest.approx(0.015)
    assert "thick-film" not in {one.code for one in fm.check(mech.with_({"B.clearance": 1e-4})).findings}
    thin = bearing(replace(SHORT, viscosity=5e-4), second=shaft)
    sol = fm.simulate(fm.Mechanism("fast", (shaft, thin), gravity=(0.0, -G)), t_end=1e-4, save=2)
    told = {one.code: one for one in sol.findings}
    assert told["turbulent-film"].numbers["reynolds"] == pytest.approx(870.0 * 3000.0 * R * C / 5e-4)
    assert "laminar" in told["turbulent-film"].text


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fm.ShortBearing(width=L), "viscosity"),
        (lambda: fm.ShortBearing(viscosity=MU), "width"),
        (lambda: fm.LongBearing(viscosity=-1.0, width=L), "1 cP is 0.001"),
        (lambda: fm.FiniteBearing(viscosity=MU, width=0.0), "width"),
        (lambda: fm.ShortBearing(viscosity=MU, width=L, cavitation="gas"), "cavitation"),
        (lambda: fm.FiniteBearing(viscosity=MU, width=L, supply="groove"), "supply"),
        (lambda: bearing(roughness=3e-5), "smaller than half of the clearance"),
        (lambda: bearing(roughness=0.0), "roughness"),
        (lambda: bearing(film=0.02), "ShortBearing"),
        (lambda: bearing(start=(C - 5e-7, 0.0)), "outside the clearance"),
        (lambda: bearing().equilibrium(1e6, 100.0), "carries up to"),
        (lambda: bearing().equilibrium(10.0, 0.0), "speed"),
        (lambda: bearing(FILMS["finite"], roughness=5e-8).equilibrium(1.0, 1.0), "0.002 of the clearance"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()


def driven_rotor(speed, mass, shaft=None):
    """A rotor under gravity whose spin a motor prescribes; `shaft`: stiffness [N/m] between journal and disc."""
    O, small = (0.0, 0.0), 1e-6 * mass
    cross, rail = (fm.RigidBody(name, O, small, 1e-3) for name in ("cross", "rail"))
    turning = fm.RigidBody("journal", O, small if shaft else mass, 1e-3)
    angle = math.radians(53.68020 - 90.0)
    start = 0.5 * C * math.cos(angle), 0.5 * C * math.sin(angle)
    parts = [cross, rail, turning, bearing(second=turning, start=start)]
    parts += [fm.Prismatic("along", fm.GROUND, cross, at=O, along=(1.0, 0.0))]
    parts += [fm.Prismatic("across", cross, rail, at=O, along=(0.0, 1.0)), fm.Revolute("pin", rail, turning, at=O)]
    parts += [fm.Drive("motor", "pin", fm.ConstantSpeed(speed))]
    if shaft:
        disc = fm.RigidBody("disc", O, mass, 1e-3)
        parts += [disc, fm.Bushing("shaft", turning, disc, O, stiffness=shaft, torsion=1e3, torsion_damping=1.0)]
    return fm.Mechanism("rotor", parts, gravity=(0.0, -G))


@pytest.mark.slow
@pytest.mark.parametrize("softness", [0.0, pytest.param(0.7, marks=pytest.mark.slow)])
def test_limit_of_whirl_by_continuation(softness):
    """Orbits of a rotor lose stability at omega sqrt(c/g) = 2.541731/sqrt(1 + k/k_s), at the eccentricity 0.5.

    k = 1.711065 W/c is the stiffness of the film, k_s = k/softness that of the shaft.
    """
    limit = 2.541731 / math.sqrt(1.0 + softness) * math.sqrt(G / C)
    load = ocvirk(0.5) * S * limit
    mech = driven_rotor(0.95 * limit, load / G, 1.711065 * load / C / softness if softness else None)
    flow = fm.chaos.MechanismFlow(mech, step=2.0 * math.pi / limit / 200.0)
    orbit = fm.chaos.periodic_orbit(flow, settle=20)
    branch = fm.chaos.follow(orbit, "motor.motion.speed", (0.95 * limit, 1.05 * limit), step=0.2, largest=0.3)
    found = [event.value for event in branch.events if event.kind == "neimark-sacker"]
    assert found == [pytest.approx(limit, rel=1e-5)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["short", "long", "finite"])
def test_random_journals_over_a_thousand_turns(name):
    """Steady, turning and reversing loads from none to beyond the film's: each run ends, or says why it does not."""
    rng = np.random.default_rng(11)
    for _ in range(20):
        gap, spin = 10.0 ** rng.uniform(-5.0, -4.0), rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(1.0, 3.0)
        shaft = journal(10.0 ** rng.uniform(-1.0, 1.0), spin)
        film = replace(FILMS[name], viscosity=10.0 ** rng.uniform(-3.0, 0.0))
        part = bearing(film, second=shaft, clearance=gap, roughness=0.02 * gap, friction=fm.ModifiedCoulomb(0.1))
        scale = film.scales(R, gap)[kernels.FORCE] * abs(spin)
        size = scale * rng.uniform(0.0, 20.0)
        rate = rng.choice([0.01, 0.5, 1.0, 2.0]) * abs(spin) / (2.0 * math.pi)
        loads = [
            fm.Force("x", shaft, (0.0, 0.0), (size, 0.0), history=fm.drives.Harmonic(1.0, rate)),
            fm.Force("y", shaft, (0.0, 0.0), (0.0, size), history=fm.drives.Harmonic(1.0, rate, phase=0.5 * math.pi)),
            fm.Force("weight", shaft, (0.0, 0.0), (0.0, -rng.uniform(0.0, 2.0) * size)),
        ]
        mech = fm.Mechanism("rotor", (shaft, part, *loads))
        sol = fm.simulate(mech, t_end=2000.0 * math.pi / abs(spin), save=2000)
        assert sol.ok or sol.status, (gap, spin)
        for signal in ("film_thickness", "pressure", "power", "ex", "normal_force"):
            assert np.isfinite(sol.array(f"B.{signal}")).all()
        assert (sol.array("B.power") >= 0.0).all()
        assert sol.ok, sol.status


def test_a_load_of_next_to_nothing_has_a_place():
    """The film is linear there: eccentricity goes with the load, coefficients stay."""
    small, tiny = (bearing().equilibrium(load, 100.0) for load in (1e-6, 1e-30))
    assert tiny.eccentricity == pytest.approx(1e-24 * small.eccentricity, rel=1e-6)
    assert tiny.stiffness == pytest.approx(small.stiffness, rel=1e-6, abs=1e-6 * np.abs(small.stiffness).max())
    assert tiny.attitude == pytest.approx(0.5 * math.pi, abs=1e-9)
