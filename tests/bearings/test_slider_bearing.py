"""A slider in an oiled guide: closed forms, the Reynolds equation by differences, tangents, energy, bad input."""

import math
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

import flexmb as fm
from flexmb.errors import InputError
from flexmb.parts.bearings import journal as slider
from flexmb.testing.bench import gradient

C, HALF, WIDTH, MU = 1e-4, 0.05, 0.01, 0.05
K = MU * WIDTH**3


def guide(second=None, first=fm.GROUND, **more):
    second = second or fm.RigidBody("slider", (0.0, 0.0), 1.0, 1e-3)
    film = fm.ShortBearing(viscosity=MU, width=WIDTH)
    given = {
        "clearance": C, "half_length": HALF, "half_height": 0.02, "normal": fm.HuntCrossley(1e8, 0.8), "film": film,
        "roughness": 1e-6, **more,
    }  # fmt: skip
    return fm.SliderBearing("S", first, second, **given)


def numbers(part=None, place=(1.0, 0.0, 0.0, 0.0, 0.0, 0.0), angle=0.0):
    part = part or guide()
    film = part.film
    return np.array([*place, angle, part.clearance, part.roughness, part.half_length, film.viscosity, film.width, 0.0])


def forces(y, tau, U, rate, turning):
    """Forces on the slider along travel and offset, and their moment."""
    return np.array(slider.force(numbers(), y, tau, U, rate, turning)[0])


@pytest.mark.slow
def test_squeeze_between_parallel_faces():
    """A narrow plate: mu L b^3 V/h^3, on the face that comes nearer (B. J. Hamrock 1994)."""
    for y, rate in ((0.0, 0.02), (4e-5, 0.02), (4e-5, -0.03)):
        h = C - y if rate > 0.0 else C + y
        found = forces(y, 0.0, 0.0, rate, 0.0)
        assert found == pytest.approx([0.0, -K * 2.0 * HALF * rate / h**3, 0.0], rel=1e-12, abs=1e-12)


def test_wedge_of_a_tilted_slider():
    """The closed form of the integral of h'/h^3: the ends alone count."""
    for tau, U in ((5e-4, 2.0), (-1.5e-3, 2.0), (1.5e-3, -3.0)):
        _, across, _ = forces(0.0, tau, U, 0.0, 0.0)
        side = -1.0 if U * tau > 0.0 else 1.0  # of the face with the converging gap: lower, or upper
        ends = [C - side * s * tau for s in (-HALF, HALF)]
        slope = -side * tau
        closed = -0.5 * K * U * (ends[0] ** -2 - ends[1] ** -2) / 2.0 * (1.0 if slope else 0.0)
        assert abs(across) == pytest.approx(abs(closed), rel=1e-6)
        assert math.copysign(1.0, across) == -side


def test_the_drag_is_that_of_both_faces():
    along, _, _ = forces(0.0, 0.0, 2.0, 0.0, 0.0)
    assert along == pytest.approx(-MU * 2.0 * 2.0 * HALF * WIDTH / C * 2.0, rel=1e-12)
    tilted, _, _ = forces(0.0, 1e-3, 1e-9, 0.0, 0.0)
    expected = MU * WIDTH * 1e-9 * 2.0 * math.log((C + 1e-3 * HALF) / (C - 1e-3 * HALF)) / 1e-3
    expected += 0.5e-3 * abs(forces(0.0, 1e-3, 1e-9, 0.0, 0.0)[1])  # half of the pressure's component along the guide
    assert tilted == pytest.approx(-expected, rel=1e-9)


def test_the_largest_pressure_of_a_tilted_slider_stands_at_its_end():
    """y = 0, tau = 1.8e-3, U = -2 m/s: |U tau|/2 over the cube of the gap of 10 um."""
    *_, largest = slider.pressed(numbers(), 0.0, 1.8e-3, -2.0, 0.0, 0.0)
    assert largest == pytest.approx(1.8e-3 / 1e-5**3, rel=1e-9)


def reynolds(width, y, tau, U, rate, turning, side, shape=(500, 24)):
    """Force across and moment of one face of a finite slider by finite differences, without cavitation."""
    n, m = shape
    x, z = np.linspace(-HALF, HALF, n + 1), np.linspace(-0.5 * width, 0.5 * width, m + 1)
    h = C - side * (y + x * tau)
    source = -12.0 * MU * side * (rate + turning * x - 0.5 * U * tau)
    middle = (0.5 * (h[1:] + h[:-1])) ** 3
    dx, dz = x[1] - x[0], z[1] - z[0]
    along = sp.diags([-(middle[1:] + middle[:-1]) / dx**2, middle[1:-1] / dx**2, middle[1:-1] / dx**2], [0, 1, -1])
    across = sp.diags([-2.0 / dz**2, 1.0 / dz**2, 1.0 / dz**2], [0, 1, -1], shape=(m - 1, m - 1))
    A = sp.kron(along, sp.eye(m - 1)) + sp.kron(sp.diags(h[1:-1] ** 3), across)
    p = spsolve(A.tocsc(), np.repeat(source[1:-1], m - 1)).reshape(n - 1, m - 1)
    line = p.sum(axis=1) * dz * dx
    return -side * line.sum(), -side * (line * x[1:-1]).sum()


def test_narrow_sliders_obey_the_reynolds_equation():
    """At a width of 1/40 of the length Reynolds' equation gives some per cent less, at a half far less."""
    for y, tau, U, rate, turning in (
        (2e-5, 3e-4, 2.0, 0.01, 0.0),
        (0.0, -6e-4, 0.0, 0.02, 0.1),
        (0.0, 1e-3, -4.0, 0.0, 0.0),
    ):
        side = math.copysign(1.0, rate - 0.5 * U * tau)
        given = y, tau, U, rate, turning
        narrow, wide = (np.array(reynolds(width, *given, side)) * (WIDTH / width) ** 3 for width in (0.0025, 0.05))
        _, across, moment = forces(*given)
        assert across == pytest.approx(narrow[0], rel=0.045)
        assert abs(narrow[0]) < abs(across)
        assert abs(wide[0]) < 0.75 * abs(across)
        if turning:
            assert moment == pytest.approx(narrow[1], rel=0.15)


def states(seed, count, p):
    """Random states with the slider anywhere in its guide, also pressed into a face."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q, v = rng.uniform(-1.0, 1.0, 6), rng.uniform(-1.0, 1.0, 6)
        q[5] = q[2] + p[slider.ANGLE] + rng.uniform(-0.7, 0.7) * C / HALF
        y, _, ux, uy = slider.pose.py_func(p, q)[:4]
        wanted = rng.uniform(-0.3, 0.3) * C
        q[3:5] += (wanted - y) * np.array([-uy, ux])
        v[5] = v[2] + rng.uniform(-0.2, 0.2)
        parts = slider.pose.py_func(p, q)
        _, rate, _ = slider.rates.py_func(*parts[8:], v)
        v[3:5] += (rng.uniform(-0.02, 0.02) - rate) * np.array([-uy, ux])
        yield q, v


def test_tangents_power_and_frames():
    angle = 0.6
    p = numbers(place=(math.cos(0.4), math.sin(0.4), 0.1, 0.02, -0.05, 0.03), angle=angle)
    none = np.zeros(0)

    def force(q, v):
        r = np.zeros(6)
        slider.GUIDE_FILM.force.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, none)
        return r

    for q, v in states(1, 20, p):
        r, Kq, Kv, M = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        slider.GUIDE_FILM.element.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, Kq, Kv, M, none)
        assert r == pytest.approx(force(q, v), rel=1e-12)
        for found, function, x, step in (
            (Kq, lambda q, v=v: force(q, v), q, 3e-3 * C * np.array([1.0, 1.0, 10.0] * 2)),
            (Kv, lambda v, q=q: force(q, v), v, np.full(6, 1e-4)),
        ):
            expected, doubt = gradient(function, x, step)
            size = np.abs(expected).max(axis=1, keepdims=True)
            assert (np.abs(found - expected) <= 1e-6 * size + doubt).all()
            assert (doubt <= 1e-3 * size).all()
        _, _, power = slider.GUIDE_FILM.energy.dispatcher(p, 0.0, q, v)
        assert power == pytest.approx(r @ v, rel=1e-9)
        assert power > 0.0
        c, s = math.cos(0.8), math.sin(0.8)
        turn = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
        assert force(turn @ q + [0, 0, 0.8, 0, 0, 0.8], turn @ v) == pytest.approx(turn @ r, rel=1e-8, abs=1e-9)
        riding = np.array([0.3 - 2.0 * q[1], -0.2 + 2.0 * q[0], 2.0, 0.3 - 2.0 * q[4], -0.2 + 2.0 * q[3], 2.0])
        assert force(q, v + riding) == pytest.approx(r, rel=1e-7, abs=1e-7)  # both ride on a turning table


def test_error_of_the_quadrature():
    """.3 % of the force where the film grows fortyfold along the slider and both faces press."""
    y, tau, U, rate, turning = 0.0, 1.95e-3, 3.0, 0.001, 0.05
    found = forces(y, tau, U, rate, turning)
    g0 = rate - 0.5 * U * tau
    places, shares = np.polynomial.legendre.leggauss(400)
    total = np.zeros(2)
    for start, end in pairwise((-HALF, -g0 / turning, HALF)):
        s = 0.5 * (start + end) + 0.5 * (end - start) * places
        g = g0 + turning * s
        f = g / (C - np.sign(g) * (y + s * tau)) ** 3 * 0.5 * (end - start) * shares
        total += -K * f.sum(), -K * (f * s).sum()
    assert found[1] == pytest.approx(total[0], abs=3e-3 * abs(total[0]))
    assert found[2] == pytest.approx(total[1], rel=3e-3)


def test_a_slider_is_held_off_its_guide_and_energy_adds_up():
    """A loaded slider that is pushed along rides on its wedge of oil, where a dry one lies on the guide."""
    body = fm.RigidBody("slider", (0.0, 0.0), 1.0, 1e-3, velocity=(2.0, 0.0, 0.0))
    press = fm.Force("press", body, (-0.004, 0.0), (0.0, -60.0))
    pull = fm.Force("pull", body, (0.0, 0.0), (2.0, 0.0))
    mech = fm.Mechanism("ride", (body, guide(body), press, pull))
    sol = fm.simulate(mech, t_end=0.3, save=600)
    assert sol.ok, sol.status
    assert sol.array("S.film_thickness").min() > 1e-6
    assert sol.array("S.film_force")[-100:].mean() == pytest.approx(60.0, rel=1e-3)
    assert sol.peak("S.lower_front.normal_force").value == 0.0
    fine = fm.simulate(mech, t_end=0.02, save=4001, step=5e-6)
    heat = np.trapezoid(fine.array("S.power"), fine.time)
    assert fine.array("energy.dissipated_damping")[-1] == pytest.approx(heat, rel=1e-4)
    assert np.abs(fine.array("energy.residual")).max() < 1e-3 * heat


def test_without_oil_it_is_the_dry_guide():
    rows = []
    for kind in ("wet", "dry"):
        body = fm.RigidBody("slider", (0.0, 0.0), 1.0, 1e-3, velocity=(1.0, 0.05, 1.0))
        thin = fm.ShortBearing(viscosity=1e-22, width=WIDTH)
        given = {"half_length": HALF, "half_height": 0.02, "normal": fm.HuntCrossley(1e8, 0.8)}
        if kind == "wet":
            part = fm.SliderBearing("S", fm.GROUND, body, clearance=C, film=thin, roughness=1e-6, **given)
        else:
            part = fm.PrismaticClearance("S", fm.GROUND, body, clearance=C - 1e-6, **given)
        sol = fm.simulate(fm.Mechanism(kind, (body, part)), t_end=0.02, save=50, step=1e-6)
        rows.append([sol.array(f"S.{name}") for name in ("offset", "tilt", "upper_front.normal_force", "mode")])
    for one, other in zip(*rows, strict=True):
        assert np.abs(one - other).max() <= 1e-9 * np.abs(other).max()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"film": fm.LongBearing(viscosity=MU, width=WIDTH)}, "ShortBearing"),
        ({"film": None}, "ShortBearing"),
        ({"film": fm.ShortBearing(viscosity=MU, width=WIDTH, cavitation="none")}, "positive"),
        ({"roughness": 6e-5}, "half of the clearance"),
        ({"clearance": 0.0}, "clearance"),
    ],
)
def test_bad_input(given, message):
    with pytest.raises(InputError, match=message):
        guide(**given)
